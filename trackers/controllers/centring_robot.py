"""A ground robot's controllers: ``centre`` turns to the estimate and keeps a distance, ``search`` extends it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackers.controllers.catalogue import Kernel, register_controller
from trackers.controllers.kernel_controller import (
    PID_FIELDS,
    PID_MEMORY,
    KernelController,
    integral_and_derivative,
    record_dtype,
    seconds_since_error,
)
from trackers.kernels.records import record_kernel
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


@record_kernel()
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


@record_kernel()
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
    LOOKS, KERNEL = ("ahead", Kernel(turn_to_centre, record_dtype(CentreRobotParameters), PID_MEMORY))


_FASTEST_MPS = 1.0
# 1 while there is no estimate, else 0; and since when.
_MEMORY = np.dtype([("is_lost", "f8"), ("lost_at_s", "f8"), *PID_FIELDS], align=True)


@dataclass(frozen=True)
class SearchRobotParameters(CentreRobotParameters):
    """Settings of the centring, and of the search.

    Attributes:
        turn_s: how long the robot turns on the spot, to the side where the target left the picture.
        search_rad_s: turn rate of the search.
        reached_m: distance to the point where the target was last seen at which the robot stops and turns.
    """

    turn_s: float = tunable(1.0, 0.0, 6.0)
    search_rad_s: float = tunable(0.8, 0.3, 1.6)
    reached_m: float = tunable(0.6, 0.3, 1.5)


@record_kernel()
def drive_in_search(
    beliefs: NDArray[np.void],
    parameters: NDArray[np.void],
    memory: NDArray[np.void],
    times_s: NDArray[np.float64],
    out: NDArray[np.float64],
) -> None:
    """Write the commands of B beliefs (B,), to centre the target or to search for it; see ``catalogue.Kernel``.

    Args:
        parameters: (1,) record of ``SearchRobotParameters``.
    """
    p = parameters[0]
    for k in range(len(beliefs)):
        b, m = beliefs[k], memory[k]
        if b.known > 0.0:
            m.is_lost = 0.0
            write_turn_to_centre(b, p, m, times_s[k], out[k])
            continue
        if m.is_lost == 0.0:
            m.is_lost, m.lost_at_s = 1.0, times_s[k]
        out[k] = 0.0
        out[k, 0], out[k, 3] = _search(b, p, times_s[k] - m.lost_at_s)


@record_kernel()
def _search(b: Any, p: Any, lost_s: float) -> tuple[float, float]:
    """Return forward speed and turn rate to the side of the target's exit, then to where it was last seen."""
    # ``picture_x`` is that of the latest estimate.
    turn_rad_s = -p.search_rad_s if b.picture_x > 0.0 else p.search_rad_s
    east_m, north_m = b.seen_x_m - b.carrier_x_m, b.seen_y_m - b.carrier_y_m
    distance_m = np.hypot(east_m, north_m)
    if b.frames <= 1.0 or lost_s < p.turn_s or distance_m < p.reached_m:
        return 0.0, turn_rad_s
    bearing_rad = np.arctan2(north_m, east_m) - b.heading_rad
    bearing_rad = (bearing_rad + np.pi) % (2 * np.pi) - np.pi
    speed_mps = min(p.speed_gain_per_s * distance_m, _FASTEST_MPS) * max(np.cos(bearing_rad), 0.0)
    return speed_mps, p.turn_gain_per_s * bearing_rad


@register_controller(
    "search",
    role="baseline",
    carrier="robot",
    summary="centres; searches for a lost target on its side, then where it was last seen",
)
class SearchRobotController(KernelController):
    """Centres the target while there is an estimate. Otherwise it turns for a while to the side where the target left
    the picture, then drives to the point where it was last seen and turns there.
    """

    Parameters = SearchRobotParameters
    LOOKS, KERNEL = "ahead", Kernel(drive_in_search, record_dtype(SearchRobotParameters), _MEMORY)
