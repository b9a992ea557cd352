"""The command link for many at a time: the equations of ``scenarios.command_link.CommandLink``."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True)
def send(
    life: Any,
    wanted: NDArray[np.float64],
    limits: NDArray[np.float64],
    steps: NDArray[np.float64],
    waiting: NDArray[np.float64],
    noise: float,
    rng: np.random.Generator,
) -> None:
    """Write the command that the carrier gets to ``life.obeyed``.

    Args:
        wanted: (4,) forward, right, climb, yaw rate.
        limits, steps: (4,) range and largest change from frame to frame; 0 for what the carrier does not obey.
        waiting: (D, 4) commands on their way, a ring whose place is the number of steps.
        noise: see ``Link``.
    """
    delay = len(waiting)
    for axis in range(4):
        value = min(max(wanted[axis], -limits[axis]), limits[axis])
        value = min(max(value, life.command[axis] - steps[axis]), life.command[axis] + steps[axis])
        life.command[axis] = value
        if delay > 0:
            place = life.steps % delay
            value, waiting[place, axis] = waiting[place, axis], value
        if noise > 0.0 and limits[axis] > 0.0:
            value += noise * limits[axis] * rng.standard_normal()
            value = min(max(value, -limits[axis]), limits[axis])
        life.obeyed[axis] = value
