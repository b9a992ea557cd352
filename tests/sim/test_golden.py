"""Finished pictures against kept ones, see ``tests.golden_picture``."""

from __future__ import annotations

import numpy as np
import pytest

from sim.optics import PinholeCamera, look_down_pose
from sim.render.pipeline import capture
from sim.render.raster import Raster
from sim.sensors.camera_sensor import CameraSensor
from sim.sensors.config import SensorConfig
from sim.shaders.daylight import DaylightShader, Sun
from tests.golden_picture import differences, require_kept

CAMERA = PinholeCamera.from_field_of_view(320, 240, np.radians(60))
VIEWS = {
    "from_above": (look_down_pose(np.array([5.0, 8.0, 60.0]), 0.3, 0.2, -0.1), Sun((0.5, 0.3, 0.6), 8e4)),
    "low_sun": (look_down_pose(np.array([-40.0, 0.0, 25.0]), 0.2, 1.2, 0.1), Sun((0.6, -0.9, 0.3), 5e4)),
}


def _picture(town, name: str) -> np.ndarray:
    T_world_camera, sun = VIEWS[name]
    shader = DaylightShader(town, sun, 1.5e4)
    sensor = CameraSensor(SensorConfig(), np.random.default_rng(1))
    raster = Raster(town)
    # The second picture comes out of the fused pipeline.
    capture(raster, shader, sensor, CAMERA, T_world_camera, 0)
    return capture(raster, shader, sensor, CAMERA, T_world_camera, 1).picture.image_rgb


@pytest.mark.parametrize("name", VIEWS)
def test_picture_is_the_kept_one(town, name, request):
    require_kept(_picture(town, name), name, request)


def test_the_comparison_can_fail(town):
    picture = _picture(town, "from_above")
    brighter = np.clip(picture.astype(int) + 2, 0, 255)
    shifted = np.roll(picture, 1, axis=1)
    assert differences(brighter, picture)[0] > 0.9
    assert differences(shifted, picture)[0] > 0.3
