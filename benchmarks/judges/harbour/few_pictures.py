"""Trackers that get only some of the pictures without intruders: what is learnt from how many?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.contract.tracker_spec import TrackerSpec
from scenarios.loop import LoopTracker, ManyFromPictures
from scenarios.scenario import Episode, Scenario
from trackers import registry
from trackers.eigen_swarm.tracker import EigenSwarm
from trackers.harbour_watch.tracker import HarbourWatch
from trackers.protocols import MultiTracker, begin
from trackers.types import CameraModel, Observation, SiteSurvey, Start, Track

COUNTS = (25, 100)
"""Numbers of pictures; the trackers themselves get all of the preset."""


class FewPictures:
    """A ``MultiTracker`` that passes on ``count`` of the pictures, evenly over time, or all if there are not more."""

    def __init__(self, tracker: MultiTracker, count: int) -> None:
        self._tracker, self._count = tracker, count
        self._site: SiteSurvey | None = None

    @property
    def decides_at(self) -> float:
        """See ``DecidingTracker``."""
        return getattr(self._tracker, "decides_at", 0.0)

    def survey(self, site: SiteSurvey) -> None:
        """See ``SiteTracker``."""
        self._site = site

    def start(self, background: Sequence[Observation], camera: CameraModel) -> None:
        """See ``MultiTracker``."""
        chosen = np.linspace(0, len(background) - 1, min(self._count, len(background))).round().astype(int)
        begin(self._tracker, Start(camera, background=tuple(background[k] for k in chosen), site=self._site))

    def update(self, observation: Observation) -> Sequence[Track]:
        """See ``MultiTracker``."""
        return self._tracker.update(observation)


@dataclass(frozen=True, kw_only=True)
class TaughtByFew(TrackerSpec):
    """A registered tracker that learns from ``count`` pictures; ``tracker``: its class."""

    tracker: type
    count: int

    def create(
        self, episode: Episode, scenario: Scenario | None, rng: np.random.Generator, *, many: bool = False
    ) -> LoopTracker:
        """See ``TrackerSpec``."""
        return ManyFromPictures(FewPictures(self.tracker(self.parameters, rng), self.count))


def _taught_by_few(of: str, tracker: type, count: int) -> TaughtByFew:
    entry = registry.entry(of)
    return TaughtByFew(
        name=f"{of}_{count}_pictures",
        role="variant",
        summary=f"{of} that learns from {count} pictures",
        suites=("harbour",),
        parameters=entry.parameters(),
        module=tracker.__module__,
        edition=entry.edition,
        tracker=tracker,
        count=count,
    )


TAUGHT_BY_FEW = {
    (of, count): _taught_by_few(of, tracker, count)
    for of, tracker in (("eigen_swarm", EigenSwarm), ("harbour_watch", HarbourWatch))
    for count in COUNTS
}
"""By name of the tracker and number of pictures."""
