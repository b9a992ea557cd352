"""The land goes on: no view from a helicopter ends in an empty edge, and nothing of it stands in the town."""

from __future__ import annotations

import numpy as np
import pytest

from scenarios.road_town.presets import ALTITUDE_RANGE_M
from scenarios.road_town.town import HILLS_M, TO_CREST_M, Hills, add_countryside
from sim.mesh import Texture
from sim.meshes.ground import ground
from sim.optics import look_down_pose
from sim.render.protocol import create_renderer
from sim.rng import generator
from sim.world import World
from tests.sim.ray_casting import away_from_edges
from trackers.types import CameraModel

EXTENT_M = 420.0
CAMERA = CameraModel.from_field_of_view(64, 48, np.deg2rad(50))


@pytest.fixture(scope="module")
def world():
    world = World()
    town = ground(EXTENT_M, Texture(np.full((4, 4, 3), 90, np.uint8)))
    world.add(town, np.eye(4), name="ground", category="ground")
    add_countryside(world, EXTENT_M, generator(5, "town"))
    return world


def test_there_is_land_in_all_directions_up_to_the_horizon(world):
    """From anywhere over the town, at the greatest height, every ray that is level or points down meets land."""
    renderer = create_renderer("raster", world)
    rng = generator(1, "views")
    for _ in range(24):
        place_m = np.array([*rng.uniform(-210.0, 210.0, 2), ALTITUDE_RANGE_M[1]])
        yaw, tilt, roll = (
            rng.uniform(0.0, 2 * np.pi),
            np.deg2rad(rng.uniform(50.0, 95.0)),
            np.deg2rad(rng.normal(0, 10)),
        )
        T_world_camera = look_down_pose(place_m, yaw, tilt, roll)
        seen = renderer.gbuffer(CAMERA, T_world_camera)
        columns, rows = np.meshgrid(np.arange(64) + 0.5, np.arange(48) + 0.5)
        rays = np.stack([columns - 32.0, rows - 24.0, np.full(columns.shape, CAMERA.focal_px)], axis=-1)
        is_level = (rays @ T_world_camera[:3, :3].T)[..., 2] <= 0.0
        assert is_level.any()
        assert np.isfinite(seen.depth_m[is_level]).all()


@pytest.mark.parametrize("extent_m", [EXTENT_M, 1000.0, 1599.0])
def test_a_town_of_any_size_lies_level_in_the_valley(extent_m):
    hills = Hills(extent_m, generator(2, "town"))
    corner_m, crest_m = extent_m / np.sqrt(2.0), hills.valley_radius_m + TO_CREST_M
    angle = np.linspace(0.0, 2.0 * np.pi, 100)
    for radius_m, low_m, high_m in ((corner_m, 0.0, 0.0), (crest_m, *HILLS_M), (crest_m + 700.0, *HILLS_M)):
        height_m = hills.height_m(radius_m * np.cos(angle), radius_m * np.sin(angle))
        assert (height_m >= low_m).all()
        assert (height_m <= high_m).all()


def test_woods_and_hedges_keep_out_of_the_town(world):
    for body in world.bodies:
        if body.category in ("wood", "hedge"):
            assert np.abs(body.mesh.vertices_m[:, :2]).max(axis=1).min() > 0.5 * EXTENT_M, body.name


def test_both_renderers_see_the_same_land(world):
    camera = CameraModel.from_field_of_view(160, 120, np.deg2rad(50))
    for yaw in (0.3, 2.4):
        T_world_camera = look_down_pose(np.array([60.0, -40.0, 90.0]), yaw, np.deg2rad(72.0), 0.05)
        raster, reference = (create_renderer(n, world).gbuffer(camera, T_world_camera) for n in ("raster", "pybullet"))
        differs = raster.instance_id != reference.instance_id
        assert len(np.unique(raster.instance_id)) > 5
        assert not (differs & away_from_edges(raster.instance_id)).any()
        near = ~differs & (raster.depth_m < 500.0)
        assert (np.abs(raster.depth_m - reference.depth_m)[near] < 0.5).mean() > 0.99
