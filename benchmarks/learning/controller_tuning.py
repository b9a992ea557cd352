"""Tuning of a controller: a search without pictures where the scene has such, a check with them on fresh seeds."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from joblib.externals.loky.process_executor import BrokenProcessPool

from benchmarks.contract.suite import controllers_suite
from benchmarks.learning.fresh_scores import ScoresOn, fresh_scores
from benchmarks.learning.search import Progress, announce_check, search
from benchmarks.learning.tracker_tuning import LIMIT_S, Tuned, chosen, rows_of, score_of
from benchmarks.learning.without_pictures import scores_without_pictures
from benchmarks.run.editions import judge_edition, own_code, package_versions, tracker_edition
from benchmarks.run.episodes import Steering, simulated
from benchmarks.run.failures import Failure
from benchmarks.run.jobs import Job
from benchmarks.run.own_modules import load_modules
from benchmarks.run.selection import tracker_named
from benchmarks.run.workers import in_processes
from scenarios import catalog
from scenarios.envs.pictureless.bank import episode_bank
from scenarios.envs.pictureless.error_model import error_model
from sim.checks import check
from trackers.controllers.catalogue import ControllerEntry, controller_entry, controllers


@dataclass(frozen=True)
class ControllerBudget:
    """Settings of a search, the same for all controllers.

    Attributes:
        scenario: catalogue id. preset: of the scenario. tracker: name.
        seeds: of the episodes that score a setting, without pictures where the scenario has such.
        fresh: of the rendered episodes that check the best setting.
        trials: number of settings; the first one is the defaults.
        workers: processes; 0 = this process. modules: users' own modules, imported first in each.
        cache: folder for planned episodes.
    """

    scenario: str
    preset: str
    tracker: str
    seeds: range
    fresh: range
    trials: int
    workers: int
    cache: Path | None = None
    modules: tuple[str, ...] = ()


def tunable_controller(name: str, carrier: str) -> ControllerEntry:
    """Return the entry of a controller that can be tuned. Raises ValueError for another."""
    entry = controller_entry(name, carrier)
    check("controllers", bool(entry.tunables()), "one with tunable parameters", f"{name!r}, which has none")
    check("controllers", entry.role != "variant", "one that is used as tuned", f"{name!r}, which never is")
    return entry


def controllers_to_tune() -> list[tuple[str, tuple[str, ...]]]:
    """Return each scenario of the controllers' suite with the controllers there that have tunable parameters."""
    found = []
    for scene in controllers_suite().scenes:
        known = controllers(catalog.scenario(scene.scenario).carrier.name)
        wanted = (name for name, entry in known.items() if entry.tunables() and entry.role not in ("variant", "policy"))
        found.append((scene.scenario, tuple(wanted)))
    return found


def tune_controller(name: str, budget: ControllerBudget, progress: Progress, studies: Path | None = None) -> Tuned:
    """Search the tunable parameters of one controller; the best replace the defaults if they are better with pictures.

    Raises:
        ValueError: without Optuna, or for a controller without tunable parameters.
    """
    entry = tunable_controller(name, catalog.scenario(budget.scenario).carrier.name)
    fields, defaults = entry.tunables(), entry.written()

    scene = catalog.scenario(budget.scenario)
    model = "" if scene.pictureless is None else error_model(budget.scenario, budget.tracker).to_json()
    failures: list[Failure] = []
    scores_on = controller_scores(name, budget, failures)
    scored = (model, controllers_suite().tuned_for)
    depends_on = (
        dataclasses.replace(budget, trials=0, workers=0, fresh=range(0), cache=None, modules=()),
        package_versions(),
        scene.id,
        judge_edition(controllers_suite()),
        tracker_edition(tracker_named(budget.tracker)),
        (entry.edition, own_code(entry.controller.__module__)),
        scored,
    )
    found = search(
        f"{entry.carrier}-{name}",
        fields,
        defaults,
        budget.trials,
        lambda settings: scores_on(settings, budget.seeds),
        progress,
        studies,
        depends_on,
    )
    announce_check(name, len(budget.fresh))
    checked = (_score_with_pictures(entry, values, budget, budget.fresh, failures) for values in (found.best, defaults))
    tuned = chosen(found, *checked)
    fresh = fresh_scores(tuned.parameters, defaults, budget.seeds, scores_on)
    return dataclasses.replace(tuned, fresh=fresh, failures=failures)


def controller_scores(name: str, budget: ControllerBudget, failures: list[Failure]) -> ScoresOn:
    """Return the function that scores settings of a controller as its search does: without pictures where the scene
    has such episodes, else adding to ``failures``.
    """
    scene = catalog.scenario(budget.scenario)
    entry = tunable_controller(name, scene.carrier.name)

    def with_pictures(settings: dict[str, dict[str, Any]], seeds: range) -> dict[str, float]:
        return {
            label: _score_with_pictures(entry, values, budget, seeds, failures) for label, values in settings.items()
        }

    def without_pictures(settings: dict[str, dict[str, Any]], seeds: range) -> dict[str, float]:
        # Episodes are planned once, for all workers.
        episode_bank(budget.scenario, scene.presets[budget.preset], seeds, budget.cache)
        labelled = partial(_labelled_score, entry, dataclasses.replace(budget, seeds=seeds))
        try:
            return dict(in_processes(labelled, settings.items(), budget.workers))
        except BrokenProcessPool:
            raise ChildProcessError(f"{name}: it ended a worker process; the same command continues") from None

    return with_pictures if scene.pictureless is None else without_pictures


def score_without_pictures(entry: ControllerEntry, values: dict[str, Any], budget: ControllerBudget) -> float:
    """Return what tuning maximises (the suite's ``tuned_for``) over the budget's episodes, each run once."""
    load_modules(budget.modules)
    scores = scores_without_pictures(
        budget.scenario, budget.preset, budget.tracker, entry.name, values, budget.seeds, budget.cache
    )
    return sum(factor * float(scores[metric].mean()) for metric, factor in controllers_suite().tuned_for.items())


def _labelled_score(
    entry: ControllerEntry, budget: ControllerBudget, setting: tuple[str, dict[str, Any]]
) -> tuple[str, float]:
    label, values = setting
    return label, score_without_pictures(entry, values, budget)


def _score_with_pictures(
    entry: ControllerEntry, values: dict[str, Any], budget: ControllerBudget, seeds: range, failures: list[Failure]
) -> float:
    judged = controllers_suite()
    carrier = catalog.scenario(budget.scenario).carrier.name
    trackers = {budget.tracker: tracker_named(budget.tracker)}
    jobs = []
    for seed in seeds:
        episode = simulated(budget.scenario, budget.preset, seed)
        steered = dataclasses.replace(episode, steering=Steering(entry.name, carrier, "prompt", values))
        jobs.append(Job(judged, steered, trackers, budget.modules, limit_s=LIMIT_S))
    return score_of(rows_of(jobs, budget.workers, failures), judged.name)
