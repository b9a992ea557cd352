"""Contact sheets: several episodes, several frames, every channel."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.data.sets.contact_sheet import boxed_frames, channel_cells, contact_sheet, draw_boxes
from benchmarks.data.sets.data_set import DataSet
from benchmarks.show.video.marks import TRUTH
from tests.benchmarks.data.sets.hand_made import write_set
from tests.benchmarks.fake_episode import HEIGHT, WIDTH

ZOOM = 3.0


def drawn(data: DataSet, frame: int, target: str = "target") -> NDArray[np.uint8]:
    image = np.zeros((int(HEIGHT * ZOOM), int(WIDTH * ZOOM), 3), dtype=np.uint8)
    episode = data.episode(0)
    draw_boxes(image, ZOOM, episode.frame(frame, ()).truth, episode.visible_boxes_of(frame), target)
    return image


def test_the_visible_box_lies_where_the_object_is(hand_made: DataSet) -> None:
    image = drawn(hand_made, 0)
    left, middle = int(30 * ZOOM), int(26 * ZOOM)
    near = image[middle, left - 4 : left + 4].astype(int)
    assert np.abs(near - TRUTH).sum(axis=1).min() < 60
    # Nothing is drawn where the object itself is to be seen, nor far away.
    assert not image[middle, int(40 * ZOOM)].any()
    assert not image[int(80 * ZOOM) :].any()


def test_a_target_outside_has_an_arrow_other_objects_outside_have_nothing(hand_made: DataSet) -> None:
    # At frame 12 the target is out to the right and the other in; at 25 it is the other way round.
    with_arrow, others = drawn(hand_made, 12), drawn(hand_made, 25)
    at_border = (slice(None), slice(int(WIDTH * ZOOM) - 30, None))
    assert with_arrow[at_border].any()
    assert not others[at_border].any()


def test_boxes_behind_the_camera_are_left_out(hand_made: DataSet) -> None:
    truth = hand_made.episode(0).frame(0, ()).truth
    nowhere = replace(truth, box_xyxy=np.full((2, 4), np.nan), position_px=np.full((2, 2), np.nan))
    image = np.zeros((60, 80, 3), dtype=np.uint8)
    draw_boxes(image, 1.0, nowhere, np.full((2, 4), np.nan), "target")
    assert not image.any()


def test_the_sheet_has_spread_frames_of_each_episode_and_the_channels_of_the_fullest(hand_made: DataSet) -> None:
    rows = boxed_frames(hand_made)
    assert [title.split(" · ")[1] for title, _ in rows[0]] == ["frame 3", "frame 11", "frame 18", "frame 26"]
    assert rows[1][0][0].startswith("seed 1 ")
    assert {image.shape for row in rows for _, image in row} == {(384, 512, 3)}
    # Both cars are in view from frame 15 to 19; of frame 15 the right picture was lost, and it is the middle.
    channels = [c for c in hand_made.request.channels if c not in ("image_rgb", "right_rgb")]
    assert [title.split()[0] for title, _ in channel_cells(hand_made)] == channels
    sheet = contact_sheet(hand_made)
    cell = np.array([240 + 28 + 6, 320 + 6])
    # Two episodes, then five channels besides the picture in rows of four.
    assert sheet.shape == (*(cell * (4, 4) - 6), 3)
    assert sheet.dtype == np.uint8


def test_a_set_of_maps_alone_is_drawn_on_a_map_and_short_episodes_in_short_rows(tmp_path: Path) -> None:
    data = write_set(tmp_path, ("depth_m",), frames=2)
    rows = boxed_frames(data)
    assert [len(row) for row in rows] == [2, 2]
    assert rows[0][0][1].any()
    assert contact_sheet(data).shape[1] == 2 * 326 - 6


def test_a_lost_picture_leaves_its_place_empty(tmp_path: Path) -> None:
    data = write_set(tmp_path, ("right_rgb",), frames=4)
    first, second = (image for _, image in boxed_frames(data)[0][:2])
    assert tuple(first[-1, -1]) == (28, 30, 35)
    assert second[-1].any()
