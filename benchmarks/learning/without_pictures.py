"""Controllers through whole episodes without pictures: what they are worth there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.envs.pictureless.vector_env import PicturelessVectorEnv
from scenarios.envs.reward import Reward


def lived_without_pictures(
    scenario: str,
    preset: str,
    tracker: str,
    controller: str,
    values: Mapping[str, Any],
    seeds: Sequence[int],
    cache: Path | None,
    repeats: int = 1,
) -> dict[str, NDArray[np.float64]]:
    """Return ``time_in_view`` and ``effort`` (S,) each, as the suite ``follow`` has them, of every episode's steps.

    Args:
        values: of the controller's parameters, other than those it was tuned to.
        seeds: of the episodes. repeats: times that the error model is drawn anew for each; means are returned.
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
    told = {"time_in_view": np.zeros(envs.num_envs), "effort": np.zeros(envs.num_envs)}
    for _ in range(steps):
        infos = envs.step(nothing)[4]
        # All end with their last step together.
        infos = infos.get("final_info", infos)
        told["time_in_view"] += infos["in_view"]
        told["effort"] -= infos["reward_effort"]
    envs.close()
    return {metric: total.reshape(len(seeds), repeats).mean(axis=1) / steps for metric, total in told.items()}
