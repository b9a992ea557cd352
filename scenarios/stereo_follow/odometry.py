"""Wheel odometry of the robot: increments with errors, summed up."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scenarios.stereo_follow.camera import camera_pose

SCALE_ERROR, TURN_SCALE_ERROR = 0.01, 0.02
SLIP_M, TURN_SLIP_RAD = 0.002, np.deg2rad(0.08)
_STANDS = 1e-4
"""Metres and radians per frame: a robot that moves less than both does not slip."""


class Odometry:
    """Dead reckoning in the frame of the robot's start, x ahead.

    Scale errors of the wheels are constant over an episode, one for distances and one for turns. On every frame in
    which the robot moves, the wheels slip: 2 mm and 0.08 degrees, standard deviations.
    """

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        self._scales = np.array([1.0 + rng.normal(0.0, SCALE_ERROR), 1.0 + rng.normal(0.0, TURN_SCALE_ERROR)])
        self._believed = np.zeros(3)
        self._true: tuple[NDArray[np.float64], float] | None = None

    def measure(self, place_m: NDArray[np.float64], heading_rad: float) -> NDArray[np.float64]:
        """Add the robot's true pose and return the measured T_world_camera (4, 4), which is level."""
        if self._true is not None:
            before_m, before_rad = self._true
            # NumPy's product differs from a compiled sum in the last bit, so pictureless drives compute their own.
            step_m = float((place_m - before_m) @ (np.cos(before_rad), np.sin(before_rad)))
            add_up(self._believed, self._scales, step_m, float(heading_rad - before_rad), self._rng)
        self._true = (np.array(place_m), heading_rad)
        return camera_pose(self._believed[:2], float(self._believed[2]))


@njit(cache=True)
def add_up(
    believed: NDArray[np.float64],
    scales: NDArray[np.float64],
    step_m: float,
    turn_rad: float,
    rng: np.random.Generator,
) -> None:
    """Advance the believed place and heading (3,) by the wheels' measurement of a step ahead and a turn.

    Args:
        scales: (2,) measured over true distances, and measured over true turns.
    """
    slip_m, slip_rad = SLIP_M * rng.standard_normal(), TURN_SLIP_RAD * rng.standard_normal()
    moves = abs(step_m) > _STANDS or abs(turn_rad) > _STANDS
    step_m = scales[0] * step_m + (slip_m if moves else 0.0)
    turn_rad = scales[1] * turn_rad + (slip_rad if moves else 0.0)
    middle_rad = believed[2] + 0.5 * turn_rad
    believed[0] += step_m * np.cos(middle_rad)
    believed[1] += step_m * np.sin(middle_rad)
    believed[2] += turn_rad
