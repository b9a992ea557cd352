"""The controller that never moves: the score of the carrier's start alone."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackers.controllers.catalogue import Kernel, register_controller
from trackers.registry import NoParameters
from trackers.types import CameraCommand, Estimate, Observation


def stay(beliefs: Any, parameters: Any, memory: Any, times_s: Any, out: NDArray[np.float64]) -> None:
    """Write zero commands, see ``catalogue.Kernel``."""
    out[:] = 0.0


@register_controller("hold", role="blind", carrier="helicopter", summary="hovers where it is")
@register_controller("hold", role="blind", carrier="robot", summary="stands where it is")
@register_controller("hold", role="blind", carrier="tank-head", summary="looks at the middle of the tank")
@register_controller("hold", role="blind", carrier="harbour-head", summary="looks at the middle of the quay")
@register_controller("hold", role="blind", carrier="tank-ptz", summary="looks where it looked at first")
@register_controller("hold", role="blind", carrier="harbour-ptz", summary="looks where it looked at first")
class HoldController:
    """Commands zero on every axis."""

    Parameters, KERNEL = NoParameters, Kernel(stay, np.dtype([]))

    def __init__(self, parameters: NoParameters) -> None:
        pass

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the zero command."""
        return CameraCommand()
