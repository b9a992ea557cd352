"""The kernel's motion and odometry equal those of the rendered env."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numba import njit

from scenarios.stereo_follow.camera import camera_pose
from scenarios.stereo_follow.floor_plan import draw_floor_plan
from scenarios.stereo_follow.pictureless.world import DRIVE_STATE, drive, look_ahead
from scenarios.stereo_follow.rig import Odometry
from scenarios.stereo_follow.robot import Robot
from trackers.types import CameraCommand

RATE_HZ = 15.0


@njit
def drive_one(states: Any, wanted: Any, free_m: Any, rng: Any) -> None:
    states[0].obeyed[0], states[0].obeyed[3] = wanted[0], wanted[1]
    drive(states[0], free_m, 1.0 / RATE_HZ, rng)
    look_ahead(states[0], rng)


@pytest.mark.heavy
def test_robots_drive_and_measure_alike() -> None:
    rng = np.random.default_rng(4)
    plan = draw_floor_plan(rng)
    start_m = np.array([plan.hall.x1 - 1.3, 0.5 * (plan.hall.y0 + plan.hall.y1)])
    robot, odometry = Robot(plan, start_m, 0.2, RATE_HZ), Odometry(np.random.default_rng(9))
    odometry.measure(robot.place_m, robot.heading_rad)
    slips = np.random.default_rng(9)
    states = np.zeros(1, DRIVE_STATE)
    states["odometry_scales"] = 1.0 + np.array([0.01, 0.02]) * slips.normal(size=2)
    states["place_m"][0, :2], states["yaw_rad"] = start_m, 0.2
    for _ in range(400):
        command = rng.normal([0.8, 0.0], [1.0, 1.5])
        robot.drive(CameraCommand(forward_mps=command[0], yaw_rate_rad_s=command[1]))
        # Slips are drawn in the same order; the draws of the camera's shaking come after them.
        state = slips.bit_generator.state
        drive_one(states, command, plan.free_m, slips)
        slips.bit_generator.state = state
        slips.normal(size=2)
        believed = odometry.measure(robot.place_m, robot.heading_rad)
        assert (states["place_m"][0, :2] == robot.place_m).all()
        np.testing.assert_allclose(states["R_measured"][0], believed[:3, :3], atol=1e-9)
        np.testing.assert_allclose(states["camera_measured_m"][0], believed[:3, 3], atol=1e-9)
        shaken = camera_pose(robot.place_m, robot.heading_rad, *states["shake_rad"][0])
        np.testing.assert_allclose(states["R"][0], shaken[:3, :3], atol=1e-9)
