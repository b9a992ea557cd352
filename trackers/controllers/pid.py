"""Integral and derivative of an error: what a PID controller adds to its proportional term."""

from __future__ import annotations

from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

_Error = TypeVar("_Error", float, NDArray[np.float64])


class IntegralAndDerivative(Generic[_Error]):
    """Integrates and differentiates an error, a number or a vector, from frame to frame."""

    def __init__(self) -> None:
        self._integral: Any = 0.0
        self._before: tuple[float, _Error] | None = None

    def interrupt(self) -> None:
        """Note a frame without an error: the integral stays, the next frame has no derivative."""
        self._before = None

    def update(
        self, time_s: float, error: _Error, integral_gain: float, derivative_gain: float, limit: float
    ) -> _Error:
        """Return ``integral_gain * integral + derivative_gain * derivative`` after the next error.

        Args:
            limit: largest magnitude of the integral (anti-windup), in each component.
        """
        before, self._before = self._before, (time_s, error)
        if before is None or time_s <= before[0]:
            return integral_gain * self._integral
        interval_s = time_s - before[0]
        self._integral = np.clip(self._integral + interval_s * error, -limit, limit)
        return integral_gain * self._integral + derivative_gain * (error - before[1]) / interval_s
