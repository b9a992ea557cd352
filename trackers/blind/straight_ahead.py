"""A blind tracker of a followed person: always the same distance straight ahead of the camera."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.blind.protocol import TargetState
from trackers.registry import register, tunable
from trackers.types import Estimate, Observation


@dataclass(frozen=True)
class AheadParameters:
    """Setting of ``blind_ahead``.

    Attributes:
        ahead_m: distance of the target along the camera's axis.
    """

    ahead_m: float = tunable(2.0, 1.0, 6.0)


@register(
    "blind_ahead", role="blind", summary="always the same distance straight ahead of the camera", suites=("stereo",)
)
class StraightAhead:
    """Returns the same position and distance on every frame."""

    Parameters = AheadParameters

    def __init__(self, parameters: AheadParameters, rng: np.random.Generator) -> None:
        self._ahead_m = parameters.ahead_m

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """See ``Tracker``."""

    def set_state(self, observation: Observation, state: TargetState) -> None:
        """See ``BlindTracker``."""

    def update(self, observation: Observation) -> Estimate:
        """See ``Tracker``."""
        camera = observation.camera
        return Estimate(0.5 * np.array([camera.width_px, camera.height_px]), depth_m=self._ahead_m)
