"""How results of a suite are shown: its figures, its pictures, the words around its tables.

What judges knows nothing of this; a suite without an entry is shown by its metrics alone.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from benchmarks.contract.rows import Row
from benchmarks.contract.suite import Condition, Suite, suites
from benchmarks.show.facts import Facts
from benchmarks.show.palette import LineStyle
from benchmarks.show.plots import Plot
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
        figures: draws the report's plots from rows by tracker, in the given styles.
        picture: writes a picture of the trackers ``shown`` for the report.
        facts: table of the report about the episodes themselves.
        oracles: note of the report about references with unfair knowledge.
        remarks: tracker -> answer to what its line beside methods as written makes readers ask, below the table.
        drawings: scenario without version -> what makes the drawing of an episode; else the larger view.
    """

    heading: str = ""
    figures: Callable[[Mapping[str, Sequence[Row]], Mapping[str, LineStyle]], list[Plot]] = lambda rows, styles: []
    picture: Callable[[Path, Condition, Mapping[str, Sequence[Row]], Sequence[str]], None] = lambda *_: None
    facts: Facts | None = None
    oracles: str = ""
    remarks: Mapping[str, str] = field(default_factory=dict)
    drawings: Mapping[str, Callable[[Episode], Drawing]] = field(default_factory=dict)


_PLACES = {
    "frame-out": "benchmarks.show.frame_out.showing",
    "follow": "benchmarks.show.follow.showing",
    "stereo": "benchmarks.show.stereo.showing",
    "fish": "benchmarks.show.fish.showing",
    "harbour": "benchmarks.show.harbour.showing",
}
"""Suite -> module whose ``SHOWING`` it is."""
_OWN: dict[str, Showing] = {}


def register_showing(suite: str, showing: Showing) -> None:
    """Show the results of a suite, by its name, in this way."""
    _OWN[suite] = showing


def showing_of(suite: Suite) -> Showing:
    """Return how a suite is shown."""
    if suite.name in _OWN or suite.name not in _PLACES:
        return _OWN.get(suite.name, Showing())
    found: Showing = importlib.import_module(_PLACES[suite.name]).SHOWING
    return found


def drawing_of(scenario: str, episode: Episode) -> Drawing:
    """Return the drawing of an episode of a scenario: that of a suite, else the larger view."""
    of_suites = (showing_of(each).drawings.get(unversioned(scenario)) for each in suites().values())
    make = next((drawing for drawing in of_suites if drawing is not None), None)
    return InLargerView() if make is None else make(episode)


def suite_shown(scenario: str, preset: str, link: str | None) -> Suite:
    """Return the suite whose kind of steering is shown if users name none: one that judges controllers.

    A preset in closed loop belongs to suites of trackers and is steered as there, unless a link is asked for.
    """
    configuration = catalog.scenario(scenario).presets.get(preset)
    as_written = link is None and configuration is not None and configuration.closed_loop
    steered = (each for each in suites().values() if not each.follows_many)
    return next(each for each in steered if each.judges_controllers != as_written)


def suite_watching(scenario: str, tracker: str | None) -> Suite:
    """Return the suite whose targets are shown without a controller: one of the scenario that fits the tracker.

    A tracker of many targets is shown with all of its tracks, if a suite asks for them.
    """
    known = None if tracker is None else registry.entries().get(tracker)
    many = tracker is None or (known is not None and known.follows_many)
    own = [each for each in suites().values() if each.is_about(scenario) and not each.judges_controllers]
    fitting = [each for each in own if each.follows_many and many] or [each for each in own if not each.follows_many]
    return fitting[0] if fitting else suite_shown(scenario, "", None)
