"""Throughput of the rendered envs with resets and without, with the settings of ``frameout train --pictures``.

In CPU time of the process, its threads included. A *cycle* has as many episodes as pass between two new worlds, so one
reset of it builds a world. Of each episode the first steps are made; the others are taken to last as long as those
after the first few:

    without = 1 / t,  with = N / (r + f + (N - M) t)

with N steps an episode, t of a later step, r of a reset and f of the first M steps, in which kernels of other sizes are
loaded and shadows are first drawn.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from typing import Any

import cv2
import numpy as np

from benchmarks.learning.training import Training
from scenarios.envs.follow_env import FollowEnv
from sim.checks import check
from tools.speed.rendering import UNTIMED_FRAMES, entries_of


@dataclass(frozen=True, slots=True)
class CycleSample:
    """CPU seconds in a cycle of episodes.

    Attributes:
        reset_s: (E,) of resets. first_s: (E,) of the first steps after each, together.
        step_s: (E, N) of single steps after these.
        episode_steps: in a whole episode.
    """

    reset_s: tuple[float, ...]
    first_s: tuple[float, ...]
    step_s: tuple[tuple[float, ...], ...]
    episode_steps: int

    @property
    def steps_per_s(self) -> float:
        """Throughput without resets."""
        return float(1.0 / np.mean(self.step_s))

    @property
    def steps_per_s_with_resets(self) -> float:
        """Throughput of whole episodes."""
        later = self.episode_steps - UNTIMED_FRAMES
        episode_s = np.mean(self.reset_s) + np.mean(self.first_s) + later * np.mean(self.step_s)
        return float(self.episode_steps / episode_s)


def measure_cycle(training: Training, seed: int, steps: int) -> CycleSample:
    """Time a cycle of episodes of a training's env, after a rehearsal of one.

    Args:
        seed: of the env. steps: timed in each episode, after the first ones.
    """
    cv2.setNumThreads(1)
    reset_s, first_s, step_s = [], [], []
    with closing(FollowEnv(training.scenario, **training.env_keywords)) as env:
        still = np.zeros(env.action_space.shape or (), dtype=np.float32)
        longest = env.settings.configuration({}).frame_count - 1
        check("frames", steps <= longest - UNTIMED_FRAMES, f"at most {longest - UNTIMED_FRAMES}", steps)
        # In another world: what a scenario keeps of its latest world must not help.
        env.reset(seed=seed + 1)
        for _ in range(UNTIMED_FRAMES + steps):
            env.step(still)
        for k in range(env.settings.episodes_per_world if env.settings.worlds else 1):
            reset_s.append(_cpu_s(partial(env.reset, seed=None if k else seed)))
            taken_s = [_cpu_s(partial(env.step, still)) for _ in range(UNTIMED_FRAMES + steps)]
            first_s.append(sum(taken_s[:UNTIMED_FRAMES]))
            step_s.append(tuple(taken_s[UNTIMED_FRAMES:]))
    return CycleSample(tuple(reset_s), tuple(first_s), tuple(step_s), min(training.episode_steps or longest, longest))


def _cpu_s(act: Callable[[], object]) -> float:
    """Return the CPU seconds of a call."""
    began = time.process_time()
    act()
    return time.process_time() - began


def measure_resets(
    env_id: str, preset: str, seeds: range, steps: int, progress: Callable[[int, int], None] = lambda done, of: None
) -> list[dict[str, Any]]:
    """Return the entries of ``summary.json`` on an env's throughput (shape: ``benchmarks.statistics.summary``).

    Args:
        env_id: env id. preset: of its scenario. seeds: of the env, a cycle each.
        steps: timed in each episode.
        progress: called with (cycles done, cycles in all).
    """
    training, samples = Training(env_id, preset=preset, pictures=True), []
    for k, seed in enumerate(seeds):
        progress(k, len(seeds))
        samples.append(measure_cycle(training, seed, steps))
    progress(len(seeds), len(seeds))
    ones = [1.0] * len(samples)
    without, with_resets = (
        [getattr(each, name) for each in samples] for name in ("steps_per_s", "steps_per_s_with_resets")
    )
    figures = (
        ("training_steps_per_s_without_resets", "1/s", "higher", without, ones),
        ("training_steps_per_s_with_resets", "1/s", "higher", with_resets, ones),
        ("training_reset_throughput", "ratio", "higher", with_resets, without),
        ("training_new_world_reset_cpu_s", "s", "lower", [each.reset_s[0] for each in samples], ones),
        ("training_reset_cpu_s", "s", "lower", [float(np.mean(each.reset_s)) for each in samples], ones),
    )
    return entries_of(training.scenario, preset, "env", seeds, figures)
