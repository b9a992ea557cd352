"""The vector entry point of ``gym.make_vec``, used without a ``vectorization_mode``: envs without pictures."""

from __future__ import annotations

from typing import Any

from scenarios.envs.pictureless.vector_env import PicturelessVectorEnv
from sim.checks import check


def follow_vector_env(num_envs: int = 1, *, pictures: bool = True, **keywords: Any) -> PicturelessVectorEnv:
    """Return ``PicturelessVectorEnv`` with these keywords.

    Raises:
        ValueError: with ``pictures``: Gymnasium itself vectorises rendered envs.
    """
    check("pictures", not pictures, 'False, or vectorization_mode="async" (or "sync") for envs with pictures', pictures)
    return PicturelessVectorEnv(num_envs, **keywords)
