"""How results of a suite are shown: its charts, its picture, the words around its tables.

A judge does not depend on it; a suite without an entry is shown by its metrics alone.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from benchmarks.contract.rows import Row
from benchmarks.contract.suite import Suite, suites
from benchmarks.show.charts import Chart
from benchmarks.show.pictures import EventPicture
from benchmarks.show.tables import Facts
from benchmarks.show.video.drawing import Drawing, InLargerView
from scenarios import catalog
from scenarios.catalog import unversioned
from scenarios.scenario import Episode
from trackers import registry


@dataclass(frozen=True, slots=True)
class Showing:
    """The showing half of a suite.

    Attributes:
        heading: of its report page; "" = its summary.
        charts: returns the report's charts from rows by tracker.
        event_picture: how the report shows one event; None = not at all. sequence_picture: the same of real sequences.
        facts: table of the report about the episodes themselves.
        oracles: note of the report about references with unfair knowledge.
        drawings: scenario without version -> what makes the drawing of an episode; else the larger view.
    """

    heading: str = ""
    charts: Callable[[Mapping[str, Sequence[Row]]], Iterable[Chart]] = lambda rows: ()
    event_picture: EventPicture | None = None
    sequence_picture: EventPicture | None = None
    facts: Facts | None = None
    oracles: str = ""
    drawings: Mapping[str, Callable[[Episode], Drawing]] = field(default_factory=dict)


_SHOWN = ("frame-out", "follow", "stereo", "fish", "harbour")
"""Suites whose ``SHOWING`` stands in a module of ``suites``."""
_OWN: dict[str, Showing] = {}


def register_showing(suite: str, showing: Showing) -> None:
    """Show the results of a suite, by its name, in this way."""
    _OWN[suite] = showing


def showing_of(suite: Suite) -> Showing:
    """Return how a suite is shown."""
    if suite.name in _OWN or suite.name not in _SHOWN:
        return _OWN.get(suite.name, Showing())
    found: Showing = importlib.import_module(f"benchmarks.show.suites.{suite.name.replace('-', '_')}").SHOWING
    return found


def drawing_of(scenario: str, episode: Episode) -> Drawing:
    """Return the drawing of an episode of a scenario: that of a suite, else the larger view."""
    of_suites = (showing_of(each).drawings.get(unversioned(scenario)) for each in suites().values())
    make = next(filter(None, of_suites), None)
    return InLargerView() if make is None else make(episode)


def suite_shown(scenario: str, preset: str, link: str | None) -> Suite:
    """Return the suite whose kind of steering is shown if users name none: one that judges controllers.

    A preset in closed loop belongs to suites of trackers and is steered as there, unless a link is named.
    """
    shown = catalog.scenario(scenario)
    as_written = link is None and shown.has_preset(preset) and shown.configuration(preset).closed_loop
    steered = (each for each in suites().values() if not each.follows_many)
    return next(each for each in steered if each.judges_controllers != as_written)


def suite_watching(scenario: str, tracker: str | None = None) -> Suite:
    """Return the suite whose targets are shown without a controller: one of the scenario that fits the tracker.

    A tracker of many targets is shown with all of its tracks, if a suite judges them.
    """
    known = None if tracker is None else registry.entries().get(tracker)
    many = tracker is None or (known is not None and known.follows_many)
    own = [each for each in suites().values() if each.is_about(scenario) and not each.judges_controllers]
    fitting = [each for each in own if each.follows_many and many] or [each for each in own if not each.follows_many]
    return fitting[0] if fitting else suite_shown(scenario, "", None)
