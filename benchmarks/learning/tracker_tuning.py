"""Tuning of a tracker's parameters on development seeds, with the same search, score and budget for all."""

from __future__ import annotations

import dataclasses
import json
import tempfile
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.contract.rows import Row
from benchmarks.contract.suite import suite
from benchmarks.contract.text import counted
from benchmarks.learning.fresh_scores import FreshScores, ScoresOn, fresh_entries, fresh_scores
from benchmarks.learning.search import Found, Progress, announce_check, search
from benchmarks.run.editions import judge_edition, package_versions, tracker_edition
from benchmarks.run.failures import Failure
from benchmarks.run.jobs import Job
from benchmarks.run.selection import experiment_on, tracker_named
from benchmarks.run.workers import results
from benchmarks.statistics.summary import grouped
from scenarios import catalog
from scenarios.scenario import Scenario
from sim.checks import check
from trackers import registry
from trackers.atomic_file import write_atomic

LIMIT_S = 600.0
"""Limit of CPU time for one frame, ten times that of a bench: a slow machine must not decide a score."""


_REASONS = 3
"""Reasons of failures that are told."""


@dataclass(frozen=True)
class Budget:
    """Settings of a search, the same for all trackers.

    Attributes:
        suite, presets, seeds: of the episodes that score a setting.
        fresh_presets, fresh: presets and seeds of the episodes that check the best setting.
        trials: number of settings; the first one is the defaults.
        workers: processes; 0 = this process. modules: users' own modules, imported first in each.
    """

    suite: str
    presets: tuple[str, ...]
    seeds: range
    fresh_presets: tuple[str, ...]
    fresh: range
    trials: int
    workers: int
    modules: tuple[str, ...] = ()


@dataclass(frozen=True)
class Tuned:
    """The result of a search.

    Attributes:
        parameters: the best setting; empty (= defaults) if it is not better in the check too.
        score, default_score: of the best setting and of the defaults on the search's seeds, see ``score_of``.
        check_score, check_default_score: of both on the episodes of the check.
        trials: number of settings tried.
        fresh: scores on episodes that decided nothing; None without better values.
        failures: of contestants in all these runs.
    """

    parameters: dict[str, Any]
    score: float
    default_score: float
    check_score: float
    check_default_score: float
    trials: int
    fresh: FreshScores | None = None
    failures: Sequence[Failure] = ()


def tunables(name: str) -> dict[str, dataclasses.Field[Any]]:
    """Return the parameters of a registered tracker that declare a range.

    Raises:
        ValueError: for an unknown tracker, one without tunable parameters, or one that has another's values.
    """
    entry = registry.entry(name)
    found = entry.tunables()
    check("tracker", bool(found), "one with tunable parameters", f"{name!r}, which has none")
    check("tracker", entry.tuned_as == name, "one with values of its own", f"{name!r}, which has {entry.tuned_as}'s")
    return found


def trackers_to_tune() -> tuple[str, ...]:
    """Return the registered trackers that have tunable parameters and values of their own."""
    return tuple(name for name, entry in registry.entries().items() if entry.tunables() and entry.tuned_as == name)


def score_of(rows: Sequence[Row], suite_name: str) -> float:
    """Return what tuning maximises, the suite's ``tuned_for``; undefined metrics count 0."""
    metrics = suite(suite_name)
    total = 0.0
    for name, factor in metrics.tuned_for.items():
        pool = metrics.metric(name).statistic.pooled(rows)
        total += factor * (0.0 if pool is None or not np.isfinite(pool.mean) else pool.mean)
    return total


def tune(name: str, budget: Budget, progress: Progress, studies: Path | None = None) -> Tuned:
    """Search the tunable parameters of one tracker; deterministic except for time limits and stops.

    Settings are tried in batches on the same pictures. The best of many settings on a few seeds is partly
    luck: it replaces the defaults only if it is better on the episodes of the check too.

    Args:
        studies: see ``benchmarks.learning.search``.

    Raises:
        ValueError: without Optuna, or for a tracker without tunable parameters.
    """
    defaults, failures = registry.entry(name).written(), list[Failure]()
    found = search(
        name,
        tunables(name),
        defaults,
        budget.trials,
        lambda settings: _scores(name, settings, budget, failures),
        progress,
        studies,
        (
            dataclasses.replace(budget, trials=0, workers=0, fresh_presets=(), fresh=range(0), modules=()),
            package_versions(),
            _scenario(budget).id,
            judge_edition(suite(budget.suite)),
            # A search sets the parameters.
            tracker_edition(dataclasses.replace(tracker_named(name), parameters=None)),
            suite(budget.suite).tuned_for,
        ),
    )
    on_fresh_episodes = dataclasses.replace(budget, presets=budget.fresh_presets, seeds=budget.fresh)
    announce_check(name, len(budget.fresh) * len(budget.fresh_presets))
    fresh = _scores(name, {"best": found.best, "defaults": defaults}, on_fresh_episodes, failures)
    tuned = chosen(found, fresh["best"], fresh["defaults"])
    measured = fresh_scores(tuned.parameters, defaults, budget.seeds, tracker_scores(name, budget, failures))
    return dataclasses.replace(tuned, fresh=measured, failures=failures)


def tracker_scores(name: str, budget: Budget, failures: list[Failure]) -> ScoresOn:
    """Return the function that scores settings of a tracker as its search does, on other seeds.

    It adds to ``failures``.
    """
    return lambda settings, seeds: _scores(name, settings, dataclasses.replace(budget, seeds=seeds), failures)


def chosen(found: Found, check_score: float, check_default_score: float) -> Tuned:
    """Return the best setting of a search, or the defaults if they are as good in the check."""
    return Tuned(
        parameters=found.best if check_score > check_default_score else {},
        score=found.score,
        default_score=found.default_score,
        check_score=check_score,
        check_default_score=check_default_score,
        trials=found.trials,
    )


def write_tuned(
    name: str, tuned: Tuned, suite_name: str, presets: Sequence[str], seeds: range, command: str, folder: Path
) -> Path:
    """Write ``NAME.json``, which in the folder of ``registry.tuned_file`` replaces the defaults. Return its path."""
    document = {
        "parameters": {key: tuned.parameters[key] for key in sorted(tuned.parameters)},
        "score": round(tuned.score, 6),
        "default_score": round(tuned.default_score, 6),
        "check_score": round(tuned.check_score, 6),
        "check_default_score": round(tuned.check_default_score, 6),
        "score_is": " + ".join(f"{factor:g} {metric}" for metric, factor in suite(suite_name).tuned_for.items()),
        "trials": tuned.trials,
        "seeds": f"{seeds.start}:{seeds.stop}",
        "episodes": len(presets) * len(seeds),
        "suite": suite_name,
        "preset": " ".join(presets),
        "command": command,
        **fresh_entries(tuned.fresh),
    }
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.json"
    write_atomic(path, json.dumps(document, indent=1) + "\n")
    return path


def _scores(
    name: str, settings: dict[str, dict[str, Any]], budget: Budget, failures: list[Failure]
) -> dict[str, float]:
    """Return the score of every labelled setting; add to ``failures``."""
    scenario = _scenario(budget)
    judged = suite(budget.suite)
    trackers = {label: tracker_named(name, **values) for label, values in settings.items()}
    jobs = [
        job
        for preset in budget.presets
        for job in experiment_on(
            judged, scenario.id, (preset,), trackers, budget.seeds, modules=budget.modules, limit_s=LIMIT_S
        ).jobs()
    ]
    groups = grouped(rows_of(jobs, budget.workers, failures))
    return {
        label: sum(score_of(trackers[label], budget.suite) for trackers in groups.values()) / len(groups)
        for label in settings
    }


def rows_of(jobs: Sequence[Job], workers: int, failures: list[Failure]) -> list[Row]:
    """Run jobs and return all of their rows, in the order of the jobs; a tracker that ends its process has no answers.

    Args:
        workers: processes; 0 = this process. failures: those of these runs are added, in the same order.

    Raises:
        ValueError: for a tracker that cannot begin, since it has no rows.
    """
    with tempfile.TemporaryDirectory() as notes:
        noted = [dataclasses.replace(job, out=Path(notes)) for job in jobs]
        made = {job.name: result for job, result in results(noted, workers, "loky")}
    failures += (failure for job in noted for failure in made[job.name].failures)
    for job in noted:
        scored = {block[0]["tracker"] for block in made[job.name].blocks}
        for failure in made[job.name].failures:
            begins = failure.tracker in scored or failure.tracker not in job.trackers
            failed = job.trackers[failure.tracker].name if failure.tracker in job.trackers else failure.tracker
            check("tracker", begins, "one that can begin", f"{failed}: {failure.reason}")
    return [row for job in noted for block in made[job.name].blocks for row in block]


def failures_in_words(failures: Sequence[Failure]) -> str:
    """Return how many runs failed, and the commonest reasons, in words; empty if none did."""
    if not failures:
        return ""
    reasons = Counter(failure.reason for failure in failures).most_common(_REASONS)
    told = ", ".join(f"{reason} ({counted(count, 'time')})" for reason, count in reasons)
    return f"; {counted(len(failures), 'run')} failed, which counts as no answer: {told}"


def _scenario(budget: Budget) -> Scenario:
    return catalog.scenario(suite(budget.suite).scenes[0].scenario)
