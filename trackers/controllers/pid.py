"""Integral and derivative of an error: what a PID controller adds to its proportional term, for kernels."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

PID_FIELDS: list[Any] = [
    # 1 if the previous frame had an error, else 0; and the time of the last one that had.
    ("has_error", "f8"),
    ("time_s", "f8"),
    ("error", "f8", (2,)),
    ("integral", "f8", (2,)),
]
PID_MEMORY = np.dtype(PID_FIELDS, align=True)
"""A kernel's memory, see ``catalogue.Kernel``. One with more fields has its own first, see ``record_dtype``."""


@njit(cache=True)
def seconds_since_error(memory: Any, time_s: float) -> float:
    """Note a frame with an error; return the time since the previous frame's, 0 if that had none."""
    interval_s = max(time_s - memory.time_s, 0.0) * memory.has_error
    memory.has_error, memory.time_s = 1.0, time_s
    return interval_s


@njit(cache=True)
def integral_and_derivative(
    memory: Any, axis: int, interval_s: float, error: float, gains: tuple[float, float], limit: float
) -> float:
    """Return ``gains[0] * integral + gains[1] * derivative`` after the next error on an axis.

    Args:
        interval_s: of ``seconds_since_error``. After a frame without an error the integral stays, and there is no
            derivative.
        limit: largest magnitude of the integral (anti-windup).
    """
    before, memory.error[axis] = memory.error[axis], error
    if interval_s == 0.0:
        return gains[0] * memory.integral[axis]
    memory.integral[axis] = min(max(memory.integral[axis] + interval_s * error, -limit), limit)
    return gains[0] * memory.integral[axis] + gains[1] * (error - before) / interval_s
