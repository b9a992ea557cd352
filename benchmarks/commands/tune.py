"""``frameout tune``: search parameters of trackers and controllers."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from benchmarks.commands.arguments import (
    FOLDER,
    NAMES,
    NUMBER,
    ONE_NAME,
    SEEDS,
    WORKERS,
    cores,
    development_seeds,
    names,
)
from benchmarks.commands.progress import progress_bar
from benchmarks.learning.controller_tuning import (
    ControllerBudget,
    controllers_to_tune,
    tunable_controller,
    tune_controller,
)
from benchmarks.learning.settings import EPISODES
from benchmarks.learning.tracker_tuning import (
    TUNED_FOLDER,
    Budget,
    Tuned,
    trackers_to_tune,
    tunables,
    tune,
    write_tuned,
)
from benchmarks.results.ledger import TEST_SPLIT
from benchmarks.run.contestants import entrant
from benchmarks.run.experiment import make_folder
from benchmarks.suites.registry import Scene, controllers_suite, suite
from scenarios import catalog
from sim.checks import check


@dataclass(frozen=True)
class Tune:
    """Search parameters on development seeds, with the same search, score and number of trials for each.

    Without names: of all trackers, on the first scene of each one's suite, then of all controllers, in all scenes.
    Controllers are tuned for suite `follow`: the search is without pictures where the scenario has such envs, with a
    model of the tracker's errors in place of the tracker; the best setting is checked with pictures.
    Writes trackers/tuned/NAME.json (controllers: trackers/tuned/controllers/CARRIER/NAME.json) with the values, the
    score, the number of trials, the seeds and this command. These values then replace the defaults; a paper's method
    stays as written and stands a second time as NAME_tuned. Variants share the values of their tracker. A run that was
    stopped continues with the same command. Needs Optuna (pip install 'frameout[tune]').

    Attributes:
        trackers: names.
        controllers: names of controllers.
        scenario: scenario for the controllers that are named.
        tracker: name of the tracker for the controllers (default: the suite's own).
        trials: number of settings to try for each.
        preset: one or more presets, one for controllers; the scores are averaged (default: as the suite says).
        seeds: episodes A to B - 1, below 10,000 (default: as the suite says).
        fresh: number of episodes after them on which the best setting must be better too (default: as the suite says);
            those of controllers are with pictures.
        workers: number of worker processes.
        out: folder for the values (default: trackers/tuned, the only folder that they are loaded from).
        studies: folder that keeps all trials, with plots.
    """

    trackers: Annotated[tuple[str, ...], tyro.conf.Positional] = ()
    controllers: Annotated[tuple[str, ...], NAMES] = ()
    scenario: str = catalog.DEFAULT
    tracker: Annotated[str, ONE_NAME] = ""
    trials: int = 40
    preset: tuple[str, ...] = ()
    seeds: Annotated[str, SEEDS] = ""
    fresh: Annotated[int | None, NUMBER] = None
    workers: Annotated[int | None, WORKERS] = None
    out: Annotated[Path, FOLDER] = TUNED_FOLDER
    studies: Annotated[Path, FOLDER] = Path("results/tune")
    resumes = True

    def run(self) -> int:
        """Tune them one after the other; return the exit status."""
        if self.seeds:
            development_seeds(self.seeds)
        for parameter, value in (("trials", self.trials), ("fresh", self.fresh)):
            check(parameter, value is None or value >= 1, "a whole number >= 1", value)
        make_folder(self.out)
        everything = not self.trackers and not self.controllers
        trackers = trackers_to_tune() if everything else names(self.trackers)
        steering = controllers_to_tune() if everything else [(self.scenario, names(self.controllers))]
        for name in trackers:
            tunables(name)
        for scenario, controllers in steering:
            for name in controllers:
                tunable_controller(name, catalog.scenario(scenario).carrier.name)
        for name in trackers:
            self._tune_tracker(name)
        for scenario, controllers in steering:
            for name in controllers:
                self._tune_controller(name, scenario)
        return 0

    def _tune_tracker(self, name: str) -> None:
        its_suite = suite(entrant(name).suites[0])
        presets, seeds, fresh = self._episodes(its_suite.scenes[0])
        budget = Budget(its_suite.name, presets, seeds, fresh, self.trials, cores(self.workers))
        with progress_bar(f"{name}, {self.trials} trials") as progress:
            tuned = tune(name, budget, progress, self.studies)
        command = self._command(name, presets, seeds, fresh)
        _report(name, tuned, write_tuned(name, tuned, budget.suite, presets, seeds, command, self.out))

    def _tune_controller(self, name: str, scenario: str) -> None:
        its_suite = controllers_suite()
        scene, known = its_suite.scene(scenario), catalog.scenario(scenario)
        presets, seeds, fresh = self._episodes(scene)
        check("preset", len(presets) == 1, "one for controllers", " ".join(presets))
        tracker = self.tracker or scene.trackers[0]
        budget = ControllerBudget(
            scenario=known.id,
            preset=presets[0],
            tracker=tracker,
            seeds=seeds,
            fresh=fresh,
            trials=self.trials,
            workers=cores(self.workers),
            cache=EPISODES,
        )
        with progress_bar(f"{name} of the {known.carrier.name}, {self.trials} trials") as progress:
            tuned = tune_controller(name, budget, progress, self.studies)
        command = self._command(
            f"--controllers {name} --scenario {scenario} --tracker {tracker}", presets, seeds, fresh
        )
        folder = self.out / "controllers" / known.carrier.name
        _report(name, tuned, write_tuned(name, tuned, its_suite.name, presets, seeds, command, folder))

    def _episodes(self, scene: Scene) -> tuple[tuple[str, ...], range, range]:
        """Return presets, seeds that score, and seeds that check."""
        seeds = development_seeds(self.seeds) if self.seeds else scene.tuned_on.seeds
        fresh = self.fresh or scene.tuned_on.fresh
        wanted = f"{fresh} development seeds after them, below {TEST_SPLIT.start}, to check the best setting on"
        check("seeds", seeds.stop + fresh <= TEST_SPLIT.start, wanted, repr(self.seeds))
        return names(self.preset) or (scene.tuned_on.preset,), seeds, range(seeds.stop, seeds.stop + fresh)

    def _command(self, tuned: str, presets: tuple[str, ...], seeds: range, fresh: range) -> str:
        episodes = f"--preset {' '.join(presets)} --seeds {seeds.start}:{seeds.stop} --fresh {len(fresh)}"
        return f"frameout tune {tuned} --trials {self.trials} {episodes}"


def _report(name: str, tuned: Tuned, path: Path) -> None:
    print(
        f"{name}: score {tuned.score:.3f}, with the defaults {tuned.default_score:.3f}; on fresh seeds "
        f"{tuned.fresh_score:.3f} and {tuned.fresh_default_score:.3f}: {path}"
    )
