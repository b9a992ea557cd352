"""Searches parameters of trackers and controllers with Optuna, checks the best, and scores it on fresh episodes."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from joblib.externals.loky.process_executor import BrokenProcessPool

from benchmarks.contract.rows import Row
from benchmarks.contract.suite import controllers_suite, suite
from benchmarks.contract.text import counted
from benchmarks.learning.without_pictures import scores_without_pictures
from benchmarks.run.editions import judge_edition, own_code, package_versions, tracker_edition
from benchmarks.run.episodes import Steering, simulated
from benchmarks.run.experiment import Progress
from benchmarks.run.failures import Failure
from benchmarks.run.jobs import Job
from benchmarks.run.own_modules import load_modules
from benchmarks.run.selection import experiment_on, tracker_named
from benchmarks.run.workers import in_processes, results
from benchmarks.statistics.summary import grouped
from scenarios import catalog
from scenarios.envs.pictureless.bank import episode_bank
from scenarios.envs.pictureless.error_model import error_model
from scenarios.scenario import Scenario
from sim.checks import check
from trackers import registry
from trackers.atomic_file import atomic_file, write_atomic
from trackers.controllers.catalogue import ControllerEntry, controller_entry, controllers

_BATCH = 8
"""Number of trials at a time: those of a tracker share the pictures, others run in parallel."""
_SEARCH_SEED = 0
_INSTALL = "pip install 'frameout[tune]'"

Scores = Callable[[dict[str, dict[str, Any]]], dict[str, float]]
"""Returns the score of each of the labelled settings."""


@dataclass(frozen=True)
class Found:
    """The result of a search.

    Attributes:
        best: the best setting. score: of it. default_score: of the defaults. trials: number of settings tried.
    """

    best: dict[str, Any]
    score: float
    default_score: float
    trials: int


def search(
    name: str,
    fields: Mapping[str, dataclasses.Field[Any]],
    defaults: Mapping[str, Any],
    trials: int,
    scores: Scores,
    progress: Progress,
    studies: Path | None = None,
    budget: object = None,
) -> Found:
    """Maximise the score by a tree-structured Parzen estimator (Optuna), the defaults first.

    Args:
        name: of the tuned component. fields: parameters with ranges in their metadata. defaults: their values.
        studies: folder for all trials and plots, from which a stopped search continues. None: nothing is kept.
        budget: other settings that scores depend on, code included; another budget is another search.

    Raises:
        ValueError: without Optuna.
    """
    optuna = needs_optuna()
    study = _study(optuna, name, studies, f"{budget!r}/{sorted(fields)}/{dict(defaults)!r}")
    tried = len(_complete(optuna, study))
    if _default_score(optuna, study, defaults) is None:
        study.enqueue_trial(dict(defaults))
    progress(tried, trials)
    while tried < trials:
        asked = [study.ask() for _ in range(min(_BATCH, trials - tried))]
        settings = {f"{name}#{trial.number}": _suggested(trial, fields) for trial in asked}
        scored = scores(settings)
        for trial, label in zip(asked, settings, strict=True):
            study.tell(trial, scored[label])
        tried += len(asked)
        progress(tried, trials)
    complete = _complete(optuna, study)
    default_score = _default_score(optuna, study, defaults)
    assert default_score is not None
    if studies is not None:
        _draw(complete, dict(defaults), studies / f"{name}.svg")
    return Found(dict(study.best_params), float(study.best_value), float(default_score), len(complete))


def announce_check(name: str, episodes: int) -> None:
    """Say on stderr what is still to be done after a search, as it may take as long again."""
    told = f"{name}: the best setting and the defaults now run on {counted(episodes, 'fresh episode')} …"
    print(told, file=sys.stderr)


def _study(optuna: Any, name: str, studies: Path | None, identity: str) -> Any:
    """Return the kept study of the same name and budget, or a new one."""
    if studies is None:
        sampler = optuna.samplers.TPESampler(seed=_SEARCH_SEED, constant_liar=True)
        return optuna.create_study(direction="maximize", sampler=sampler)
    studies.mkdir(parents=True, exist_ok=True)
    backend = optuna.storages.journal.JournalFileBackend(str(studies / f"{name}.journal"))
    key = f"{name}-{hashlib.sha256(identity.encode()).hexdigest()[:10]}"
    study = optuna.create_study(
        study_name=key,
        storage=optuna.storages.JournalStorage(backend),
        direction="maximize",
        load_if_exists=True,
    )
    # A resumed search draws new random numbers.
    study.sampler = optuna.samplers.TPESampler(seed=_SEARCH_SEED + len(study.trials), constant_liar=True)
    return study


def _complete(optuna: Any, study: Any) -> list[Any]:
    complete: list[Any] = study.get_trials(states=(optuna.trial.TrialState.COMPLETE,))
    return complete


def _suggested(trial: Any, fields: Mapping[str, dataclasses.Field[Any]]) -> dict[str, Any]:
    values: dict[str, Any] = {}
    for key, field in fields.items():
        low, high, log = (field.metadata[part] for part in ("low", "high", "log"))
        suggest = trial.suggest_int if isinstance(field.default, int) else trial.suggest_float
        values[key] = suggest(key, low, high, log=log)
    return values


def _default_score(optuna: Any, study: Any, defaults: Mapping[str, Any]) -> float | None:
    """Return the score of the defaults, None if no complete trial of them exists."""
    return next((trial.value for trial in _complete(optuna, study) if trial.params == dict(defaults)), None)


def _draw(complete: list[Any], defaults: dict[str, Any], path: Path) -> None:
    """Draw the score of every trial, and against every parameter; the defaults are crosses."""
    from matplotlib.figure import Figure

    names = sorted(defaults)
    first = next(trial.value for trial in complete if trial.params == defaults)
    figure = Figure(figsize=(3.0 * (len(names) + 1), 3.0), layout="constrained")
    axes = figure.subplots(1, len(names) + 1, sharey=True, squeeze=False)[0]
    values = [trial.value for trial in complete]
    best = [max(values[: k + 1]) for k in range(len(values))]
    axes[0].plot([trial.number for trial in complete], values, ".", color="0.6")
    axes[0].plot([trial.number for trial in complete], best, "-", color="#0072b2")
    axes[0].set(xlabel="trial", ylabel="score")
    for axis, name in zip(axes[1:], names, strict=True):
        axis.plot([trial.params[name] for trial in complete], values, ".", color="#0072b2")
        axis.plot([defaults[name]], [first], "x", color="#d55e00")
        axis.set_xlabel(name)
    with atomic_file(path) as file:
        figure.savefig(file, format="svg", metadata={"Date": None})


def needs_optuna() -> Any:
    """Return Optuna. Raises ValueError if it is not installed."""
    try:
        import optuna
    except ImportError:
        raise ValueError(f"tune: expected Optuna to be installed ({_INSTALL}), got none") from None
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    return optuna


ScoresOn = Callable[[dict[str, dict[str, Any]], range], dict[str, float]]
"""Returns the score of each of the labelled settings on the episodes of these seeds."""
_FIRST_SEED, _FEWEST = 9_000, 8
NO_VALUES = "no values take the place of the written ones"


@dataclass(frozen=True)
class FreshScores:
    """Scores on fresh episodes, see ``score_of``.

    Attributes:
        seeds: of the episodes. written, tuned: score of the written values and of the tuned ones.
    """

    seeds: range
    written: float
    tuned: float


def fresh_scores(
    tuned: Mapping[str, Any],
    written: Mapping[str, Any],
    searched: range,
    scores_on: ScoresOn,
) -> FreshScores | None:
    """Return the scores on episodes of each preset of the search, seed 9,000 and following, as many but at least 8.

    Args:
        tuned, written: values of the parameters. searched: seeds of the search.

    Returns:
        None without tuned values.
    """
    if not tuned:
        return None
    seeds = range(_FIRST_SEED, _FIRST_SEED + max(len(searched), _FEWEST))
    scores = scores_on({"written": dict(written), "tuned": {**written, **tuned}}, seeds)
    return FreshScores(seeds, scores["written"], scores["tuned"])


def fresh_entries(fresh: FreshScores | None) -> dict[str, Any]:
    """Return what a file of tuned values says of them: ``fresh``, or null and under ``no_fresh`` why."""
    if fresh is None:
        return {"fresh": None, "no_fresh": NO_VALUES}
    seeds = f"{fresh.seeds.start}:{fresh.seeds.stop}"
    return {"fresh": {"seeds": seeds, "written": round(fresh.written, 6), "tuned": round(fresh.tuned, 6)}}


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
        failures: of trackers in all these runs.
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
        studies: see ``search``.

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
            return dict(in_processes(labelled, settings.items(), budget.workers, modules=lambda each: budget.modules))
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
