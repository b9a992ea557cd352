"""Flights of many helicopters at a time, with the equations of ``scenarios.road_town.flight.Helicopter``.

``Helicopter`` does not use this kernel: NumPy's norm and matrix products differ from compiled sums in the last bit.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scenarios.envs.pictureless.episode_state import state_dtype
from scenarios.envs.pictureless.poses import pitch_forward, turn_down, turned
from scenarios.road_town.flight import (
    MAXIMUM_CLIMB_MPS,
    MAXIMUM_SPEED_MPS,
    MAXIMUM_YAW_RATE_RAD_S,
    RESPONSE_TIME_S,
)
from scenarios.road_town.presets import ALTITUDE_RANGE_M

_LOWEST_M, _HIGHEST_M = ALTITUDE_RANGE_M
FLIGHT_STATE = state_dtype(
    ("velocity_mps", "f8", (3,)), ("position_bias_m", "f8", (3,)), ("attitude_bias_rad", "f8", (3,))
)
"""State of a flight: with its velocity and the constant errors of its instruments."""


@njit(cache=True)
def fly(state: Any, turned_rad: float, interval_s: float) -> None:
    """Obey ``state.obeyed`` for one frame: a first-order response of all velocities.

    Args:
        turned_rad: yaw of the air, by which a pitched camera's heading deviates; 0 for one that looks straight down.
    """
    wanted = state.obeyed
    c, s = np.cos(state.yaw_rad + turned_rad), np.sin(state.yaw_rad + turned_rad)
    east, north = c * wanted[0] + s * wanted[1], s * wanted[0] - c * wanted[1]
    slower = min(1.0, MAXIMUM_SPEED_MPS / max(np.sqrt(east * east + north * north), 1e-9))
    climb = min(max(wanted[2], -MAXIMUM_CLIMB_MPS), MAXIMUM_CLIMB_MPS)
    response = 1.0 - np.exp(-interval_s / RESPONSE_TIME_S)
    state.velocity_mps[0] += response * (slower * east - state.velocity_mps[0])
    state.velocity_mps[1] += response * (slower * north - state.velocity_mps[1])
    state.velocity_mps[2] += response * (climb - state.velocity_mps[2])
    yaw_rate = min(max(wanted[3], -MAXIMUM_YAW_RATE_RAD_S), MAXIMUM_YAW_RATE_RAD_S)
    state.yaw_rate_rad_s += response * (yaw_rate - state.yaw_rate_rad_s)
    for axis in range(3):
        state.place_m[axis] += state.velocity_mps[axis] * interval_s
    state.place_m[2] = min(max(state.place_m[2], _LOWEST_M), _HIGHEST_M)
    state.yaw_rad += state.yaw_rate_rad_s * interval_s


@njit(cache=True)
def look_down(
    state: Any,
    attitude_rad: NDArray[np.float64],
    mount_rad: float,
    position_noise_m: float,
    attitude_noise_rad: float,
    rng: np.random.Generator,
    scratch: NDArray[np.float64],
) -> None:
    """Write the camera's pose, true and as measured.

    Args:
        attitude_rad: (3,) roll, pitch, yaw due to air and gusts on this frame.
        mount_rad: by which the camera is pitched forward.
    """
    turn_down(state.R, state.yaw_rad + attitude_rad[2], attitude_rad[1], attitude_rad[0])
    pitch_forward(state.R, mount_rad)
    for axis in range(3):
        state.camera_m[axis] = state.place_m[axis]
        noise_m = position_noise_m * rng.standard_normal()
        state.camera_measured_m[axis] = state.place_m[axis] + state.position_bias_m[axis] + noise_m
        scratch[axis] = state.attitude_bias_rad[axis] + attitude_noise_rad * rng.standard_normal()
    turned(state.R, scratch, state.R_measured)
