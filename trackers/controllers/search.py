"""``centre`` with an expanding-square search about the point where the target was last seen."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from trackers.controllers.catalogue import Kernel, register_controller
from trackers.controllers.centre import CentreParameters, write_centring
from trackers.controllers.kernel_controller import KernelController, record_dtype
from trackers.controllers.pid import PID_FIELDS
from trackers.registry import tunable

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


@njit(cache=True)
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


@njit(cache=True)
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


@njit(cache=True)
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
