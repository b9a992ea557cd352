"""The robot that carries the camera."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scenarios.stereo_follow.floor_plan import FloorPlan
from trackers.types import CameraCommand, Carrier, CommandAxis

FASTEST_MPS, FASTEST_TURN_RAD_S = 1.6, 1.6
ACCELERATION_MPS2, TURN_ACCELERATION_RAD_S2 = 1.5, 4.0
ROBOT = Carrier(
    "robot",
    (
        CommandAxis("forward_mps", FASTEST_MPS, ACCELERATION_MPS2),
        CommandAxis("yaw_rate_rad_s", FASTEST_TURN_RAD_S, TURN_ACCELERATION_RAD_S2),
    ),
    "ahead",
)
"""The limits are those of its motors."""


class Robot:
    """A robot on two driven wheels: it moves ahead or back and turns, within limits, and stops at walls.

    Attributes:
        place_m: (2,). heading_rad: counter-clockwise from world x.
    """

    def __init__(self, plan: FloorPlan, place_m: NDArray[np.float64], heading_rad: float, rate_hz: float) -> None:
        self._free_m = plan.free_m
        self._interval_s = 1.0 / rate_hz
        self._speed_mps = self._turn_rad_s = 0.0
        self.place_m = np.array(place_m, dtype=float)
        self.heading_rad = float(heading_rad)

    def drive(self, command: CameraCommand) -> None:
        """Obey ``forward_mps`` and ``yaw_rate_rad_s`` of a command for one frame, within limits."""
        x_m, y_m, self.heading_rad, self._speed_mps, self._turn_rad_s = driven(
            self.place_m,
            self.heading_rad,
            self._speed_mps,
            self._turn_rad_s,
            float(command.forward_mps),
            float(command.yaw_rate_rad_s),
            self._free_m,
            self._interval_s,
        )
        self.place_m = np.array([x_m, y_m])


@njit(cache=True)
def driven(
    place_m: NDArray[np.float64],
    heading_rad: float,
    speed_mps: float,
    turn_rad_s: float,
    wanted_mps: float,
    wanted_rad_s: float,
    free_m: NDArray[np.float64],
    interval_s: float,
) -> tuple[float, float, float, float, float]:
    """Return place x, y, heading, speed and turn rate one frame later; the robot slides along walls.

    Args:
        free_m: (P, 4) rectangles x0, y0, x1, y1 where the robot can be.
    """
    wanted_mps = min(max(wanted_mps, -FASTEST_MPS), FASTEST_MPS)
    wanted_rad_s = min(max(wanted_rad_s, -FASTEST_TURN_RAD_S), FASTEST_TURN_RAD_S)
    most_mps, most_rad_s = ACCELERATION_MPS2 * interval_s, TURN_ACCELERATION_RAD_S2 * interval_s
    speed_mps += min(max(wanted_mps - speed_mps, -most_mps), most_mps)
    turn_rad_s += min(max(wanted_rad_s - turn_rad_s, -most_rad_s), most_rad_s)
    middle_rad = heading_rad + 0.5 * turn_rad_s * interval_s
    heading_rad += turn_rad_s * interval_s
    east_m = speed_mps * interval_s * np.cos(middle_rad)
    north_m = speed_mps * interval_s * np.sin(middle_rad)
    x_m, y_m = place_m[0], place_m[1]
    if _is_free(free_m, x_m + east_m, y_m + north_m):
        return x_m + east_m, y_m + north_m, heading_rad, speed_mps, turn_rad_s
    if _is_free(free_m, x_m + east_m, y_m):
        return x_m + east_m, y_m, heading_rad, speed_mps, turn_rad_s
    if _is_free(free_m, x_m, y_m + north_m):
        return x_m, y_m + north_m, heading_rad, speed_mps, turn_rad_s
    return x_m, y_m, heading_rad, 0.0, turn_rad_s


@njit(cache=True)
def _is_free(free_m: NDArray[np.float64], x_m: float, y_m: float) -> bool:
    free = False
    for k in range(len(free_m)):
        if free_m[k, 0] <= x_m <= free_m[k, 2] and free_m[k, 1] <= y_m <= free_m[k, 3]:
            free = True
    return free


@njit(cache=True)
def is_straight_way(from_m: NDArray[np.float64], to_m: NDArray[np.float64], free_m: NDArray[np.float64]) -> bool:
    """Return whether the robot can drive on a straight line between two places (2,); ``free_m`` as for ``driven``."""
    for share in np.linspace(0.0, 1.0, 20):
        x_m, y_m = from_m[0] + share * (to_m[0] - from_m[0]), from_m[1] + share * (to_m[1] - from_m[1])
        if not _is_free(free_m, x_m, y_m):
            return False
    return True
