"""``frameout tune``: search parameters of trackers and controllers."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from benchmarks.commands.arguments import (
    FOLDER,
    NAMES,
    ONE_NAME,
    SEEDS,
    WORKERS,
    cores,
    development_seeds,
    names,
)
from benchmarks.commands.progress import progress_bar
from benchmarks.learning.controller_tuning import ControllerBudget, tunable_controller, tune_controller
from benchmarks.learning.settings import EPISODES
from benchmarks.learning.tracker_tuning import TUNED_FOLDER, Budget, Tuned, tunables, tune, write_tuned
from benchmarks.results.ledger import TEST_SPLIT
from benchmarks.run.contestants import entrant
from benchmarks.run.experiment import make_folder
from benchmarks.suites.registry import controllers_suite
from scenarios import catalog
from sim.checks import check
from trackers import registry


@dataclass(frozen=True)
class Tune:
    """Search parameters on development seeds, with the same search, score and number of trials for each.

    Trackers are tuned on the first of their suites. Controllers are tuned for suite `follow`: the search is without
    pictures where the scenario has such envs, with a model of the tracker's errors in place of the tracker; the best
    setting is checked with pictures.
    Writes trackers/tuned/NAME.json (controllers: trackers/tuned/controllers/CARRIER/NAME.json) with the values, the
    score, the number of trials, the seeds and this command; these values then replace the defaults. Variants share the
    values of their tracker. A run that was stopped continues with the same command. Needs Optuna
    (pip install 'frameout[tune]').

    Attributes:
        trackers: names (default without --controllers: all trackers with tunable parameters).
        controllers: names of controllers to tune instead.
        scenario: scenario for the controllers.
        tracker: name of the tracker for the controllers (default: the suite's own).
        trials: number of settings to try for each.
        preset: one or more presets, one for controllers; the scores are averaged.
        seeds: episodes A to B - 1, below 10,000; the best setting replaces the defaults if it is also better on the
            next B - A episodes (controllers: on the next --fresh ones).
        fresh: number of rendered episodes for the check of controllers.
        workers: number of worker processes.
        out: folder for the values (default: trackers/tuned, the only folder that they are loaded from).
        studies: folder that keeps all trials, with plots.
    """

    trackers: Annotated[tuple[str, ...], tyro.conf.Positional] = ()
    controllers: Annotated[tuple[str, ...], NAMES] = ()
    scenario: str = catalog.DEFAULT
    tracker: Annotated[str, ONE_NAME] = ""
    trials: int = 40
    preset: tuple[str, ...] = ("standard",)
    seeds: Annotated[str, SEEDS] = "0:4"
    fresh: int = 8
    workers: Annotated[int | None, WORKERS] = None
    out: Annotated[Path, FOLDER] = TUNED_FOLDER
    studies: Annotated[Path, FOLDER] = Path("results/tune")
    resumes = True

    def run(self) -> int:
        """Tune them one after the other; return the exit status."""
        seeds = development_seeds(self.seeds)
        make_folder(self.out)
        for parameter, value in (("trials", self.trials), ("fresh", self.fresh)):
            check(parameter, value >= 1, "a whole number >= 1", value)
        wanted = f"as many development seeds after them, below {TEST_SPLIT.start}, to check the best setting on"
        check("seeds", seeds.stop + max(len(seeds), self.fresh) <= TEST_SPLIT.start, wanted, repr(self.seeds))
        if self.controllers:
            self._tune_controllers(seeds)
        if self.trackers or not self.controllers:
            self._tune_trackers(seeds)
        return 0

    def _tune_trackers(self, seeds: range) -> None:
        known = names(self.trackers) or tuple(filter(_has_tunables, registry.entries()))
        for name in known:
            tunables(name)
        for name in known:
            suite_name = entrant(name).suites[0]
            budget = Budget(suite_name, names(self.preset), seeds, self.trials, cores(self.workers))
            with progress_bar(f"{name}, {self.trials} trials") as progress:
                tuned = tune(name, budget, progress, self.studies)
            path = write_tuned(name, tuned, suite_name, budget.presets, seeds, self._command(name), self.out)
            _report(name, tuned, path)

    def _tune_controllers(self, seeds: range) -> None:
        scenario, suite = catalog.scenario(self.scenario), controllers_suite()
        presets = names(self.preset)
        check("preset", len(presets) == 1, "one for controllers", " ".join(presets))
        (preset,) = presets
        tracker = self.tracker or suite.scene(scenario.id).trackers[0]
        budget = ControllerBudget(
            scenario=scenario.id,
            preset=preset,
            tracker=tracker,
            seeds=seeds,
            fresh=range(seeds.stop, seeds.stop + self.fresh),
            trials=self.trials,
            workers=cores(self.workers),
            cache=EPISODES,
        )
        for name in names(self.controllers):
            tunable_controller(name, scenario.carrier.name)
        for name in names(self.controllers):
            with progress_bar(f"{name}, {self.trials} trials") as progress:
                tuned = tune_controller(name, budget, progress, self.studies)
            command = self._command(
                f"--controllers {name} --scenario {self.scenario} --tracker {tracker} --fresh {self.fresh}"
            )
            folder = self.out / "controllers" / scenario.carrier.name
            _report(name, tuned, write_tuned(name, tuned, suite.name, (preset,), seeds, command, folder))

    def _command(self, tuned: str) -> str:
        return f"frameout tune {tuned} --trials {self.trials} --preset {' '.join(self.preset)} --seeds {self.seeds}"


def _report(name: str, tuned: Tuned, path: Path) -> None:
    print(
        f"{name}: score {tuned.score:.3f}, with the defaults {tuned.default_score:.3f}; on fresh seeds "
        f"{tuned.fresh_score:.3f} and {tuned.fresh_default_score:.3f}: {path}"
    )


def _has_tunables(name: str) -> bool:
    entry = registry.entry(name)
    if entry.name != entry.tuned_as:
        return False
    try:
        tunables(name)
    except ValueError:
        return False
    return True
