"""Suites by name: each one combines scenarios, presets, a judge, metrics and figures.

A suite registers where it is defined, ``register_suite(Suite(...))``. Code that runs, pools,
compares or reports looks suites up here and names none.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from benchmarks.report.palette import LineStyle
from benchmarks.run.records import Row
from benchmarks.suites.judging import Judge
from scenarios.catalog import unversioned
from scenarios.scenario import Episode, Scenario
from scenarios.truth import Truth, TruthExtent

if TYPE_CHECKING:
    from benchmarks.run.contestants import Entrant
    from benchmarks.video.drawing import Drawing

_MODULES = {
    "frame-out": "benchmarks.suites.frame_out.suite",
    "follow": "benchmarks.suites.follow.suite",
    "stereo": "benchmarks.suites.stereo.suite",
}
"""Suite -> module that defines it; the first is the default. Add yours here."""
DEFAULT = next(iter(_MODULES))
"""Name of the suite that is run, and that trackers take part in, where none is named."""

_SUITES: dict[str, Suite] = {}

Statistic = Literal[
    "mean",
    "median",
    "geometric mean",
    "precision",
    "recall",
    "f",
    "precision of counts",
    "recall of counts",
    "f of counts",
    "detection f1 of counts",
    "restricted mean",
]
Condition = tuple[str, str, str, str, str]
"""Suite, scenario, preset, renderer, and how the camera is steered: the controller, "" on a set path; where controllers
are contestants themselves, the link to what they steer.
"""
Name = Literal["tracker", "controller"]
EventTest = Callable[[dict[str, Any]], bool]


@dataclass(frozen=True, slots=True)
class Metric:
    """One metric of a suite, as it stands in ``summary.json``.

    Attributes:
        name: in the summary.
        summary: one line: what it is.
        unit: ``fraction``, ``m``, ``px``, ``frames`` …
        better: which way is better. rows: metrics of the rows it is made from.
        statistic: how rows become one number, see ``benchmarks.scores.pooling``.
        kind: only rows of events of this kind, or of which this attribute is true; None = all.
        horizon_frames: a restricted mean counts no more than this; never = this.
        ideal: the right value, of a metric that can be too low and too high, e.g. a coverage.
    """

    name: str
    summary: str
    unit: str
    better: Literal["higher", "lower"]
    rows: tuple[str, ...]
    statistic: Statistic = "mean"
    kind: str | None = None
    horizon_frames: int = 60
    ideal: float | None = None


@dataclass(frozen=True, slots=True)
class Plot:
    """A figure of the report with its words; ``svg`` as ``report.plots.svg`` returns it."""

    title: str
    words: str
    svg: str


@dataclass(frozen=True, slots=True)
class Facts:
    """A table of the report of what rows say of the episodes themselves, whoever watches.

    Attributes:
        title: of the table. words: what it says.
        lines: name of a line -> what follows ``_`` in the names of its rows.
        columns: metrics, whose rows are named without that.
    """

    title: str
    words: str
    lines: Mapping[str, str]
    columns: tuple[Metric, ...]


@dataclass(frozen=True, slots=True)
class EventWords:
    """What a suite says of its events, the parts of an episode that rows may be about.

    Attributes:
        name: in the plural, in words.
        key: of the rows, where the event's attributes stand.
        tests: what events are divided by when two trackers are compared: a name in words, and the test whether an
            event's attributes are of it.
        compared: metrics of single events in which they are compared.
        describe: takes all events of a condition to one line: how many there are and of what kind.
        episodes: metrics of whole episodes in which two are compared besides; () = where nothing divides events, those
            in which the suite compares.
    """

    name: str
    key: str
    tests: Mapping[str, EventTest]
    compared: tuple[Metric, ...]
    describe: Callable[[Sequence[dict[str, Any]]], str]
    episodes: tuple[Metric, ...] = ()


NO_EVENTS = EventWords("events", "event", {}, (), lambda events: "no events")


@dataclass(frozen=True, slots=True)
class Scene:
    """A scenario that a suite is about.

    Attributes:
        scenario: catalogue id without version.
        trackers_of: name of the suite whose trackers take part; "" = the suite's own.
        trackers: who takes part if nobody is named; () = everyone.
        drawing: makes what draws an episode of it; None: another suite's, or the larger view.
    """

    scenario: str
    trackers_of: str = ""
    trackers: tuple[str, ...] = ()
    drawing: Callable[[Episode], Drawing] | None = None


def no_picture(
    directory: Path, condition: Condition, trackers: Mapping[str, Sequence[Row]], shown: Sequence[str]
) -> None:
    """Put no picture beside the rows."""


@dataclass(frozen=True, slots=True)
class Suite:
    """Scores that answer one question.

    Attributes:
        name: what users type.
        summary: one line. heading: of a page about it.
        scenes: what it is about, the first one is what tuning looks at. preset, quick_preset: defaults.
        judge: makes the judge of an episode of a scenario; it decides which objects are targets.
        metrics: of the summary, in order.
        headline: metrics of the leaderboard on the terminal, the first one ranks.
        compared: metrics in which ours is compared with each other contestant.
        tuned_for: what tuning maximises: the sum of these metrics times these factors.
        events: what rows may be about besides whole episodes.
        silence: what a frame on which a tracker says nothing counts as, in words.
        figures: draws the report's plots from the rows of trackers by name, in the styles given.
        picture: puts a picture beside the rows, for the report, of the trackers ``shown``.
        facts: what the report says of the episodes themselves, if anything.
        references: contestants with unfair knowledge. oracles: what the report says of them.
        controller: who steers the camera by the estimate where a preset asks for it and users do not say; None: no
            controller there is can.
        contestants: what names a contestant, keys of rows. Whose role it is that rows tell, stands first.
        truth: how much of it the judge looks at.
        follows_many: whether contestants answer with the tracks of many targets.
        definitions: function, class or module whose docstring defines rows -> the rows' names.
    """

    name: str
    summary: str
    heading: str
    scenes: tuple[Scene, ...]
    preset: str
    quick_preset: str
    judge: Callable[[Episode, Scenario], Judge]
    metrics: tuple[Metric, ...]
    headline: tuple[str, ...]
    compared: tuple[str, ...]
    tuned_for: Mapping[str, float]
    silence: str
    events: EventWords = NO_EVENTS
    figures: Callable[[Mapping[str, Sequence[Row]], Mapping[str, LineStyle]], list[Plot]] = lambda rows, styles: []
    picture: Callable[[Path, Condition, Mapping[str, Sequence[Row]], Sequence[str]], None] = no_picture
    facts: Facts | None = None
    references: tuple[Entrant, ...] = ()
    oracles: str = ""
    controller: str | None = "centre"
    contestants: tuple[Name, ...] = ("tracker",)
    truth: TruthExtent = "all"
    follows_many: bool = False
    definitions: Mapping[Any, tuple[str, ...]] = field(default_factory=dict)

    @property
    def judges_controllers(self) -> bool:
        """Whether controllers are contestants."""
        return "controller" in self.contestants

    def scene(self, scenario: str) -> Scene:
        """Return the scene of a scenario, with or without version; of one that it is not about, its own trackers."""
        known = {scene.scenario: scene for scene in self.scenes}
        return known.get(scenario) or known.get(unversioned(scenario)) or Scene(scenario)

    def is_about(self, scenario: str) -> bool:
        """Return whether a scenario, with or without version, is one of its scenes."""
        return any(scene.scenario in (scenario, scenario.rsplit("-v", 1)[0]) for scene in self.scenes)

    def tracked_by(self, scene: Scene) -> str:
        """Return the name of the suite whose trackers take part in a scene."""
        return scene.trackers_of or self.name

    def names_of(self, row: Mapping[str, Any]) -> tuple[str, ...]:
        """Return what names the contestant of a row, or of an entry of the summary."""
        return tuple(row[key] for key in self.contestants)

    def targets(self, scenario: Scenario, truth: Truth) -> tuple[int, ...]:
        """Return which objects are targets: the scenario's one, or where many are followed, all that there are."""
        return tuple(range(len(truth.names))) if self.follows_many else (truth.index_of(scenario.target),)

    def metric(self, name: str) -> Metric:
        """Return one metric by name.

        Raises:
            ValueError: for an unknown name.
        """
        for metric in self.metrics:
            if metric.name == name:
                return metric
        raise ValueError(f"metric: expected one of {', '.join(m.name for m in self.metrics)}; got {name!r}")


def register_suite(new: Suite) -> None:
    """Make a suite known under its name. Raises ValueError if it is taken, or for a metric that the suite has not."""
    if new.name in _SUITES:
        raise ValueError(f"suite: the name {new.name!r} is taken")
    for name in (*new.headline, *new.compared, *new.tuned_for):
        new.metric(name)
    _SUITES[new.name] = new


def suites() -> dict[str, Suite]:
    """Return all suites by name, in its order: which one was imported first is chance."""
    for module in _MODULES.values():
        importlib.import_module(module)
    return dict(sorted(_SUITES.items()))


def add_metric(suite_name: str, metric: Metric, *, headline: bool = False) -> None:
    """Add a metric to a suite's summary, and with ``headline`` to its leaderboard.

    Raises:
        ValueError: if the suite is unknown or has a metric of this name.
    """
    old = suite(suite_name)
    if any(metric.name == known.name for known in old.metrics):
        raise ValueError(f"metric: expected a new name, got {metric.name!r}, which the suite has")
    shown = (*old.headline, metric.name) if headline else old.headline
    _SUITES[suite_name] = replace(old, metrics=(*old.metrics, metric), headline=shown)


def add_scene(suite_name: str, scene: Scene) -> None:
    """Make a suite about one more scenario. Raises ValueError if the suite is unknown or is about it."""
    old = suite(suite_name)
    if any(scene.scenario == known.scenario for known in old.scenes):
        raise ValueError(f"scene: expected a scenario that the suite is not about, got {scene.scenario!r}")
    _SUITES[suite_name] = replace(old, scenes=(*old.scenes, scene))


def suite(name: str) -> Suite:
    """Return a suite by name.

    Raises:
        ValueError: for an unknown name; lists the known ones.
    """
    known = suites()
    if name not in known:
        raise ValueError(f"suite: expected one of {', '.join(known)}; got {name!r}")
    return known[name]


def controllers_suite() -> Suite:
    """Return the first suite in which controllers are contestants."""
    return next(each for each in suites().values() if each.judges_controllers)


def event_of(row: Row) -> dict[str, Any] | None:
    """Return the attributes of the event that a row is about; None of one about the whole episode."""
    event: dict[str, Any] | None = row.get(suite(row["suite"]).events.key)
    return event
