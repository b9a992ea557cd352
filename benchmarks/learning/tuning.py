"""Searches parameters of trackers and controllers with Optuna, checks the best, and scores it on fresh episodes."""

from __future__ import annotations

import hashlib
import json
import sys
import tempfile
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from joblib.externals.loky.process_executor import BrokenProcessPool

from benchmarks.contract.rows import Row
from benchmarks.contract.suite import Suite, controllers_suite, suite
from benchmarks.contract.text import counted
from benchmarks.learning.settings import EPISODES, RUNS
from benchmarks.learning.without_pictures import scores_without_pictures, write_answers
from benchmarks.run.editions import judge_edition, own_code, package_versions, tracker_edition
from benchmarks.run.episodes import Steering, simulated
from benchmarks.run.failures import Failure
from benchmarks.run.jobs import Job
from benchmarks.run.packages import check_packages
from benchmarks.run.selection import experiment_on, tracker_named
from benchmarks.run.workers import in_processes, results
from benchmarks.statistics.summary import grouped
from scenarios import catalog
from scenarios.envs.pictureless.bank import episode_bank
from scenarios.envs.pictureless.error_model import error_model
from scenarios.envs.settings import FollowSettings
from scenarios.field_values import split_name
from scenarios.scenario import Scenario
from sim.checks import check, check_choice
from trackers import registry
from trackers.atomic_file import write_atomic
from trackers.controllers.catalogue import ControllerEntry, controller_entry, controllers
from trackers.registry import MethodEntry, TrackerEntry

_BATCH = 8
"""Number of trials at a time: those of a tracker share the pictures, others run in parallel."""
_USUAL_TRIALS, _TRIALS_WITHOUT_PICTURES = 40, 600
_SEARCH_SEED = 0
_FIRST_SEED, _FEWEST = 9_000, 8
_REASONS = 3
"""Reasons of failures that are shown."""
LIMIT_S = 600.0
"""Limit of CPU time for one frame, ten times that of a bench: a slow machine must not decide a score."""
NO_VALUES = "no values take the place of the written ones"

Progress = Callable[[int, int], None]
Settings = Mapping[str, dict[str, Any]]
"""Values of parameters by label."""


@dataclass(frozen=True, kw_only=True)
class Search(ABC):
    """What is searched and how, the same for all methods of a suite.

    Attributes:
        name: of the method. suite: name of the one that scores it. scenario: catalogue id.
        presets, seeds: of the episodes that score a setting.
        fresh_presets, fresh: presets and seeds of the episodes that check the best setting.
        trials: number of settings, None = ``usual_trials``; the first one is the defaults.
        workers: processes; 0 = this process. modules: users' own modules, imported first in each.
        failures: those of all runs so far.
    """

    name: str
    suite: str
    scenario: str
    presets: tuple[str, ...]
    seeds: range
    fresh_presets: tuple[str, ...]
    fresh: range
    trials: int | None
    workers: int
    modules: tuple[str, ...] = ()
    failures: list[Failure] = field(default_factory=list, compare=False)
    _parameter = "tracker"

    def __post_init__(self) -> None:
        tunable = bool(self.entry.tunables())
        check(self._parameter, tunable, "one with tunable parameters", f"{self.name!r}, which has none")
        for parameter, chosen in (("preset", self.presets), ("fresh_preset", self.fresh_presets)):
            for each in chosen:
                check_choice(parameter, split_name(each)[0], self.scene.presets)

    @property
    @abstractmethod
    def entry(self) -> MethodEntry:
        """The method. Raises ValueError for an unknown one."""

    @property
    def judging(self) -> Suite:
        """The suite that scores it."""
        return suite(self.suite)

    @property
    def scene(self) -> Scenario:
        """The scenario of its episodes."""
        return catalog.scenario(self.scenario)

    @property
    def place(self) -> str:
        """Its file of tuned values, below their folder and without a suffix."""
        return self.name

    @property
    def usual_trials(self) -> int:
        """Number of settings unless a user says another."""
        return _USUAL_TRIALS

    @property
    def trial_count(self) -> int:
        """Number of settings."""
        return self.trials or self.usual_trials

    def sampler(self, optuna: Any, seed: int) -> Any:
        """Return what proposes settings: a tree-structured Parzen estimator, for few trials."""
        return optuna.samplers.TPESampler(seed=seed, constant_liar=True)

    @property
    @abstractmethod
    def depends_on(self) -> object:
        """All that its scores depend on besides presets, seeds, packages, scene and judge."""

    @abstractmethod
    def scores(
        self, settings: Settings, presets: Sequence[str], seeds: range, *, pictures: bool = False
    ) -> dict[str, float]:
        """Return the score of each of the labelled settings on these episodes; ``pictures``: in any case with them."""


@dataclass(frozen=True, kw_only=True)
class TrackerSearch(Search):
    """See ``Search``. Settings are tried on the same pictures."""

    def __post_init__(self) -> None:
        super().__post_init__()
        owner = self.entry.tuned_as
        check("tracker", owner == self.name, "one with values of its own", f"{self.name!r}, which has {owner}'s")

    @property
    def entry(self) -> TrackerEntry:
        """See ``Search``."""
        return registry.entry(self.name)

    @property
    def depends_on(self) -> object:
        """See ``Search``."""
        # A search sets the parameters.
        return tracker_edition(replace(tracker_named(self.name), parameters=None))

    def scores(
        self, settings: Settings, presets: Sequence[str], seeds: range, *, pictures: bool = False
    ) -> dict[str, float]:
        """See ``Search``."""
        trackers = {label: tracker_named(self.name, **values) for label, values in settings.items()}
        how: dict[str, Any] = {"modules": self.modules, "limit_s": LIMIT_S}
        jobs = [
            job
            for preset in presets
            for job in experiment_on(self.judging, self.scenario, (preset,), trackers, seeds, **how).jobs()
        ]
        groups = grouped(rows_of(jobs, self.workers, self.failures))
        return {
            label: sum(score_of(rows[label], self.judging) for rows in groups.values()) / len(groups)
            for label in settings
        }


@dataclass(frozen=True, kw_only=True)
class ControllerSearch(Search):
    """See ``Search``. It is without pictures where the scenario has such episodes, its check always with pictures.

    Attributes:
        tracker: name of the one that it steers by.
        cache: folder for planned episodes. runs: folder for runs with pictures, of trackers that no controller moves.
    """

    tracker: str
    cache: Path | None = EPISODES
    runs: Path = RUNS
    _parameter = "controllers"

    def __post_init__(self) -> None:
        super().__post_init__()
        used = self.entry.role != "variant"
        check("controllers", used, "one that is used as tuned", f"{self.name!r}, which never is")
        check("preset", len(self.presets) == 1, "one for controllers", " ".join(self.presets))
        alike = self.fresh_presets == self.presets
        check("fresh_preset", alike, "none for controllers", " ".join(self.fresh_presets))

    @property
    def entry(self) -> ControllerEntry:
        """See ``Search``."""
        return controller_entry(self.name, self.scene.carrier.name)

    @property
    def place(self) -> str:
        """See ``Search``."""
        return f"controllers/{self.scene.carrier.name}/{self.name}"

    @property
    def usual_trials(self) -> int:
        """See ``Search``."""
        return _TRIALS_WITHOUT_PICTURES if self.scene.pictureless is not None else super().usual_trials

    def sampler(self, optuna: Any, seed: int) -> Any:
        """Return what proposes settings: CMA-ES without pictures, where there are many trials, of several numbers."""
        if self.scene.pictureless is None or len(self.entry.tunables()) == 1:
            return super().sampler(optuna, seed)
        return optuna.samplers.CmaEsSampler(seed=seed)

    @property
    def depends_on(self) -> object:
        """See ``Search``."""
        model = "" if self.scene.pictureless is None else error_model(self.scenario, self.tracker).to_json()
        own = (self.entry.edition, own_code(self.entry.controller.__module__))
        return tracker_edition(tracker_named(self.tracker)), own, model

    def scores(
        self, settings: Settings, presets: Sequence[str], seeds: range, *, pictures: bool = False
    ) -> dict[str, float]:
        """See ``Search``."""
        pictureless = self.scene.pictureless
        if pictureless is None or (pictures and not pictureless.watches_at_rest):
            return {label: self._with_pictures(values, seeds) for label, values in settings.items()}
        # Episodes are planned once, for all workers, and run with pictures once, for all settings.
        episode_bank(self.scenario, self.scene.configuration(presets[0]), seeds, self.cache)
        played = self.runs if pictures else None
        scored = partial(_without_pictures, replace(self, failures=[]), seeds, played)
        try:
            if played is not None:
                followed = FollowSettings(self.scenario, self.tracker, preset=presets[0], worlds=0)
                each = partial(write_answers, followed, played)
                list(in_processes(each, seeds, self.workers, modules=lambda seed: self.modules))
            return dict(in_processes(scored, settings.items(), self.workers, modules=lambda each: self.modules))
        except BrokenProcessPool:
            raise ChildProcessError(f"{self.name}: it ended a worker process; the same command continues") from None

    def _with_pictures(self, values: dict[str, Any], seeds: range) -> float:
        steering = Steering(self.name, self.scene.carrier.name, "prompt", values)
        trackers = {self.tracker: tracker_named(self.tracker)}
        jobs = [
            Job(
                self.judging,
                replace(simulated(self.scenario, self.presets[0], seed), steering=steering),
                trackers,
                self.modules,
                limit_s=LIMIT_S,
            )
            for seed in seeds
        ]
        return score_of(rows_of(jobs, self.workers, self.failures), self.judging)


def _without_pictures(
    search: ControllerSearch, seeds: range, played: Path | None, setting: tuple[str, dict[str, Any]]
) -> tuple[str, float]:
    """Return the label and the score of a setting over episodes, each once; the runs ``played`` have the answers."""
    label, values = setting
    followed = (search.scenario, search.presets[0], search.tracker)
    scores = scores_without_pictures(*followed, search.name, values, seeds, search.cache, runs=played)
    return label, sum(factor * float(scores[metric].mean()) for metric, factor in search.judging.tuned_for.items())


def trackers_to_tune() -> tuple[str, ...]:
    """Return the registered trackers that have tunable parameters and values of their own."""
    return tuple(name for name, entry in registry.entries().items() if entry.tunables() and entry.tuned_as == name)


def controllers_to_tune() -> list[tuple[str, tuple[str, ...]]]:
    """Return each scenario of the controllers' suite with the controllers there that have tunable parameters."""
    found = []
    for scene in controllers_suite().scenes:
        known = controllers(catalog.scenario(scene.scenario).carrier.name)
        wanted = (name for name, entry in known.items() if entry.tunables() and entry.role not in ("variant", "policy"))
        found.append((scene.scenario, tuple(wanted)))
    return found


@dataclass(frozen=True)
class Tuned:
    """The result of a search.

    Attributes:
        parameters: the best setting; empty (= defaults) if it is not better in the check too.
        score, default_score: of the best setting and of the defaults on the search's seeds, see ``score_of``.
        check_score, check_default_score: of both on the episodes of the check.
        trials: number of settings tried.
        fresh: scores of the ``written`` and the ``tuned`` values on episodes of ``seeds`` that decided nothing; None
            without better values.
    """

    parameters: dict[str, Any]
    score: float
    default_score: float
    check_score: float
    check_default_score: float
    trials: int
    fresh: dict[str, Any] | None = None


def tune(search: Search, progress: Progress, studies: Path | None = None) -> Tuned:
    """Maximise the score by Optuna, with the search's sampler, the defaults first.

    Deterministic except for time limits and stops. The best of many settings on a few seeds is partly luck: it replaces
    the defaults only if it is better on the episodes of the check too.

    Args:
        studies: folder for all trials, from which a stopped search continues. None: nothing is kept.

    Raises:
        ValueError: without Optuna.
    """
    optuna = needs_optuna()
    defaults, study = search.entry.written(), _study(optuna, search, studies)

    def complete() -> list[Any]:
        return list(study.get_trials(states=(optuna.trial.TrialState.COMPLETE,)))

    tried = len(complete())
    if all(trial.params != defaults for trial in complete()):
        study.enqueue_trial(defaults)
    progress(tried, search.trial_count)
    while tried < search.trial_count:
        trials = [study.ask() for _ in range(min(_BATCH, search.trial_count - tried))]
        settings = {f"{search.name}#{trial.number}": _suggested(trial, search.entry) for trial in trials}
        scores = search.scores(settings, search.presets, search.seeds)
        for trial, label in zip(trials, settings, strict=True):
            study.tell(trial, scores[label])
        tried += len(trials)
        progress(tried, search.trial_count)
    episodes = counted(len(search.fresh) * len(search.fresh_presets), "fresh episode")
    # It may take as long again.
    print(f"{search.name}: the best setting and the defaults now run on {episodes} …", file=sys.stderr)
    best = dict(study.best_params)
    settings = {"best": best, "defaults": defaults}
    checked = search.scores(settings, search.fresh_presets, search.fresh, pictures=True)
    parameters = best if checked["best"] > checked["defaults"] else {}
    return Tuned(
        parameters=parameters,
        score=float(study.best_value),
        default_score=next(float(trial.value) for trial in complete() if trial.params == defaults),
        check_score=checked["best"],
        check_default_score=checked["defaults"],
        trials=len(complete()),
        fresh=_fresh_scores(search, parameters) if parameters else None,
    )


def _study(optuna: Any, search: Search, studies: Path | None) -> Any:
    """Return the kept study of the same search, or a new one."""
    storage = None
    if studies is not None:
        studies.mkdir(parents=True, exist_ok=True)
        file = studies / f"{search.place.replace('/', '-')}.journal"
        storage = optuna.storages.JournalStorage(optuna.storages.journal.JournalFileBackend(str(file)))
    depends_on = (
        (search.presets, search.seeds, sorted(search.entry.tunables()), search.entry.written()),
        (package_versions(), search.scene.id, judge_edition(search.judging), search.judging.tuned_for),
        search.depends_on,
    )
    study = optuna.create_study(
        study_name=hashlib.sha256(repr(depends_on).encode()).hexdigest()[:10],
        storage=storage,
        direction="maximize",
        load_if_exists=True,
    )
    # A resumed search draws new random numbers.
    study.sampler = search.sampler(optuna, _SEARCH_SEED + len(study.trials))
    return study


def _suggested(trial: Any, entry: MethodEntry) -> dict[str, Any]:
    values: dict[str, Any] = {}
    for key, each in entry.tunables().items():
        suggest = trial.suggest_int if isinstance(each.default, int) else trial.suggest_float
        values[key] = suggest(key, each.metadata["low"], each.metadata["high"], log=each.metadata["log"])
    return values


def needs_optuna() -> Any:
    """Return Optuna. Raises ValueError if it is not installed."""
    check_packages(["optuna", "cmaes"], "tune")
    import optuna

    optuna.logging.set_verbosity(optuna.logging.WARNING)
    return optuna


def _fresh_scores(search: Search, tuned: Mapping[str, Any]) -> dict[str, Any]:
    """Return the scores on seed 9,000 and following, as many as the search had, at least 8, see ``Tuned.fresh``."""
    seeds = range(_FIRST_SEED, _FIRST_SEED + max(len(search.seeds), _FEWEST))
    written = search.entry.written()
    scores = search.scores({"written": written, "tuned": {**written, **tuned}}, search.presets, seeds)
    return {"seeds": f"{seeds.start}:{seeds.stop}", **{label: round(score, 6) for label, score in scores.items()}}


def write_tuned(search: Search, tuned: Tuned, command: str, folder: Path) -> Path:
    """Write ``NAME.json``, which in the folder of ``registry.tuned_file`` replaces the defaults. Return its path."""
    scores = ("score", "default_score", "check_score", "check_default_score")
    document = {
        "parameters": dict(sorted(tuned.parameters.items())),
        **{name: round(getattr(tuned, name), 6) for name in scores},
        "score_is": " + ".join(f"{factor:g} {metric}" for metric, factor in search.judging.tuned_for.items()),
        "trials": tuned.trials,
        "seeds": f"{search.seeds.start}:{search.seeds.stop}",
        "episodes": len(search.presets) * len(search.seeds),
        "suite": search.judging.name,
        "preset": " ".join(search.presets),
        "command": command,
        "fresh": tuned.fresh,
        **({"no_fresh": NO_VALUES} if tuned.fresh is None else {}),
    }
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{search.name}.json"
    write_atomic(path, json.dumps(document, indent=1) + "\n")
    return path


def score_of(rows: Iterable[Row], judging: Suite) -> float:
    """Return what tuning maximises, the suite's ``tuned_for``; undefined metrics count 0."""
    rows, total = list(rows), 0.0
    for name, factor in judging.tuned_for.items():
        pool = judging.metric(name).statistic.pooled(rows)
        total += factor * (0.0 if pool is None or not np.isfinite(pool.mean) else pool.mean)
    return total


def rows_of(jobs: Sequence[Job], workers: int, failures: list[Failure]) -> list[Row]:
    """Run jobs and return all of their rows, in the order of the jobs; a tracker that ends its process has no answers.

    Args:
        workers: processes; 0 = this process. failures: those of these runs are added, in the same order.

    Raises:
        ValueError: for a tracker that cannot begin, since it has no rows.
    """
    with tempfile.TemporaryDirectory() as notes:
        noted = [replace(job, out=Path(notes)) for job in jobs]
        made = {job.name: result for job, result in results(noted, workers)}
    rows: list[Row] = []
    for job in noted:
        result = made[job.name]
        scored = {block[0]["tracker"] for block in result.blocks}
        for failure in result.failures:
            tracker = job.trackers.get(failure.tracker)
            begins = tracker is None or failure.tracker in scored
            name = failure.tracker if tracker is None else tracker.name
            check("tracker", begins, "one that can begin", f"{name}: {failure.reason}")
        failures += result.failures
        rows += (row for block in result.blocks for row in block)
    return rows


def failures_in_words(failures: Sequence[Failure]) -> str:
    """Return how many runs failed, and the commonest reasons, in words; empty if none did."""
    if not failures:
        return ""
    reasons = Counter(failure.reason for failure in failures).most_common(_REASONS)
    shown = ", ".join(f"{reason} ({counted(count, 'time')})" for reason, count in reasons)
    return f"; {counted(len(failures), 'run')} failed, which counts as no answer: {shown}"
