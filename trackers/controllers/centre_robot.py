"""A ground robot's PID controller: turn towards the estimate and keep a distance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from trackers.controllers.catalogue import Kernel, register_controller
from trackers.controllers.kernel_controller import KernelController, record_dtype
from trackers.controllers.pid import PID_MEMORY, integral_and_derivative, seconds_since_error
from trackers.registry import tunable


@dataclass(frozen=True)
class CentreRobotParameters:
    """Settings.

    Attributes:
        turn_gain_per_s: turn rate per radian of the estimate's bearing.
        turn_integral_per_s2: turn rate per radian second of integrated bearing.
        turn_derivative: turn rate per rad/s of change of the bearing.
        speed_gain_per_s: speed per metre that the target is too far away; negative where it is too near.
        distance_m: distance to keep.
    """

    turn_gain_per_s: float = tunable(2.2, 0.5, 6.0, log=True)
    turn_integral_per_s2: float = tunable(0.0, 0.0, 2.0)
    turn_derivative: float = tunable(0.0, 0.0, 0.5)
    speed_gain_per_s: float = tunable(1.1, 0.3, 3.0, log=True)
    distance_m: float = tunable(1.8, 1.2, 3.0)


_INTEGRAL_LIMIT_RAD_S = 0.5
"""Limit of the integral: its largest turn rate is half its gain."""


@njit(cache=True)
def turn_to_centre(
    beliefs: NDArray[np.void],
    parameters: NDArray[np.void],
    memory: NDArray[np.void],
    times_s: NDArray[np.float64],
    out: NDArray[np.float64],
) -> None:
    """Write the commands of B beliefs (B,), see ``catalogue.Kernel``.

    Args:
        parameters: (1,) record of ``CentreRobotParameters``. memory: (B,) records of ``PID_MEMORY``.
    """
    for k in range(len(beliefs)):
        write_turn_to_centre(beliefs[k], parameters[0], memory[k], times_s[k], out[k])


@njit(cache=True)
def write_turn_to_centre(b: Any, p: Any, memory: Any, time_s: float, out: Any) -> None:
    """Write the command (4,) for one belief; parameters and memory may have further fields."""
    out[:] = 0.0
    if b.known == 0.0:
        memory.has_error = 0.0
        return
    # Positive to the left, as turn rates are.
    bearing_rad = -np.arctan(b.picture_x * b.half_right_m)
    off_m = b.depth_m / np.cos(bearing_rad) - p.distance_m
    interval_s, gains = seconds_since_error(memory, time_s), (p.turn_integral_per_s2, p.turn_derivative)
    terms_rad_s = integral_and_derivative(memory, 0, interval_s, bearing_rad, gains, _INTEGRAL_LIMIT_RAD_S)
    out[0] = p.speed_gain_per_s * off_m * np.cos(bearing_rad)
    out[3] = p.turn_gain_per_s * bearing_rad + terms_rad_s


@register_controller(
    "centre_as_written", role="variant", carrier="robot", summary="with its values as written, not tuned"
)
@register_controller(
    "centre", role="baseline", carrier="robot", summary="turns to the estimate (PID) and keeps a distance"
)
class CentreRobotController(KernelController):
    """Turns and drives by PID; as written it is proportional. Without an estimate (NaN) it stands still;
    without a measured distance it takes the target to be 3 m away.
    """

    Parameters = CentreRobotParameters
    LOOKS, KERNEL = (
        "ahead",
        Kernel(turn_to_centre, record_dtype(CentreRobotParameters), PID_MEMORY),
    )
