"""Speed of the envs without pictures."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np

from scenarios import catalog
from scenarios.envs.pictureless.vector_env import PicturelessVectorEnv
from tools.speed.rendering import entries_of

_ENVS = 1024
_WARM_UP, _STEPS, _EPISODE_STEPS = 20, 200, 150


def measure_pictureless(env_id: str, preset: str, seeds: range, cache: Path | None = None) -> list[dict[str, Any]]:
    """Return the entry of ``summary.json`` on an env without pictures (shape: ``benchmarks.statistics.summary``).

    Args:
        env_id: env id. preset: of its scenario. seeds: of the episodes.
        cache: folder where planned episodes are kept.
    """
    step_s = [step_cpu_s(env_id, preset, seed, cache) for seed in seeds]
    figures = (("env_steps_per_s_without_pictures", "1/s", "higher", [1.0] * len(step_s), step_s),)
    return entries_of(catalog.envs()[env_id][0], preset, "env", seeds, figures)


def step_cpu_s(env_id: str, preset: str, seed: int, cache: Path | None = None) -> float:
    """Return the thread's CPU seconds for a step of one of 1,024 envs in the same episode, resets included."""
    scenario, tracker = catalog.envs()[env_id]
    envs = PicturelessVectorEnv(
        _ENVS, scenario, tracker, preset=preset, seeds=[seed], cache=cache, max_episode_steps=_EPISODE_STEPS
    )
    envs.reset(seed=0)
    nothing = np.zeros(envs.action_space.shape or ())
    for _ in range(_WARM_UP):
        envs.step(nothing)
    begun_s = time.thread_time()
    for _ in range(_STEPS):
        envs.step(nothing)
    seconds = time.thread_time() - begun_s
    envs.close()
    return seconds / (_ENVS * _STEPS)
