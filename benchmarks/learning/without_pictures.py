"""Scores of controllers in whole episodes without pictures, and how far they are from those with pictures."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from benchmarks.learning.settings import EPISODES
from benchmarks.learning.tracker_errors import read_run, write_runs
from scenarios.envs.pictureless.bank import EpisodeBank, episode_bank
from scenarios.envs.pictureless.episode_state import ANSWER
from scenarios.envs.pictureless.error_model import ErrorModel, error_model
from scenarios.envs.pictureless.vector_env import PicturelessVectorEnv
from scenarios.envs.reward import Reward
from scenarios.envs.settings import FollowSettings
from sim.checks import check

_REPEATS = 16
"""Number of draws of the error model for each episode of a check."""


def scores_without_pictures(
    scenario: str,
    preset: str,
    tracker: str,
    controller: str,
    values: Mapping[str, Any],
    seeds: Sequence[int],
    cache: Path | None,
    repeats: int = 1,
    runs: Path | None = None,
) -> dict[str, NDArray[np.float64]]:
    """Return ``time_in_view`` and ``effort`` (S,) each, of each episode, defined as in suite ``follow``.

    Args:
        values: of the controller's parameters in place of the tuned ones.
        seeds: of the episodes. repeats: number of draws of the error model for each; means are returned.
        cache: folder where planned episodes are kept.
        runs: folder of runs with pictures, see ``with_answers``; None: an error model stands for the tracker.
    """
    # As of a bench, whose episodes have worlds of their own.
    settings = FollowSettings(scenario, tracker, preset=preset, worlds=0)
    envs = PicturelessVectorEnv(
        len(seeds) * repeats,
        scenario,
        tracker,
        seeds=seeds,
        cache=cache,
        bank=None if runs is None else with_answers(settings, seeds, cache, runs),
        preset=preset,
        action="correction",
        controller=controller,
        controller_values=values,
        reward=Reward(effort=1.0),
    )
    envs.reset(seed=0, options={"episode_seed": np.repeat(seeds, repeats)})
    nothing = np.zeros(envs.action_space.shape or ())
    steps = envs.bank.frame_count - 1
    totals = {"time_in_view": np.zeros(envs.num_envs), "effort": np.zeros(envs.num_envs)}
    for _ in range(steps):
        infos = envs.step(nothing)[4]
        # All envs end with the last step.
        infos = infos.get("final_info", infos)
        totals["time_in_view"] += infos["in_view"]
        totals["effort"] -= infos["reward_effort"]
    envs.close()
    return {metric: total.reshape(len(seeds), repeats).mean(axis=1) / steps for metric, total in totals.items()}


def with_answers(settings: FollowSettings, seeds: Sequence[int], cache: Path | None, folder: Path) -> EpisodeBank:
    """Return planned episodes in which the tracker answers as it did with pictures.

    This is for trackers that watch a camera at rest, whose answers are the same whatever a controller does.

    Args:
        cache: see ``scores_without_pictures``. folder: where runs are kept; runs of the same editions are reused.
    """
    bank = episode_bank(settings.scenario, settings.configuration({}), seeds, cache)
    runs = [read_run(write_answers(settings, folder, seed)) for seed in seeds]
    return replace(bank, arrays=bank.arrays | {"answers": np.stack([_answers(run) for run in runs])})


def write_answers(settings: FollowSettings, folder: Path, seed: int) -> Path:
    """Write the run of an episode whose answers ``with_answers`` plays; return its file, which may have been there."""
    [path] = write_runs(settings, range(seed, seed + 1), ["hold"], folder)
    return path


def _answers(run: NDArray[np.void]) -> NDArray[np.void]:
    """Return what the tracker answered in a run (T,), of dtype ``ANSWER``."""
    answers, sighting = np.zeros(len(run), ANSWER), run["sighting"]
    for name in ("known", "depth_m", "length_share", "spread_m", "densest_share"):
        answers[name] = sighting[name]
    answers["estimate_px"], answers["probability"] = run["estimate_px"], sighting["in_view_probability"]
    for axis, name in enumerate("xy"):
        answers["densest_offset_m"][:, axis] = sighting[f"densest_{name}_m"] - sighting[f"{name}_m"]
    return answers


def model_check(
    settings: FollowSettings,
    controllers: Sequence[str],
    seeds: Sequence[int],
    folder: Path,
    report: Callable[[int, int], None],
) -> pd.DataFrame:
    """Run controllers through the same episodes in both envs, to check the error model.

    Args:
        seeds: of episodes that the model was not fitted to.
        folder: where runs with pictures are kept; runs of the same editions are reused.
        report: called with (runs with pictures done, all).

    Returns:
        A line for each controller and seed: share of the time in view ``with pictures``, and its mean ``without``.

    Raises:
        ValueError: for a seed that the model was fitted to.
    """
    used = sorted(fitted_seeds(error_model(settings.scenario, settings.tracker)) & set(seeds))
    check("seeds", not used, "episodes that the error model was not fitted to", f"{used}, among others")
    followed = (settings.scenario, settings.preset_name, settings.tracker)
    lines: list[tuple[str, int, float, float]] = []
    for controller in controllers:
        pictureless = scores_without_pictures(*followed, controller, {}, seeds, EPISODES, _REPEATS)["time_in_view"]
        for seed, without in zip(seeds, pictureless, strict=True):
            report(len(lines), len(controllers) * len(seeds))
            [path] = write_runs(settings, range(seed, seed + 1), [controller], folder)
            lines.append((controller, seed, float(read_run(path)["in_view"][1:].mean()), without))
    report(len(lines), len(lines))
    return pd.DataFrame(lines, columns=["controller", "seed", "with pictures", "without"])


def fitted_seeds(model: ErrorModel) -> set[int]:
    """Return the seeds of the runs that a model was fitted to."""
    return {int(run.split("-")[1]) for run in model.made["runs"]}


def as_table(compared: pd.DataFrame) -> str:
    """Return a ``model_check`` as text: of each controller the means over its episodes, in per cent of the time."""
    shares = compared.set_index("controller")[["with pictures", "without"]] * 100
    shares["difference"] = shares["without"] - shares["with pictures"]
    shares["mean |difference|"] = shares["difference"].abs()
    by_controller = shares.groupby("controller", sort=False)
    means = by_controller.mean()
    means.insert(0, "episodes", by_controller.size())
    return means.reset_index().to_string(index=False, float_format="{:.1f}".format)
