"""Suites by name: each combines scenarios, presets, a judge and metrics. How it is shown: ``benchmarks.show.showing``.

A suite's module registers it, ``register_suite(Suite(...))``. A run receives its suite; what pools, compares
and reports looks it up by the name in rows.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

from benchmarks.contract.judging import Judge, OnSequences, Recording
from benchmarks.contract.metric import Better, Metric, Statistic
from benchmarks.contract.rows import EVENT_COLUMNS, REAL
from benchmarks.contract.track_table import TrackTable
from benchmarks.contract.tracker_spec import TrackerSpec
from scenarios.catalog import unversioned
from scenarios.scenario import Episode, Scenario
from scenarios.truth import Truth, TruthExtent
from sim.checks import check, check_choice

_MODULES = {
    "frame-out": "benchmarks.judges.frame_out.suite",
    "follow": "benchmarks.judges.follow.suite",
    "stereo": "benchmarks.judges.stereo.suite",
    "fish": "benchmarks.judges.fish.suite",
    "harbour": "benchmarks.judges.harbour.suite",
    "many": "benchmarks.judges.many.suite",
}
"""Suite -> module that defines it; the first is the default. Add yours here."""
DEFAULT = next(iter(_MODULES))
"""Name of the default suite of commands and trackers."""

_SUITES: dict[str, Suite] = {}

Condition = tuple[str, str, str, str, str]
"""Suite, scenario, preset, renderer and steering: the controller, "" on a set path; the link if controllers compete."""
Name = Literal["tracker", "controller"]
EventTest = Callable[[dict[str, Any]], bool]


@dataclass(frozen=True, slots=True)
class EventWords:
    """A suite's description of its events, the parts of an episode with rows of their own.

    Attributes:
        name: in the plural, in words. key: column of the event's attributes in rows.
        tests: groups of events in comparisons of two trackers: name in words -> test of an event's attributes.
        describe: returns one line about all events of a condition: numbers and kinds.
        compared: metrics of single events in comparisons.
        episodes: metrics of whole episodes in comparisons; () = the suite's ``compared`` if there are no ``tests``.
    """

    name: str
    key: str
    tests: Mapping[str, EventTest]
    describe: Callable[[Sequence[dict[str, Any]]], str]
    compared: tuple[Metric, ...] = ()
    episodes: tuple[Metric, ...] = ()


NO_EVENTS = EventWords("events", "event", {}, lambda events: "no events")


@dataclass(frozen=True, slots=True)
class TuningEpisodes:
    """Development episodes on which parameters are tuned, the same for all methods of a scene.

    Attributes:
        preset: of the scenario. seeds: of the episodes that score a setting.
        fresh: number of the episodes after them that check the best setting, in each preset of ``fresh_presets``.
        fresh_presets: presets where values that are good on ``preset`` may be bad: longer episodes, more targets;
            () = ``preset``.
    """

    preset: str = "standard"
    seeds: range = range(300, 304)
    fresh: int = 4
    fresh_presets: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Scene:
    """A scenario of a suite.

    Attributes:
        scenario: catalogue id without version.
        trackers_of: name of the suite whose trackers take part; "" = its own. trackers: default ones; () = all.
        preset: default one; "" = the suite's.
        tuned_on: development episodes, see ``frameout tune``.
    """

    scenario: str
    trackers_of: str = ""
    trackers: tuple[str, ...] = ()
    preset: str = ""
    tuned_on: TuningEpisodes = TuningEpisodes()


@dataclass(frozen=True, slots=True)
class Suite:
    """Scores that answer one question.

    Attributes:
        name: what users type. summary: one line.
        edition: of its rows; raise it when its judge gives other rows, see ``benchmarks.run.editions``.
        scenes: its scenarios; tuning uses the first. preset, quick_preset: defaults.
        judge: makes the judge of an episode of a scenario; it decides which objects are targets.
        metrics: of the summary, in order.
        headline: metrics of the leaderboard on the terminal; the first one ranks.
        compared: metrics of the comparison of ours with each other tracker.
        tuned_for: objective of tuning: the sum of these metrics times these factors.
        events: parts of an episode with rows of their own. silence: score of a frame without an answer, in words.
        references: trackers with unfair knowledge.
        controller: default controller of presets in closed loop; None: no controller can steer.
        key_columns: columns of rows that name what is compared; the column ``role`` is that of the first.
        truth: extent of the truth that the judge needs.
        follows_many: whether trackers answer with the tracks of many targets.
        needs_depth: whether a track without ``depth_m`` scores nothing.
        recordings: takes real tracks, see ``frameout bench --real``, to recordings, notes for the user, and what is
            wrong with tracks that cannot be used, a line each; None: the suite judges none.
        on_sequences: judges trackers on real sequences, see ``frameout bench --real``; None: the suite does not.
    """

    name: str
    summary: str
    scenes: tuple[Scene, ...]
    preset: str
    quick_preset: str
    judge: Callable[[Episode, Scenario], Judge]
    metrics: tuple[Metric, ...]
    headline: tuple[str, ...]
    compared: tuple[str, ...]
    tuned_for: Mapping[str, float]
    silence: str
    edition: int = 1
    events: EventWords = NO_EVENTS
    references: tuple[TrackerSpec, ...] = ()
    controller: str | None = "centre"
    key_columns: tuple[Name, ...] = ("tracker",)
    truth: TruthExtent = "all"
    follows_many: bool = False
    needs_depth: bool = False
    recordings: Callable[[Sequence[TrackTable]], tuple[Sequence[Recording], list[str], list[str]]] | None = None
    on_sequences: OnSequences | None = None

    def judge_of(self, episode: Episode, scenario: Scenario) -> Judge:
        """Return the judge of an episode; it calls the suite's metrics that are functions of one."""
        judge = self.judge(episode, scenario)
        if functions := tuple(metric for metric in self.metrics if metric.value is not None):
            judge.functions = functions  # type: ignore[attr-defined]
        return judge

    @property
    def judges_controllers(self) -> bool:
        """Whether controllers are trackers."""
        return "controller" in self.key_columns

    def scene(self, scenario: str) -> Scene:
        """Return the scene of a scenario, with or without version; for others one with the suite's own trackers."""
        known = {scene.scenario: scene for scene in self.scenes}
        return known.get(scenario) or known.get(unversioned(scenario)) or Scene(scenario)

    def is_about(self, scenario: str) -> bool:
        """Return whether a scenario, with or without version, is one of its scenes."""
        return any(scene.scenario in (scenario, unversioned(scenario)) for scene in self.scenes)

    def tracked_by(self, scene: Scene) -> str:
        """Return the name of the suite whose trackers take part in a scene."""
        return scene.trackers_of or self.name

    def names_of(self, row: Mapping[str, Any]) -> tuple[str, ...]:
        """Return the names of the tracker of a row or of an entry of the summary."""
        return tuple(row[key] for key in self.key_columns)

    def targets(self, scenario: Scenario, truth: Truth) -> tuple[int, ...]:
        """Return the indices of the targets: the scenario's one, or all objects where many are followed."""
        return tuple(range(len(truth.names))) if self.follows_many else (truth.index_of(scenario.target),)

    def headline_in(self, scenario: str) -> tuple[str, ...]:
        """Return the metrics of the leaderboard of a scenario, or of real recordings."""
        return self.on_sequences.headline if scenario == REAL and self.on_sequences else self.headline

    def silence_in(self, scenario: str) -> str:
        """Return the score of a frame without an answer, in words, in a scenario or on real recordings."""
        return self.on_sequences.silence if scenario == REAL and self.on_sequences else self.silence

    def showing(self, metrics: Sequence[str]) -> Suite:
        """Return the suite with these metrics on its leaderboard, in this order; unchanged if it has none of them."""
        known = {metric.name for metric in self.metrics}
        shown = tuple(name for name in metrics if name in known)
        if not shown:
            return self
        real = self.on_sequences and replace(self.on_sequences, headline=shown)
        return replace(self, headline=shown, on_sequences=real)

    def compared_in(self, scenario: str) -> tuple[str, ...]:
        """Return the metrics of comparisons in a scenario, or on real recordings."""
        return self.on_sequences.compared if scenario == REAL and self.on_sequences else self.compared

    def metric(self, name: str) -> Metric:
        """Return one metric by name. Raises ValueError for an unknown name."""
        known = {metric.name: metric for metric in self.metrics}
        check_choice("metric", name, known)
        return known[name]


def register_suite(new: Suite) -> None:
    """Register a suite under its name. Raises ValueError if the name is taken, or for the name of an unknown metric."""
    check("suite", new.name not in _SUITES, "a new name", f"{new.name!r}, which is taken")
    check_choice("events.key", new.events.key, EVENT_COLUMNS)
    known = [metric.name for metric in new.metrics]
    for metric in new.metrics:
        _check_metric(new, metric)
        check("metrics", known.count(metric.name) == 1, "each name once", f"{metric.name!r} twice")
    named: dict[str, Iterable[str]] = {"headline": new.headline, "compared": new.compared, "tuned_for": new.tuned_for}
    if (real := new.on_sequences) is not None:
        named |= {"on_sequences.headline": real.headline, "on_sequences.compared": real.compared}
    for field_name, names in named.items():
        check(field_name, not isinstance(names, str), "names of metrics, such as ('recovery_rate',)", repr(names))
        for name in names:
            check_choice(field_name, name, known)
    _SUITES[new.name] = new


def _check_metric(judging: Suite, metric: Metric) -> None:
    """Raise ValueError for a direction that there is not, a statistic that is none or has no formula, or a function of
    an episode in a suite whose judge calls none.
    """
    check_choice(f"better of metric {metric.name}", metric.better, get_args(Better))
    is_one = isinstance(metric.statistic, Statistic)
    check(f"statistic of metric {metric.name}", is_one, "a Statistic, such as Mean(quantity)", repr(metric.statistic))
    formula = getattr(metric.statistic, "formula", None)
    check(f"formula of metric {metric.name}", isinstance(formula, str), "a text, such as 'mean of {0}'", repr(formula))
    called = metric.value is None or hasattr(judging.judge, "functions")
    check(
        f"value of metric {metric.name}", called, f"None, as the judge of {judging.name} makes all rows", metric.value
    )


def suites() -> dict[str, Suite]:
    """Return all suites by name, sorted, since the order of imports varies."""
    for module in _MODULES.values():
        importlib.import_module(module)
    return dict(sorted(_SUITES.items()))


def add_metric(suite_name: str, metric: Metric, *, headline: bool = False, compared: bool = False) -> None:
    """Add a metric to a suite, with ``headline`` to its leaderboard, with ``compared`` to comparisons of whole
    episodes.

    Raises:
        ValueError: if the suite is unknown or has a metric of this name, for an unknown direction or statistic, or for
            a function where the suite's judge makes all rows.
    """
    old = suite(suite_name)
    _check_metric(old, metric)
    taken = any(metric.name == known.name for known in old.metrics)
    check("metric", not taken, "a new name", f"{metric.name!r}, which the suite has")
    new = replace(old, metrics=(*old.metrics, metric))
    if headline:
        # After the one that ranks: a narrow terminal leaves out the last columns.
        new = replace(new, headline=(*old.headline[:1], metric.name, *old.headline[1:]))
    if compared:
        new = replace(new, compared=(*old.compared, metric.name))
        if old.events.tests or old.events.episodes:
            new = replace(new, events=replace(old.events, episodes=(*old.events.episodes, metric)))
    _SUITES[suite_name] = new


def add_scene(suite_name: str, scene: Scene) -> None:
    """Add a scenario to a suite. Raises ValueError if the suite is unknown or has it."""
    old = suite(suite_name)
    taken = any(scene.scenario == known.scenario for known in old.scenes)
    check("scene", not taken, "a scenario that the suite does not have", repr(scene.scenario))
    _SUITES[suite_name] = replace(old, scenes=(*old.scenes, scene))


def suite(name: str) -> Suite:
    """Return a suite by name.

    Raises:
        ValueError: for an unknown name; lists the known ones.
    """
    if name in _MODULES:
        importlib.import_module(_MODULES[name])
    if name not in _SUITES:
        check_choice("suite", name, suites())
    return _SUITES[name]


def controllers_suite() -> Suite:
    """Return the first suite in which controllers are trackers."""
    return next(each for each in suites().values() if each.judges_controllers)


def check_metrics(metrics: Iterable[str], suite_names: Iterable[str]) -> None:
    """Raise ValueError for a metric that none of the suites has."""
    known = {metric.name: None for name in suite_names for metric in suite(name).metrics}
    for name in metrics:
        check_choice("metric", name, known)
