"""The preset ``quick`` in closed loop, without pictures: steering at random loses what a robot at rest keeps."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from scenarios.stereo_follow.crowd import Crowd, draw_crowd
from scenarios.stereo_follow.floor_plan import FloorPlan, draw_floor_plan
from scenarios.stereo_follow.presets import PRESETS
from scenarios.stereo_follow.robot import FASTEST_MPS, FASTEST_TURN_RAD_S, Robot
from scenarios.stereo_follow.sight import is_in_sight
from sim.rng import generator
from trackers.types import CameraCommand

QUICK = PRESETS["quick"]
Steering = Callable[[Robot, NDArray[np.float64]], CameraCommand]


def _seen_share(plan: FloorPlan, crowd: Crowd, steer: Steering) -> float:
    robot = Robot(plan, crowd.robot_m[0], crowd.robot_heading_rad[0], QUICK.rate_hz)
    target_m, *others_m = (walk.place_m for walk in crowd.walks)
    seen = 0
    for frame, place_m in enumerate(target_m):
        among_m = np.array([other_m[frame] for other_m in others_m]).reshape(-1, 2)
        seen += is_in_sight(robot.place_m, robot.heading_rad, place_m, among_m, plan.openings_m)
        robot.drive(steer(robot, place_m))
    return seen / len(target_m)


def _following(robot: Robot, place_m: NDArray[np.float64]) -> CameraCommand:
    """Turn towards the target and keep 1.6 m from it."""
    sight_m = place_m - robot.place_m
    bearing_rad = (np.arctan2(*sight_m[::-1]) - robot.heading_rad + np.pi) % (2 * np.pi) - np.pi
    return CameraCommand(forward_mps=float(np.hypot(*sight_m) - 1.6), yaw_rate_rad_s=2.0 * float(bearing_rad))


@pytest.mark.heavy
def test_random_commands_lose_the_target_more_than_rest_and_rest_more_than_following() -> None:
    shares = []
    for seed in range(50):
        plan = draw_floor_plan(generator(seed, "floor plan"))
        crowd = draw_crowd(QUICK, plan, generator(seed, "crowd"))
        rng = np.random.default_rng(seed)

        def at_random(robot: Robot, place_m: NDArray[np.float64], rng: np.random.Generator = rng) -> CameraCommand:
            forward, turn = rng.uniform(-1.0, 1.0, 2)
            return CameraCommand(forward_mps=forward * FASTEST_MPS, yaw_rate_rad_s=turn * FASTEST_TURN_RAD_S)

        steerings = (at_random, lambda robot, place_m: CameraCommand(), _following)
        shares.append([_seen_share(plan, crowd, steer) for steer in steerings])
    random, rest, following = np.mean(shares, axis=0)
    assert random < rest - 0.04
    assert rest < following - 0.08
    assert following > 0.75
