"""The kernel flies a helicopter exactly as the rendered env does."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numba import njit

from scenarios.road_town.flight import AirState, Helicopter, Pulse
from scenarios.road_town.pictureless.world import FLIGHT_STATE, fly, look_down
from scenarios.road_town.presets import RoadTown
from trackers.types import CameraCommand

RATE_HZ = 15.0


@njit
def fly_one(
    states: Any, wanted: Any, turned_rad: float, attitude_rad: Any, mount_rad: float, rng: Any, scratch: Any
) -> None:
    for axis in range(4):
        states[0].obeyed[axis] = wanted[axis]
    fly(states[0], turned_rad, 1.0 / RATE_HZ)
    look_down(states[0], attitude_rad, mount_rad, 0.0, 0.0, rng, scratch)


@pytest.mark.parametrize("mount_rad", [0.0, 0.7])
def test_helicopters_fly_alike(mount_rad: float) -> None:
    rng = np.random.default_rng(3)
    air = AirState(70.0, rng.normal(0, 0.1, (300, 3)), np.zeros((300, 2)), 0.7, mount_rad)
    pulse = Pulse(50, 6, 20, 8, (30.0, -20.0), True)
    helicopter = Helicopter(RoadTown(""), air, [pulse], np.array([5.0, -3.0]))
    states, scratch = np.zeros(1, FLIGHT_STATE), np.zeros(3)
    states["place_m"], states["yaw_rad"] = [5.0, -3.0, 70.0], 0.7
    attitude_rad = helicopter._attitude_rad
    for frame in range(1, 300):
        # Commands exceed every limit at times, and the flight is long enough to reach the lowest height.
        command = rng.normal([0, 0, -4, 0], [25, 25, 6, 1])
        helicopter.obey(CameraCommand(*command), frame - 1)
        turned_rad = attitude_rad[frame - 1, 2] if mount_rad > 0.0 else 0.0
        fly_one(states, command, turned_rad, attitude_rad[frame], mount_rad, rng, scratch)
        pose = helicopter.pose(frame)
        np.testing.assert_allclose(states["R"][0], pose[:3, :3], atol=1e-9)
        np.testing.assert_allclose(states["camera_m"][0], pose[:3, 3], atol=1e-9)
    assert states["place_m"][0, 2] == pytest.approx(40.0)
