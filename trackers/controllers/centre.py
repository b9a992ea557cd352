"""The simple controller of paper A.2: keep the tracker's estimate in the middle of the picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.types import CameraCommand, Estimate, Observation


@dataclass(frozen=True)
class CentreParameters:
    """Setting of the controller.

    Attributes:
        gain_per_s: velocity asked for, for each metre that the estimate lies off the point under the camera.
        fastest_mps: limit of the velocity's magnitude.
        assumed_height_m: height above ground where none is measured.
    """

    gain_per_s: float = 1.8
    fastest_mps: float = 20.0
    assumed_height_m: float = 60.0


class CentreController:
    """Proportional: the velocity is ``gain`` times the estimate's offset on the ground from the camera, limited.

    With a measured pose the offset is where the estimate's ray meets the ground, so that a gust that tilts the camera
    is not answered by flying away from the car. Without one, it is ``h / f * (estimate - centre)`` of a camera that
    looks straight down. It neither climbs nor turns. An estimate that says nothing (NaN), or lies at or above the
    horizon, makes it hover.
    """

    Parameters = CentreParameters

    def __init__(self, parameters: CentreParameters) -> None:
        self._parameters = parameters

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the command that brings the camera over the estimate."""
        p = self._parameters
        offset_m = _ground_offset_m(observation, np.asarray(estimate.position_px), p.assumed_height_m)
        if not np.isfinite(offset_m).all():
            return CameraCommand()
        velocity_mps = p.gain_per_s * offset_m
        velocity_mps *= min(1.0, p.fastest_mps / max(float(np.hypot(*velocity_mps)), 1e-9))
        return CameraCommand(forward_mps=float(velocity_mps[0]), right_mps=float(velocity_mps[1]))


def _ground_offset_m(
    observation: Observation, position_px: NDArray[np.float64], assumed_height_m: float
) -> NDArray[np.float64]:
    """Return the estimate's offset (forward, right) on flat ground from the point under the camera (2,)."""
    camera = observation.camera
    x, y = (position_px - 0.5 * np.array([camera.width_px, camera.height_px])) / camera.focal_px
    if observation.ego is None:
        return assumed_height_m * np.array([-y, x])
    R, height_m = observation.ego.T_world_camera[:3, :3], observation.ego.T_world_camera[2, 3]
    ray = R @ [x, y, 1.0]
    if not ray[2] < 0.0:
        return np.full(2, np.nan)
    forward = -R[:2, 1] / np.hypot(*R[:2, 1])
    ground_m = ray[:2] * (height_m / -ray[2])
    return np.array([ground_m @ forward, ground_m @ [forward[1], -forward[0]]])
