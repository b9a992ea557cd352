"""Smoothed edges against the mean of a picture with many times as many pixels."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim.mesh import Texture, TexturedMesh
from sim.optics import look_down_pose
from sim.render.pipeline import capture, radiance_of
from sim.render.raster import Raster
from sim.sensors.camera_sensor import CameraSensor
from sim.sensors.config import SensorConfig
from sim.shaders.daylight import DaylightShader, Sun
from sim.world import World
from trackers.types import CameraModel

CAMERA = CameraModel.from_field_of_view(64, 48, np.radians(55))
FINE = 16
SUN = Sun((0.5, 0.3, 0.6), 80_000.0)


def _sheet(angle_rad: float, shift_m: float, height_m: float, grey: int) -> TexturedMesh:
    """A large square, one of whose sides runs at an angle, ``shift_m`` from the origin."""
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    local = np.array([shift_m, 0.0]) + np.array([[0, -60], [120, -60], [120, 60], [0, 60]])
    corners = np.column_stack([local @ [[c, s], [-s, c]], np.full(4, height_m)]).astype(np.float32)
    normals = np.tile(np.float32([0, 0, 1]), (4, 1))
    texture = Texture(np.full((1, 1, 3), grey, np.uint8))
    faces = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    return TexturedMesh(corners, normals, np.full((4, 2), 0.5, np.float32), faces, texture)


def _fine_mean(renderer, shader, T_world_camera, camera=CAMERA):
    fine = CameraModel(FINE * camera.width_px, FINE * camera.height_px, FINE * camera.focal_px)
    radiance = radiance_of(renderer, shader, fine, T_world_camera, smooth=False)
    blocks = radiance.reshape(camera.height_px, FINE, 3, camera.width_px, FINE)
    return blocks.mean(axis=(1, 4), dtype=np.float64)


@settings(max_examples=25, deadline=None)
@given(st.floats(0, 2 * np.pi), st.floats(-0.5, 0.5), st.sampled_from([0.0, 3.0]))
def test_an_edge_at_any_angle_divides_pixels_by_area(angle_rad, shift_m, above_m):
    world = World()
    # Below a higher sheet the ground goes on.
    below_m = 20.0 if above_m else 0.0
    world.add(_sheet(angle_rad + np.pi, -shift_m - below_m, 0.0, 40), np.eye(4), name="dark", category="ground")
    world.add(_sheet(angle_rad, shift_m, above_m, 220), np.eye(4), name="bright", category="ground")
    renderer, shader = Raster(world), DaylightShader(world, Sun((0, 0, 1), 80_000.0), 15_000.0)
    pose = look_down_pose(np.array([0.0, 0.0, 30.0]), 0.0, 0.0, 0.0)
    sharp, smooth = (radiance_of(renderer, shader, CAMERA, pose, smooth=each) for each in (False, True))
    step = sharp.max() - sharp.min()
    # At the picture's border the other side of an edge may lie outside.
    inside = np.s_[1:-1, :, 1:-1]
    sharp, smooth, exact = sharp[inside], smooth[inside], _fine_mean(renderer, shader, pose)[inside]
    # By area an edge at 45° cuts corners off that its place along one axis does not tell: an eighth of a pixel.
    assert np.abs(smooth - exact).max() < 0.13 * step + 1.5 * step / FINE
    # A mean of 16 x 16 samples is itself wrong by up to 1/32 of the step along the edge.
    of_samples = 3 * CAMERA.width_px * step / (2 * FINE)
    # At 45° half of the error stays.
    assert np.abs(smooth - exact).sum() < 0.5 * np.abs(sharp - exact).sum() + of_samples


def test_a_town_comes_near_the_mean_of_many_samples(town):
    renderer, shader = Raster(town), DaylightShader(town, SUN, 15_000.0)
    camera = CameraModel.from_field_of_view(160, 120, np.radians(55))
    pose = look_down_pose(np.array([2.0, 8.0, 40.0]), 0.3, 0.05, 0.3)
    sharp, smooth = (radiance_of(renderer, shader, camera, pose, smooth=each) for each in (False, True))
    exact = _fine_mean(renderer, shader, pose, camera)
    ids = renderer.gbuffer(camera, pose).instance_id
    border = np.zeros(ids.shape, bool)
    border[:, 1:] |= ids[:, 1:] != ids[:, :-1]
    border[1:] |= ids[1:] != ids[:-1]
    errors = [np.abs(each - exact).mean(axis=1)[border].mean() for each in (sharp, smooth)]
    assert errors[1] < 0.35 * errors[0]
    # Inside surfaces nothing is averaged.
    changed = (sharp != smooth).any(axis=1)
    assert 0.2 * border.mean() < changed.mean() < 0.2


def test_ids_and_depth_stay_those_of_the_centres(town):
    def taken(smooth):
        sensor = CameraSensor(SensorConfig(), np.random.default_rng(3))
        renderer, shader = Raster(town), DaylightShader(town, SUN, 15_000.0)
        pose = look_down_pose(np.array([2.0, 8.0, 60.0]), 0.3, 0.05, 0.3)
        return capture(renderer, shader, sensor, CAMERA, pose, 0, smooth=smooth)

    sharp, smooth = taken(False), taken(True)
    np.testing.assert_array_equal(sharp.depth_m, smooth.depth_m)
    np.testing.assert_array_equal(sharp.instance_id, smooth.instance_id)
    assert (sharp.picture.image_rgb != smooth.picture.image_rgb).any()
    assert sharp.picture.image_rgb.astype(int).mean() == pytest.approx(smooth.picture.image_rgb.mean(), rel=0.02)


def test_rows_on_their_way_and_a_whole_film_are_smoothed_alike(town):
    sensor = CameraSensor(SensorConfig(), np.random.default_rng(3))
    renderer, shader = Raster(town), DaylightShader(town, SUN, 15_000.0)
    pose = look_down_pose(np.array([2.0, 8.0, 60.0]), 0.3, 0.05, 0.3)
    # The first picture, of which the exposure is not known before, is lit as a whole.
    first = capture(renderer, shader, sensor, CAMERA, pose, 0, smooth=True)
    sensor.hold(exposure=True, white_balance=True)
    again = capture(renderer, shader, sensor, CAMERA, pose, 0, smooth=True)
    assert not sensor.needs_whole(CAMERA, None, None)
    # The light was measured after edges were smoothed, and now before.
    np.testing.assert_allclose(again.picture.image_rgb.astype(int), first.picture.image_rgb, atol=1)
