"""A ground robot's PID controller: turn towards the estimate and keep a distance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trackers.belief.sighting import distance_m, within_reach
from trackers.controllers.catalogue import register_controller
from trackers.controllers.pid import IntegralAndDerivative
from trackers.registry import tunable
from trackers.types import CameraCommand, Estimate, Observation


@dataclass(frozen=True)
class CentreRobotParameters:
    """Settings.

    Attributes:
        turn_gain_per_s: turn rate per radian of the estimate's bearing.
        turn_integral_per_s2: turn rate per radian second of integrated bearing.
        turn_derivative: turn rate per rad/s of change of the bearing.
        speed_gain_per_s: speed per metre that the target is too far away; negative where it is too near.
        distance_m: distance to keep.
        assumed_distance_m: distance of the target if the tracker does not measure it.
    """

    turn_gain_per_s: float = tunable(2.2, 0.5, 6.0, log=True)
    turn_integral_per_s2: float = tunable(0.0, 0.0, 2.0)
    turn_derivative: float = tunable(0.0, 0.0, 0.5)
    speed_gain_per_s: float = tunable(1.1, 0.3, 3.0, log=True)
    distance_m: float = tunable(1.8, 1.2, 3.0)
    assumed_distance_m: float = 3.0


_INTEGRAL_LIMIT_RAD_S = 0.5
"""Limit of the integral: its largest turn rate is half its gain."""


@register_controller(
    "centre_as_written", role="variant", carrier="robot", summary="with its values as written, not tuned"
)
@register_controller(
    "centre", role="baseline", carrier="robot", summary="turns to the estimate (PID) and keeps a distance"
)
class CentreRobotController:
    """Turns and drives by PID; as written it is proportional. Without an estimate (NaN) it stands still."""

    Parameters = CentreRobotParameters

    def __init__(self, parameters: CentreRobotParameters) -> None:
        self.parameters = parameters
        self._terms = IntegralAndDerivative[float]()

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the command that brings the estimate to the middle and to its distance."""
        p, camera = self.parameters, observation.camera
        if not np.isfinite(estimate.position_px).all():
            self._terms.interrupt()
            return CameraCommand()
        # Positive to the left, as turn rates are.
        right_px = within_reach(estimate.position_px)[0] - 0.5 * camera.width_px
        bearing_rad = -float(np.arctan(right_px / camera.focal_px))
        depth_m = distance_m(estimate, p.assumed_distance_m)
        off_m = depth_m / np.cos(bearing_rad) - p.distance_m
        gains = p.turn_integral_per_s2, p.turn_derivative
        terms_rad_s = self._terms.update(observation.time_s, bearing_rad, *gains, _INTEGRAL_LIMIT_RAD_S)
        return CameraCommand(
            forward_mps=float(p.speed_gain_per_s * off_m * np.cos(bearing_rad)),
            yaw_rate_rad_s=float(p.turn_gain_per_s * bearing_rad + terms_rad_s),
        )
