"""What ``gym.make_vec`` calls: rendered envs side by side, or envs without pictures."""

from __future__ import annotations

from typing import Any

from gymnasium.vector import VectorEnv


def follow_vector_env(num_envs: int = 1, *, pictures: bool = True, **keywords: Any) -> VectorEnv:
    """Return ``FollowVectorEnv``, or, without ``pictures``, ``PicturelessVectorEnv``; keywords are those of each."""
    if pictures:
        from scenarios.envs.vector_env import FollowVectorEnv

        return FollowVectorEnv(num_envs, **keywords)
    # Imported where it is wanted: its kernels take seconds to load.
    from scenarios.envs.pictureless.vector_env import PicturelessVectorEnv

    return PicturelessVectorEnv(num_envs, **keywords)
