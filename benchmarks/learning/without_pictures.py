"""Scores of controllers in whole episodes without pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.envs.pictureless.vector_env import PicturelessVectorEnv
from scenarios.envs.reward import Reward


def scores_without_pictures(
    scenario: str,
    preset: str,
    tracker: str,
    controller: str,
    values: Mapping[str, Any],
    seeds: Sequence[int],
    cache: Path | None,
    repeats: int = 1,
) -> dict[str, NDArray[np.float64]]:
    """Return ``time_in_view`` and ``effort`` (S,) each, of each episode, defined as in suite ``follow``.

    Args:
        values: of the controller's parameters in place of the tuned ones.
        seeds: of the episodes. repeats: number of draws of the error model for each; means are returned.
        cache: folder where planned episodes are kept.
    """
    envs = PicturelessVectorEnv(
        len(seeds) * repeats,
        scenario,
        tracker,
        seeds=seeds,
        cache=cache,
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
