"""What the robot's wheels say of its way: increments with errors, added up."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenarios.stereo_follow.camera import camera_pose

SCALE_ERROR, TURN_SCALE_ERROR = 0.01, 0.02
SLIP_M, TURN_SLIP_RAD = 0.002, np.deg2rad(0.08)


class Odometry:
    """Dead reckoning from where the robot starts: its frame is that place, x ahead.

    Wheels are a little larger or smaller than believed (one error an episode for ways, one for turns), and slip a
    little every frame in which the robot moves: 2 mm and 0.08 degrees, standard deviations.
    """

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        self._scale = 1.0 + rng.normal(0.0, SCALE_ERROR)
        self._turn_scale = 1.0 + rng.normal(0.0, TURN_SCALE_ERROR)
        self._place_m, self._heading_rad = np.zeros(2), 0.0
        self._true: tuple[NDArray[np.float64], float] | None = None

    def measure(self, place_m: NDArray[np.float64], heading_rad: float) -> NDArray[np.float64]:
        """Take in where the robot now really is and return T_world_camera (4, 4) as it believes: level."""
        if self._true is not None:
            before_m, before_rad = self._true
            step_m = float((place_m - before_m) @ (np.cos(before_rad), np.sin(before_rad)))
            turn_rad = heading_rad - before_rad
            slips = self._rng.normal(0.0, (SLIP_M, TURN_SLIP_RAD)) * (abs(step_m) > 1e-4 or abs(turn_rad) > 1e-4)
            step_m, turn_rad = self._scale * step_m + slips[0], self._turn_scale * turn_rad + slips[1]
            middle_rad = self._heading_rad + 0.5 * turn_rad
            self._place_m = self._place_m + step_m * np.array([np.cos(middle_rad), np.sin(middle_rad)])
            self._heading_rad += turn_rad
        self._true = (np.array(place_m), heading_rad)
        return camera_pose(self._place_m, self._heading_rad)
