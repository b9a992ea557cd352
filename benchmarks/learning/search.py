"""A resumable search for the best parameters, the same for trackers and controllers, with plots."""

from __future__ import annotations

import dataclasses
import hashlib
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.contract.text import counted
from trackers.atomic_file import atomic_file

_BATCH = 8
"""Number of trials at a time: those of a tracker share the pictures, others run in parallel."""
_SEARCH_SEED = 0
_INSTALL = "pip install 'frameout[tune]'"

Progress = Callable[[int, int], None]
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
