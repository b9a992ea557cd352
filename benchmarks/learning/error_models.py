"""Makes the error models of the package: runs with pictures, then the fit."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from benchmarks.learning.error_fit import fit
from benchmarks.learning.recorded_runs import read_run, write_runs
from scenarios.envs.pictureless.bank import pictureless_of
from scenarios.envs.pictureless.error_model import ErrorModel, model_path
from scenarios.envs.settings import FollowSettings
from trackers.atomic_file import write_atomic


def make_error_model(
    settings: FollowSettings, seeds: range, folder: Path, report: Callable[[int, int], None]
) -> ErrorModel:
    """Run one episode with pictures for each seed and return the model fitted to these runs.

    Args:
        seeds: of development episodes. folder: where runs are kept; runs of the same editions are reused.
        report: called with (episodes done, all).
    """
    controllers = list(pictureless_of(settings.scenario).runs.controllers)
    return model_of(settings, write_runs(settings, seeds, controllers, folder, report))


def model_of(settings: FollowSettings, paths: Sequence[Path]) -> ErrorModel:
    """Return the model fitted to runs of ``write_runs`` with these settings."""
    runs = [read_run(path) for path in paths]
    made = {
        "by": "benchmarks.learning.error_models",
        "preset": settings.preset_name,
        "frames": sum(len(run) - 1 for run in runs),
        "runs": [path.stem.removeprefix(f"{settings.scenario}-") for path in paths],
    }
    return fit(settings.tracker, settings.scenario, runs, made)


def save_error_model(model: ErrorModel) -> Path:
    """Write a model to its place in the package; return its file."""
    path = model_path(model.scenario, model.tracker)
    write_atomic(path, model.to_json())
    return path
