"""The contract of a tracker that sees no pictures and receives the target's true state at each exit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from trackers.protocols import Tracker
from trackers.types import Observation


@dataclass(frozen=True, slots=True)
class TargetState:
    """The target's true state at one time, in the camera's frame (x right, y down, z forward).

    Attributes:
        place_m: (3,) position of its centre.
        velocity_mps: (3,) velocity over the ground.
    """

    place_m: NDArray[np.float64]
    velocity_mps: NDArray[np.float64]


@runtime_checkable
class BlindTracker(Tracker, Protocol):
    """A tracker whose observations hold only time, camera model and measured ego pose; its pictures are empty."""

    def set_state(self, observation: Observation, state: TargetState) -> None:
        """Set the target's true state at the time of ``observation``: at the first picture and at each exit."""
        ...
