"""The helicopter's flight for many at a time: the equations of ``scenarios.road_town.flight.Helicopter``.

That one is not served by this kernel: NumPy's norm and matrix products round other than compiled sums by a bit.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scenarios.envs.pictureless.life import life_with
from scenarios.envs.pictureless.poses import turn_down, turned
from scenarios.road_town.flight import (
    ALTITUDE_RANGE_M,
    MAXIMUM_CLIMB_MPS,
    MAXIMUM_SPEED_MPS,
    MAXIMUM_YAW_RATE_RAD_S,
    RESPONSE_TIME_S,
)

_LOWEST_M, _HIGHEST_M = ALTITUDE_RANGE_M
FLIGHT_LIFE = life_with(
    ("velocity_mps", "f8", (3,)), ("position_bias_m", "f8", (3,)), ("attitude_bias_rad", "f8", (3,))
)
"""A flight: its velocity, and the errors of its instruments that last."""


@njit(cache=True)
def fly(life: Any, interval_s: float) -> None:
    """Obey ``life.obeyed`` for one frame: a first-order response of all velocities."""
    wanted = life.obeyed
    c, s = np.cos(life.yaw_rad), np.sin(life.yaw_rad)
    east, north = c * wanted[0] + s * wanted[1], s * wanted[0] - c * wanted[1]
    slower = min(1.0, MAXIMUM_SPEED_MPS / max(np.sqrt(east * east + north * north), 1e-9))
    climb = min(max(wanted[2], -MAXIMUM_CLIMB_MPS), MAXIMUM_CLIMB_MPS)
    response = 1.0 - np.exp(-interval_s / RESPONSE_TIME_S)
    life.velocity_mps[0] += response * (slower * east - life.velocity_mps[0])
    life.velocity_mps[1] += response * (slower * north - life.velocity_mps[1])
    life.velocity_mps[2] += response * (climb - life.velocity_mps[2])
    yaw_rate = min(max(wanted[3], -MAXIMUM_YAW_RATE_RAD_S), MAXIMUM_YAW_RATE_RAD_S)
    life.yaw_rate_rad_s += response * (yaw_rate - life.yaw_rate_rad_s)
    for axis in range(3):
        life.place_m[axis] += life.velocity_mps[axis] * interval_s
    life.place_m[2] = min(max(life.place_m[2], _LOWEST_M), _HIGHEST_M)
    life.yaw_rad += life.yaw_rate_rad_s * interval_s


@njit(cache=True)
def look_down(
    life: Any,
    attitude_rad: NDArray[np.float64],
    position_noise_m: float,
    attitude_noise_rad: float,
    rng: np.random.Generator,
    scratch: NDArray[np.float64],
) -> None:
    """Write the camera's pose, true and as measured.

    Args:
        attitude_rad: (3,) roll, pitch, yaw by which air and gusts tilt it on this frame.
    """
    turn_down(life.R, life.yaw_rad + attitude_rad[2], attitude_rad[1], attitude_rad[0])
    for axis in range(3):
        life.camera_m[axis] = life.place_m[axis]
        noise_m = position_noise_m * rng.standard_normal()
        life.camera_measured_m[axis] = life.place_m[axis] + life.position_bias_m[axis] + noise_m
        scratch[axis] = life.attitude_bias_rad[axis] + attitude_noise_rad * rng.standard_normal()
    turned(life.R, scratch, life.R_measured)
