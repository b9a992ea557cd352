"""The kernels move carriers, pass commands on and measure ways exactly as the rendered env does."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numba import njit
from scipy.spatial.transform import Rotation

from scenarios.command_link import CommandLink, Link
from scenarios.envs.pictureless.drive_kernel import drive, look_ahead, measure
from scenarios.envs.pictureless.flight_kernel import fly, look_down
from scenarios.envs.pictureless.life import LIFE
from scenarios.envs.pictureless.link_kernel import send
from scenarios.envs.pictureless.poses import turned
from scenarios.envs.pictureless.worlds import command_limits
from scenarios.road_town.flight import HELICOPTER, AirState, Helicopter, Pulse
from scenarios.road_town.presets import RoadTown
from scenarios.stereo_follow.camera import camera_pose
from scenarios.stereo_follow.floor_plan import draw_floor_plan
from scenarios.stereo_follow.odometry import Odometry
from scenarios.stereo_follow.robot import ROBOT, Robot
from trackers.types import CameraCommand

RATE_HZ = 15.0


@njit
def obey(lives: Any, wanted: Any) -> None:
    for axis in range(4):
        lives[0].obeyed[axis] = wanted[axis]


@njit
def fly_one(lives: Any, attitude_rad: Any, rng: Any, scratch: Any) -> None:
    fly(lives[0], 1.0 / RATE_HZ)
    look_down(lives[0], attitude_rad, 0.0, 0.0, rng, scratch)


@njit
def drive_one(lives: Any, free_m: Any, rng: Any) -> None:
    life = lives[0]
    x_m, y_m, yaw_rad = life.place_m[0], life.place_m[1], life.yaw_rad
    drive(life, free_m, 1.0 / RATE_HZ)
    measure(life, x_m, y_m, yaw_rad, rng)
    look_ahead(life, rng)


@njit
def send_one(lives: Any, wanted: Any, limits: Any, steps: Any, waiting: Any, rng: Any) -> None:
    send(lives[0], wanted, limits, steps, waiting, 0.0, rng)
    lives[0].steps += 1


def test_helicopters_fly_alike() -> None:
    rng = np.random.default_rng(3)
    air = AirState(70.0, rng.normal(0, 0.1, (300, 3)), np.zeros((300, 2)), np.full(300, 0.7))
    pulse = Pulse(50, 6, 20, 8, (30.0, -20.0), True)
    helicopter = Helicopter(RoadTown(""), air, [pulse], np.array([5.0, -3.0]))
    lives, scratch = np.zeros(1, LIFE), np.zeros(3)
    lives["place_m"], lives["yaw_rad"] = [5.0, -3.0, 70.0], 0.7
    attitude_rad = helicopter._attitude_rad
    for frame in range(1, 300):
        # Now and then beyond every limit, long enough to reach the lowest height.
        command = rng.normal([0, 0, -4, 0], [25, 25, 6, 1])
        helicopter.fly(CameraCommand(*command))
        obey(lives, command)
        fly_one(lives, attitude_rad[frame], rng, scratch)
        pose = helicopter.pose(frame)
        np.testing.assert_allclose(lives["R"][0], pose[:3, :3], atol=1e-9)
        np.testing.assert_allclose(lives["camera_m"][0], pose[:3, 3], atol=1e-9)
    assert lives["place_m"][0, 2] == pytest.approx(40.0)


def test_robots_drive_slide_and_measure_alike() -> None:
    rng = np.random.default_rng(4)
    plan = draw_floor_plan(rng)
    free_m = np.array([[a.x0, a.y0, a.x1, a.y1] for a in plan.free_parts])
    start_m = np.array([plan.hall.x1 - 1.3, 0.5 * (plan.hall.y0 + plan.hall.y1)])
    robot, odometry = Robot(plan, start_m, 0.2, RATE_HZ), Odometry(np.random.default_rng(9))
    odometry.measure(robot.place_m, robot.heading_rad)
    slips = np.random.default_rng(9)
    lives = np.zeros(1, LIFE)
    lives["odometry_scales"] = 1.0 + np.array([0.01, 0.02]) * slips.normal(size=2)
    lives["place_m"][0, :2], lives["yaw_rad"] = start_m, 0.2
    touched = 0
    for _ in range(400):
        command = np.array([rng.normal(0.8, 1.0), 0.0, 0.0, rng.normal(0.0, 1.5)])
        before_m = robot.place_m.copy()
        robot.drive(CameraCommand(forward_mps=command[0], yaw_rate_rad_s=command[3]))
        touched += abs(np.linalg.norm(robot.place_m - before_m) * RATE_HZ - abs(robot._speed_mps)) > 1e-6
        obey(lives, command)
        # Slips are drawn in the same order; the camera's shaking after them must not disturb that.
        state = slips.bit_generator.state
        drive_one(lives, free_m, slips)
        slips.bit_generator.state = state
        slips.normal(size=2)
        believed = odometry.measure(robot.place_m, robot.heading_rad)
        np.testing.assert_allclose(lives["place_m"][0, :2], robot.place_m, atol=1e-9)
        np.testing.assert_allclose(lives["R_measured"][0], believed[:3, :3], atol=1e-9)
        np.testing.assert_allclose(lives["camera_measured_m"][0], believed[:3, 3], atol=1e-9)
        shaken = camera_pose(robot.place_m, robot.heading_rad, *lives["shake_rad"][0])
        np.testing.assert_allclose(lives["R"][0], shaken[:3, :3], atol=1e-9)
    assert touched > 5, "it never slid along a wall"


@pytest.mark.parametrize("carrier", [HELICOPTER, ROBOT], ids=lambda carrier: carrier.name)
@pytest.mark.parametrize("delay", [0, 3])
def test_links_pass_the_same_on(carrier: Any, delay: int) -> None:
    rng = np.random.default_rng(5)
    link = CommandLink(carrier, RATE_HZ, Link(delay_frames=delay), rng)
    limits, steps = command_limits(carrier, 1.0 / RATE_HZ)
    lives, waiting = np.zeros(1, LIFE), np.zeros((delay, 4))
    for _ in range(60):
        command = rng.normal(0, [20, 20, 5, 1])
        given = link.send(CameraCommand(*command))
        send_one(lives, command, limits, steps, waiting, rng)
        expected = [given.forward_mps, given.right_mps, given.climb_mps, given.yaw_rate_rad_s]
        np.testing.assert_allclose(lives["obeyed"][0], expected, atol=1e-12)


def test_small_turns_are_rotations() -> None:
    rng = np.random.default_rng(6)
    for scale in (1e-14, 1e-3, 2.0):
        R, vector, out = Rotation.random(rng=rng).as_matrix(), rng.normal(0, scale, 3), np.zeros((3, 3))
        turned(R, vector, out)
        np.testing.assert_allclose(out, R @ Rotation.from_rotvec(vector).as_matrix(), atol=1e-12)
