"""Controllers of the ground robot turn to their target, keep their distance, search for it, and stay finite."""

from __future__ import annotations

import numpy as np
import pytest

from scenarios.stereo_follow.camera import camera, camera_pose
from trackers.controllers.catalogue import controllers
from trackers.types import CameraModel, EgoPose, Estimate, Observation

CAMERA = camera(640, 480)
NAMES = ("centre", "search", "reentry")
RATE_HZ = 15.0
PARTS = ("forward_mps", "right_mps", "climb_mps", "yaw_rate_rad_s")


def _observation(frame, place_m=(0.0, 0.0), heading_rad=0.0):
    pose = EgoPose(camera_pose(np.array(place_m), heading_rad))
    model = CameraModel(640, 480, CAMERA.focal_px, 0.12)
    return Observation(np.zeros((480, 640, 3), np.uint8), frame / RATE_HZ, model, ego=pose)


def _estimate(ahead_m, left_m):
    position_px = CAMERA.centre_px + CAMERA.focal_px * np.array([-left_m / ahead_m, 0.33 / ahead_m])
    return Estimate(position_px, in_view_probability=1.0, depth_m=ahead_m)


def _nothing():
    return Estimate(np.full(2, np.nan), in_view_probability=0.0)


def _commands(name, estimates, drives=False):
    """Return commands (F, 4) of a controller as written; a robot that drives obeys them at once."""
    controller = controllers("robot")[name].create_as_written()
    place_m, heading_rad, commands = np.zeros(2), 0.0, []
    for frame, estimate in enumerate(estimates):
        command = controller.command(_observation(frame, place_m, heading_rad), estimate)
        commands.append([getattr(command, part) for part in PARTS])
        if drives:
            heading_rad += command.yaw_rate_rad_s / RATE_HZ
            place_m = place_m + command.forward_mps / RATE_HZ * np.array([np.cos(heading_rad), np.sin(heading_rad)])
    return np.array(commands)


@pytest.mark.parametrize("name", NAMES)
def test_mirrored_targets_give_mirrored_commands(name):
    walked = [(2.0 + 0.03 * frame, 0.2 + 0.02 * frame) for frame in range(30)]
    estimates = [[_estimate(ahead, side * left) for ahead, left in walked] + [_nothing()] * 20 for side in (1, -1)]
    left, right = (_commands(name, each) for each in estimates)
    np.testing.assert_allclose(left[:, 3], -right[:, 3], atol=1e-9)
    np.testing.assert_allclose(left[:, :3], right[:, :3], atol=1e-9)
    assert left[29, 3] > 0.1


@pytest.mark.parametrize("name", NAMES)
def test_without_any_estimate_commands_are_finite(name):
    commands = _commands(name, [_nothing()] * 40)
    assert np.isfinite(commands).all()
    assert (commands[:, :3] == 0.0).all()


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("distance_m", [0.15, 0.5, 0.9])
def test_too_near_it_stops_or_backs_off(name, distance_m):
    commands = _commands(name, [_estimate(distance_m, 0.0)] * 15)
    assert (commands[:, 0] <= 0.0).all()
    assert np.abs(commands[:, 3]).max() < 0.05


@pytest.mark.parametrize("name", NAMES)
def test_far_away_it_goes_there(name):
    assert _commands(name, [_estimate(5.0, 0.0)] * 15)[-1, 0] > 0.5


@pytest.mark.parametrize("name", ["search", "reentry"])
def test_lost_to_the_left_it_turns_left(name):
    walked = [_estimate(2.0, 0.2 + 0.07 * frame) for frame in range(15)]
    commands = _commands(name, walked + [_nothing()] * 8)
    assert (commands[15:, 3] > 0.2).all()


def test_reentry_turns_ahead_of_a_target_that_walks_aside():
    moving = _commands("reentry", [_estimate(1.8, 0.06 * (frame - 20)) for frame in range(21)])
    standing = _commands("reentry", [_estimate(1.8, 0.0)] * 21)
    # In the middle of the picture right now, near enough to stay.
    assert moving[-1, 3] > standing[-1, 3] + 0.1


def test_reentry_goes_where_the_target_was_lost_and_looks_around_there():
    walked = [_estimate(3.0 + 0.03 * frame, 0.0) for frame in range(20)]
    controller = controllers("robot")["reentry"].create_as_written()
    place_m, heading_rad, looked = np.zeros(2), 0.0, []
    for frame in range(400):
        estimate = walked[frame] if frame < len(walked) else _nothing()
        # The robot moves only after the target is lost, so ``walked`` is relative to its start.
        command = controller.command(_observation(frame, place_m, heading_rad), estimate)
        if frame >= len(walked):
            heading_rad += command.yaw_rate_rad_s / RATE_HZ
            forward = np.array([np.cos(heading_rad), np.sin(heading_rad)])
            place_m = place_m + np.clip(command.forward_mps, -1.6, 1.6) / RATE_HZ * forward
            looked.append(heading_rad)
    assert np.linalg.norm(place_m - [4.0, 0.0]) < 1.0
    # All around, and not at one and the same direction in the end.
    sectors = np.unique(np.round(np.array(looked) / (np.pi / 4)).astype(int) % 8)
    assert len(sectors) >= 6


def test_reentry_follows_the_trail_where_the_straight_path_is_blocked():
    """The target goes ahead and then left; the robot, blocked by a wall on the straight path, turns to its trail."""
    controller = controllers("robot")["reentry"].create_as_written()
    corner = [(1.0 + 0.08 * step, 0.0) for step in range(25)] + [(3.0, 0.08 * step) for step in range(25)]
    for frame, (x_m, y_m) in enumerate(corner):
        command = controller.command(_observation(frame), _estimate(x_m, y_m))
    towards_target = controllers("robot")["centre"].create_as_written().command(_observation(0), _estimate(x_m, y_m))
    assert command.yaw_rate_rad_s < towards_target.yaw_rate_rad_s
