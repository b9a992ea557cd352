"""How fast the envs without pictures are."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np

from scenarios.envs.ids import FOLLOW_ENVS
from scenarios.envs.pictureless.vector_env import PicturelessVectorEnv

_WARM_UP, _STEPS = 20, 200


def steps_per_s(env_id: str, envs: int = 1024, seeds: range = range(16), cache: Path | None = None) -> float:
    """Return steps a second of one core: of the thread's own time, B envs together, actions zero, resets included.

    Raises:
        ValueError: for an unknown id.
    """
    if env_id not in FOLLOW_ENVS:
        raise ValueError(f"env_id: expected one of {', '.join(FOLLOW_ENVS)}; got {env_id!r}")
    scenario, tracker = FOLLOW_ENVS[env_id]
    made = PicturelessVectorEnv(envs, scenario, tracker, seeds=seeds, cache=cache, max_episode_steps=150)
    made.reset(seed=0)
    nothing = np.zeros(made.action_space.shape or ())
    for _ in range(_WARM_UP):
        made.step(nothing)
    begun_s = time.thread_time()
    for _ in range(_STEPS):
        made.step(nothing)
    seconds = time.thread_time() - begun_s
    made.close()
    return envs * _STEPS / seconds
