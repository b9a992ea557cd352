"""The controller that searches as the books say: in an expanding square about the place where the target was lost."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.belief.belief_filter import BeliefKeeper
from trackers.controllers.catalogue import register_controller
from trackers.controllers.centre import CentreController, CentreParameters
from trackers.registry import tunable
from trackers.types import CameraCommand, Estimate, Observation

_SHORTEST_LEG_M = 1.0


@dataclass(frozen=True)
class SearchParameters(CentreParameters):
    """Setting of the controller: that of ``centre`` and of the search.

    Attributes:
        patience_s: how long the target is out of view before it may count as lost.
        lost_spread_m: it is lost where the posterior is wider; where there is none, it is lost at once then.
        search_mps: how fast the square is flown.
        apart: distance of neighbouring legs, in heights of the picture on the ground.
    """

    patience_s: float = tunable(1.5, 0.3, 5.0)
    lost_spread_m: float = tunable(12.0, 3.0, 40.0, log=True)
    search_mps: float = tunable(12.0, 5.0, 25.0)
    apart: float = tunable(0.8, 0.4, 1.5)


@register_controller(
    "search", role="baseline", carrier="helicopter", summary="PID; flies an expanding square while the target is lost"
)
class SearchController:
    """``centre`` while the target is seen or its place known, else an expanding square about where it was seen."""

    Parameters = SearchParameters

    def __init__(self, parameters: SearchParameters) -> None:
        self._centre = CentreController(parameters)
        self.parameters = parameters
        self._keeper = BeliefKeeper("down")
        self._searching_s = 0.0

    @property
    def parameters(self) -> SearchParameters:
        """The setting; another may take its place between two pictures."""
        return self._parameters

    @parameters.setter
    def parameters(self, parameters: SearchParameters) -> None:
        self._parameters = parameters
        self._centre.parameters = parameters

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the command that brings the camera over the estimate, or on along the square."""
        p, belief = self._parameters, self._keeper.update(observation, estimate)[0]
        centred = self._centre.command(observation, estimate)
        known = belief["known"] > 0.0 and 0.0 < belief["spread_m"] <= p.lost_spread_m
        if known or belief["seconds_since_seen"] <= p.patience_s:
            self._searching_s = 0.0
            return centred
        self._searching_s += self._keeper.interval_s
        leg_m = max(p.apart * 2.0 * belief["half_ahead_m"], _SHORTEST_LEG_M)
        place_m = expanding_square(p.search_mps * self._searching_s, leg_m)
        seen_m = np.array([belief["seen_x_m"] - belief["carrier_x_m"], belief["seen_y_m"] - belief["carrier_y_m"]])
        velocity_mps = p.gain_per_s * (seen_m + place_m)
        velocity_mps *= min(1.0, p.fastest_mps / max(float(np.hypot(*velocity_mps)), 1e-9))
        c, s = np.cos(belief["heading_rad"]), np.sin(belief["heading_rad"])
        ahead_mps, right_mps = np.array([[c, s], [s, -c]]) @ velocity_mps
        return CameraCommand(float(ahead_mps), float(right_mps), climb_mps=p.climb_mps)


def expanding_square(way_m: float, leg_m: float) -> NDArray[np.float64]:
    """Return the place (2,) after a way along the square spiral from (0, 0): legs of 1, 1, 2, 2, 3, 3 ... ``leg_m``."""
    place_m, direction = np.zeros(2), np.array([1.0, 0.0])
    leg = 0
    while True:
        length_m = (leg // 2 + 1) * leg_m
        if way_m <= length_m:
            return place_m + way_m * direction
        place_m, way_m = place_m + length_m * direction, way_m - length_m
        direction, leg = np.array([-direction[1], direction[0]]), leg + 1
