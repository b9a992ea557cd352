"""The two contracts of this package: a tracker, and a controller that steers by one."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from trackers.types import CameraCommand, Estimate, Observation


class Tracker(Protocol):
    """Follows one target. Told where it is once, then asked at every picture."""

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """Start on the target inside ``box_xyxy`` (4,) of the first picture."""
        ...

    def update(self, observation: Observation) -> Estimate:
        """Take in the next picture and say where the target is now, inside the picture or not."""
        ...


class Controller(Protocol):
    """Steers the camera's carrier by what a tracker believes."""

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the command that holds until the next picture."""
        ...
