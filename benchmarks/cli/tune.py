"""``frameout tune``: search parameters of trackers and controllers."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

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
from benchmarks.contract.suite import Scene, Suite, controllers_suite, suite
from benchmarks.contract.text import counted
from benchmarks.learning.tuning import (
    NO_VALUES,
    ControllerSearch,
    Search,
    TrackerSearch,
    Tuned,
    controllers_to_tune,
    failures_in_words,
    needs_optuna,
    trackers_to_tune,
    tune,
    write_tuned,
)
from benchmarks.run.result_folder import make_folder
from benchmarks.run.selection import tracker_named
from benchmarks.run.workers import cores
from benchmarks.show.progress import progress_bar
from scenarios import catalog
from sim.checks import check
from trackers import registry


@dataclass(frozen=True)
class Tune(WithModules):
    """Search parameters on development seeds, with the same search, score and number of trials for all of a scene.

    Without names: of all trackers, on the first scene of each one's suite, then of all controllers, in all scenes.
    Controllers are tuned for suite `follow`: the search is without pictures where the scenario has such envs, with a
    model of the tracker's errors in place of the tracker; the best setting is checked with pictures.
    Writes trackers/tuned/NAME.json (controllers: trackers/tuned/controllers/CARRIER/NAME.json), or, for a method in a
    module of yours, tuned/NAME.json beside it, with the values, the score, the number of trials, the seeds and this
    command. These values then replace the defaults; a paper's method stays as written and stands a second time as
    NAME_tuned. Variants share the values of their tracker. A run that was stopped continues with the same command.
    Needs Optuna (pip install 'frameout[tune]').

    The score of a search is the best of many trials on few episodes: it promises too much. The files say on how many
    episodes it was, and what written and tuned values score on fresh ones that decided nothing (seed 9,000 and
    following, as many as the search had, at least 8).

    Attributes:
        trackers: names, see `frameout list` (default: all).
        controllers: names of controllers, see `frameout list`.
        scenario: scenario for the controllers that are named (default: the first one of `frameout list`).
        tracker: name of the tracker for the controllers that are named (default: the suite's own).
        trials: number of settings to try for each (default: 40; 600 of a controller without pictures, by CMA-ES).
        preset: one or more presets, one for controllers; the scores are averaged (default: as the suite says).
        seeds: episodes A to B - 1, or A alone, below 10,000 (default: as the suite says).
        fresh: number of episodes after them, in each preset of --fresh-preset, on which the best setting must be better
            too (default: as the suite says); those of controllers are with pictures.
        fresh_preset: one or more presets of those episodes, for trackers (default: those of --preset, or as the suite
            says).
        workers: number of worker processes; 0 = run in this process.
        out: folder for the values (default: the one above, the only one that they are loaded from).
        studies: folder that keeps all trials, journals of Optuna (default: results/tune).
    """

    trackers: tyro.conf.Positional[Names] = ()
    controllers: Names = ()
    scenario: Annotated[str, ONE_NAME] = ""
    tracker: Annotated[str, ONE_NAME] = ""
    trials: Annotated[int | None, COUNT] = None
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
        searches: list[TrackerSearch | ControllerSearch] = [
            *(self._of_tracker(name) for name in (self.trackers if named else trackers_to_tune())),
            *(self._of_controller(name, each) for each, names in steering for name in names),
        ]
        needs_optuna()
        for search in searches:
            make_folder(self._folder(search))
            _ = search.depends_on  # An unknown tracker, or one without a model of its errors, is refused.
        for search in searches:
            episodes = counted(len(search.seeds) * len(search.presets), "episode")
            how = f"{counted(search.trial_count, 'trial')} on {episodes} of {' and '.join(search.presets)}"
            with progress_bar(f"{search.place}, {how}") as progress:
                tuned = tune(search, progress, self.studies)
            path = write_tuned(search, tuned, self._command(search), self._folder(search))
            _report(search, tuned, path)
        return 0

    def _of_tracker(self, name: str) -> TrackerSearch:
        for parameter, value in (("scenario", self.scenario), ("tracker", self.tracker)):
            check(parameter, bool(self.controllers) or not value, "none without --controllers", repr(value))
        its_suite = suite(tracker_named(name).suites[0])
        usual = self.preset or its_suite.scenes[0].tuned_on.fresh_presets
        return TrackerSearch(name=name, **self._how(its_suite, its_suite.scenes[0], usual))

    def _of_controller(self, name: str, scenario: str) -> ControllerSearch:
        its_suite = controllers_suite()
        scene = its_suite.scene(scenario)
        return ControllerSearch(name=name, tracker=self.tracker or scene.trackers[0], **self._how(its_suite, scene))

    def _how(self, its_suite: Suite, scene: Scene, fresh_presets: tuple[str, ...] = ()) -> dict[str, Any]:
        """Return all of a search that is no matter of its method."""
        seeds, fresh = self.seeds or scene.tuned_on.seeds, self.fresh or scene.tuned_on.fresh
        wanted = f"{fresh} development seeds after them, below {TEST_SPLIT.start}, to check the best setting on"
        check("seeds", seeds.stop + fresh <= TEST_SPLIT.start, wanted, seeds_text(seeds))
        presets = self.preset or (scene.tuned_on.preset,)
        return {
            "suite": its_suite.name,
            "scenario": catalog.id_of(scene.scenario),
            "presets": presets,
            "seeds": seeds,
            "fresh_presets": self.fresh_preset or fresh_presets or presets,
            "fresh": range(seeds.stop, seeds.stop + fresh),
            "trials": self.trials,
            "workers": cores(self.workers),
            "modules": self.modules,
        }

    def _folder(self, search: TrackerSearch | ControllerSearch) -> Path:
        module = (search.entry.tracker if isinstance(search, TrackerSearch) else search.entry.controller).__module__
        file = registry.tuned_file(search.place, module) if self.out is None else self.out / search.place
        return file.parent

    def _command(self, search: TrackerSearch | ControllerSearch) -> str:
        """Return the command that finds the values again."""
        named = search.name
        if isinstance(search, ControllerSearch):
            scenario = catalog.unversioned(search.scenario)
            named = f"--controllers {search.name} --scenario {scenario} --tracker {search.tracker}"
        command = f"frameout tune {named} --trials {search.trial_count} --preset {' '.join(search.presets)}"
        command += f" --seeds {seeds_text(search.seeds)} --fresh {len(search.fresh)}"
        command += "" if search.fresh_presets == search.presets else f" --fresh-preset {' '.join(search.fresh_presets)}"
        return command + (f" --modules {shlex.join(self.modules)}" if self.modules else "")


def _report(search: Search, tuned: Tuned, path: Path) -> None:
    kept = "" if tuned.parameters else ", so that the defaults stay"
    fresh = f"nothing, since {NO_VALUES}"
    if tuned.fresh is not None:
        fresh = f"{tuned.fresh['tuned']:.4f}, with the written values {tuned.fresh['written']:.4f}"
    print(
        f"{search.name}: score of the best trial {tuned.score:.4f}, with the defaults {tuned.default_score:.4f}; in "
        f"the check {tuned.check_score:.4f}, with the defaults {tuned.check_default_score:.4f}{kept}; on fresh ones "
        f"{fresh}: {path}{failures_in_words(search.failures)}"
    )
