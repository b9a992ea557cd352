"""Ours: keeps the target where it stays in view, whatever the air does, and goes where it will come back into view."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from trackers.belief.belief_filter import BeliefKeeper
from trackers.controllers.catalogue import register_controller
from trackers.controllers.reentry_kernel import REENTRY, steer
from trackers.registry import tunable
from trackers.types import CameraCommand, Estimate, Observation


@dataclass(frozen=True)
class ReentryParameters:
    """Setting of the controller.

    Attributes:
        gain_per_s: velocity for each metre that the target lies off its place.
        urgent_per_s: velocity more for each metre that it lies outside the picture.
        push_s: how much the carrier's lag is made up for: seconds of the acceleration wanted.
        gust_lead_s: how far ahead a swing of the optical axis is taken to go on.
        lean: how far the target's place goes along when the optical axis swings away; 0 keeps it under the camera.
        damping: share of the velocity at which the target moves off its place that is taken back.
        border: share of the picture's half sizes, along its border, that is not counted as in view.
        rest: how far off its place, in halves of the picture, the target may lie before anything is done.
        height_m: height above ground flown at while it is known where the target is.
        sink_mps: how fast it sinks to that.
        doubt: a posterior wider than this, in halves of the picture's height on the ground, is of a lost target.
        patience_s: how long a target of a tracker without posterior may be out of view before it counts as lost.
        search_mps: how fast the search for such a one goes outwards.
        fastest_mps: limit of the velocity's magnitude.
    """

    gain_per_s: float = tunable(1.0, 0.2, 8.0, log=True)
    urgent_per_s: float = tunable(1.0, 0.0, 8.0)
    push_s: float = tunable(0.45, 0.0, 2.0)
    gust_lead_s: float = tunable(0.45, 0.0, 1.5)
    lean: float = tunable(0.45, 0.0, 0.7)
    damping: float = tunable(0.25, 0.0, 0.8)
    border: float = tunable(0.14, 0.05, 0.5)
    rest: float = tunable(0.05, 0.0, 0.5)
    height_m: float = tunable(40.0, 40.0, 65.0)
    sink_mps: float = tunable(4.0, 0.5, 5.0)
    doubt: float = 0.4
    patience_s: float = 1.5
    search_mps: float = 6.0
    fastest_mps: float = 25.0


@register_controller(
    "reentry",
    role="ours",
    carrier="helicopter",
    summary="keeps the target in view, or flies to where it will come back",
    kernel=(steer, REENTRY),
)
class ReentryController:
    """Flies no further than it must to have the target in view, soon and after the gust.

    All places are on the ground, ahead and right of the point below the camera. With the place ``x`` and the velocity
    ``v`` of the target, the own velocity ``u``, the picture's inner part ``Q`` (the border cut off) and the optical
    axis ``a``, all as believed::

        a' = a + gust_lead_s (da/dt along a)
        g  = the place within Q(a') nearest to: lean a', brought within Q(0)
        e  = x - g, less what of it is nearer than ``rest``
        s  = the place within Q(a') nearest to x
        w  = v + gain_per_s e + urgent_per_s (x - s) + damping (v - u - lean da/dt)
        command = w + push_s (w - u), no faster than fastest_mps

    In still air ``g`` is about the point below the camera. A gust that throws the view aside takes ``g`` along part of
    the way: into the tilted picture, and still within the level one, so that the target is in view while the gust
    lasts and when it is over. Lower down the same tilt is fewer metres of flight, so the helicopter sinks.

    A target is lost when its posterior is wider than ``doubt``. Then ``x`` is the densest window of the posterior (its
    tracker knows where it was looked for in vain), ``v`` fades, and the helicopter climbs until the picture is as large
    as the posterior. With a tracker that gives none, the search goes outwards from the place last seen, where it was
    not looked yet, at first the way that the target was heading.
    """

    Parameters = ReentryParameters

    def __init__(self, parameters: ReentryParameters) -> None:
        self.parameters = parameters
        self._keeper = BeliefKeeper("down")
        self._command = np.zeros((1, 4))

    @property
    def parameters(self) -> ReentryParameters:
        """The setting; another may take its place between two pictures."""
        return self._parameters

    @parameters.setter
    def parameters(self, parameters: ReentryParameters) -> None:
        self._parameters = parameters
        self._record = np.array([dataclasses.astuple(parameters)], REENTRY)

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the command for what is now believed."""
        steer(self._keeper.update(observation, estimate), self._record, self._command)
        return CameraCommand(*(float(number) for number in self._command[0]))
