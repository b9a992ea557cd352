"""Many envs as one: the entry point of ``gym.make_vec``."""

from __future__ import annotations

from functools import partial
from typing import Any

import gymnasium as gym

from sim.checks import check


def follow_vector_env(
    num_envs: int = 1, *, pictures: bool = True, max_episode_steps: int | None = None, **keywords: Any
) -> gym.vector.VectorEnv[Any, Any, Any]:
    """Return rendered envs, one after the other as ``vectorization_mode="sync"`` has them, or ``PicturelessVectorEnv``.

    Args:
        pictures: whether they are rendered.
        max_episode_steps: longer episodes are truncated; None: at their last frame.
        keywords: of ``FollowEnv``, or of ``PicturelessVectorEnv``.
    """
    check("num_envs", num_envs >= 1, "a whole number >= 1", num_envs)
    if pictures:
        return gym.vector.SyncVectorEnv([partial(_rendered, max_episode_steps, **keywords)] * num_envs)
    # It imports kernels, which takes seconds.
    from scenarios.envs.pictureless.vector_env import PicturelessVectorEnv

    return PicturelessVectorEnv(num_envs, max_episode_steps=max_episode_steps, **keywords)


def _rendered(max_episode_steps: int | None, **keywords: Any) -> Any:
    from scenarios.envs.follow_env import FollowEnv

    env = FollowEnv(**keywords)
    return env if max_episode_steps is None else gym.wrappers.TimeLimit(env, max_episode_steps)
