"""``centre`` with an expanding-square search about the point where the target was last seen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.belief.belief_filter import BeliefFilter
from trackers.controllers.catalogue import register_controller
from trackers.controllers.centre import CentreController, CentreParameters
from trackers.registry import tunable
from trackers.types import CameraCommand, Estimate, Observation

_SHORTEST_LEG_M = 1.0


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


@register_controller(
    "search", role="baseline", carrier="helicopter", summary="PID; flies an expanding square while the target is lost"
)
class SearchController(CentreController):
    """Centres the target while its position is known; searches for a lost target in an expanding square."""

    Parameters = SearchParameters
    parameters: SearchParameters

    def __init__(self, parameters: SearchParameters) -> None:
        super().__init__(parameters)
        self._filter = BeliefFilter("down")
        self._searching_s = 0.0

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the command towards the estimate, or along the square."""
        p, belief = self.parameters, self._filter.update(observation, estimate)[0]
        centred = super().command(observation, estimate)
        known = belief["known"] > 0.0 and 0.0 < belief["spread_m"] <= p.lost_spread_m
        if known or belief["seconds_since_seen"] <= p.patience_s:
            self._searching_s = 0.0
            return centred
        self._searching_s += self._filter.interval_s
        leg_m = max(p.apart * 2.0 * belief["half_ahead_m"], _SHORTEST_LEG_M)
        place_m = expanding_square(p.search_mps * self._searching_s, leg_m)
        seen_m = np.array([belief["seen_x_m"] - belief["carrier_x_m"], belief["seen_y_m"] - belief["carrier_y_m"]])
        c, s = np.cos(belief["heading_rad"]), np.sin(belief["heading_rad"])
        # A camera that is pitched forward looks at the square from behind.
        behind_m = belief["mount_slope"] * belief["height_m"] * np.array([c, s])
        velocity_mps = p.gain_per_s * (seen_m + place_m - behind_m)
        velocity_mps *= min(1.0, p.fastest_mps / max(float(np.hypot(*velocity_mps)), 1e-9))
        ahead_mps, right_mps = np.array([[c, s], [s, -c]]) @ velocity_mps
        return CameraCommand(float(ahead_mps), float(right_mps), climb_mps=p.climb_mps)


def expanding_square(way_m: float, leg_m: float) -> NDArray[np.float64]:
    """Return the point (2,) at a path length on the square spiral from (0, 0): legs of 1, 1, 2, 2, ... ``leg_m``."""
    place_m, direction = np.zeros(2), np.array([1.0, 0.0])
    leg = 0
    while True:
        length_m = (leg // 2 + 1) * leg_m
        if way_m <= length_m:
            return place_m + way_m * direction
        place_m, way_m = place_m + length_m * direction, way_m - length_m
        direction, leg = np.array([-direction[1], direction[0]]), leg + 1
