"""Experiments by names, whose fields tests replace."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from benchmarks.run.experiment import Experiment, run
from benchmarks.run.jobs import Keeper
from benchmarks.run.outcome import Outcome
from benchmarks.run.own_modules import load_modules
from benchmarks.run.selection import experiment_on


@dataclass(frozen=True)
class NamedExperiment:
    """See ``experiment_on`` and ``Experiment``. ``stored``: makes stored episodes of rendered ones."""

    suite: str
    scenario: str
    presets: Any
    trackers: Any
    seeds: range
    renderer: str = "raster"
    controllers: tuple[str, ...] | None = None
    link: str = "prompt"
    workers: int = 1
    repeats: int | None = None
    limit_s: float = 60.0
    real_time_hz: float | None = None
    modules: tuple[str, ...] = ()
    keeper: Keeper | None = None
    stored: Callable[..., Any] | None = None

    def made(self) -> Experiment:
        """Return what is run."""
        load_modules(self.modules)
        fields = {name: value for name, value in vars(self).items() if name not in ("suite", "stored")}
        made = experiment_on(self.suite, **fields)
        return made if self.stored is None else replace(made, episodes=self.stored(made.episodes))


def run_named(experiment: NamedExperiment, out: Path, *progress: Callable[[int, int], None]) -> Outcome:
    """See ``benchmarks.run.experiment.run``."""
    return run(experiment.made(), out, *progress)
