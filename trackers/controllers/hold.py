"""The controller that never moves: the score of the carrier's start alone."""

from __future__ import annotations

from trackers.controllers.catalogue import register_controller
from trackers.registry import NoParameters
from trackers.types import CameraCommand, Estimate, Observation


@register_controller("hold", role="blind", carrier="helicopter", summary="hovers where it is")
@register_controller("hold", role="blind", carrier="robot", summary="stands where it is")
@register_controller("hold", role="blind", carrier="tank-head", summary="looks at the middle of the tank")
@register_controller("hold", role="blind", carrier="harbour-head", summary="looks at the middle of the quay")
class HoldController:
    """Commands zero on every axis."""

    Parameters = NoParameters

    def __init__(self, parameters: NoParameters) -> None:
        pass

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the zero command."""
        return CameraCommand()
