"""The centring controller flies towards the estimate, with a tilted camera too."""

from __future__ import annotations

import numpy as np
import pytest

from sim.optics import PinholeCamera, look_down_pose, project
from trackers.controllers.centre import CentreController, CentreParameters
from trackers.types import CameraModel, EgoPose, Estimate, Observation

CAMERA = PinholeCamera.from_field_of_view(640, 480, np.deg2rad(50))


def _command(place_m, yaw=0.0, pitch=0.0, roll=0.0, with_ego=True):
    T = look_down_pose(np.array([5.0, -3.0, 50.0]), yaw, pitch, roll)
    pixel, _ = project(CAMERA, T, np.array([*place_m, 0.0]))
    observation = Observation(
        np.zeros((480, 640, 3), np.uint8),
        0.0,
        CameraModel(640, 480, CAMERA.focal_px),
        ego=EgoPose(T) if with_ego else None,
    )
    return CentreController(CentreParameters()).command(observation, Estimate(pixel))


@pytest.mark.parametrize(("pitch", "roll"), [(0.0, 0.0), (0.4, 0.0), (-0.3, 0.2), (0.0, -0.5)])
@pytest.mark.parametrize("yaw", [0.0, 1.3, -2.0])
def test_tilt_does_not_change_the_command(pitch, roll, yaw):
    command = _command((12.0, -3.0), yaw, pitch, roll)
    # 7 m along world x from the camera.
    np.testing.assert_allclose(
        [command.forward_mps, command.right_mps],
        CentreParameters().gain_per_s * 7.0 * np.array([np.cos(yaw), np.sin(yaw)]),
        atol=1e-6,
    )


def test_without_instruments_it_takes_the_camera_to_look_straight_down():
    command = _command((12.0, -3.0), with_ego=False)
    assert command.forward_mps == pytest.approx(CentreParameters().gain_per_s * 7.0 * 60 / 50)
    assert command.right_mps == pytest.approx(0.0, abs=1e-9)


def test_silence_and_horizon_make_it_hover():
    observation = Observation(
        np.zeros((480, 640, 3), np.uint8), 0.0, CameraModel(640, 480, CAMERA.focal_px),
        ego=EgoPose(look_down_pose(np.array([0, 0, 50.0]), 0, 1.2, 0)),
    )  # fmt: skip
    controller = CentreController(CentreParameters())
    for pixel in ([np.nan, np.nan], [320.0, -2000.0]):
        command = controller.command(observation, Estimate(np.array(pixel)))
        assert (command.forward_mps, command.right_mps) == (0.0, 0.0)
