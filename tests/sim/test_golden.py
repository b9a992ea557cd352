"""Finished pictures against kept ones.

A pixel may differ by 1 of 255. One in 2,000 may differ by more: another processor rounds elsewhere, so that a point
falls on the other side of an edge. Where a test fails, the picture and the (tenfold) difference are left in
``results/golden``; ``pytest --new-golden`` makes the kept pictures anew, which then must be looked at.
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from sim.optics import PinholeCamera, look_down_pose
from sim.render.pipeline import capture
from sim.render.raster import Raster
from sim.sensors.camera_sensor import CameraSensor
from sim.sensors.config import SensorConfig
from sim.shaders.daylight import DaylightShader, Sun
from tests.sim.demo_scene import build_town

KEPT = Path(__file__).parent.parent / "golden"
FAILED = Path(__file__).parent.parent.parent / "results" / "golden"
CAMERA = PinholeCamera.from_field_of_view(320, 240, np.radians(60))
VIEWS = {
    "from_above": (look_down_pose(np.array([5.0, 8.0, 60.0]), 0.3, 0.2, -0.1), Sun((0.5, 0.3, 0.6), 8e4)),
    "low_sun": (look_down_pose(np.array([-40.0, 0.0, 25.0]), 0.2, 1.2, 0.1), Sun((0.6, -0.9, 0.3), 5e4)),
}


def _differences(picture: np.ndarray, kept: np.ndarray) -> tuple[float, np.ndarray]:
    """Return the share of pixels that differ by more than 1, and the difference (H, W, 3)."""
    difference = np.abs(picture.astype(int) - kept)
    return float((difference.max(axis=-1) > 1).mean()), difference


@pytest.fixture(scope="module")
def town():
    with build_town(np.random.default_rng(5), extent_m=200, houses=30, cars=12, trees=20) as world:
        yield world


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
    picture, path = _picture(town, name), KEPT / f"{name}.png"
    if request.config.getoption("--new-golden"):
        cv2.imwrite(str(path), picture[..., ::-1])
        pytest.skip(f"{path} made anew")
    wrong, difference = _differences(picture, cv2.imread(str(path))[..., ::-1])
    if wrong > 5e-4:
        FAILED.mkdir(parents=True, exist_ok=True)
        cv2.imwrite(str(FAILED / f"{name}.png"), picture[..., ::-1])
        tenfold = np.clip(10 * difference, 0, 255).astype(np.uint8)
        cv2.imwrite(str(FAILED / f"{name}-difference.png"), tenfold[..., ::-1])
    assert wrong <= 5e-4


def test_the_comparison_can_fail(town):
    picture = _picture(town, "from_above")
    brighter = np.clip(picture.astype(int) + 2, 0, 255)
    shifted = np.roll(picture, 1, axis=1)
    assert _differences(brighter, picture)[0] > 0.9
    assert _differences(shifted, picture)[0] > 0.3
