"""How a published table is made: by the same code as its command, into a folder, resumable."""

from __future__ import annotations

import importlib
import json
import time
from abc import ABC, abstractmethod
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from benchmarks.cli.bench import Bench
from benchmarks.cli.paper import Paper
from benchmarks.contract.rows import FILE_NAME, BlockKey, Row, read_blocks, rounded
from benchmarks.contract.suite import suite
from benchmarks.papers.camera_experiment import CameraExperiment
from benchmarks.papers.experiment import PaperExperiment
from benchmarks.papers.repeat import findings
from benchmarks.papers.tracker_experiment import TrackerExperiment
from benchmarks.run.episode_time import seconds_of_episode
from benchmarks.run.episodes import Simulated
from benchmarks.run.experiment import Experiment, Progress, run
from benchmarks.run.result_folder import MadeNow, tidy
from benchmarks.run.selection import Asked, Choice, choices, experiment_on, tracker_named
from benchmarks.statistics.summary import COMPARISONS_FILE_NAME, SUMMARY_FILE_NAME
from scenarios.scenario import RendererName
from sim.checks import check
from tools.publishing.ledger import command_of
from tools.publishing.published import PublishedTable
from tools.publishing.tuning_budgets import budgets_of
from tools.time_speed import Speed

_TRIAL_SEEDS = range(1)  # A development seed.
_RENDERER: RendererName = "raster"


@dataclass(frozen=True)
class TableRun(ABC):
    """The run of one published table.

    Attributes:
        table: its data.
    """

    table: PublishedTable

    @property
    @abstractmethod
    def command(self) -> str:
        """The command that makes the same rows."""

    @property
    def trackers(self) -> tuple[str, ...]:
        """Those of a bench; () for others."""
        return ()

    @property
    @abstractmethod
    def made_now(self) -> MadeNow:
        """What tells the present ``editions`` of the table's blocks of rows."""

    @property
    def blocks_of_seed(self) -> int:
        """How many blocks of rows a seed has."""
        return 1

    @property
    def varied_blocks(self) -> int:
        """How many blocks of rows a paper's varied settings have beside, in all."""
        return 0

    def is_current(self, key: BlockKey, rows: list[Row]) -> bool:
        """Return whether rows are the table's, of the present editions and parameters."""
        return key.seed in self.table.seeds and self.made_now(key) == rows[0].get("editions")

    def missing(self) -> dict[str, str]:
        """Return those of ``trackers`` that need what is not installed; each with how to install it."""
        return {name: missing for name in self.trackers if (missing := tracker_named(name).missing())}

    def check_installed(self) -> None:
        """Raise ValueError if one of ``trackers`` needs what is not installed."""
        missing = [f"{name}: {why}" for name, why in self.missing().items()]
        check("tables", not missing, "ones whose trackers are installed", f"{self.table.name}: {'; '.join(missing)}")

    def run(self, out: Path, workers: int, progress: Progress) -> None:
        """Make what ``out`` lacks. Rows of what the table no longer has are moved to another file."""
        for folder in (file.parent for file in out.rglob(FILE_NAME)):
            found = read_blocks(folder)
            strangers = {key for key in found if key.seed not in self.table.seeds}
            if folder == out:  # What a paper varies, in a folder of its own, has names that the table does not know.
                strangers |= {key for key in found if self.made_now(key) is None}
            if strangers:
                tidy(folder, strangers)
        self._make(out, workers, progress)

    @abstractmethod
    def _make(self, out: Path, workers: int, progress: Progress) -> None: ...

    @abstractmethod
    def seconds_of_seed(self, report: Progress) -> float:
        """Measure about how many seconds of one core one seed takes with all contestants, on a development seed."""

    def budgets(self, rows: list[Row]) -> dict[str, dict[str, Any]]:
        """Return what the tuning of contestants took, see ``budgets_of``."""
        return {}

    def findings(self, rows: list[Row]) -> list[dict[str, Any]]:
        """Return findings beside a paper's claims; none where there is no paper."""
        return []

    def varied(self, out: Path, rows: list[Row]) -> dict[str, Any] | None:
        """Return how a paper's figures depend on what was fitted; None where nothing was."""
        return None

    def entries(self, out: Path, findings: list[dict[str, Any]]) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
        """Return the lists of summary.json and comparisons.json."""
        lists = [out / SUMMARY_FILE_NAME, out / COMPARISONS_FILE_NAME]
        summary, comparisons = (json.loads(file.read_text()) if file.is_file() else [] for file in lists)
        return summary, comparisons


class BenchRun(TableRun):
    """Runs a suite."""

    @cached_property
    def _choice(self) -> Choice:
        table = self.table
        asked = Asked(
            scenarios=(table.scenario,), presets=(table.preset,), trackers=table.trackers, controllers=table.controllers
        )
        found = choices(suite(table.suite), asked, variants=False, absent=True)
        known = bool(found) and found[0].scenario == table.scenario
        check("scenario", known, f"one of suite {table.suite} with its version", repr(table.scenario))
        return found[0]

    @cached_property
    def experiment(self) -> Experiment:
        """What is run, the same on every machine. Raises ValueError for unknown names."""
        return self._experiment(self.table.seeds)

    def _experiment(self, seeds: range) -> Experiment:
        chosen = self._choice
        named = (self.table.suite, chosen.scenario, chosen.presets, chosen.trackers, seeds)
        return experiment_on(*named, controllers=chosen.controllers or None)

    @property
    def trackers(self) -> tuple[str, ...]:
        """See ``TableRun``."""
        return tuple(self.experiment.trackers)

    @property
    def command(self) -> str:
        """See ``TableRun``."""
        chosen = self._choice
        _ = self.experiment  # Unknown names are refused.
        options = Bench(
            suites=(self.table.suite,),
            scenario=(chosen.scenario,),
            preset=chosen.presets,
            trackers=chosen.trackers,
            controllers=chosen.controllers,
            seeds=_words(self.table.seeds),
        )
        return command_of("bench", options, "suites")

    @cached_property
    def made_now(self) -> MadeNow:
        """See ``TableRun``."""
        return self.experiment.made_now

    @property
    def blocks_of_seed(self) -> int:
        """See ``TableRun``."""
        return len(self.trackers) * max(len(self._choice.controllers), 1)

    def _make(self, out: Path, workers: int, progress: Progress) -> None:
        run(replace(self.experiment, workers=workers), out, progress)

    def seconds_of_seed(self, report: Progress) -> float:
        """See ``TableRun``."""
        return _seconds_of(self.experiment, report)

    def budgets(self, rows: list[Row]) -> dict[str, dict[str, Any]]:
        """See ``TableRun``. Of papers there are none: their parameters are as written."""
        return budgets_of(rows)


class PaperRun(TableRun):
    """Repeats a paper's experiment."""

    @cached_property
    def experiment(self) -> PaperExperiment:
        """What is run."""
        module = importlib.import_module(f"benchmarks.papers.{self.table.experiment.lower()}")
        found: PaperExperiment = module.EXPERIMENT
        return found

    @property
    def command(self) -> str:
        """See ``TableRun``."""
        options = Paper(self.table.experiment, seeds=_words(self.table.seeds), renderer=_RENDERER)
        return command_of("paper", options, "experiment")

    @cached_property
    def made_now(self) -> MadeNow:
        """See ``TableRun``."""
        return self.experiment.made_now(_RENDERER)

    @property
    def blocks_of_seed(self) -> int:
        """See ``TableRun``."""
        return len(self.experiment.presets) * len(self.experiment.contestants)

    @property
    def varied_blocks(self) -> int:
        """See ``TableRun``."""
        made = self.experiment
        if not isinstance(made, TrackerExperiment):
            return 0
        varied = made.varied_runs(made.runs(self.table.seeds, _RENDERER, workers=0))
        return sum(each.block_count for each in varied)

    def _make(self, out: Path, workers: int, progress: Progress) -> None:
        self.experiment.run(out, self.table.seeds, _RENDERER, workers, progress)

    def seconds_of_seed(self, report: Progress) -> float:
        """See ``TableRun``."""
        made, renderer = self.experiment, _RENDERER
        if isinstance(made, TrackerExperiment):
            own = made.runs(self.table.seeds, renderer, workers=0)
            varied = sum(_seed_count(each) * _seconds_of(each, report) for each in made.varied_runs(own))
            return _seconds_of(own, report) + varied / _seed_count(own)
        assert isinstance(made, CameraExperiment)
        started = time.process_time()
        made.block(_TRIAL_SEEDS.start, renderer)
        return time.process_time() - started

    def findings(self, rows: list[Row]) -> list[dict[str, Any]]:
        """See ``TableRun``."""
        return [
            {
                "tracker": found.claim.tracker,
                "minus": found.claim.minus,
                "metric": found.claim.metric,
                "counted": found.claim.counted,
                "paper": found.claim.words,
                "expected": found.expected,
                "agrees": found.agrees,
                "unit": found.unit,
                **{key: rounded(asdict(found)[key]) for key in ("mean", "ci_low", "ci_high")},
                "n": found.episodes,
            }
            for found in findings(self.experiment, rows)
        ]

    def varied(self, out: Path, rows: list[Row]) -> dict[str, Any] | None:
        """See ``TableRun``."""
        found = self.experiment.sensitivity(out, rows, self.table.seeds, _RENDERER)
        return None if found is None else found._asdict()

    def entries(self, out: Path, findings: list[dict[str, Any]]) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
        """See ``TableRun``. Measurements of a camera belong to no suite: each finding is an entry of their summary."""
        made = self.experiment
        if isinstance(made, TrackerExperiment):
            return super().entries(out, findings)
        heading = {"suite": made.suite, "scenario": made.scenario, "preset": made.preset}
        heading |= {"tracker": "none", "role": "measured", "renderer": _RENDERER}
        numbers = ("unit", "mean", "ci_low", "ci_high", "n")
        summary = [
            {**heading, "metric": each["metric"], "better": "higher", **{key: each[key] for key in numbers}}
            for each in findings
        ]
        return summary, []


class SpeedRun(TableRun):
    """Times pictures. Nothing of it can be equal in another run: there are no rows."""

    @property
    def _options(self) -> Speed:
        table = self.table
        return Speed(
            (table.scenario,), table.preset, seeds=_words(table.seeds), frames=table.frames, stored=table.stored
        )

    @property
    def command(self) -> str:
        """See ``TableRun``."""
        return command_of("speed", self._options, "scenarios")

    @property
    def made_now(self) -> MadeNow:
        """See ``TableRun``: there are no rows."""
        return lambda key: None

    def _make(self, out: Path, workers: int, progress: Progress) -> None:
        # Measured on one core, whatever ``workers``.
        if not (out / SUMMARY_FILE_NAME).is_file():
            replace(self._options, out=out).run()

    def seconds_of_seed(self, report: Progress) -> float:
        """See ``TableRun``. Its frames are what is measured: to foretell their time takes as long."""
        return float("nan")


def run_of(table: PublishedTable) -> TableRun:
    """Return the run of a table."""
    if table.kind == "bench":
        return BenchRun(table)
    return PaperRun(table) if table.kind == "paper" else SpeedRun(table)


def _seed_count(experiment: Experiment) -> int:
    return len({each.seed for each in experiment.episodes})


def _seconds_of(experiment: Experiment, report: Progress) -> float:
    """Return the seconds of one seed, measured on a development seed."""
    first = experiment.episodes[0].seed
    of_one = [each for each in experiment.episodes if each.seed == first and isinstance(each, Simulated)]
    trial = [replace(each, seed=seed) for seed in _TRIAL_SEEDS for each in of_one]
    jobs, seconds = list(replace(experiment, episodes=trial).jobs()), 0.0
    for done, job in enumerate(jobs):
        report(done, len(jobs))
        seconds += seconds_of_episode(job)
    report(len(jobs), len(jobs))
    return seconds


def _words(seeds: range) -> str:
    return f"{seeds.start}:{seeds.stop}"
