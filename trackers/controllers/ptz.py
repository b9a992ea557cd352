"""The controller ``lead`` of a camera that sees through the pan-tilt-zoom head that it steers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.belief.features import is_seen
from trackers.belief.sighting import sighting_of
from trackers.controllers.catalogue import register_controller
from trackers.registry import tunable
from trackers.types import CameraCommand, Estimate, Observation


@dataclass(frozen=True)
class LeadPtzParameters:
    """Settings.

    Attributes:
        gain_per_s: turn rate per radian between the optical axis and the goal.
        lead_s: the goal is where the target will be after this time.
        velocity_share: gain of the filter of the target's angular velocity.
        patience_s: time constant of the decay of the velocity while the target is not seen.
        view_m: wanted width of the view at the target's place, by the measured pose over the ground.
        zoom_gain_per_s: rate of zoom per unit of the zoom's logarithm.
        grace_s: for so long after the target was seen the head does not zoom out.
        search_per_s: rate at which it then zooms out.
    """

    gain_per_s: float = tunable(5.0, 0.5, 15.0, log=True)
    lead_s: float = tunable(0.1, 0.0, 0.5)
    velocity_share: float = tunable(0.15, 0.02, 0.6, log=True)
    patience_s: float = tunable(1.0, 0.05, 4.0, log=True)
    view_m: float = tunable(5.0, 2.5, 6.1, log=True)
    zoom_gain_per_s: float = tunable(2.0, 0.2, 6.0, log=True)
    grace_s: float = tunable(0.5, 0.0, 4.0)
    search_per_s: float = tunable(0.5, 0.05, 1.5, log=True)


@dataclass(frozen=True)
class LeadTankParameters(LeadPtzParameters):
    """The same above a tank."""

    view_m: float = tunable(0.11, 0.06, 0.14, log=True)


class LeadPtz:
    """Turns to where the target will be, and searches for it where it went.

    The target's direction d and its angular velocity v, both (3,) in the frame of the measured pose, follow from the
    estimates on which it is seen. The goal is ``d + v lead_s``; without the target it goes on with v, which decays, and
    the head zooms out until the target is seen again.
    """

    Parameters = LeadPtzParameters

    def __init__(self, parameters: LeadPtzParameters) -> None:
        self.parameters = parameters
        self._direction: NDArray[np.float64] | None = None
        self._velocity = np.zeros(3)
        self._seen_s = 0.0

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the command towards the goal."""
        p, camera, ego = self.parameters, observation.camera, observation.ego
        R = np.eye(3) if ego is None else ego.T_world_camera[:3, :3]
        seen = is_seen(estimate)
        if seen:
            ray = R @ [*(estimate.position_px - camera.centre_px) / camera.focal_px, 1.0]
            self._follow(ray / np.linalg.norm(ray), observation.time_s)
        if self._direction is None:
            return CameraCommand()
        waited_s = observation.time_s - self._seen_s
        # The way that the target covers while its velocity decays.
        ahead_s = p.lead_s + p.patience_s * (1.0 - np.exp(-waited_s / p.patience_s))
        x, y, z = (self._direction + ahead_s * self._velocity) @ R
        zoom = 0.0
        depth_m = float(sighting_of("around", observation, estimate)["depth_m"][0])
        if seen and np.isfinite(depth_m):
            zoom = p.zoom_gain_per_s * np.log(depth_m * camera.width_px / (p.view_m * camera.focal_px))
        elif waited_s > p.grace_s:
            zoom = -p.search_per_s
        return CameraCommand(
            pan_rad_s=-p.gain_per_s * float(np.arctan2(x, z)),
            tilt_rad_s=-p.gain_per_s * float(np.arctan2(y, np.hypot(x, z))),
            zoom_per_s=float(zoom),
        )

    def _follow(self, direction: NDArray[np.float64], time_s: float) -> None:
        """Correct direction and velocity by a sighting."""
        passed_s = time_s - self._seen_s
        if self._direction is not None and passed_s > 0.0:
            share = self.parameters.velocity_share
            self._velocity += share * ((direction - self._direction) / passed_s - self._velocity)
        self._direction, self._seen_s = direction, time_s


_SUMMARY = "turns to where the target will be, zooms out where it went when it is lost"


@register_controller("lead", role="ours", carrier="harbour-ptz", summary=_SUMMARY)
class LeadHarbour(LeadPtz):
    """``LeadPtz`` over a harbour."""


@register_controller("lead", role="ours", carrier="tank-ptz", summary=_SUMMARY)
class LeadTank(LeadPtz):
    """``LeadPtz`` above a tank, whose targets are small."""

    Parameters = LeadTankParameters
