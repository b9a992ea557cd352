"""Experiments that run a paper's trackers with their written parameters in a suite."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from benchmarks.contract.metric import Metric, Quantity
from benchmarks.contract.rows import Row, read_rows
from benchmarks.contract.suite import suite
from benchmarks.contract.text import interval_text, number_text, ranges_text, unit_sign
from benchmarks.papers.experiment import Claim, PaperExperiment, Robustness, TextTable
from benchmarks.run.experiment import Experiment, Progress
from benchmarks.run.experiment import run as run_experiment
from benchmarks.run.result_folder import MadeNow
from benchmarks.run.selection import experiment_on, job_on, tracker_named
from benchmarks.show.pictures import drawn_cells
from benchmarks.show.video.drawing import InLargerView, picture_sheet
from benchmarks.statistics.bootstrap import bootstrap_interval
from benchmarks.statistics.pooling import Median
from scenarios import catalog
from scenarios.scenario import RendererName

FOLDER = "robustness"
"""Of the rows of what is varied, in the experiment's folder."""
_SCALE = 3.0
_CELL_PX = 600


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackerExperiment(PaperExperiment):
    """See ``PaperExperiment``. Claims are about the suite's metrics.

    Attributes:
        trackers: of the paper, in the order of its figure.
        beside: other trackers, of which the paper says nothing. They run in the same episodes, and the table shows for
            each of them what the claims count.
        variants: preset → in which it differs from the paper's, in words. All trackers run there too, with the same
            seeds, and the table shows what the claims count.
        frames: shown in the paper's figure; none where it names none.
        robustness: what is varied beside it; None for experiments in which nothing was fitted.
    """

    trackers: tuple[str, ...]
    beside: tuple[str, ...] = ()
    variants: Mapping[str, str] = field(default_factory=dict)
    frames: tuple[int, ...] = ()
    robustness: Robustness | None = None

    @property
    def presets(self) -> tuple[str, ...]:
        """See ``PaperExperiment``."""
        return (self.preset, *self.variants)

    @property
    def methods(self) -> tuple[str, ...]:
        """See ``PaperExperiment``."""
        return (*self.trackers, *self.beside)

    @property
    def shown_claims(self) -> tuple[Claim, ...]:
        """See ``PaperExperiment``: the claims, and their metrics of trackers ``beside``, and in ``variants``."""
        counted = {claim.metric: claim.counted for claim in self.claims if not claim.minus}
        beside = (Claim(metric, words, tracker=tracker) for metric, words in counted.items() for tracker in self.beside)
        varied = (
            Claim(metric, f"{difference}: {words}", tracker=tracker, preset=preset)
            for preset, difference in self.variants.items()
            for metric, words in counted.items()
            for tracker in self.methods
        )
        return (*self.claims, *beside, *varied)

    def metric(self, name: str) -> Metric:
        """See ``PaperExperiment``: a metric of the suite, or the median of a class, ``region_width_m person``."""
        row, _, kind = name.partition(" ")
        if kind:
            return Metric(name, f"{row} of class {kind}", "m", "lower", Median(Quantity(row), kind=kind))
        return suite(self.suite).metric(name)

    def run(self, out: Path, seeds: range, renderer: RendererName, workers: int, progress: Progress) -> list[str]:
        """See ``PaperExperiment``."""
        own = self.runs(seeds, renderer, workers)
        moved = run_experiment(own, out, progress).moved
        for varied in self.varied_runs(own):
            moved += run_experiment(varied, out / FOLDER, progress).moved
        return moved

    def made_now(self, renderer: RendererName) -> MadeNow:
        """See ``PaperExperiment``."""
        return self.runs(self.seeds, renderer, workers=0).made_now

    def varied_runs(self, own: Experiment) -> tuple[Experiment, ...]:
        """Return what ``robustness`` adds: all varied settings on the same pictures, and other pictures."""
        made = self.robustness
        if made is None:
            return ()
        seeds = sorted({each.seed for each in own.episodes})[: made.episodes]
        varied = {
            alias(name, words): tracker_named(name, **values)
            for words, values in made.settings.items()
            for name in made.trackers
        }
        usual = catalog.scenario(self.scenario).presets[self.preset]
        changed = {alias(self.preset, words): replace(usual, **fields) for words, fields in made.rates.items()}
        few = partial(
            experiment_on,
            self.suite,
            self.scenario,
            seeds=range(seeds[0], seeds[-1] + 1),
            renderer=own.episodes[0].renderer,
            workers=own.workers,
        )
        return few((self.preset,), varied), few(changed, made.trackers)

    def sensitivity(self, out: Path, rows: Sequence[Row], seeds: range, renderer: RendererName) -> TextTable | None:
        """See ``PaperExperiment``: the figures as set, with other settings, and with other rates."""
        made = self.robustness
        if made is None:
            return None
        few = seeds[: made.episodes]
        columns = [(tracker, self.metric(name)) for tracker in made.trackers for name in made.metrics]

        def line(words: str, drawn: Sequence[Row], preset: str, setting: str = "") -> tuple[str, ...]:
            own = [row for row in drawn if row["renderer"] == renderer and row["preset"] == preset]
            names = [(alias(tracker, setting) if setting else tracker, metric) for tracker, metric in columns]
            return (words, *_cells(own, names))

        varied = read_rows(out / FOLDER)
        lines = [
            line("as in the table above", [row for row in rows if row["seed"] in few], self.preset),
            *(line(words, varied, self.preset, words) for words in made.settings),
            *(line(words, varied, alias(self.preset, words)) for words in made.rates),
        ]
        heads = [f"{tracker}: {_head(metric)}" for tracker, metric in columns]
        words = f"{made.words} Episodes {ranges_text(few)}; 95 % intervals over them."
        return TextTable("What was fitted, varied", words, ("varied", *heads), tuple(lines))

    def runs(self, seeds: range, renderer: RendererName, workers: int) -> Experiment:
        """Return what is run."""
        return experiment_on(
            self.suite, self.scenario, self.presets, self.methods, seeds, renderer=renderer, workers=workers
        )

    def show(self, out: Path, rows: Sequence[Row], seeds: range, renderer: RendererName) -> None:
        """See ``PaperExperiment``: one episode with each method, the observed frame inside the larger view.

        Where the paper names no frames nothing is shown.
        """
        if not self.frames:
            return
        seed, cells = seeds.start, []
        for tracker in self.trackers:
            how: Any = {"controller": self.controller, "renderer": renderer, "repeats": 1}
            job = job_on(self.suite, self.scenario, self.preset, seed, (tracker,), **how)
            cells += drawn_cells(job, lambda episode: InLargerView(_CELL_PX), self.frames, scale=_SCALE)
        caption = (
            f"Frames {', '.join(map(str, self.frames))}, as in the paper's figure, of seed {seed}. White: the "
            "camera's picture; its surroundings are not shown to trackers. Blue: the car. Orange: the estimate. "
            "Yellow: the particles. An arrow at the border points to a place beyond it."
        )
        self.write_figure(out, picture_sheet(cells, _CELL_PX), seed, renderer, "figure", caption)


def alias(name: str, words: str) -> str:
    """Return the name under which a varied tracker or preset runs."""
    return f"{name} ({words})"


def _cells(rows: Sequence[Row], columns: Sequence[tuple[str, Metric]]) -> Iterator[str]:
    for tracker, metric in columns:
        pool = metric.statistic.pooled([row for row in rows if row["tracker"] == tracker])
        if pool is None or pool.seed_count == 0:
            yield "–"
        else:
            yield f"{number_text(pool.mean, metric.unit)} ({interval_text(*bootstrap_interval(pool), metric.unit)})"


def _head(metric: Metric) -> str:
    """Return the name of a metric in words, with its unit."""
    words, sign = metric.name.removesuffix(f"_{metric.unit}").replace("_", " "), unit_sign(metric.unit)
    return f"{words} ({sign})" if sign else words
