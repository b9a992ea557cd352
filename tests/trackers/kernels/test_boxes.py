"""The length of a car from its upright box, and the overlap of boxes against shapely."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from trackers.kernels.boxes import WIDTH_TO_LENGTH, apparent_length_px, box_iou

NUMBERS = st.floats(-50, 50, allow_nan=False)
SIZES = st.just(0.0) | st.floats(0.01, 40)


@pytest.mark.parametrize("heading_rad", [0.0, 0.4, 0.9, 1.5])
def test_the_length_of_a_car_follows_from_its_upright_box(heading_rad: float) -> None:
    c, s = np.cos(heading_rad), np.sin(heading_rad)
    width, height = 40 * (c + WIDTH_TO_LENGTH * s), 40 * (s + WIDTH_TO_LENGTH * c)
    assert apparent_length_px(np.array([10, 20, 10 + width, 20 + height])) == pytest.approx(40.0, rel=1e-6)


@settings(deadline=None)
@given(NUMBERS, NUMBERS, SIZES, SIZES, NUMBERS, NUMBERS, SIZES, SIZES)
def test_iou_is_that_of_shapely(x: float, y: float, w: float, h: float, u: float, v: float, p: float, q: float) -> None:
    first, second = np.array([x, y, x + w, y + h]), np.array([u, v, u + p, v + q])
    a, b = shapely.box(*first), shapely.box(*second)
    expected = a.intersection(b).area / a.union(b).area if a.area > 0 and b.area > 0 else 0.0
    np.testing.assert_allclose(box_iou(first, second), expected, atol=1e-6)
    assert box_iou(first, second) == box_iou(second, first)


def test_no_overlap_with_what_is_not_a_number() -> None:
    assert box_iou(np.full(4, np.nan), np.array([0.0, 0.0, 1.0, 1.0])) == 0.0
