"""The controller of a pan-tilt-zoom head that turns towards the estimate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trackers.belief.belief_filter import BeliefFilter
from trackers.controllers.catalogue import register_controller
from trackers.registry import tunable
from trackers.types import CameraCommand, Estimate, Observation


@dataclass(frozen=True)
class CentreHeadParameters:
    """Settings.

    Attributes:
        gain_per_s: turn rate per radian of the estimate's angle from the optical axis.
    """

    gain_per_s: float = tunable(4.0, 0.5, 15.0, log=True)


@register_controller("centre_as_written", role="variant", carrier="tank-head", summary="with its gain not tuned")
@register_controller("centre", role="baseline", carrier="tank-head", summary="turns towards the estimate")
@register_controller("centre_as_written", role="variant", carrier="harbour-head", summary="with its gain not tuned")
@register_controller("centre", role="baseline", carrier="harbour-head", summary="turns towards the estimate")
class CentreHeadController:
    """Turns in proportion to the angle; does not zoom. Without an estimate (NaN) the head stays."""

    Parameters = CentreHeadParameters

    def __init__(self, parameters: CentreHeadParameters) -> None:
        self.parameters = parameters
        self._filter = BeliefFilter("around")

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the command that turns the optical axis towards the estimate."""
        belief, view = self._filter.update(observation, estimate)[0], observation.steered or observation
        if belief["known"] == 0.0:
            return CameraCommand()
        camera, gain = view.camera, self.parameters.gain_per_s
        right_rad = np.arctan(belief["picture_x"] * 0.5 * camera.width_px / camera.focal_px)
        down_rad = np.arctan(belief["picture_y"] * 0.5 * camera.height_px / camera.focal_px)
        return CameraCommand(pan_rad_s=-gain * float(right_rad), tilt_rad_s=-gain * float(down_rad))
