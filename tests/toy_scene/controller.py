"""What steers the yard's pan-tilt-zoom head: nothing, or a controller that keeps the belief in the middle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trackers.belief.sighting import BeliefFilter
from trackers.controllers.catalogue import register_controller
from trackers.controllers.hold import HoldController
from trackers.registry import tunable
from trackers.types import CameraCommand, Estimate, Observation

register_controller("hold", role="blind", carrier="yard-head", summary="looks where it looked")(HoldController)


@dataclass(frozen=True)
class CentreHeadParameters:
    """Settings.

    Attributes:
        gain_per_s: turn rate for each radian that the target lies off the middle.
    """

    gain_per_s: float = tunable(2.0, 0.3, 6.0, log=True)


@register_controller("centre", role="baseline", carrier="yard-head", summary="turns towards the estimate")
class CentreHead:
    """See ``trackers.protocols.Controller``. Proportional; without an estimate the head stays."""

    Parameters = CentreHeadParameters

    def __init__(self, parameters: CentreHeadParameters) -> None:
        self.parameters = parameters
        self._filter = BeliefFilter("around")

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """See ``Controller``."""
        belief = self._filter.update(observation, estimate)[0]
        if belief["known"] == 0.0 or observation.steered is None:
            return CameraCommand()
        camera, gain = observation.steered.camera, self.parameters.gain_per_s
        right_rad = np.arctan(belief["picture_x"] * 0.5 * camera.width_px / camera.focal_px)
        down_rad = np.arctan(belief["picture_y"] * 0.5 * camera.height_px / camera.focal_px)
        return CameraCommand(pan_rad_s=-gain * float(right_rad), tilt_rad_s=-gain * float(down_rad))
