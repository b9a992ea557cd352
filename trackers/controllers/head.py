"""Controllers of a pan-tilt-zoom head: ``centre`` turns towards the estimate, ``lead`` to where the target will be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trackers.belief.sighting import BeliefFilter
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


@dataclass(frozen=True)
class LeadHeadParameters:
    """Settings.

    Attributes:
        gain_per_s: turn rate per radian between the optical axis and the goal.
        lead_s: the goal is where the target will be after this time.
        patience_s: time constant of the decay of the target's velocity while no estimate comes.
        margin: half the picture's width, as a multiple of one standard deviation of the posterior and the distance
            that the target swims in ``lead_s``, to which the head zooms.
        zoom_gain_per_s: rate of zoom per unit of the zoom's logarithm.
    """

    gain_per_s: float = tunable(8.0, 0.5, 15.0, log=True)
    lead_s: float = tunable(0.1, 0.0, 0.5)
    patience_s: float = tunable(0.5, 0.05, 4.0, log=True)
    margin: float = tunable(12.0, 2.0, 40.0, log=True)
    zoom_gain_per_s: float = tunable(1.0, 0.0, 4.0)


@register_controller(
    "lead", role="ours", carrier="tank-head", summary="turns to where the target will be, zooms out when it is unsure"
)
@register_controller(
    "lead",
    role="ours",
    carrier="harbour-head",
    summary="turns to where the target will be, zooms out when it is unsure",
)
class LeadHeadController:
    """Turns towards the predicted place, by the belief's position and velocity on the ground.

    With the goal ``g = x + v lead_s`` ahead and right of the head at height ``h``::

        pan  = gain_per_s atan2(-g_right, g_ahead)
        tilt = gain_per_s (atan2(h, axis) - atan2(h, |g|))
        zoom = zoom_gain_per_s log(half width of the picture / (margin (spread + |v| lead_s)))

    Without an estimate ``x`` goes on with ``v``, which decays, and the head zooms out.
    """

    Parameters = LeadHeadParameters

    def __init__(self, parameters: LeadHeadParameters) -> None:
        self.parameters = parameters
        self._filter = BeliefFilter("around")
        self._has_known = False

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the command towards the goal."""
        p, belief = self.parameters, self._filter.update(observation, estimate)[0]
        is_known = belief["known"] > 0.0
        self._has_known |= bool(is_known)
        if not self._has_known:
            return CameraCommand()
        waited_s = 0.0 if is_known else float(belief["seconds_since_seen"])
        # The distance that the target covers while its velocity decays.
        ahead_s = p.lead_s + p.patience_s * (1.0 - np.exp(-waited_s / p.patience_s))
        goal_ahead_m = belief["ahead_m"] + ahead_s * belief["velocity_ahead_mps"]
        goal_right_m = belief["right_m"] + ahead_s * belief["velocity_right_mps"]
        height_m = belief["height_m"]
        axis_m = np.hypot(belief["axis_ahead_m"], belief["axis_right_m"])
        tilt_rad = np.arctan2(height_m, axis_m) - np.arctan2(height_m, np.hypot(goal_ahead_m, goal_right_m))
        pan_rad = np.arctan2(-goal_right_m, goal_ahead_m)
        speed_mps = np.hypot(belief["velocity_ahead_mps"], belief["velocity_right_mps"])
        wanted_m = p.margin * (belief["spread_m"] + speed_mps * p.lead_s) + 1e-6
        zoom = p.zoom_gain_per_s * np.log(belief["half_right_m"] / wanted_m) if is_known else -p.zoom_gain_per_s
        return CameraCommand(
            pan_rad_s=p.gain_per_s * float(pan_rad), tilt_rad_s=p.gain_per_s * float(tilt_rad), zoom_per_s=float(zoom)
        )
