"""Trackers that get only some of the pictures without intruders: what is learnt from how many?"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.contract.entrant import Entrant
from scenarios.loop import Contestant, ManyFromPictures
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


def _entrant(of: str, tracker: Any, count: int) -> Entrant:
    parameters = registry.entry(of).parameters()

    def create(episode: Episode, scenario: Scenario, rng: np.random.Generator, many: bool = False) -> Contestant:
        return ManyFromPictures(FewPictures(tracker(parameters, rng), count))

    return Entrant(
        name=f"{of}_{count}_pictures",
        role="variant",
        summary=f"{of} that learns from {count} pictures",
        suites=("harbour",),
        reproducible=True,
        parameters=parameters,
        module=tracker.__module__,
        edition=registry.entry(of).edition,
        create=create,
    )


TAUGHT_BY_FEW = {
    (of, count): _entrant(of, tracker, count)
    for of, tracker in (("eigen_swarm", EigenSwarm), ("harbour_watch", HarbourWatch))
    for count in COUNTS
}
"""By name of the tracker and number of pictures."""
