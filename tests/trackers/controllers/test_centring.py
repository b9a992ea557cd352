"""Controllers ``centre`` and ``search`` of a helicopter."""

from __future__ import annotations

import numpy as np
import pytest

from sim.optics import look_down_pose, project
from trackers.controllers.centring import (
    CentreController,
    CentreParameters,
    SearchController,
    SearchParameters,
    expanding_square,
)
from trackers.types import CameraModel, EgoPose, Estimate, Observation

CAMERA = CameraModel.from_field_of_view(640, 480, np.deg2rad(50))


CAMERA_M = np.array([5.0, -3.0, 50.0])


def _observation(T, with_ego=True, time_s=0.0):
    camera, ego = CameraModel(640, 480, CAMERA.focal_px), EgoPose(T) if with_ego else None
    return Observation(np.zeros((480, 640, 3), np.uint8), time_s, camera, ego=ego)


def _command(place_m, yaw=0.0, pitch=0.0, roll=0.0, mount=0.0, with_ego=True):
    """Return the command on a second picture; the camera was level on the first one, but for its mount."""
    level = look_down_pose(CAMERA_M, yaw, mount, 0.0)
    tilted = look_down_pose(CAMERA_M, yaw, mount + pitch, roll)
    controller = CentreController(CentreParameters())
    controller.command(_observation(level, with_ego), Estimate(np.full(2, np.nan)))
    pixel, _ = project(CAMERA, tilted, np.array([*place_m, 0.0]))
    return controller.command(_observation(tilted, with_ego, 1 / 15), Estimate(pixel))


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


@pytest.mark.parametrize("yaw", [0.0, 1.3])
@pytest.mark.parametrize("pitch", [0.0, -0.4])
def test_under_a_camera_pitched_forward_it_keeps_behind_the_target_and_turns_the_nose_to_it(yaw, pitch):
    mount, nose = np.deg2rad(45.0), np.array([np.cos(yaw), np.sin(yaw)])
    # The axis of a level camera meets the ground 50 m ahead.
    there = _command(CAMERA_M[:2] + 50.0 * nose, yaw, pitch, mount=mount)
    np.testing.assert_allclose([there.forward_mps, there.right_mps, there.yaw_rate_rad_s], 0.0, atol=1e-6)
    to_right = np.array([nose[1], -nose[0]])
    aside = _command(CAMERA_M[:2] + 54.0 * nose + 5.0 * to_right, yaw, pitch, mount=mount)
    gain_per_s = CentreParameters().gain_per_s
    np.testing.assert_allclose([aside.forward_mps, aside.right_mps], [4.0 * gain_per_s, 5.0 * gain_per_s], atol=1e-6)
    assert aside.yaw_rate_rad_s == pytest.approx(-CentreParameters().turn_per_s * np.arctan2(5.0, 54.0))


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


T = look_down_pose(np.array([5.0, -3.0, 50.0]), 0.4, 0.1, 0.0)


def _observed(k):
    return Observation(np.zeros((2, 2, 3), np.uint8), k / 15, CameraModel(640, 480, CAMERA.focal_px), ego=EgoPose(T))


def _estimate(place_m, seen, spread_px=5.0):
    pixel, _ = project(CAMERA, T, np.array([*place_m, 0.0]))
    return Estimate(pixel, in_view_probability=float(seen), covariance_px=spread_px**2 * np.eye(2))


def test_known_it_is_centre():
    search, centre = SearchController(SearchParameters()), CentreController(CentreParameters())
    for k in range(90):
        # Out of view most of the time, but its position is known.
        estimate = _estimate((8.0 + 0.1 * k, -3.0), seen=k < 10)
        assert search.command(_observed(k), estimate) == centre.command(_observed(k), estimate)


@pytest.mark.parametrize("silent", [False, True])
def test_lost_it_flies_about_the_place_last_seen(silent):
    search = SearchController(SearchParameters(patience_s=1.0))
    for k in range(10):
        search.command(_observed(k), _estimate((5.0, -3.0), seen=True))
    lost = Estimate(np.full(2, np.nan)) if silent else _estimate((60.0, 40.0), seen=False, spread_px=600.0)
    commands = [search.command(_observed(k), lost) for k in range(10, 200)]
    velocity_mps = np.array([[command.forward_mps, command.right_mps] for command in commands[20:]])
    assert np.isfinite(velocity_mps).all()
    assert np.hypot(*velocity_mps.T).max() <= SearchParameters().fastest_mps + 1e-9
    # The square goes all around.
    assert (velocity_mps.max(axis=0) > 5.0).all()
    assert (velocity_mps.min(axis=0) < -5.0).all()


def test_the_square_expands():
    corners = [expanding_square(way, 2.0) for way in (0.0, 2.0, 4.0, 8.0, 12.0, 18.0)]
    np.testing.assert_allclose(corners, [[0, 0], [2, 0], [2, 2], [-2, 2], [-2, -2], [4, -2]], atol=1e-12)
