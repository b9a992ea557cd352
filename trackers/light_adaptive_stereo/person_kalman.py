"""Kalman filter of a person's position and velocity on the ground (paper B, section 3.2.1)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_WALKING_MPS = 1.0
"""Standard deviation of the initial velocity."""


class PersonKalman:
    """Estimates the state (X, Y, X', Y') in metres and m/s with white acceleration.

    ``x = F x, P = F P Fᵀ + Q``; ``K = P Hᵀ (H P Hᵀ + R)⁻¹, x += K (z - H x), P -= K H P``.

    Attributes:
        x: (4,) state. P: (4, 4) covariance.
    """

    def __init__(self, place_m: NDArray[np.float64], acceleration_mps2: float, place_noise_m: float) -> None:
        """Start at a position (2,) with velocity zero.

        Args:
            acceleration_mps2: standard deviation of the acceleration along each axis.
            place_noise_m: that of a measured position.
        """
        self._acceleration_mps2, self._place_noise_m = acceleration_mps2, place_noise_m
        self.x = np.concatenate([place_m, np.zeros(2)])
        self.P = np.diag([place_noise_m**2] * 2 + [_WALKING_MPS**2] * 2)

    @property
    def place_m(self) -> NDArray[np.float64]:
        """Estimated position (2,)."""
        return self.x[:2]

    @property
    def velocity_mps(self) -> NDArray[np.float64]:
        """Estimated velocity (2,)."""
        return self.x[2:]

    def predict(self, seconds: float) -> None:
        """Predict by ``seconds``."""
        F = np.eye(4)
        F[0, 2] = F[1, 3] = seconds
        G = np.array([[0.5 * seconds**2, 0.0], [0.0, 0.5 * seconds**2], [seconds, 0.0], [0.0, seconds]])
        self.x = F @ self.x
        self.P = F @ self.P @ F.T + self._acceleration_mps2**2 * G @ G.T

    def innovation(self, place_noise_m: float | None = None) -> NDArray[np.float64]:
        """Return the innovation covariance (2, 2) of a measured position."""
        noise_m = self._place_noise_m if place_noise_m is None else place_noise_m
        return self.P[:2, :2] + noise_m**2 * np.eye(2)

    def correct(self, place_m: NDArray[np.float64], place_noise_m: float | None = None) -> None:
        """Correct by a measured position (2,), with another noise than the default if given."""
        gain = self.P[:, :2] @ np.linalg.inv(self.innovation(place_noise_m))
        self.x = self.x + gain @ (place_m - self.x[:2])
        self.P = self.P - gain @ self.P[:2]

    def stand_still(self) -> None:
        """Set the velocity to zero."""
        self.x[2:] = 0.0
