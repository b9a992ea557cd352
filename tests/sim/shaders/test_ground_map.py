"""Shares of the sky beside walls, and how bodies that move darken the ground."""

from __future__ import annotations

import numpy as np
import pytest

from sim.optics import Intrinsics, look_down_pose
from sim.shaders.ground_map import (
    COARSE_M,
    FINER,
    Footprint,
    GroundMap,
    HeightMap,
    ground_map,
    ground_row,
    new_ground_scratch,
    sky_shares,
)

CELLS = 81
CAMERA = Intrinsics(64, 48, 60.0)
DOWN = look_down_pose(np.array([0.0, 0.0, 40.0]), 0.0, 0.0, 0.0)


def test_open_ground_sees_all_of_the_sky():
    empty = np.zeros((CELLS, CELLS), np.float32)
    np.testing.assert_array_equal(sky_shares(HeightMap(empty, empty)), 1.0)


@pytest.mark.parametrize("cells", [3, 6, 12])
def test_a_long_wall_takes_the_share_of_geometry(cells):
    height_m = np.zeros((CELLS, CELLS), np.float32)
    height_m[:, :40] = 6.0
    share = sky_shares(HeightMap(height_m, np.zeros_like(height_m)))[CELLS // 2, 39 + cells]
    # An endless wall of height h at distance d blocks (1 - d / sqrt(d² + h²)) / 2 of a uniform sky's light.
    d = (cells - 0.5) * COARSE_M
    assert share == pytest.approx(1.0 - 0.5 * (1.0 - d / np.hypot(d, 6.0)), abs=0.05)


def plain_map() -> GroundMap:
    share = np.ones((CELLS, CELLS), np.float32)
    return ground_map(share, np.full((FINER * CELLS, FINER * CELLS), 51, np.uint8), np.empty((0, 7)))


def test_a_body_darkens_the_ground_beside_it_and_nothing_after_it_has_gone():
    ground, car = plain_map(), [Footprint(0, 4.5, 1.8, 1.4)]
    here, there = np.eye(4)[None].copy(), np.eye(4)[None].copy()
    there[0, :2, 3] = 9.0, 5.0
    view = ground.view(car)
    dark = view.arrays(here, CAMERA, DOWN).packed.reshape(ground.size, -1) & 255
    middle = ground.size // 2
    assert dark[middle, middle] < 100 < dark[middle + 8, middle] < dark[middle + 14, middle] < 255
    moved = view.arrays(there, CAMERA, DOWN).packed.copy()
    np.testing.assert_array_equal(moved, ground.view(car).arrays(there, CAMERA, DOWN).packed)


def test_places_of_pixels_are_those_on_the_ground():
    arrays = plain_map().view([]).arrays(np.empty((0, 4, 4)), CAMERA, DOWN)
    x, y = 40.5, 10.5
    column, row, height = 40.0 * arrays.from_pixel[:, :3] @ (x, y, 1.0) + arrays.from_pixel[:, 3]
    # Looking down with the heading along +x: up in the picture is +x, right is -y.
    cell_m, half_m = COARSE_M / FINER, 0.5 * CELLS * COARSE_M
    along, right = (24.0 - y) / 60.0 * 40.0, (x - 32.0) / 60.0 * 40.0
    assert column == pytest.approx((along + half_m) / cell_m, abs=1e-3)
    assert row == pytest.approx((half_m + right) / cell_m, abs=1e-3)
    assert height == pytest.approx(0.0, abs=1e-4)


def test_cover_and_share_are_interpolated():
    ground = plain_map().view([]).arrays(np.empty((0, 4, 4)), CAMERA, DOWN)
    column, row = (np.array([10.2, 100.7], np.float32) for _ in range(2))
    share, cover = np.empty((2, 2), np.float32)
    ground_row(ground, column, row, new_ground_scratch(2), share, cover)
    np.testing.assert_allclose(share, 1.0, rtol=1e-6)
    np.testing.assert_allclose(cover, 0.2, rtol=1e-6)
