"""The contracts of this package: trackers of one target and of many, and a controller that steers by one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from trackers.types import CameraCommand, CameraModel, Estimate, Observation, Track


class Tracker(Protocol):
    """Follows one target. Told where it is once, then asked at every picture."""

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """Start on the target inside ``box_xyxy`` (4,) of the first picture."""
        ...

    def update(self, observation: Observation) -> Estimate:
        """Take in the next picture and say where the target is now, inside the picture or not."""
        ...


class MultiTracker(Protocol):
    """Follows any number of targets. No target is pointed at: it finds them itself."""

    def start(self, background: Sequence[Observation], camera: CameraModel) -> None:
        """Start with pictures without targets, in order of time and maybe none, and the camera's calibration."""
        ...

    def update(self, observation: Observation) -> Sequence[Track]:
        """Take in the next picture, the first one included, and return all targets that there are now.

        No identity may stand twice in an answer. A track that is left out has ended for now; its identity may come
        back later for the same target.
        """
        ...


class Controller(Protocol):
    """Steers the camera's carrier by what a tracker believes."""

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the command that holds until the next picture."""
        ...
