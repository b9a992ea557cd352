"""Contact sheets: several episodes, several frames, every channel."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.page.sheets import boxed_shots, channel_shots, contact_sheet
from tests.benchmarks.data.sets.hand_made import write_set


def test_rows_are_episodes_and_their_frames_are_spread(hand_made: DataSet) -> None:
    rows = boxed_shots(hand_made)
    titles = [[shot.title for shot in row] for row in rows]
    assert [title.split(" · ")[1] for title in titles[0]] == ["frame 3", "frame 11", "frame 18", "frame 26"]
    assert titles[1][0].startswith("seed 1 ")
    assert rows[0][0].words == "target: in; 1 of 2 objects in view"
    assert {shot.image_rgb.shape for row in rows for shot in row} == {(384, 512, 3)}


def test_channels_are_of_a_frame_that_shows_most(hand_made: DataSet) -> None:
    shots = channel_shots(hand_made)
    # Both cars are in view from frame 15 to 19; of frame 15 the right picture was lost, and it is the middle.
    assert [shot.title for shot in shots] == [c for c in hand_made.request.channels if c != "right_rgb"]
    assert shots[0].words == "seed 0, frame 15"


def test_the_sheet_holds_them_all(hand_made: DataSet) -> None:
    sheet = contact_sheet(hand_made)
    cell = np.array([240 + 28 + 6, 320 + 6])
    # Two episodes, then five channels besides the picture in rows of four.
    assert sheet.shape == (*(cell * (4, 4) - 6), 3)
    assert sheet.dtype == np.uint8


def test_a_set_of_maps_alone_is_drawn_on_a_map_and_short_episodes_in_short_rows(tmp_path: Path) -> None:
    data = write_set(tmp_path, ("depth_m",), frames=2)
    rows = boxed_shots(data)
    assert [len(row) for row in rows] == [2, 2]
    assert rows[0][0].image_rgb.any()
    assert contact_sheet(data).shape[1] == 2 * 326 - 6


def test_a_lost_picture_leaves_its_place_empty(tmp_path: Path) -> None:
    data = write_set(tmp_path, ("right_rgb",), frames=4)
    first, second = (shot.image_rgb for shot in boxed_shots(data)[0][:2])
    assert tuple(first[-1, -1]) == (28, 30, 35)
    assert second[-1].any()


def test_a_set_without_pixels_has_no_sheet(tmp_path: Path) -> None:
    data = write_set(tmp_path, (), frames=2)
    assert boxed_shots(data) == []
    assert channel_shots(data) == []
    with pytest.raises(ValueError, match=r"channels: expected a data set with at least one, got none"):
        contact_sheet(data)
