"""The controller that does nothing: what the carrier's start alone is worth."""

from __future__ import annotations

from dataclasses import dataclass

from trackers.controllers.catalogue import register_controller
from trackers.types import CameraCommand, Estimate, Observation


@dataclass(frozen=True)
class HoldParameters:
    """Nothing to set."""


@register_controller("hold", role="blind", carrier="helicopter", summary="hovers where it is")
@register_controller("hold", role="blind", carrier="robot", summary="stands where it is")
class HoldController:
    """Never moves."""

    Parameters = HoldParameters

    def __init__(self, parameters: HoldParameters) -> None:
        pass

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the command to stay."""
        return CameraCommand()
