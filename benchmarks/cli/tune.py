"""``frameout tune``: search parameters of trackers and controllers."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from benchmarks.cli.arguments import (
    COUNT,
    FOLDER,
    ONE_NAME,
    WORKERS,
    Names,
    UsualDevelopmentSeeds,
    WithModules,
    seeds_text,
)
from benchmarks.contract.rows import TEST_SPLIT
from benchmarks.contract.suite import Scene, controllers_suite, suite
from benchmarks.contract.text import counted
from benchmarks.learning.training import EPISODES
from benchmarks.learning.tuning import (
    NO_VALUES,
    Budget,
    ControllerBudget,
    Tuned,
    controllers_to_tune,
    failures_in_words,
    needs_optuna,
    trackers_to_tune,
    tunable_controller,
    tunables,
    tune,
    tune_controller,
    write_tuned,
)
from benchmarks.run.result_folder import make_folder
from benchmarks.run.selection import tracker_named
from benchmarks.run.workers import cores
from benchmarks.show.progress import progress_bar
from scenarios import catalog
from sim.checks import check, check_choice
from trackers import registry
from trackers.controllers.catalogue import controller_entry

_Episodes = tuple[tuple[str, ...], range, tuple[str, ...], range]
"""Presets and seeds of a search, and those of its check."""


@dataclass(frozen=True)
class Tune(WithModules):
    """Search parameters on development seeds, with the same search, score and number of trials for each.

    Without names: of all trackers, on the first scene of each one's suite, then of all controllers, in all scenes.
    Controllers are tuned for suite `follow`: the search is without pictures where the scenario has such envs, with a
    model of the tracker's errors in place of the tracker; the best setting is checked with pictures.
    Writes trackers/tuned/NAME.json (controllers: trackers/tuned/controllers/CARRIER/NAME.json), or, for a method in a
    module of yours, tuned/NAME.json beside it, with the values, the score, the number of trials, the seeds and this
    command. These values then replace the defaults; a paper's method
    stays as written and stands a second time as NAME_tuned. Variants share the values of their tracker. A run that was
    stopped continues with the same command. Needs Optuna (pip install 'frameout[tune]').

    The score of a search is the best of many trials on few episodes: it promises too much. The files say on how many
    episodes it was, and what written and tuned values score on fresh ones that decided nothing (seed 9,000 and
    following, as many as the search had, at least 8).

    Attributes:
        trackers: names, see `frameout list` (default: all).
        controllers: names of controllers, see `frameout list`.
        scenario: scenario for the controllers that are named (default: the first one of `frameout list`).
        tracker: name of the tracker for the controllers that are named (default: the suite's own).
        trials: number of settings to try for each.
        preset: one or more presets, one for controllers; the scores are averaged (default: as the suite says).
        seeds: episodes A to B - 1, or A alone, below 10,000 (default: as the suite says).
        fresh: number of episodes after them, in each preset of --fresh-preset, on which the best setting must be better
            too (default: as the suite says); those of controllers are with pictures.
        fresh_preset: one or more presets of those episodes, for trackers (default: those of --preset, or as the suite
            says).
        workers: number of worker processes; 0 = run in this process.
        out: folder for the values (default: the one above, the only one that they are loaded from).
        studies: folder that keeps all trials, with plots (default: results/tune).
    """

    trackers: tyro.conf.Positional[Names] = ()
    controllers: Names = ()
    scenario: Annotated[str, ONE_NAME] = ""
    tracker: Annotated[str, ONE_NAME] = ""
    trials: int = 40
    preset: Names = ()
    seeds: UsualDevelopmentSeeds = None
    fresh: Annotated[int | None, COUNT] = None
    fresh_preset: Names = ()
    workers: Annotated[int | None, WORKERS] = None
    out: Annotated[Path | None, FOLDER] = None
    studies: Annotated[Path, FOLDER] = Path("results/tune")
    resumes = True

    def run(self) -> int:
        """Tune them one after the other; return the exit status."""
        for parameter, value in (("trials", self.trials), ("fresh", self.fresh)):
            check(parameter, value is None or value >= 1, "a whole number >= 1", value)
        named = bool(self.trackers or self.controllers)
        scenario = self.scenario or catalog.DEFAULT
        steering = [(scenario, self.controllers)] if named else controllers_to_tune()
        # All is checked before the first search: they take hours.
        trackers = {name: self._tracker_budget(name) for name in (self.trackers if named else trackers_to_tune())}
        controllers = [(name, self._controller_budget(name, each)) for each, names in steering for name in names]
        needs_optuna()
        for folder in [*map(self._tracker_folder, trackers), *(self._controller_folder(*each) for each in controllers)]:
            make_folder(folder)
        for name, budget in trackers.items():
            with progress_bar(self._title(name, budget.presets, budget.seeds)) as progress:
                tuned = tune(name, budget, progress, self.studies)
            episodes = (budget.presets, budget.seeds, budget.fresh_presets, budget.fresh)
            self._write(name, tuned, budget.suite, episodes, name, self._tracker_folder(name))
        for name, steered in controllers:
            presets, carrier = (steered.preset,), catalog.scenario(steered.scenario).carrier.name
            with progress_bar(self._title(f"{name} of the {carrier}", presets, steered.seeds)) as progress:
                tuned = tune_controller(name, steered, progress, self.studies)
            of = f"--controllers {name} --scenario {catalog.unversioned(steered.scenario)} --tracker {steered.tracker}"
            episodes = (presets, steered.seeds, presets, steered.fresh)
            self._write(name, tuned, controllers_suite().name, episodes, of, self._controller_folder(name, steered))
        return 0

    def _tracker_budget(self, name: str) -> Budget:
        for parameter, value in (("scenario", self.scenario), ("tracker", self.tracker)):
            check(parameter, bool(self.controllers) or not value, "none without --controllers", repr(value))
        tunables(name)
        its_suite = suite(tracker_named(name).suites[0])
        scene = its_suite.scenes[0]
        presets, seeds, fresh = self._episodes(scene)
        checked = self.fresh_preset or self.preset or scene.tuned_on.fresh_presets or presets
        known = catalog.scenario(scene.scenario).presets
        for parameter, chosen in (("preset", presets), ("fresh_preset", checked)):
            for each in chosen:
                check_choice(parameter, each, known)
        return Budget(
            suite=its_suite.name,
            presets=presets,
            seeds=seeds,
            fresh_presets=checked,
            fresh=fresh,
            trials=self.trials,
            workers=cores(self.workers),
            modules=self.modules,
        )

    def _controller_budget(self, name: str, scenario: str) -> ControllerBudget:
        scene, known = controllers_suite().scene(scenario), catalog.scenario(scenario)
        tunable_controller(name, known.carrier.name)
        presets, seeds, fresh = self._episodes(scene)
        check("preset", len(presets) == 1, "one for controllers", " ".join(presets))
        check("fresh_preset", not self.fresh_preset, "none for controllers", " ".join(self.fresh_preset))
        return ControllerBudget(
            scenario=known.id,
            preset=presets[0],
            tracker=self.tracker or scene.trackers[0],
            seeds=seeds,
            fresh=fresh,
            trials=self.trials,
            workers=cores(self.workers),
            cache=EPISODES,
            modules=self.modules,
        )

    def _episodes(self, scene: Scene) -> tuple[tuple[str, ...], range, range]:
        """Return presets, seeds that score, and seeds that check."""
        seeds, fresh = self.seeds or scene.tuned_on.seeds, self.fresh or scene.tuned_on.fresh
        wanted = f"{fresh} development seeds after them, below {TEST_SPLIT.start}, to check the best setting on"
        check("seeds", seeds.stop + fresh <= TEST_SPLIT.start, wanted, seeds_text(seeds))
        return self.preset or (scene.tuned_on.preset,), seeds, range(seeds.stop, seeds.stop + fresh)

    def _tracker_folder(self, name: str) -> Path:
        return self.out or registry.tuned_file(name, registry.entry(name).tracker.__module__).parent

    def _controller_folder(self, name: str, budget: ControllerBudget) -> Path:
        carrier = catalog.scenario(budget.scenario).carrier.name
        own = f"controllers/{carrier}/{name}"
        file = registry.tuned_file(own, controller_entry(name, carrier).controller.__module__)
        return file.parent if self.out is None else (self.out / own).parent

    def _title(self, what: str, presets: Sequence[str], seeds: range) -> str:
        """Return what is tuned and how large the search is, in words."""
        episodes = counted(len(seeds) * len(presets), "episode")
        return f"{what}, {counted(self.trials, 'trial')} on {episodes} of {' and '.join(presets)}"

    def _write(self, name: str, tuned: Tuned, suite_name: str, episodes: _Episodes, named: str, folder: Path) -> None:
        """Write the values, with the command that finds them again, and print the scores."""
        presets, seeds, fresh_presets, fresh = episodes
        command = f"frameout tune {named} --trials {self.trials} --preset {' '.join(presets)}"
        command += f" --seeds {seeds_text(seeds)} --fresh {len(fresh)}"
        command += f" --fresh-preset {' '.join(fresh_presets)}" if fresh_presets != presets else ""
        command += f" --modules {shlex.join(self.modules)}" if self.modules else ""
        path = write_tuned(name, tuned, suite_name, presets, seeds, command, folder)
        kept = "" if tuned.parameters else ", so that the defaults stay"
        on_fresh = f"nothing, since {NO_VALUES}"
        if tuned.fresh is not None:
            on_fresh = f"{tuned.fresh.tuned:.4f}, with the written values {tuned.fresh.written:.4f}"
        print(
            f"{name}: score of the best trial {tuned.score:.4f}, with the defaults {tuned.default_score:.4f}; in the "
            f"check {tuned.check_score:.4f}, with the defaults {tuned.check_default_score:.4f}{kept}; on fresh ones "
            f"{on_fresh}: {path}{failures_in_words(tuned.failures)}"
        )
