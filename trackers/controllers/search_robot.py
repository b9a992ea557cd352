"""``centre`` of a ground robot with a search for a lost target."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trackers.belief.belief_filter import BeliefFilter
from trackers.controllers.catalogue import register_controller
from trackers.controllers.centre_robot import CentreRobotController, CentreRobotParameters
from trackers.registry import tunable
from trackers.types import CameraCommand, Estimate, Observation

_FASTEST_MPS = 1.0


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


@register_controller(
    "search",
    role="baseline",
    carrier="robot",
    summary="centres; searches for a lost target on its side, then where it was last seen",
)
class SearchRobotController(CentreRobotController):
    """Centres the target while there is an estimate. Otherwise it turns for a while to the side where the target left
    the picture, then drives to the point where it was last seen and turns there.
    """

    Parameters = SearchRobotParameters
    parameters: SearchRobotParameters

    def __init__(self, parameters: SearchRobotParameters) -> None:
        super().__init__(parameters)
        self._filter = BeliefFilter("ahead")
        self._lost_at_s: float | None = None

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the command to centre the target or to search for it."""
        belief = self._filter.update(observation, estimate)[0]
        if belief["known"] > 0.0:
            self._lost_at_s = None
            return super().command(observation, estimate)
        if self._lost_at_s is None:
            self._lost_at_s = observation.time_s
        p = self.parameters
        # ``picture_x`` is that of the latest estimate.
        turn_rad_s = -p.search_rad_s if belief["picture_x"] > 0.0 else p.search_rad_s
        if belief["frames"] <= 1.0 or observation.time_s - self._lost_at_s < p.turn_s:
            return CameraCommand(yaw_rate_rad_s=turn_rad_s)
        east_m = float(belief["seen_x_m"] - belief["carrier_x_m"])
        north_m = float(belief["seen_y_m"] - belief["carrier_y_m"])
        distance_m = float(np.hypot(east_m, north_m))
        if distance_m < p.reached_m:
            return CameraCommand(yaw_rate_rad_s=turn_rad_s)
        bearing_rad = float(np.arctan2(north_m, east_m) - belief["heading_rad"])
        bearing_rad = (bearing_rad + np.pi) % (2 * np.pi) - np.pi
        speed_mps = min(p.speed_gain_per_s * distance_m, _FASTEST_MPS) * max(np.cos(bearing_rad), 0.0)
        return CameraCommand(forward_mps=float(speed_mps), yaw_rate_rad_s=p.turn_gain_per_s * bearing_rad)
