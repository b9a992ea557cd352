"""Boxes drawn on a frame."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.page.boxes import VISIBLE, draw_boxes, zoomed
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
    assert np.abs(near - VISIBLE).sum(axis=1).min() < 60
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


@pytest.mark.parametrize("width_px", [40, 160, 512])
def test_zoom_keeps_the_shape_and_the_place_of_edges(width_px: int) -> None:
    image = np.zeros((120, 160, 3), dtype=np.uint8)
    image[:, 80:] = 200
    large = zoomed(image, width_px)
    assert large.shape == (round(0.75 * width_px), width_px, 3)
    assert large[:, : width_px // 2 - 1].max() == 0
    assert large[:, width_px // 2 + 1 :].min() == 200
