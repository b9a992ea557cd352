"""``frameout tune``: search parameters of trackers and controllers."""

from __future__ import annotations

import dataclasses
import json
import shlex
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import tyro

from benchmarks.cli.arguments import (
    COUNT,
    FOLDER,
    NAMES,
    ONE_NAME,
    USUAL_SEEDS,
    WORKERS,
    WithModules,
    check_unset,
    development_seeds,
    names,
    seed_range,
)
from benchmarks.contract.rows import TEST_SPLIT
from benchmarks.contract.suite import Scene, controllers_suite, suite
from benchmarks.contract.text import counted
from benchmarks.learning.training import EPISODES
from benchmarks.learning.tuning import (
    Budget,
    ControllerBudget,
    ScoresOn,
    Tuned,
    controller_scores,
    controllers_to_tune,
    failures_in_words,
    fresh_entries,
    needs_optuna,
    scored_anew,
    tracker_scores,
    trackers_to_tune,
    tunable_controller,
    tunables,
    tune,
    tune_controller,
    write_tuned,
)
from benchmarks.run.failures import Failure
from benchmarks.run.result_folder import make_folder
from benchmarks.run.selection import tracker_named
from benchmarks.run.workers import cores
from benchmarks.show.progress import progress_bar
from scenarios import catalog
from sim.checks import check, check_choice
from trackers import registry
from trackers.atomic_file import write_atomic
from trackers.controllers.catalogue import controller_entry

_ITS_OWN = "with --rescore, which takes what the files say"


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
            too (default: as the suite says); those of controllers are with pictures. With --rescore: of the fresh ones
            that decided nothing.
        fresh_preset: one or more presets of those episodes, for trackers (default: those of --preset, or as the suite
            says).
        workers: number of worker processes; 0 = run in this process.
        rescore: search nothing; score stored values anew, on the episodes of their search and on fresh ones.
        out: folder for the values (default: the one above, the only one that they are loaded from).
        studies: folder that keeps all trials, with plots (default: results/tune).
    """

    trackers: Annotated[tuple[str, ...], tyro.conf.Positional, NAMES] = ()
    controllers: Annotated[tuple[str, ...], NAMES] = ()
    scenario: Annotated[str, ONE_NAME] = ""
    tracker: Annotated[str, ONE_NAME] = ""
    trials: int = 40
    preset: Annotated[tuple[str, ...], NAMES] = ()
    seeds: Annotated[str, USUAL_SEEDS] = ""
    fresh: Annotated[int | None, COUNT] = None
    fresh_preset: Annotated[tuple[str, ...], NAMES] = ()
    workers: Annotated[int | None, WORKERS] = None
    rescore: bool = False
    out: Annotated[Path | None, FOLDER] = None
    studies: Annotated[Path, FOLDER] = Path("results/tune")
    resumes = True

    def run(self) -> int:
        """Tune them one after the other; return the exit status."""
        for parameter, value in (("trials", self.trials), ("fresh", self.fresh)):
            check(parameter, value is None or value >= 1, "a whole number >= 1", value)
        # All is checked before the first search: they take hours.
        trackers = [(name, self._tracker_budget(name)) for name in self._trackers()]
        controllers = [(name, self._controller_budget(name, scenario)) for scenario, name in self._controllers()]
        if self.rescore:
            check_unset(self, ("trials", "preset", "seeds", "fresh_preset"), _ITS_OWN)
            return self._rescore(trackers, controllers)
        needs_optuna()
        for name, _ in trackers:
            make_folder(self._tracker_folder(name))
        for name, steering in controllers:
            make_folder(self._controller_folder(name, steering))
        for name, budget in trackers:
            self._tune_tracker(name, budget)
        for name, steering in controllers:
            self._tune_controller(name, steering)
        return 0

    def _rescore(
        self, trackers: Sequence[tuple[str, Budget]], controllers: Sequence[tuple[str, ControllerBudget]]
    ) -> int:
        """Score stored values anew; return the exit status."""
        for name, budget in trackers:
            path = self._tracker_folder(name) / f"{name}.json"
            stored = _stored(path)
            of_search = dataclasses.replace(budget, presets=tuple(stored["preset"].split()))
            self._write_anew(path, stored, registry.entry(name).written(), partial(tracker_scores, name, of_search))
        for name, steering in controllers:
            path = self._controller_folder(name, steering) / f"{name}.json"
            stored = _stored(path)
            carrier = catalog.scenario(steering.scenario).carrier.name
            of_controller = dataclasses.replace(steering, preset=stored["preset"])
            written = controller_entry(name, carrier).written()
            self._write_anew(path, stored, written, partial(controller_scores, name, of_controller))
        return 0

    def _write_anew(
        self,
        path: Path,
        stored: dict[str, Any],
        written: dict[str, Any],
        scores: Callable[[list[Failure]], ScoresOn],
    ) -> None:
        """Replace the scores in a file of tuned values."""
        failures: list[Failure] = []
        anew = scored_anew(stored, written, seed_range(stored["seeds"]), scores(failures), self.fresh)
        write_atomic(path, json.dumps(anew, indent=1) + "\n")
        print(
            f"{path.stem}: on the {counted(anew['episodes'], 'episode')} of the search {anew['score']:.4f}, with the "
            f"written values {anew['default_score']:.4f}; {_fresh_words(anew)}: {path}{failures_in_words(failures)}",
            flush=True,
        )

    @property
    def _everything(self) -> bool:
        return not self.trackers and not self.controllers

    def _trackers(self) -> tuple[str, ...]:
        return trackers_to_tune() if self._everything else names(self.trackers)

    def _controllers(self) -> list[tuple[str, str]]:
        """Return (scenario, name) of each."""
        if self._everything:
            return [(scenario, name) for scenario, found in controllers_to_tune() for name in found]
        return [(self.scenario or catalog.DEFAULT, name) for name in names(self.controllers)]

    def _tracker_budget(self, name: str) -> Budget:
        for parameter, value in (("scenario", self.scenario), ("tracker", self.tracker)):
            check(parameter, bool(self.controllers) or not value, "none without --controllers", repr(value))
        tunables(name)
        its_suite = suite(tracker_named(name).suites[0])
        scene = its_suite.scenes[0]
        presets, seeds, fresh = self._episodes(scene)
        checked = names(self.fresh_preset) or names(self.preset) or scene.tuned_on.fresh_presets or presets
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

    def _tune_tracker(self, name: str, budget: Budget) -> None:
        with progress_bar(f"{name}, {self._search(budget.seeds, budget.presets)}") as progress:
            tuned = tune(name, budget, progress, self.studies)
        command = self._command(name, budget.presets, budget.seeds, budget.fresh, budget.fresh_presets)
        folder = self._tracker_folder(name)
        _report(name, tuned, write_tuned(name, tuned, budget.suite, budget.presets, budget.seeds, command, folder))

    def _tune_controller(self, name: str, budget: ControllerBudget) -> None:
        carrier, presets = catalog.scenario(budget.scenario).carrier.name, (budget.preset,)
        with progress_bar(f"{name} of the {carrier}, {self._search(budget.seeds, presets)}") as progress:
            tuned = tune_controller(name, budget, progress, self.studies)
        of = f"--controllers {name} --scenario {catalog.unversioned(budget.scenario)} --tracker {budget.tracker}"
        command = self._command(of, presets, budget.seeds, budget.fresh, presets)
        folder = self._controller_folder(name, budget)
        _report(name, tuned, write_tuned(name, tuned, controllers_suite().name, presets, budget.seeds, command, folder))

    def _search(self, seeds: range, presets: Sequence[str]) -> str:
        """Return how large a search is, in words."""
        episodes = counted(len(seeds) * len(presets), "episode")
        return f"{counted(self.trials, 'trial')} on {episodes} of {' and '.join(presets)}"

    def _tracker_folder(self, name: str) -> Path:
        return self.out or registry.tuned_file(name, registry.entry(name).tracker.__module__).parent

    def _controller_folder(self, name: str, budget: ControllerBudget) -> Path:
        carrier = catalog.scenario(budget.scenario).carrier.name
        own = f"controllers/{carrier}/{name}"
        file = registry.tuned_file(own, controller_entry(name, carrier).controller.__module__)
        return file.parent if self.out is None else (self.out / own).parent

    def _episodes(self, scene: Scene) -> tuple[tuple[str, ...], range, range]:
        """Return presets, seeds that score, and seeds that check."""
        seeds = development_seeds(self.seeds) if self.seeds else scene.tuned_on.seeds
        fresh = self.fresh or scene.tuned_on.fresh
        wanted = f"{fresh} development seeds after them, below {TEST_SPLIT.start}, to check the best setting on"
        check("seeds", seeds.stop + fresh <= TEST_SPLIT.start, wanted, repr(self.seeds))
        return names(self.preset) or (scene.tuned_on.preset,), seeds, range(seeds.stop, seeds.stop + fresh)

    def _command(
        self, tuned: str, presets: tuple[str, ...], seeds: range, fresh: range, fresh_presets: tuple[str, ...]
    ) -> str:
        episodes = f"--preset {' '.join(presets)} --seeds {seeds.start}:{seeds.stop} --fresh {len(fresh)}"
        episodes += f" --fresh-preset {' '.join(fresh_presets)}" if fresh_presets != presets else ""
        modules = f" --modules {shlex.join(self.modules)}" if self.modules else ""
        return f"frameout tune {tuned} --trials {self.trials} {episodes}{modules}"


def _stored(path: Path) -> dict[str, Any]:
    """Return the content of a file of tuned values. Raises ValueError without one."""
    check("rescore", path.is_file(), "a tracker with tuned values", f"none in {str(path)!r}")
    stored: dict[str, Any] = json.loads(path.read_text())
    return stored


def _report(name: str, tuned: Tuned, path: Path) -> None:
    scores = (tuned.score, tuned.default_score, tuned.check_score, tuned.check_default_score)
    score, default, checked, check_default = (f"{value:.4f}" for value in scores)
    kept = "" if tuned.parameters else ", so that the defaults stay"
    print(
        f"{name}: score of the best trial {score}, with the defaults {default}; in the check {checked}, with the "
        f"defaults {check_default}{kept}; {_fresh_words(fresh_entries(tuned.fresh))}: {path}"
        f"{failures_in_words(tuned.failures)}"
    )


def _fresh_words(entries: dict[str, Any]) -> str:
    """Return what fresh episodes gave, in words."""
    fresh = entries["fresh"]
    if fresh is None:
        return f"on fresh ones nothing, since {entries['no_fresh']}"
    return f"on fresh ones {fresh['tuned']:.4f}, with the written values {fresh['written']:.4f}"
