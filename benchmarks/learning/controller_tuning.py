"""Chooses a controller's parameters: searched for without pictures, checked on fresh seeds with them."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import joblib

from benchmarks.learning.search import Progress, search
from benchmarks.learning.tracker_tuning import Tuned, chosen, score_of
from benchmarks.learning.without_pictures import lived_without_pictures
from benchmarks.run.jobs import Job, run_job
from benchmarks.run.steering import link_in
from benchmarks.run.versions import versions_of_modules
from benchmarks.suites.registry import controllers_suite
from scenarios import catalog
from scenarios.envs.pictureless.bank import episode_bank
from scenarios.envs.pictureless.error_model import error_model
from trackers.controllers.catalogue import ControllerEntry, controller_entry

_DEFAULTS, _BEST = "defaults", "best"


@dataclass(frozen=True)
class ControllerBudget:
    """How a search is done; the same for all controllers, so that none is favoured.

    Attributes:
        scenario: catalogue id. preset, tracker: what is followed with.
        seeds: of the episodes without pictures on which a setting is scored.
        fresh: of the rendered episodes that the best setting is checked on.
        trials: settings tried, the first one is the defaults.
        workers: processes.
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


def tunable_controller(name: str, carrier: str) -> ControllerEntry:
    """Return the entry of a controller that can be tuned. Raises ValueError for another."""
    entry = controller_entry(name, carrier)
    if not entry.tunables():
        raise ValueError(f"controllers: expected one with tunable parameters, got {name!r}, which has none")
    if entry.role == "variant":
        raise ValueError(f"controllers: expected one that is used as tuned, got {name!r}, which never is")
    return entry


def tune_controller(name: str, budget: ControllerBudget, progress: Progress, studies: Path | None = None) -> Tuned:
    """Search the tunable parameters of one controller; the best replace the defaults if they are better with pictures.

    Raises:
        ValueError: if Optuna is not there, or the controller has nothing to tune.
    """
    entry = tunable_controller(name, catalog.scenario(budget.scenario).carrier.name)
    fields, defaults = entry.tunables(), entry.written()

    def scores(settings: dict[str, dict[str, Any]]) -> dict[str, float]:
        jobs = (joblib.delayed(score_without_pictures)(entry, values, budget) for values in settings.values())
        found = joblib.Parallel(n_jobs=budget.workers)(jobs)
        return dict(zip(settings, found, strict=True))

    # Planned once, for all workers.
    episode_bank(budget.scenario, catalog.scenario(budget.scenario).presets[budget.preset], budget.seeds, budget.cache)
    scene = type(catalog.scenario(budget.scenario)).__module__
    code = versions_of_modules(__name__, entry.controller.__module__, scene)
    scored = (error_model(budget.scenario, budget.tracker).to_json(), controllers_suite().tuned_for)
    told = (dataclasses.replace(budget, trials=0, workers=0, cache=None), code, scored)
    found = search(f"{entry.carrier}-{name}", fields, defaults, budget.trials, scores, progress, studies, told)
    fresh = _scores_with_pictures(entry, {_BEST: found.best, _DEFAULTS: defaults}, budget)
    return chosen(found, fresh[_BEST], fresh[_DEFAULTS])


def score_without_pictures(entry: ControllerEntry, values: dict[str, Any], budget: ControllerBudget) -> float:
    """Return what tuning maximises (the suite's ``tuned_for``) over the budget's episodes, each lived through once."""
    told = lived_without_pictures(
        budget.scenario, budget.preset, budget.tracker, entry.name, values, budget.seeds, budget.cache
    )
    return sum(factor * float(told[metric].mean()) for metric, factor in controllers_suite().tuned_for.items())


def _scores_with_pictures(
    entry: ControllerEntry, settings: dict[str, dict[str, Any]], budget: ControllerBudget
) -> dict[str, float]:
    suite = controllers_suite().name
    jobs = {
        label: [
            Job(
                suite=suite,
                scenario=budget.scenario,
                preset=budget.preset,
                renderer="raster",
                seed=seed,
                controller=entry.name,
                controller_values=values,
                trackers=(budget.tracker,),
                link=link_in(suite),
            )
            for seed in budget.fresh
        ]
        for label, values in settings.items()
    }
    everyone = [job for mine in jobs.values() for job in mine]
    results = iter(joblib.Parallel(n_jobs=budget.workers)(joblib.delayed(run_job)(job) for job in everyone))
    rows = {
        label: [row for _ in mine for block in next(results).blocks for row in block] for label, mine in jobs.items()
    }
    return {label: score_of(mine, suite) for label, mine in rows.items()}
