"""The robot's way for many at a time: the equations of ``scenarios.stereo_follow.robot.Robot`` and ``Odometry``."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scenarios.envs.pictureless.poses import turn_down
from scenarios.stereo_follow.camera import CAMERA_HEIGHT_M
from scenarios.stereo_follow.episode import NOD_KEPT, NOD_RAD
from scenarios.stereo_follow.odometry import SLIP_M, TURN_SLIP_RAD
from scenarios.stereo_follow.robot import ACCELERATION_MPS2, FASTEST_MPS, FASTEST_TURN_RAD_S, TURN_ACCELERATION_RAD_S2

_HALF_TURN_RAD = 0.5 * np.pi
_STANDS_M = 1e-4
_HALF_WIDTH_M = 0.25
"""Of a person, as others are hidden behind."""


@njit(cache=True)
def drive(life: Any, free_m: NDArray[np.float64], interval_s: float) -> None:
    """Obey ``life.obeyed`` for one frame, and slide along walls.

    Args:
        free_m: (P, 4) rectangles x0, y0, x1, y1 where the robot can be.
    """
    wanted_mps = min(max(life.obeyed[0], -FASTEST_MPS), FASTEST_MPS)
    wanted_rad_s = min(max(life.obeyed[3], -FASTEST_TURN_RAD_S), FASTEST_TURN_RAD_S)
    most_mps, most_rad_s = ACCELERATION_MPS2 * interval_s, TURN_ACCELERATION_RAD_S2 * interval_s
    life.speed_mps += min(max(wanted_mps - life.speed_mps, -most_mps), most_mps)
    life.yaw_rate_rad_s += min(max(wanted_rad_s - life.yaw_rate_rad_s, -most_rad_s), most_rad_s)
    middle_rad = life.yaw_rad + 0.5 * life.yaw_rate_rad_s * interval_s
    life.yaw_rad += life.yaw_rate_rad_s * interval_s
    east_m = life.speed_mps * interval_s * np.cos(middle_rad)
    north_m = life.speed_mps * interval_s * np.sin(middle_rad)
    x_m, y_m = life.place_m[0], life.place_m[1]
    if _is_free(free_m, x_m + east_m, y_m + north_m):
        life.place_m[0], life.place_m[1] = x_m + east_m, y_m + north_m
    elif _is_free(free_m, x_m + east_m, y_m):
        life.place_m[0] = x_m + east_m
    elif _is_free(free_m, x_m, y_m + north_m):
        life.place_m[1] = y_m + north_m
    else:
        life.speed_mps = 0.0


@njit(cache=True)
def _is_free(free_m: NDArray[np.float64], x_m: float, y_m: float) -> bool:
    free = False
    for k in range(len(free_m)):
        if free_m[k, 0] <= x_m <= free_m[k, 2] and free_m[k, 1] <= y_m <= free_m[k, 3]:
            free = True
    return free


@njit(cache=True)
def measure(life: Any, x_m: float, y_m: float, yaw_rad: float, rng: np.random.Generator) -> None:
    """Add up what the wheels say of the way from a place (x, y) and heading to where the robot is."""
    step_m = (life.place_m[0] - x_m) * np.cos(yaw_rad) + (life.place_m[1] - y_m) * np.sin(yaw_rad)
    turn_rad = life.yaw_rad - yaw_rad
    slip_m, slip_rad = SLIP_M * rng.standard_normal(), TURN_SLIP_RAD * rng.standard_normal()
    moves = abs(step_m) > _STANDS_M or abs(turn_rad) > _STANDS_M
    step_m = life.odometry_scales[0] * step_m + (slip_m if moves else 0.0)
    turn_rad = life.odometry_scales[1] * turn_rad + (slip_rad if moves else 0.0)
    middle_rad = life.odometry[2] + 0.5 * turn_rad
    life.odometry[0] += step_m * np.cos(middle_rad)
    life.odometry[1] += step_m * np.sin(middle_rad)
    life.odometry[2] += turn_rad


@njit(cache=True)
def look_ahead(life: Any, rng: np.random.Generator) -> None:
    """Write the camera's pose, true and as measured; the robot shakes it."""
    for axis in range(2):
        fresh = np.sqrt(1.0 - NOD_KEPT**2) * NOD_RAD * rng.standard_normal()
        life.shake_rad[axis] = NOD_KEPT * life.shake_rad[axis] + fresh
    turn_down(life.R, life.yaw_rad, _HALF_TURN_RAD + life.shake_rad[0], life.shake_rad[1])
    turn_down(life.R_measured, life.odometry[2], _HALF_TURN_RAD, 0.0)
    for axis in range(2):
        life.camera_m[axis], life.camera_measured_m[axis] = life.place_m[axis], life.odometry[axis]
    life.camera_m[2] = life.camera_measured_m[2] = CAMERA_HEIGHT_M


@njit(cache=True)
def is_walled(from_x_m: float, from_y_m: float, to_x_m: float, to_y_m: float, openings_m: NDArray[np.float64]) -> bool:
    """Return whether a wall bars the line from one place to another: it has gaps (W, 4), x0, y0, x1, y1, alone."""
    for k in range(len(openings_m)):
        for side in (0, 2):
            wall_x_m = openings_m[k, side]
            if (wall_x_m - from_x_m) * (wall_x_m - to_x_m) < 0.0:
                y_m = from_y_m + (to_y_m - from_y_m) * (wall_x_m - from_x_m) / (to_x_m - from_x_m)
                if not openings_m[k, 1] < y_m < openings_m[k, 3]:
                    return True
    return False


@njit(cache=True)
def covered_share(life: Any, others_m: NDArray[np.float64], openings_m: NDArray[np.float64]) -> float:
    """Return which share of the target is behind walls or, at most, behind one of the others (N, 2)."""
    from_x_m, from_y_m = life.place_m[0], life.place_m[1]
    if is_walled(from_x_m, from_y_m, life.target_m[0], life.target_m[1], openings_m):
        return 1.0
    to_x_m, to_y_m = life.target_m[0] - from_x_m, life.target_m[1] - from_y_m
    most, distance_m = 0.0, max(np.hypot(to_x_m, to_y_m), 1e-6)
    for n in range(len(others_m)):
        x_m, y_m = others_m[n, 0] - from_x_m, others_m[n, 1] - from_y_m
        share = (x_m * to_x_m + y_m * to_y_m) / distance_m**2
        if 0.02 < share < 1.0:
            # His shadow on the plane of the target.
            aside_m = (x_m * to_y_m - y_m * to_x_m) / distance_m / share
            shadow_m = _HALF_WIDTH_M / share
            both_m = min(_HALF_WIDTH_M, aside_m + shadow_m) - max(-_HALF_WIDTH_M, aside_m - shadow_m)
            most = max(most, both_m / (2.0 * _HALF_WIDTH_M))
    return most
