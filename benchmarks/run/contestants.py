"""The contestants: every registered tracker, and each suite's references with unfair knowledge."""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.contract.entrant import Entrant
from benchmarks.contract.suite import DEFAULT, Scene, Suite, suites
from benchmarks.run.blindfold import Blindfolded, ManyBlindfolded
from benchmarks.run.own_inputs import own
from benchmarks.run.stale_kernels import forget_stale_kernels
from scenarios.loop import Contestant, FromPictures, ManyFromPictures
from scenarios.scenario import Episode, Scenario
from sim.checks import check_choice, suggestion
from trackers import registry
from trackers.follow_one import FollowOne
from trackers.gaps import GapMethod
from trackers.protocols import BridgingTracker


def entrants(suite: str | None = None) -> dict[str, Entrant]:
    """Return all entrants, or those of a suite, by name; trackers in order of registration."""
    trackers = (_from_registry(entry) for entry in registry.entries().values())
    references = (reference for each in suites().values() for reference in each.references)
    return {each.name: each for each in (*trackers, *references) if suite is None or suite in each.suites}


def entrants_of(suite: Suite, scene: Scene) -> dict[str, Entrant]:
    """Return all that may take part in a scene of a suite, by name: its trackers, and those of the suite itself."""
    return entrants(suite.tracked_by(scene)) | entrants(suite.name)


def entrant(name: str, values: dict[str, Any] | None = None) -> Entrant:
    """Return one entrant; a tracker with ``values`` of its parameters, if any are given.

    Raises:
        ValueError: for an unknown name; lists the known ones.
    """
    if values:
        return _from_registry(registry.entry(name), **values)
    known = entrants()
    if name not in known:
        own = f"{registry.OWN_NEEDS_MODULE} (--modules; in Python modules=)"
        check_choice("tracker", name, known, why=suggestion(name, known) or own)
    return known[name]


def contestant_of_one(name: str, rng: np.random.Generator) -> Contestant:
    """Return a fresh contestant of one target that needs pictures alone."""
    return FromPictures(registry.entry(name).create_for_one(rng))


def gap_method_of(name: str, rng: np.random.Generator) -> GapMethod | None:
    """Return the method of a fresh tracker to bridge gaps; None if it offers none."""
    tracker = registry.entry(name).create(rng)
    return tracker.gap_method if isinstance(tracker, BridgingTracker) else None


def _from_registry(entry: registry.TrackerEntry, **changes: Any) -> Entrant:
    forget_stale_kernels()
    parameters = entry.parameters(**changes)

    def create(episode: Episode, scenario: Scenario, rng: np.random.Generator, many: bool = False) -> Contestant:
        tracker = entry.tracker(parameters, rng)
        if entry.follows_many and many:
            return ManyBlindfolded(tracker) if entry.role == "blind" else ManyFromPictures(tracker)
        if entry.follows_many:
            start = own(episode.start)
            return FromPictures(FollowOne(tracker, start.background, start.site))
        return Blindfolded(tracker, scenario.target) if entry.role == "blind" else FromPictures(tracker)

    return Entrant(
        name=entry.name,
        role=entry.role,
        summary=entry.summary,
        suites=entry.suites or (DEFAULT,),
        reproducible=entry.reproducible,
        parameters=parameters,
        module=entry.tracker.__module__,
        create=create,
        missing=entry.missing,
        edition=entry.edition,
    )
