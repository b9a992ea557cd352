"""Polygons and oriented boxes of masks, against how Ultralytics reads them and against shapely."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.ndimage import label
from shapely import MultiPoint, Polygon, minimum_rotated_rectangle

from benchmarks.data.exports.outlines import oriented_box, polygon_of

UP = np.array([0.0, -1.0])


def filled(polygon: NDArray[np.float64], height: int, width: int) -> NDArray[np.bool_]:
    """Return the mask that Ultralytics makes of a line: points cut to whole pixels, then ``cv2.fillPoly``."""
    mask = np.zeros((height, width), np.uint8)
    cv2.fillPoly(mask, polygon.astype(np.int32)[None], 1)
    return mask.astype(bool)


def blob(seed: int, height: int = 40, width: int = 50) -> NDArray[np.bool_]:
    """Return overlapping discs with holes cut into them; it may have several parts."""
    rng, mask = np.random.default_rng(seed), np.zeros((height, width), np.uint8)
    for k in range(rng.integers(1, 9)):
        x, y, radius = rng.integers(0, width), rng.integers(0, height), rng.integers(1, 12)
        cv2.circle(mask, (int(x), int(y)), int(radius), int(k % 3 != 2), -1)
    mask[rng.integers(0, height), rng.integers(0, width)] = 1
    return mask.astype(bool)


@given(st.integers(0, 10_000))
def test_a_polygon_gives_the_mask_back(seed: int) -> None:
    """All of its pixels, and else only those on the ways between its parts, none within one part."""
    mask = blob(seed)
    back = filled(polygon_of(mask), *mask.shape)
    assert back[mask].all()
    parts = label(mask, np.ones((3, 3)))[1]
    if parts == 1:
        np.testing.assert_array_equal(back, mask)
    else:
        assert (back & ~mask).sum() <= (parts - 1) * max(mask.shape)


def test_a_hole_stays_a_hole_and_one_pixel_is_three_points() -> None:
    ring = np.ones((9, 9), bool)
    ring[3:6, 3:6] = False
    np.testing.assert_array_equal(filled(polygon_of(ring), 9, 9), ring)
    single = np.zeros((4, 5), bool)
    single[2, 3] = True
    np.testing.assert_array_equal(polygon_of(single), [[3.5, 2.5]] * 3)
    np.testing.assert_array_equal(filled(polygon_of(single), 4, 5), single)


@given(st.integers(0, 10_000))
def test_an_oriented_box_is_the_least_rectangle_around_all_pixels(seed: int) -> None:
    mask = blob(seed)
    y, x = np.nonzero(mask)
    pixels = np.concatenate([np.stack([x + dx, y + dy], axis=1) for dx in (0, 1) for dy in (0, 1)])
    corners = oriented_box(mask, UP)
    assert Polygon(corners).buffer(1e-6).covers(MultiPoint(pixels))
    assert Polygon(corners).area == pytest.approx(minimum_rotated_rectangle(MultiPoint(pixels)).area, rel=1e-6)


@given(st.floats(0.0, 360.0), st.floats(0.0, 60.0))
def test_corners_begin_at_the_front_left_and_go_round_clockwise(heading_deg: float, off_deg: float) -> None:
    """Of a long car that drives in any direction; its front is told within 30 degrees."""
    angle = np.deg2rad(heading_deg)
    ahead = np.array([np.cos(angle), np.sin(angle)])
    right = np.array([-ahead[1], ahead[0]])
    body = np.array([60.0, 60.0]) + [a * 40 * ahead + b * 12 * right for a, b in ((1, -1), (1, 1), (-1, 1), (-1, -1))]
    mask = np.zeros((120, 120), np.uint8)
    cv2.fillPoly(mask, np.rint(body - 0.5).astype(np.int32)[None], 1)
    off = np.deg2rad(off_deg - 30)
    told = np.cos(off) * ahead + np.sin(off) * right
    np.testing.assert_allclose(oriented_box(mask.astype(bool), 3.0 * told), body, atol=2.5)


def test_without_a_direction_corners_begin_at_the_top_left() -> None:
    mask = np.zeros((8, 12), bool)
    mask[2:5, 3:10] = True
    for ahead in (np.zeros(2), np.full(2, np.nan)):
        np.testing.assert_allclose(oriented_box(mask, ahead), [[3, 2], [10, 2], [10, 5], [3, 5]])
