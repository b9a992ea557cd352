"""The simple controller of paper A.2: keep the tracker's estimate in the middle of the picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.belief.sighting import within_reach
from trackers.controllers.catalogue import register_controller
from trackers.registry import tunable
from trackers.types import CameraCommand, Estimate, Observation


@dataclass(frozen=True)
class CentreParameters:
    """Setting of the controller. The paper has the first two alone; the others, 0 and 1 by default, make it a PID.

    Attributes:
        gain_per_s: velocity asked for, for each metre that the estimate lies off its aim.
        fastest_mps: limit of the velocity's magnitude.
        integral_per_s2: velocity for each metre second that it has lain off.
        derivative: velocity for each metre a second that it moves off.
        levelled: 1 aims the point under the camera, 0 the one in the middle of the picture, however it tilts.
        climb_mps: how fast it climbs (or sinks) all the time, as far as it may.
        assumed_height_m: height above ground where none is measured.
    """

    gain_per_s: float = tunable(1.8, 0.3, 6.0, log=True)
    fastest_mps: float = tunable(20.0, 8.0, 25.0)
    integral_per_s2: float = tunable(0.0, 0.0, 1.0)
    derivative: float = tunable(0.0, 0.0, 0.5)
    levelled: float = tunable(1.0, 0.0, 1.0)
    climb_mps: float = tunable(0.0, -2.0, 2.0)
    assumed_height_m: float = 60.0


@register_controller(
    "centre_as_written", role="variant", carrier="helicopter", summary="with the values of paper A.2, not tuned"
)
@register_controller("centre", role="baseline", carrier="helicopter", summary="keeps the estimate in the middle (PID)")
class CentreController:
    """Proportional, as written: the velocity is ``gain`` times the estimate's offset on the ground from the camera.

    With a measured pose the offset is where the estimate's ray meets the ground, so that a gust that tilts the camera
    is not answered by flying away from the car. Without one, it is ``h / f * (estimate - centre)`` of a camera that
    looks straight down. It does not turn. An estimate that says nothing (NaN), or lies at or above the horizon, makes
    it hover.
    """

    Parameters = CentreParameters

    def __init__(self, parameters: CentreParameters) -> None:
        self.parameters = parameters
        self._sum_ms = np.zeros(2)
        self._before: tuple[float, NDArray[np.float64]] | None = None

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the command that brings the camera over the estimate."""
        p = self.parameters
        offset_m = self._offset_m(observation, within_reach(estimate.position_px))
        if not np.isfinite(offset_m).all():
            self._before = None
            return CameraCommand(climb_mps=p.climb_mps)
        velocity_mps = p.gain_per_s * offset_m + self._integral_and_derivative(observation.time_s, offset_m)
        velocity_mps *= min(1.0, p.fastest_mps / max(float(np.hypot(*velocity_mps)), 1e-9))
        return CameraCommand(float(velocity_mps[0]), float(velocity_mps[1]), climb_mps=p.climb_mps)

    def _offset_m(self, observation: Observation, position_px: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the estimate's offset (forward, right) on flat ground from what is aimed (2,)."""
        camera, ego = observation.camera, observation.ego
        tangents = (position_px - 0.5 * np.array([camera.width_px, camera.height_px])) / camera.focal_px
        if ego is None:
            return self.parameters.assumed_height_m * np.array([-tangents[1], tangents[0]])
        offset_m = _on_ground_m(ego.T_world_camera, tangents)
        if self.parameters.levelled < 1.0:
            offset_m = offset_m - (1.0 - self.parameters.levelled) * _on_ground_m(ego.T_world_camera, np.zeros(2))
        return offset_m

    def _integral_and_derivative(self, time_s: float, offset_m: NDArray[np.float64]) -> NDArray[np.float64]:
        p = self.parameters
        before, self._before = self._before, (time_s, offset_m)
        if before is None or time_s <= before[0]:
            return p.integral_per_s2 * self._sum_ms
        interval_s = time_s - before[0]
        # Wound up no further than to full speed.
        most_ms = p.fastest_mps / max(p.integral_per_s2, 1e-9)
        self._sum_ms = np.clip(self._sum_ms + interval_s * offset_m, -most_ms, most_ms)
        return p.integral_per_s2 * self._sum_ms + p.derivative * (offset_m - before[1]) / interval_s


def _on_ground_m(T_world_camera: NDArray[np.float64], tangents: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return where a ray, tangents (2,) of its angles right and down, meets the ground: (forward, right) from below
    the camera; NaN at or above the horizon.
    """
    R, height_m = T_world_camera[:3, :3], T_world_camera[2, 3]
    ray = R @ [*tangents, 1.0]
    if not ray[2] < 0.0:
        return np.full(2, np.nan)
    forward = -R[:2, 1] / np.hypot(*R[:2, 1])
    ground_m = ray[:2] * (height_m / -ray[2])
    return np.array([ground_m @ forward, ground_m @ [forward[1], -forward[0]]])
