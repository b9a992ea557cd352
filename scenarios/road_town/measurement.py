"""The helicopter's instruments, which measure its pose."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenarios.road_town.presets import EgoErrors
from sim.pose import rotation_by


class Instruments:
    """Measures poses with white noise and a constant bias. The errors do not depend on the pose."""

    def __init__(self, errors: EgoErrors, rng: np.random.Generator) -> None:
        self._errors = errors
        self._rng = rng
        self._position_bias_m = rng.normal(0.0, 1.0, 3) * errors.position_bias_m
        self._attitude_bias_deg = rng.normal(0.0, 1.0, 3) * errors.attitude_bias_deg

    def measure(self, T_world_camera: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the measured T_world_camera (4, 4); the attitude error is a rotation about the camera's axes."""
        noise = self._rng.normal(0.0, 1.0, (2, 3))
        turn_deg = self._attitude_bias_deg + self._errors.attitude_noise_deg * noise[1]
        measured = T_world_camera.copy()
        measured[:3, :3] @= rotation_by(np.deg2rad(turn_deg))
        measured[:3, 3] += self._position_bias_m + self._errors.position_noise_m * noise[0]
        return measured
