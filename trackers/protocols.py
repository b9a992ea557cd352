"""The contracts of this package: trackers of one target and of many, and controllers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from trackers.gaps import GapMethod
from trackers.types import CameraCommand, CameraModel, Estimate, Observation, SiteSurvey, Start, Track


class Tracker(Protocol):
    """Follows one target, given its box in the first picture."""

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """Start on the target inside ``box_xyxy`` (4,) of the first picture."""
        ...

    def update(self, observation: Observation) -> Estimate:
        """Return the estimate of the target on the next picture, inside its borders or not."""
        ...


@runtime_checkable
class OutsourcingTracker(Protocol):
    """A tracker, of one target or of many, that others work for: processes, or trackers of the same pictures whose
    results it shares.

    Attributes:
        elsewhere_cpu_s: CPU time in seconds that they spent for it on the latest picture, >= 0; it counts as its own.
    """

    elsewhere_cpu_s: float


class MultiTracker(Protocol):
    """Follows any number of targets, which it detects itself."""

    def start(self, background: Sequence[Observation], camera: CameraModel) -> None:
        """Start with pictures without targets, in order of time, possibly none, and the camera's calibration."""
        ...

    def update(self, observation: Observation) -> Sequence[Track]:
        """Return the tracks of all targets on the next picture; the first call gets the first picture.

        Each identity occurs at most once in an answer. A track may be left out and return later with the same identity
        for the same target.
        """
        ...


@runtime_checkable
class SiteTracker(MultiTracker, Protocol):
    """A ``MultiTracker`` of a surveyed site."""

    def survey(self, site: SiteSurvey) -> None:
        """Take in the survey, before ``start``; not called where there is none."""
        ...


@runtime_checkable
class RevisingTracker(MultiTracker, Protocol):
    """A ``MultiTracker`` that decides identities later than it answers."""

    def revised(self) -> Sequence[Sequence[Track]]:
        """Return the answers on all pictures so far, as decided with hindsight; called once, after the last picture."""
        ...


@runtime_checkable
class BridgingTracker(MultiTracker, Protocol):
    """A ``MultiTracker`` that also offers its method to bridge gaps, from its construction on.

    The method that is judged is a copy made before ``start``: it learns by ``learn`` alone.
    """

    gap_method: GapMethod


@runtime_checkable
class DecidingTracker(MultiTracker, Protocol):
    """A ``MultiTracker`` that also answers with tracks that it holds for unlikely, so that all its confidences are
    judged.

    Attributes:
        decides_at: confidence from which on a track is its decision, in [0, 1].
    """

    decides_at: float


def begin(tracker: MultiTracker, start: Start) -> None:
    """Start a tracker with its inputs before the first picture, the site's survey too if it is a ``SiteTracker``."""
    if isinstance(tracker, SiteTracker) and start.site is not None:
        tracker.survey(start.site)
    tracker.start(start.background, start.camera)


class Controller(Protocol):
    """Steers the camera's carrier by a tracker's estimates."""

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the command until the next picture."""
        ...


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
