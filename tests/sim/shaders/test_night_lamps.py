"""Street lamps and headlights: inverse square, cosine, flux, shadows; what cars leave behind."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from sim.optics import Intrinsics, look_down_pose
from sim.shaders.ground_map import COARSE_M, Footprint, GroundArrays, HeightMap
from sim.shaders.night_lamps import (
    BEAM_REACH_M,
    CHANNELS,
    LampArrays,
    LampView,
    bake_lamps,
    intensity_down_cd,
    lamp_row,
    new_lamp_scratch,
    profile,
)

CELLS = 101
EMPTY = HeightMap(np.zeros((CELLS, CELLS), np.float32), np.zeros((CELLS, CELLS), np.float32))
MIDDLE = CELLS // 2


def baked(height_m: float, heights: HeightMap = EMPTY) -> np.ndarray:
    return bake_lamps(np.array([[0.0, 0.0, height_m]]), np.array([6000.0]), heights)


def test_the_profile_holds_the_whole_flux():
    # Monte Carlo over the lower half sphere: cosines of its directions are uniform.
    cosines = np.random.default_rng(0).random(200_000)
    assert intensity_down_cd(6000.0) * 2.0 * np.pi * profile(cosines).mean() == pytest.approx(6000.0, rel=0.01)


def test_straight_below_the_light_falls_with_the_square_of_the_height():
    near, far = (baked(height_m)[MIDDLE, MIDDLE, 2] for height_m in (6.0, 12.0))
    assert near / far == pytest.approx(4.0, rel=0.02)
    assert near == pytest.approx(intensity_down_cd(6000.0) / 36.0, rel=0.02)


@pytest.mark.parametrize("cells", [3, 8, 15, 25])
def test_beside_the_lamp_the_vector_is_intensity_over_squared_distance(cells):
    light = baked(8.0)[MIDDLE, MIDDLE + cells]
    away = np.array([-cells * COARSE_M, 0.0, 8.0])
    distance = np.linalg.norm(away)
    expected = intensity_down_cd(6000.0) * float(profile(np.array(8.0 / distance))) * away / distance**3
    np.testing.assert_allclose(light[:3], expected, rtol=0.02, atol=2e-3)


def test_a_house_throws_a_shadow_and_a_crown_a_thin_one():
    solid, crown = np.zeros((2, CELLS, CELLS), np.float32)
    solid[MIDDLE, MIDDLE + 5], crown[MIDDLE, MIDDLE - 5] = 7.0, 6.0
    free, shadowed = baked(8.0), baked(8.0, HeightMap(solid, crown))
    assert shadowed[MIDDLE, MIDDLE + 10, 2] == 0.0
    assert 0.0 < shadowed[MIDDLE, MIDDLE - 10, 2] < free[MIDDLE, MIDDLE - 10, 2]
    np.testing.assert_array_equal(shadowed[MIDDLE + 10], free[MIDDLE + 10])


def view(poses: np.ndarray) -> LampView:
    cars = [Footprint(k, 4.5, 1.8, 1.4) for k in range(len(poses))]
    white = np.ones(3)
    return LampView(np.zeros((CELLS, CELLS, 6), np.float32), cars, lamp_rgb=white, head_rgb=white, height_m=8.0)


def lit(lamps: LampView, poses: np.ndarray) -> np.ndarray:
    ground = GroundArrays(np.empty(0, np.uint16), 4 * CELLS, np.empty((3, 4), np.float32))
    return (
        lamps.arrays(
            poses, ground, Intrinsics(640, 480, 300.0), look_down_pose(np.array([0.0, 0.0, 60.0]), 0.0, 0.0, 0.0)
        )
        .light_lx.reshape(CELLS, CELLS, 6)[..., 3:]
        .copy()
    )


def test_headlights_shine_ahead_alone_and_less_far_away():
    poses = np.eye(4)[None].copy()
    light = lit(view(poses), poses)
    ahead = light[MIDDLE, MIDDLE + 4 :, 2]
    assert not light[:, : MIDDLE + 2].any()
    assert (np.diff(ahead[3:40]) <= 0.0).all()
    reach = round((BEAM_REACH_M + 3.0) / COARSE_M)
    assert not light[:, MIDDLE + reach :].any()
    # The vector points back to the car, and up.
    assert (light[MIDDLE, MIDDLE + 6 : MIDDLE + 30, 0] < 0.0).all()


def test_nothing_is_left_where_a_car_has_been():
    first, later = np.eye(4)[None].copy(), np.eye(4)[None].copy()
    later[0, :2, 3] = 12.0, -9.0
    moved = view(first)
    lit(moved, first)
    np.testing.assert_array_equal(lit(moved, later), lit(view(later), later))


@pytest.mark.parametrize("width", [1, 2, 7, 8, 23])
@pytest.mark.parametrize("is_plain", [False, True])
def test_a_row_reads_the_map_between_its_cells(width: int, is_plain: bool) -> None:
    """Straight rows are read at the ends of blocks, of a map that is a plane; bent ones at every pixel, of any map."""
    rng = np.random.default_rng(width)
    light_lx = rng.random((CELLS, CELLS, CHANNELS)).astype(np.float32)
    columns, rows = rng.uniform(40, 80, (2, width)).astype(np.float32)
    if is_plain:
        plane = np.add.outer(np.arange(CELLS), 2 * np.arange(CELLS))
        light_lx = (plane[..., None] + np.arange(CHANNELS)).astype(np.float32)
        columns, rows = (np.linspace(a, b, width, dtype=np.float32) for a, b in ((40, 60), (70, 66)))
    lamps = LampArrays(
        light_lx.reshape(-1, CHANNELS), CELLS, np.float32(1), *np.ones((2, 3), np.float32), np.float32(8)
    )
    normal = rng.random((3, width)).astype(np.float32)
    lamp_lx, head_lx = np.empty((2, width), np.float32)
    lamp_row(lamps, columns, rows, np.zeros(width, np.float32), normal, new_lamp_scratch(width), lamp_lx, head_lx)
    at = [rows - 0.5, columns - 0.5]
    read = np.stack([map_coordinates(each, at, order=1) for each in np.moveaxis(light_lx, -1, 0)])
    np.testing.assert_allclose(lamp_lx, (normal * read[:3]).sum(axis=0), rtol=1e-4)
    np.testing.assert_allclose(head_lx, (normal * read[3:]).sum(axis=0), rtol=1e-4)
