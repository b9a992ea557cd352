"""Motion of many robots and their cameras at a time."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scenarios.envs.pictureless.episode_state import state_dtype
from scenarios.envs.pictureless.poses import turn_down
from scenarios.stereo_follow.camera import CAMERA_HEIGHT_M
from scenarios.stereo_follow.episode import NOD_KEPT, NOD_RAD
from scenarios.stereo_follow.odometry import add_up
from scenarios.stereo_follow.robot import driven

DRIVE_STATE = state_dtype(
    ("speed_mps", "f8"), ("shake_rad", "f8", (2,)), ("odometry", "f8", (3,)), ("odometry_scales", "f8", (2,))
)
"""State of a drive: with its speed, the camera's shaking, and the odometry."""
_HALF_TURN_RAD = 0.5 * np.pi


@njit(cache=True)
def drive(state: Any, free_m: NDArray[np.float64], interval_s: float, rng: np.random.Generator) -> None:
    """Obey ``state.obeyed`` for one frame, and advance the odometry.

    Args:
        free_m: (P, 4) rectangles x0, y0, x1, y1 where the robot can be.
    """
    x_m, y_m, yaw_rad = state.place_m[0], state.place_m[1], state.yaw_rad
    state.place_m[0], state.place_m[1], state.yaw_rad, state.speed_mps, state.yaw_rate_rad_s = driven(
        state.place_m,
        yaw_rad,
        state.speed_mps,
        state.yaw_rate_rad_s,
        state.obeyed[0],
        state.obeyed[3],
        free_m,
        interval_s,
    )
    step_m = (state.place_m[0] - x_m) * np.cos(yaw_rad) + (state.place_m[1] - y_m) * np.sin(yaw_rad)
    add_up(state.odometry, state.odometry_scales, step_m, state.yaw_rad - yaw_rad, rng)


@njit(cache=True)
def look_ahead(state: Any, rng: np.random.Generator) -> None:
    """Write the camera's pose, true with shaking, and as measured."""
    for axis in range(2):
        fresh = np.sqrt(1.0 - NOD_KEPT**2) * NOD_RAD * rng.standard_normal()
        state.shake_rad[axis] = NOD_KEPT * state.shake_rad[axis] + fresh
    turn_down(state.R, state.yaw_rad, _HALF_TURN_RAD + state.shake_rad[0], state.shake_rad[1])
    turn_down(state.R_measured, state.odometry[2], _HALF_TURN_RAD, 0.0)
    for axis in range(2):
        state.camera_m[axis], state.camera_measured_m[axis] = state.place_m[axis], state.odometry[axis]
    state.camera_m[2] = state.camera_measured_m[2] = CAMERA_HEIGHT_M
