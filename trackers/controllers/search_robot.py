"""A ground robot's controller that centres the target, and looks for it once it is lost."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trackers.belief.belief_filter import BeliefKeeper
from trackers.controllers.catalogue import register_controller
from trackers.controllers.centre_robot import CentreRobotController, CentreRobotParameters
from trackers.registry import tunable
from trackers.types import CameraCommand, Estimate, Observation

_FASTEST_MPS = 1.0


@dataclass(frozen=True)
class SearchRobotParameters(CentreRobotParameters):
    """Settings of the centring, and of the search.

    Attributes:
        turn_s: how long a lost target is looked for where the robot stands, to the side it left by.
        search_rad_s: turn rate while searching.
        reached_m: how near the place where it was last seen is near enough; there the robot turns on.
    """

    turn_s: float = tunable(1.0, 0.0, 6.0)
    search_rad_s: float = tunable(0.8, 0.3, 1.6)
    reached_m: float = tunable(0.6, 0.3, 1.5)


@register_controller(
    "search", role="baseline", carrier="robot", summary="centres; a lost target is looked for to its side, then there"
)
class SearchRobotController:
    """Centres what is known. Else it turns to the side of the picture where the target was last, for a while, goes to
    the place where it was last seen, and turns there.
    """

    Parameters = SearchRobotParameters

    def __init__(self, parameters: SearchRobotParameters) -> None:
        self._centre = CentreRobotController(parameters)
        self.parameters = parameters
        self._keeper = BeliefKeeper("ahead")
        self._lost_at_s: float | None = None

    @property
    def parameters(self) -> SearchRobotParameters:
        """The setting; another may take its place between two pictures."""
        return self._parameters

    @parameters.setter
    def parameters(self, parameters: SearchRobotParameters) -> None:
        self._parameters = parameters
        self._centre.parameters = parameters

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the command to centre the target or to search for it."""
        belief = self._keeper.update(observation, estimate)[0]
        if belief["known"] > 0.0:
            self._lost_at_s = None
            return self._centre.command(observation, estimate)
        if self._lost_at_s is None:
            self._lost_at_s = observation.time_s
        p = self._parameters
        # ``picture_x`` is still that of the latest estimate.
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
