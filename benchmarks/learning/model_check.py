"""Comparison of controllers' time in view with and without pictures, to check the error model."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.learning.tracker_errors import read_run, write_runs
from benchmarks.learning.training import EPISODES
from benchmarks.learning.without_pictures import scores_without_pictures
from scenarios.envs.pictureless.error_model import ErrorModel, error_model
from scenarios.envs.settings import FollowSettings
from sim.checks import check

_REPEATS = 16
"""Number of draws of the error model for each episode."""

Report = Callable[[int, int], None]


@dataclass(frozen=True, eq=False)
class Compared:
    """One controller over S episodes.

    Attributes:
        controller: name. seeds: (S,).
        rendered: (S,) share of frames in view, with pictures. pictureless: (S,) its mean without.
    """

    controller: str
    seeds: tuple[int, ...]
    rendered: NDArray[np.float64]
    pictureless: NDArray[np.float64]


def model_check(
    settings: FollowSettings, controllers: Sequence[str], seeds: Sequence[int], folder: Path, report: Report
) -> list[Compared]:
    """Run controllers through the same episodes in both envs.

    Args:
        seeds: of episodes that the model was not fitted to.
        folder: where runs with pictures are kept; runs of the same editions are reused.
        report: called with (runs with pictures done, all).

    Raises:
        ValueError: for a seed that the model was fitted to.
    """
    fitted = fitted_seeds(error_model(settings.scenario, settings.tracker))
    used = sorted(fitted & set(seeds))
    check("seeds", not used, "episodes that the error model was not fitted to", f"{used}, among others")
    compared = []
    for k, controller in enumerate(controllers):
        rendered = []
        for n, seed in enumerate(seeds):
            report(k * len(seeds) + n, len(controllers) * len(seeds))
            [path] = write_runs(settings, range(seed, seed + 1), [controller], folder)
            rendered.append(float(read_run(path)["in_view"][1:].mean()))
        followed = (settings.scenario, settings.preset_name, settings.tracker)
        pictureless = scores_without_pictures(*followed, controller, {}, seeds, EPISODES, _REPEATS)["time_in_view"]
        compared.append(Compared(controller, tuple(seeds), np.array(rendered), pictureless))
    report(len(controllers) * len(seeds), len(controllers) * len(seeds))
    return compared


def fitted_seeds(model: ErrorModel) -> set[int]:
    """Return the seeds of the runs that a model was fitted to."""
    return {int(run.split("-")[1]) for run in model.made["runs"]}


def as_table(compared: Sequence[Compared]) -> str:
    """Return the comparison as text: shares of time in view in per cent, and differences."""
    rows: list[tuple[str, ...]] = [
        ("controller", "episodes", "with pictures", "without", "difference", "mean |difference|")
    ]
    for each in compared:
        apart = each.pictureless - each.rendered
        shares = [f"{100 * share.mean():.1f} %" for share in (each.rendered, each.pictureless)]
        differences = (f"{100 * apart.mean():+.1f}", f"{100 * np.abs(apart).mean():.1f}")
        rows.append((each.controller, str(len(each.seeds)), *shares, *differences))
    first, *others = (max(map(len, column)) for column in zip(*rows, strict=True))
    return "\n".join("  ".join([row[0].ljust(first), *map(str.rjust, row[1:], others)]) for row in rows)
