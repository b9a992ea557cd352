"""Experiments that run a paper's trackers with their written parameters in a suite."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from benchmarks.contract.metric import Metric
from benchmarks.contract.rows import Row, read_rows
from benchmarks.contract.suite import Condition, suite
from benchmarks.papers.claims import Claim
from benchmarks.papers.experiment import PaperExperiment, Plots
from benchmarks.papers.robustness import FOLDER, Robustness, Sensitivity, alias, sensitivity
from benchmarks.run.experiment import Experiment, Progress
from benchmarks.run.experiment import run as run_experiment
from benchmarks.run.result_folder import MadeNow
from benchmarks.run.selection import experiment_on, job_on, tracker_named
from benchmarks.show.pictures import drawn_cells, keep_event_picture
from benchmarks.show.showing import showing_of
from benchmarks.show.video.drawing import InLargerView, picture_sheet
from benchmarks.statistics.summary import grouped
from scenarios import catalog
from scenarios.scenario import RendererName

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
    def contestants(self) -> tuple[str, ...]:
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
            for tracker in self.contestants
        )
        return (*self.claims, *beside, *varied)

    def metric(self, name: str) -> Metric:
        """See ``PaperExperiment``."""
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

    def sensitivity(self, out: Path, rows: Sequence[Row], seeds: range, renderer: RendererName) -> Sensitivity | None:
        """See ``PaperExperiment``."""
        made = self.robustness
        if made is None:
            return None
        drawn, varied = (
            [row for row in each if row["renderer"] == renderer] for each in (rows, read_rows(out / FOLDER))
        )
        return sensitivity(made, [self.metric(name) for name in made.metrics], drawn, varied, self.preset, seeds)

    def runs(self, seeds: range, renderer: RendererName, workers: int) -> Experiment:
        """Return what is run."""
        return experiment_on(
            self.suite, self.scenario, self.presets, self.contestants, seeds, renderer=renderer, workers=workers
        )

    def show(self, out: Path, rows: Sequence[Row], seeds: range, renderer: RendererName) -> Plots | None:
        """See ``PaperExperiment``: the paper's frames; where it names none, the suite's picture."""
        if self.frames:
            self._show_frames(out, seeds.start, renderer)
        else:
            condition = self.condition(renderer)
            self.keep_picture(out, condition, grouped(rows)[condition])
        return None

    def keep_picture(self, out: Path, condition: Condition, trackers: Mapping[str, Sequence[Row]]) -> None:
        """Keep the suite's picture of an event, with the paper's trackers, if it has one."""
        event = showing_of(suite(self.suite)).event_picture
        if event is not None:
            keep_event_picture(out, condition, trackers, self.trackers, event)

    def _show_frames(self, out: Path, seed: int, renderer: RendererName) -> None:
        """Run one episode with each method; show the observed frame inside the larger view."""
        cells = []
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
