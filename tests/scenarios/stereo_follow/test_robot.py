from __future__ import annotations

import numpy as np

from scenarios.stereo_follow.floor_plan import draw_floor_plan
from scenarios.stereo_follow.robot import Robot
from trackers.types import CameraCommand

RATE_HZ = 15.0


def test_a_robot_keeps_to_its_equations_to_the_last_bit_and_slides_along_walls() -> None:
    rng = np.random.default_rng(4)
    plan, dt = draw_floor_plan(rng), 1.0 / RATE_HZ
    heading_rad, corner = 0.25 * np.pi, plan.free_area("hall")
    place_m = np.array([corner.x1, corner.y1]) - 0.02
    robot = Robot(plan, place_m, heading_rad, RATE_HZ)
    speed_mps, turn_rad_s, ways = 0.0, 0.0, np.zeros(4, int)
    for _ in range(1500):
        command = rng.normal([0.8, 0.0], [1.0, 1.5])
        robot.drive(CameraCommand(forward_mps=command[0], right_mps=9.0, yaw_rate_rad_s=command[1]))
        wanted_mps, wanted_rad_s = np.clip(command, -1.6, 1.6)
        speed_mps += np.clip(wanted_mps - speed_mps, -1.5 * dt, 1.5 * dt)
        turn_rad_s += np.clip(wanted_rad_s - turn_rad_s, -4.0 * dt, 4.0 * dt)
        middle_rad = heading_rad + 0.5 * turn_rad_s * dt
        heading_rad += turn_rad_s * dt
        step_m = speed_mps * dt * np.array([np.cos(middle_rad), np.sin(middle_rad)])
        parts_m = place_m + np.array([step_m, [step_m[0], 0.0], [0.0, step_m[1]], [0.0, 0.0]])
        way = int(np.append(plan.is_free(parts_m[:3]), True).argmax())
        place_m, ways[way] = parts_m[way], ways[way] + 1
        speed_mps *= way < 3
        assert (robot.place_m == place_m).all()
        assert robot.heading_rad == heading_rad
    assert (ways > 5).all(), f"free, along x, along y, stopped: {ways}"
