"""A helicopter's controllers: ``centre`` keeps the estimate in the middle (paper A.2), ``search`` extends it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackers.belief.sighting import FARTHEST_M
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
class CentreParameters:
    """Settings. The paper has only the first two; the others make it a PID controller.

    Attributes:
        gain_per_s: velocity per metre of error: the estimate's offset from the aim point.
        fastest_mps: limit of the velocity's magnitude.
        integral_per_s2: velocity per metre second of integrated error.
        derivative: velocity per m/s of change of the error.
        levelled: 1 aims the point below the camera at the target (where it is pitched forward, that ahead at which
            its axis meets the ground in still air), 0 the optical axis, however it tilts.
        climb_mps: constant climb rate, negative to sink.
        turn_per_s: turn rate per radian of the target's bearing; of a camera that is pitched forward alone.
    """

    gain_per_s: float = tunable(1.8, 0.3, 6.0, log=True)
    fastest_mps: float = tunable(20.0, 8.0, 25.0)
    integral_per_s2: float = tunable(0.0, 0.0, 1.0)
    derivative: float = tunable(0.0, 0.0, 0.5)
    levelled: float = tunable(1.0, 0.0, 1.0)
    climb_mps: float = tunable(0.0, -2.0, 2.0)
    turn_per_s: float = 2.0


@record_kernel()
def fly_to_centre(
    beliefs: NDArray[np.void],
    parameters: NDArray[np.void],
    memory: NDArray[np.void],
    times_s: NDArray[np.float64],
    out: NDArray[np.float64],
) -> None:
    """Write the commands of B beliefs (B,), as ``CentreController`` defines them; see ``catalogue.Kernel``.

    Args:
        parameters: (1,) record of ``CentreParameters``. memory: (B,) records of ``PID_MEMORY``.
    """
    for k in range(len(beliefs)):
        write_centring(beliefs[k], parameters[0], memory[k], times_s[k], out[k])


@record_kernel()
def write_centring(b: Any, p: Any, memory: Any, time_s: float, out: Any) -> None:
    """Write the command (4,) for one belief; parameters and memory may have further fields."""
    out[0], out[1], out[2], out[3] = 0.0, 0.0, p.climb_mps, 0.0
    # Hover without an estimate, or if the ray to what is to be aimed meets no ground.
    if b.known == 0.0 or not np.isfinite(b.depth_m) or (p.levelled != 1.0 and not np.isfinite(b.axis_depth_m)):
        memory.has_error = 0.0
        return
    # The belief's points on the ground are no farther than ``FARTHEST_M``; these are where the rays end.
    farther = b.depth_m / min(b.depth_m, FARTHEST_M)
    target_ahead_m, target_right_m = farther * b.ahead_m, farther * b.right_m
    mount_ahead_m = b.mount_slope * b.height_m
    ahead_m, right_m = target_ahead_m - p.levelled * mount_ahead_m, target_right_m
    if p.levelled != 1.0:
        share = (1.0 - p.levelled) * b.axis_depth_m / min(b.axis_depth_m, FARTHEST_M)
        ahead_m, right_m = ahead_m - share * b.axis_ahead_m, right_m - share * b.axis_right_m
    interval_s = seconds_since_error(memory, time_s)
    gains, limit_ms = (p.integral_per_s2, p.derivative), p.fastest_mps / max(p.integral_per_s2, 1e-9)
    ahead_mps = p.gain_per_s * ahead_m + integral_and_derivative(memory, 0, interval_s, ahead_m, gains, limit_ms)
    right_mps = p.gain_per_s * right_m + integral_and_derivative(memory, 1, interval_s, right_m, gains, limit_ms)
    slower = min(1.0, p.fastest_mps / max(np.hypot(ahead_mps, right_mps), 1e-9))
    out[0], out[1] = slower * ahead_mps, slower * right_mps
    if mount_ahead_m > 0.0:
        # A target nearly below the camera has no bearing.
        out[3] = -p.turn_per_s * np.arctan2(target_right_m, max(target_ahead_m, 0.5 * mount_ahead_m))


@register_controller(
    "centre_as_written", role="variant", carrier="helicopter", summary="with the values of paper A.2, not tuned"
)
@register_controller("centre", role="baseline", carrier="helicopter", summary="keeps the estimate in the middle (PID)")
class CentreController(KernelController):
    """Commands ``gain`` times the estimate's offset on the ground from the camera; as written it is proportional.

    With a measured pose the offset is where the estimate's ray meets the ground, so a gust that tilts the camera does
    not make it fly away from the car. Without one it is ``h / f * (estimate - centre)``, as for a camera that looks
    straight down from 60 m. Without an estimate (NaN), or with one at or above the horizon, it hovers.

    The first picture tells whether the camera is pitched forward (``mount_slope``). Then the helicopter keeps as far
    behind the target as the camera looks ahead, and turns its nose to it; otherwise it does not turn.
    """

    Parameters = CentreParameters
    LOOKS, KERNEL = "down", Kernel(fly_to_centre, record_dtype(CentreParameters), PID_MEMORY)


_SHORTEST_LEG_M = 1.0
# How long the target had been out of view when its position was last known.
_MEMORY = np.dtype([("unseen_s", "f8"), *PID_FIELDS], align=True)


@dataclass(frozen=True)
class SearchParameters(CentreParameters):
    """Settings of ``centre``, and of the search.

    Attributes:
        patience_s: time out of view after which the target may count as lost.
        lost_spread_m: after that time it is lost if the posterior is wider than this, or if there is none.
        search_mps: speed along the square.
        apart: distance between neighbouring legs, in heights of the picture on the ground.
    """

    patience_s: float = tunable(1.5, 0.3, 5.0)
    lost_spread_m: float = tunable(12.0, 3.0, 40.0, log=True)
    search_mps: float = tunable(12.0, 5.0, 25.0)
    apart: float = tunable(0.8, 0.4, 1.5)


@record_kernel()
def fly_in_search(
    beliefs: NDArray[np.void],
    parameters: NDArray[np.void],
    memory: NDArray[np.void],
    times_s: NDArray[np.float64],
    out: NDArray[np.float64],
) -> None:
    """Write the commands of B beliefs (B,), towards the estimate or along the square; see ``catalogue.Kernel``.

    Args:
        parameters: (1,) record of ``SearchParameters``.
    """
    p = parameters[0]
    for k in range(len(beliefs)):
        b, m = beliefs[k], memory[k]
        write_centring(b, p, m, times_s[k], out[k])
        is_known = b.known > 0.0 and 0.0 < b.spread_m <= p.lost_spread_m
        if is_known or b.seconds_since_seen <= p.patience_s:
            m.unseen_s = b.seconds_since_seen
        else:
            out[k, 0], out[k, 1] = _along_square(b, p, b.seconds_since_seen - m.unseen_s)
            out[k, 3] = 0.0


@record_kernel()
def _along_square(b: Any, p: Any, searching_s: float) -> tuple[float, float]:
    """Return the velocity ahead and right along the square about the place last seen."""
    leg_m = max(p.apart * 2.0 * b.half_ahead_m, _SHORTEST_LEG_M)
    place_x_m, place_y_m = expanding_square(p.search_mps * searching_s, leg_m)
    c, s = np.cos(b.heading_rad), np.sin(b.heading_rad)
    # A camera that is pitched forward looks at the square from behind.
    behind_m = b.mount_slope * b.height_m
    east_mps = p.gain_per_s * (b.seen_x_m - b.carrier_x_m + place_x_m - behind_m * c)
    north_mps = p.gain_per_s * (b.seen_y_m - b.carrier_y_m + place_y_m - behind_m * s)
    slower = min(1.0, p.fastest_mps / max(np.hypot(east_mps, north_mps), 1e-9))
    return slower * (c * east_mps + s * north_mps), slower * (s * east_mps - c * north_mps)


@record_kernel()
def expanding_square(way_m: float, leg_m: float) -> tuple[float, float]:
    """Return the point (x, y) at a path length on the square spiral from (0, 0): legs of 1, 1, 2, 2, ... ``leg_m``."""
    x_m, y_m, along_x, along_y, leg = 0.0, 0.0, 1.0, 0.0, 0
    while True:
        length_m = (leg // 2 + 1) * leg_m
        if way_m <= length_m:
            return x_m + way_m * along_x, y_m + way_m * along_y
        x_m, y_m, way_m = x_m + length_m * along_x, y_m + length_m * along_y, way_m - length_m
        along_x, along_y, leg = -along_y, along_x, leg + 1


@register_controller(
    "search", role="baseline", carrier="helicopter", summary="PID; flies an expanding square while the target is lost"
)
class SearchController(KernelController):
    """Centres the target while its position is known; searches for a lost target in an expanding square."""

    Parameters = SearchParameters
    LOOKS, KERNEL = "down", Kernel(fly_in_search, record_dtype(SearchParameters), _MEMORY)
