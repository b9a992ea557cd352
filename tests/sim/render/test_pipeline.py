"""The fused pipeline against its own stages, and pictures against kept ones."""

from __future__ import annotations

import numpy as np
import pytest

from sim.labels import ground_homography, pixels_from_ground
from sim.optics import CameraMotion, look_down_pose
from sim.render.pipeline import capture
from sim.render.protocol import create_renderer
from sim.sensors.camera_sensor import CameraSensor
from sim.sensors.config import SensorConfig
from sim.shaders.daylight import DaylightShader, Sun
from sim.shaders.lamps import Lamp, LampShader, Surroundings
from trackers.types import CameraModel

CAMERA = CameraModel.from_field_of_view(320, 240, np.radians(55))
SUN = Sun((0.5, 0.3, 0.6), 80_000.0)
PATH = [look_down_pose(np.array([2.0 * k, 8.0 - k, 60.0]), 0.3 + 0.02 * k, 0.05 * k, 0.3) for k in range(6)]


def _parts(town, renderer="raster"):
    sensor = CameraSensor(SensorConfig(), np.random.default_rng(3))
    return create_renderer(renderer, town), DaylightShader(town, SUN, 15_000.0), sensor


def _staged(parts, T_world_camera, frame, camera=CAMERA, **motion):
    renderer, shader, sensor = parts
    gbuffer = renderer.gbuffer(camera, T_world_camera)
    radiance = shader.shade(gbuffer, camera, T_world_camera)
    return sensor.expose(radiance, camera, frame, **motion), gbuffer


def test_fused_pictures_are_those_of_the_stages(town):
    fused, staged = _parts(town), _parts(town)
    for frame, T_world_camera in enumerate(PATH):
        seen = capture(*fused, CAMERA, T_world_camera, frame)
        picture, gbuffer = _staged(staged, T_world_camera, frame)
        np.testing.assert_array_equal(seen.depth_m, gbuffer.depth_m)
        np.testing.assert_array_equal(seen.instance_id, gbuffer.instance_id)
        difference = np.abs(seen.picture.image_rgb.astype(int) - picture.image_rgb)
        # The compiler may round a product and a sum at once in one and not in the other; on the border of two
        # texels of a palette that decides between them.
        assert (difference > 0).mean() < 1e-3
        assert (difference > 2).mean() < 1e-4
        assert seen.picture.settings.exposure_s == pytest.approx(picture.settings.exposure_s, rel=1e-5)


@pytest.mark.heavy
@pytest.mark.parametrize("renderer", ["raster", "pybullet"])
def test_the_same_pictures_again_are_byte_identical(town, renderer):
    runs = []
    for _ in range(2):
        parts = _parts(town, renderer)
        runs.append([capture(*parts, CAMERA, pose, k).picture.image_rgb for k, pose in enumerate(PATH[:3])])
    np.testing.assert_array_equal(runs[0], runs[1])


def test_fast_motion_and_scattered_light_go_through_the_stages(town):
    motion = CameraMotion(ground_homography(*(pixels_from_ground(CAMERA, PATH[k]) for k in (0, 5))), 1e-3)
    fused, staged = _parts(town), _parts(town)
    for frame in (0, 1):
        blurred = capture(*fused, CAMERA, PATH[0], frame, motion=motion).picture
        picture, _ = _staged(staged, PATH[0], frame, motion=motion)
        np.testing.assert_array_equal(blurred.image_rgb, picture.image_rgb)
    sharp = capture(*_parts(town), CAMERA, PATH[0], 0).picture
    assert (
        np.abs(np.diff(sharp.image_rgb.astype(int), axis=1)).mean()
        > 1.1 * np.abs(np.diff(blurred.image_rgb.astype(int), axis=1)).mean()
    )
    for parts in (fused, staged):
        parts[2].config = SensorConfig(veiling_glare=0.05)
    veiled = capture(*fused, CAMERA, PATH[0], 2).picture.image_rgb
    np.testing.assert_array_equal(veiled, _staged(staged, PATH[0], 2)[0].image_rgb)
    assert veiled.min() > sharp.image_rgb.min()


def test_a_shader_without_a_row_kernel_goes_through_the_stages(town):
    shader = LampShader([Lamp((0.0, 0.0, 40.0), 1e8, 4000.0)], Surroundings(surface_m2=1e4, reflectance=0.2))
    fused, staged = ((renderer, shader, sensor) for renderer, _, sensor in (_parts(town), _parts(town)))
    for frame, T_world_camera in enumerate(PATH[:2]):
        seen = capture(*fused, CAMERA, T_world_camera, frame)
        picture, gbuffer = _staged(staged, T_world_camera, frame)
        np.testing.assert_array_equal(seen.picture.image_rgb, picture.image_rgb)
        np.testing.assert_array_equal(seen.depth_m, gbuffer.depth_m)
        assert seen.picture.settings == picture.settings
        assert picture.image_rgb.std() > 5


def test_both_renderers_give_nearly_the_same_picture(town):
    one, other = (capture(*_parts(town, name), CAMERA, PATH[2], 0) for name in ("raster", "pybullet"))
    assert (one.instance_id == other.instance_id).mean() > 0.999
    difference = np.abs(one.picture.image_rgb.astype(int) - other.picture.image_rgb)
    # The ground's grain is interpolated in one and not in the other.
    assert np.median(difference) <= 4
    means = [seen.picture.image_rgb.mean(axis=(0, 1)) for seen in (one, other)]
    np.testing.assert_allclose(*means, atol=1.0)
