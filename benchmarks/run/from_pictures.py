"""What the run loop asks of a contestant, and how a tracker becomes one."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from scenarios.scenario import Frame
from trackers.protocols import Tracker
from trackers.types import Estimate


class Contestant(Protocol):
    """One that is asked at every frame where the target is."""

    def initialise(self, frame: Frame, box_xyxy: NDArray[np.float64]) -> None:
        """Start on the target inside ``box_xyxy`` (4,) of the first frame."""
        ...

    def update(self, frame: Frame) -> Estimate:
        """Say where the target is on the next frame."""
        ...


class FromPictures:
    """A tracker as a contestant: it is handed the observation of a frame, and nothing of its truth."""

    def __init__(self, tracker: Tracker) -> None:
        self._tracker = tracker

    def initialise(self, frame: Frame, box_xyxy: NDArray[np.float64]) -> None:
        """See ``Contestant``."""
        self._tracker.initialise(frame.observation, box_xyxy)

    def update(self, frame: Frame) -> Estimate:
        """See ``Contestant``."""
        return self._tracker.update(frame.observation)
