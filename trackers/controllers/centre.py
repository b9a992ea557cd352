"""The simple controller of paper A.2: keep the tracker's estimate in the middle of the picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trackers.types import CameraCommand, Estimate, Observation


@dataclass(frozen=True)
class Parameters:
    """Setting of the controller.

    Attributes:
        gain_per_s: velocity asked for, for each metre that the estimate lies off the middle.
        fastest_mps: limit of the velocity's magnitude.
        assumed_height_m: height above ground where none is measured.
    """

    gain_per_s: float = 1.2
    fastest_mps: float = 20.0
    assumed_height_m: float = 60.0


class CentreController:
    """Proportional: the velocity over ground is ``gain * h / f * (estimate - centre)``, limited.

    h is the measured height, f the focal length: the offset in metres of the estimate on flat ground seen straight down.
    It neither climbs nor turns. An estimate that says nothing (NaN) makes it hover.
    """

    Parameters = Parameters

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the command that brings the estimate to the middle."""
        camera, p = observation.camera, self._parameters
        height_m = p.assumed_height_m if observation.ego is None else observation.ego.T_world_camera[2, 3]
        offset_px = np.asarray(estimate.position_px) - 0.5 * np.array([camera.width_px, camera.height_px])
        if not np.isfinite(offset_px).all():
            return CameraCommand()
        velocity_mps = p.gain_per_s * offset_px * height_m / camera.focal_px
        velocity_mps *= min(1.0, p.fastest_mps / max(float(np.hypot(*velocity_mps)), 1e-9))
        return CameraCommand(forward_mps=-float(velocity_mps[1]), right_mps=float(velocity_mps[0]))
