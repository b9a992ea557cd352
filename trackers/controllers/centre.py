"""The controller of paper A.2: keep the estimate in the middle of the picture."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.belief.kernel import mount_slope
from trackers.belief.sighting import within_reach
from trackers.controllers.catalogue import register_controller
from trackers.controllers.pid import IntegralAndDerivative
from trackers.registry import tunable
from trackers.types import CameraCommand, Estimate, Observation


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
        assumed_height_m: height above ground where no pose is measured.
    """

    gain_per_s: float = tunable(1.8, 0.3, 6.0, log=True)
    fastest_mps: float = tunable(20.0, 8.0, 25.0)
    integral_per_s2: float = tunable(0.0, 0.0, 1.0)
    derivative: float = tunable(0.0, 0.0, 0.5)
    levelled: float = tunable(1.0, 0.0, 1.0)
    climb_mps: float = tunable(0.0, -2.0, 2.0)
    turn_per_s: float = 2.0
    assumed_height_m: float = 60.0


@register_controller(
    "centre_as_written", role="variant", carrier="helicopter", summary="with the values of paper A.2, not tuned"
)
@register_controller("centre", role="baseline", carrier="helicopter", summary="keeps the estimate in the middle (PID)")
class CentreController:
    """Commands ``gain`` times the estimate's offset on the ground from the camera; as written it is proportional.

    With a measured pose the offset is where the estimate's ray meets the ground, so a gust that tilts the camera does
    not make it fly away from the car. Without one it is ``h / f * (estimate - centre)``, as for a camera that looks
    straight down. Without an estimate (NaN), or with one at or above the horizon, it hovers.

    The first picture tells whether the camera is pitched forward (``mount_slope``). Then the helicopter keeps as far
    behind the target as the camera looks ahead, and turns its nose to it; otherwise it does not turn.
    """

    Parameters = CentreParameters

    def __init__(self, parameters: CentreParameters) -> None:
        self.parameters = parameters
        self._mount_slope: float | None = None
        self._terms = IntegralAndDerivative[NDArray[np.float64]]()

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the command that brings the camera over the estimate."""
        p = self.parameters
        target_m = self._target_m(observation, within_reach(estimate.position_px))
        ahead_m = self._mount_ahead_m(observation)
        offset_m = target_m - self._aim_m(observation, ahead_m)
        if not np.isfinite(offset_m).all():
            self._terms.interrupt()
            return CameraCommand(climb_mps=p.climb_mps)
        limit_ms = p.fastest_mps / max(p.integral_per_s2, 1e-9)
        terms_mps = self._terms.update(observation.time_s, offset_m, p.integral_per_s2, p.derivative, limit_ms)
        velocity_mps = p.gain_per_s * offset_m + terms_mps
        velocity_mps *= min(1.0, p.fastest_mps / max(float(np.hypot(*velocity_mps)), 1e-9))
        turn_rad_s = 0.0
        if ahead_m > 0.0:
            # A target nearly below the camera has no bearing.
            turn_rad_s = -p.turn_per_s * math.atan2(target_m[1], max(target_m[0], 0.5 * ahead_m))
        return CameraCommand(float(velocity_mps[0]), float(velocity_mps[1]), p.climb_mps, turn_rad_s)

    def _target_m(self, observation: Observation, position_px: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the estimate's place (forward, right) on flat ground from the point below the camera (2,)."""
        camera, ego = observation.camera, observation.ego
        tangents = (position_px - 0.5 * np.array([camera.width_px, camera.height_px])) / camera.focal_px
        if ego is None:
            return self.parameters.assumed_height_m * np.array([-tangents[1], tangents[0]])
        return _on_ground_m(ego.T_world_camera, tangents)

    def _mount_ahead_m(self, observation: Observation) -> float:
        """Return how far ahead the optical axis meets the ground in still air; 0 for a camera that looks down."""
        camera, ego = observation.camera, observation.ego
        if ego is None:
            return 0.0
        height_m = float(ego.T_world_camera[2, 3])
        if self._mount_slope is None:
            axis_m = _on_ground_m(ego.T_world_camera, np.zeros(2))
            self._mount_slope = mount_slope(axis_m[0], height_m, 0.5 * camera.height_px / camera.focal_px * height_m)
        return self._mount_slope * height_m

    def _aim_m(self, observation: Observation, mount_ahead_m: float) -> NDArray[np.float64]:
        """Return the point (forward, right) of the point below the camera over which the estimate is to be (2,)."""
        ego, levelled = observation.ego, self.parameters.levelled
        aim_m = np.array([levelled * mount_ahead_m, 0.0])
        if ego is None or levelled == 1.0:
            return aim_m
        return aim_m + (1.0 - levelled) * _on_ground_m(ego.T_world_camera, np.zeros(2))


def _on_ground_m(T_world_camera: NDArray[np.float64], tangents: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return where a ray, tangents (2,) of its angles right and down, meets the ground: (forward, right) of the point
    below the camera; NaN at or above the horizon.
    """
    R, height_m = T_world_camera[:3, :3], T_world_camera[2, 3]
    ray = R @ [*tangents, 1.0]
    if not ray[2] < 0.0:
        return np.full(2, np.nan)
    forward = -R[:2, 1] / np.hypot(*R[:2, 1])
    ground_m = ray[:2] * (height_m / -ray[2])
    return np.array([ground_m @ forward, ground_m @ [forward[1], -forward[0]]])
