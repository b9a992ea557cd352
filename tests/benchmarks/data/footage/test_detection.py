"""What moves is found, whether the camera rests or pans; where nothing moves, that is said."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.data.footage.detection import first_moving
from benchmarks.data.footage.sources import Picture
from tests.benchmarks.data.footage.written_footage import SIDE_PX, picture_of
from trackers.kernels.boxes import box_iou


def footage(pan_px: int, speed_px: int, count: int = 60) -> Iterator[tuple[Picture, tuple[int, int]]]:
    """Yield pictures with the corner of the square in them."""
    for k in range(count):
        corner = 150 + speed_px * k, 60
        yield Picture(picture_of(k, pan_px, (400, 160), corner), k / 30), (corner[0] - pan_px * k, corner[1])


@settings(max_examples=3, deadline=None)
@given(pan_px=st.integers(0, 4), ahead_px=st.sampled_from([-2, 2, 3]))
def test_what_moves_is_found_before_a_camera_that_pans(pan_px: int, ahead_px: int) -> None:
    corners: list[tuple[int, int]] = []

    def pictures() -> Iterator[Picture]:
        for picture, corner in footage(pan_px, max(pan_px + ahead_px, 0) or 2):
            corners.append(corner)
            yield picture

    picture, box = first_moving(pictures())
    x, y = corners[-1]
    assert picture.time_s == (len(corners) - 1) / 30
    assert box_iou(box, np.array([x, y, x + SIDE_PX, y + SIDE_PX], float)) > 0.4


def test_where_nothing_moves_that_is_said() -> None:
    still = (picture for picture, _ in footage(pan_px=0, speed_px=0))
    with pytest.raises(ValueError, match="detect: expected footage in which something moves in the first"):
        first_moving(still)
