"""A ground robot's simple controller: turn towards the estimate, keep a distance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trackers.belief.sighting import distance_m, within_reach
from trackers.controllers.catalogue import register_controller
from trackers.registry import tunable
from trackers.types import CameraCommand, Estimate, Observation


@dataclass(frozen=True)
class CentreRobotParameters:
    """Settings.

    Attributes:
        turn_gain_per_s: turn rate for each radian that the estimate lies off the middle.
        turn_integral_per_s2: turn rate for each radian second that it has lain off.
        turn_derivative: turn rate for each radian a second that it moves off.
        speed_gain_per_s: speed for each metre that it is too far away; backwards where it is too near.
        distance_m: how far away it is wanted.
        assumed_distance_m: how far away it is by a tracker that does not measure it.
    """

    turn_gain_per_s: float = tunable(2.2, 0.5, 6.0, log=True)
    turn_integral_per_s2: float = tunable(0.0, 0.0, 2.0)
    turn_derivative: float = tunable(0.0, 0.0, 0.5)
    speed_gain_per_s: float = tunable(1.1, 0.3, 3.0, log=True)
    distance_m: float = tunable(1.8, 1.2, 3.0)
    assumed_distance_m: float = 3.0


_MOST_WOUND_UP_RAD_S = 0.5
"""The integral grows no further: a turn rate of half its gain."""


@register_controller(
    "centre_as_written", role="variant", carrier="robot", summary="with the values that it was written with, not tuned"
)
@register_controller(
    "centre", role="baseline", carrier="robot", summary="turns to the estimate (PID) and keeps a distance"
)
class CentreRobotController:
    """Proportional, as written. An estimate that says nothing (NaN) makes it stand still."""

    Parameters = CentreRobotParameters

    def __init__(self, parameters: CentreRobotParameters) -> None:
        self.parameters = parameters
        self._sum_rad_s = 0.0
        self._before: tuple[float, float] | None = None

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the command that brings the estimate into the middle and to its distance."""
        p, camera = self.parameters, observation.camera
        if not np.isfinite(estimate.position_px).all():
            self._before = None
            return CameraCommand()
        # Positive to the left, as turn rates are.
        right_px = within_reach(estimate.position_px)[0] - 0.5 * camera.width_px
        bearing_rad = -float(np.arctan(right_px / camera.focal_px))
        depth_m = distance_m(estimate, p.assumed_distance_m)
        off_m = depth_m / np.cos(bearing_rad) - p.distance_m
        return CameraCommand(
            forward_mps=float(p.speed_gain_per_s * off_m * np.cos(bearing_rad)),
            yaw_rate_rad_s=p.turn_gain_per_s * bearing_rad + self._integral_and_derivative(observation, bearing_rad),
        )

    def _integral_and_derivative(self, observation: Observation, bearing_rad: float) -> float:
        p = self.parameters
        before, self._before = self._before, (observation.time_s, bearing_rad)
        if before is None or observation.time_s <= before[0]:
            return p.turn_integral_per_s2 * self._sum_rad_s
        interval_s = observation.time_s - before[0]
        wound_up_rad_s = self._sum_rad_s + interval_s * bearing_rad
        self._sum_rad_s = min(max(wound_up_rad_s, -_MOST_WOUND_UP_RAD_S), _MOST_WOUND_UP_RAD_S)
        return p.turn_integral_per_s2 * self._sum_rad_s + p.turn_derivative * (bearing_rad - before[1]) / interval_s
