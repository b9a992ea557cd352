"""A paper's experiment: setting, runs, claims and our findings.

``experiment_named`` reads it from ``NAME.toml`` beside this module: words, names of trackers and presets, claims, and
what is varied. Those of a camera have a class each, for what they measure.
"""

from __future__ import annotations

import importlib
import tomllib
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.metric import Metric
from benchmarks.contract.rows import Row, read_rows
from benchmarks.contract.suite import Condition
from benchmarks.contract.text import interval_text, number_text, unit_sign
from benchmarks.run.experiment import Progress
from benchmarks.run.result_folder import MadeNow
from benchmarks.show.pictures import write_picture
from benchmarks.statistics.bootstrap import bootstrap_interval
from benchmarks.statistics.summary import paired
from scenarios.scenario import RendererName

if TYPE_CHECKING:
    from benchmarks.show.plots import Plot

NAMES = ("A2", "A3", "B1", "B2", "B3", "C", "D")
_OF_A_CAMERA = {"B1": "b1:DimmedLamp", "B2": "b2:Drive"}
"""Name → module and class; the others run trackers."""


@dataclass(frozen=True, slots=True)
class Claim:
    """A claim of the paper, and the number that tests it.

    Attributes:
        metric: of the rows or of the suite. counted: definition of the number, in words. words: the paper's claim.
        bound: the side of ``level`` that agrees with the paper, by our choice; ``interval below`` = all of the interval
            is below it; ``reported`` = the paper gives no side.
        tracker: name of the method; "" without one.
        preset: of the episodes; "" for the experiment's.
        tolerance: distance from ``level`` that still agrees, for the bound ``within``.
        minus: name of the method whose number on the same episodes is subtracted; "" without one.
        fitted: whether scene or method was set so that this number is the paper's: then it is no evidence for it.
    """

    metric: str
    counted: str
    words: str = "not in the paper"
    bound: Literal["at most", "at least", "more than", "within", "interval below", "reported"] = "reported"
    level: float = 0.0
    tracker: str = ""
    preset: str = ""
    tolerance: float = 0.0
    minus: str = ""
    fitted: bool = False


@dataclass(frozen=True, slots=True)
class Finding:
    """A claim and our value.

    Attributes:
        mean, ci_low, ci_high: 95 % interval over episodes; None without rows.
        unit: of the metric. episodes: number with rows of it.
    """

    claim: Claim
    mean: float | None
    ci_low: float | None
    ci_high: float | None
    unit: str
    episodes: int

    @property
    def agrees(self) -> bool | None:
        """Whether the mean lies on the paper's side; None where there is no side. An unknown mean does not agree."""
        if self.claim.bound == "reported":
            return None
        if self.mean is None or self.ci_high is None:
            return False
        level = self.claim.level
        sides = {
            "at most": self.mean <= level,
            "at least": self.mean >= level,
            "more than": self.mean > level,
            "interval below": self.ci_high < level,
            "within": abs(self.mean - level) <= self.claim.tolerance,
        }
        return sides[self.claim.bound]

    @property
    def value(self) -> str:
        """The mean in words."""
        text = number_text(self.mean, self.unit)
        return text if self.mean is None else f"{text} {unit_sign(self.unit)}".rstrip()

    @property
    def interval(self) -> str:
        """The interval in words."""
        return interval_text(self.ci_low, self.ci_high, self.unit)

    @property
    def expected(self) -> str:
        """Bound and level in words."""
        if self.claim.bound == "reported":
            return "–"
        scale = 100.0 if self.unit == "fraction" else 1.0
        if self.claim.bound == "within":
            around = f"{scale * self.claim.level:.3g} ± {scale * self.claim.tolerance:.3g}"
            return f"{around} {unit_sign(self.unit)}".rstrip()
        return f"{self.claim.bound} {scale * self.claim.level:g} {unit_sign(self.unit)}".rstrip()


@dataclass(frozen=True, slots=True, kw_only=True)
class Robustness:
    """What is varied beside an experiment, one thing at a time.

    Attributes:
        trackers: methods whose figures were fitted.
        metrics: of the experiment.
        settings: words → values of the methods' parameters; they run on the pictures of the experiment.
        rates: words → values of the preset's fields; the methods run as in the experiment.
        words: on what is varied and why.
        episodes: the first ones of the experiment's that are used.
    """

    trackers: tuple[str, ...]
    metrics: tuple[str, ...]
    settings: Mapping[str, Mapping[str, Any]]
    rates: Mapping[str, Mapping[str, Any]]
    words: str
    episodes: int


class TextTable(NamedTuple):
    """A table of texts with a title and words about it: ``heads`` of its columns, and its ``rows``."""

    title: str
    words: str
    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


class Plots(NamedTuple):
    """Plots under one title."""

    title: str
    plots: Sequence[Plot]


@dataclass(frozen=True, slots=True, kw_only=True)
class PaperExperiment(ABC):
    """An experiment as the paper describes it.

    Attributes:
        name: of the command's argument. title, setting: in words.
        fitted: what of scene and method was set so that results agree with the paper's, in words; "" for nothing.
        suite: of the rows. scenario: catalogue id. preset: of the scenario.
        claims: of the paper. notes: on the figures.
        controller: steers by the estimate; None on a set path.
        seeds: default seeds of the episodes.
    """

    name: str
    title: str
    setting: str
    suite: str
    scenario: str
    preset: str
    claims: tuple[Claim, ...]
    fitted: str = ""
    notes: tuple[str, ...] = ()
    controller: str | None = None
    seeds: range = range(10_000, 10_050)

    @property
    def presets(self) -> tuple[str, ...]:
        """Presets of the episodes, the paper's first."""
        return (self.preset,)

    @property
    @abstractmethod
    def methods(self) -> tuple[str, ...]:
        """All trackers of the rows."""

    @property
    def shown_claims(self) -> tuple[Claim, ...]:
        """Lines of the table: the paper's claims, and what else is counted beside them."""
        return self.claims

    @abstractmethod
    def metric(self, name: str) -> Metric:
        """Return a claim's metric."""

    @abstractmethod
    def run(self, out: Path, seeds: range, renderer: RendererName, workers: int, progress: Progress) -> list[str]:
        """Write the rows that ``out`` lacks; return messages about rows that were moved to another file.

        The same call after a stop continues. Rows of other editions are made again; those of the other renderer stay.

        Raises:
            ValueError: for a folder that holds rows of other seeds or cannot be written.
        """

    @abstractmethod
    def show(self, out: Path, rows: Sequence[Row], seeds: range, renderer: RendererName) -> Plots | None:
        """Write the paper's figure to ``out``, and return plots of the rows, if there are any."""

    @abstractmethod
    def made_now(self, renderer: RendererName) -> MadeNow:
        """Return what tells the current ``editions`` of the rows of ``run``."""

    def sensitivity(self, out: Path, rows: Sequence[Row], seeds: range, renderer: RendererName) -> TextTable | None:
        """Return how the figures depend on what was fitted, for experiments in which that was measured."""
        return None

    def rows_in(self, out: Path, renderer: str = "raster") -> list[Row]:
        """Return the experiment's rows in a folder, of one renderer."""
        own = {(self.suite, self.scenario, preset, self.controller, renderer) for preset in self.presets}
        keys = ("suite", "scenario", "preset", "controller", "renderer")
        return [row for row in read_rows(out) if tuple(row[key] for key in keys) in own]

    def condition(self, renderer: str) -> Condition:
        """Return the condition of the rows of one renderer."""
        return self.suite, self.scenario, self.preset, renderer, self.controller or ""

    def write_figure(
        self,
        out: Path,
        image_rgb: NDArray[np.uint8],
        seed: int,
        renderer: RendererName,
        name: str,
        caption: str,
    ) -> None:
        """Write our version (H, W, 3) of one of the paper's figures."""
        title, file = f"The paper's {name}, in this world", f"{self.preset}-{renderer}"
        write_picture(out, file, image_rgb, self.condition(renderer), title, caption, f"seed {seed}")


@cache
def experiment_named(name: str) -> PaperExperiment:
    """Return one of the experiments ``NAMES``."""
    module, _, kind = _OF_A_CAMERA.get(name, "tracker_experiment:TrackerExperiment").partition(":")
    given = tomllib.loads(Path(__file__).with_name(f"{name.lower()}.toml").read_text(encoding="utf-8"))
    given["claims"] = [Claim(**claim) for claim in given["claims"]]
    if "robustness" in given:
        given["robustness"] = Robustness(**_frozen(given["robustness"]))
    if "seeds" in given:
        given["seeds"] = range(*given["seeds"])
    found: PaperExperiment = getattr(importlib.import_module(f"benchmarks.papers.{module}"), kind)(**_frozen(given))
    return found


def _frozen(fields: Mapping[str, Any]) -> dict[str, Any]:
    return {name: tuple(value) if isinstance(value, list) else value for name, value in fields.items()}


def findings(experiment: PaperExperiment, rows: Sequence[Row]) -> list[Finding]:
    """Return the finding of each line of the table, from rows of one renderer."""
    return [_finding(experiment, claim, rows) for claim in experiment.shown_claims]


def _finding(experiment: PaperExperiment, claim: Claim, rows: Sequence[Row]) -> Finding:
    metric = experiment.metric(claim.metric)
    preset = claim.preset or experiment.preset
    drawn = [row for row in rows if row["preset"] == preset]
    own = [row for row in drawn if claim.tracker in ("", row["tracker"])]
    if claim.minus:
        found = paired(own, [row for row in drawn if row["tracker"] == claim.minus], metric)
        if found is not None:
            return Finding(claim, found.difference, found.ci_low, found.ci_high, metric.unit, found.n)
    else:
        pool = metric.statistic.pooled(own)
        if pool is not None and pool.seed_count:
            return Finding(claim, pool.mean, *bootstrap_interval(pool), metric.unit, pool.seed_count)
    return Finding(claim, None, None, None, metric.unit, 0)
