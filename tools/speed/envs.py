"""Speed of the envs: rendered steps against a bare call of PyBullet's renderer, resets, and steps without pictures.

A *step* is one ``env.step`` of ``frameout/RoadTownFollow-v3`` with pictures of 84 × 84 observed on every step: action
to command, everything moved, picture with shadows, light and noise, ``colour_pf`` with 500 particles, belief, truth of
the target and reward. Step and *bare call*, ``getCameraImage`` of TinyRenderer with shadows, are timed in one run,
alternately, on the same view, in CPU time of the working thread, after a rehearsal. *With resets* are whole episodes
that never ran before, one after the other, each with its reset, in a world that the process has built already; what it
takes to *build a world*, once a process, is a figure of its own. *Process scaling* is the wall-clock speed of a vector
env, eight envs in two processes, over that of a single env; *arithmetic scaling* is the same for processes that only
count, without memory access or our code, and synchronise as often: the limit of the machine.
"""

from __future__ import annotations

import multiprocessing
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any, cast

import cv2
import numpy as np

from scenarios import catalog
from scenarios.envs.follow_env import FollowEnv
from scenarios.envs.pictureless.vector_env import PicturelessVectorEnv
from scenarios.envs.settings import WORLDS
from scenarios.envs.vectors import FollowVectorEnv
from sim.bullet import TinyRenderer
from sim.checks import check
from tools.speed.figures import UNTIMED_FRAMES, Figure, bare_calls, bare_cpu_s, cpu_s, rate, seconds, timed

SCENARIO = catalog.envs()[catalog.DEFAULT_ENV][0]
SIDE_PX = 84
_ENVS, _WORKERS = 8, 2
_TURN_STEPS = 10
_COUNTED = 40_000
"""Counting to this number takes about two thirds of the time of a step of one env."""
_PICTURELESS_ENVS = 1024
_NEW_EPISODES = 3
_WARM_UP, _STEPS, _EPISODE_STEPS = 20, 200, 150


def measure_env(preset: str, steps: int, seed: int) -> dict[str, Figure]:
    """Return the figures of the rendered env's steps in an episode.

    Raises:
        ValueError: if the preset's episodes have fewer steps.
    """
    step_s, bare_s = step_times(preset, seed, steps)
    episodes_s, resets_s, episode_steps = episode_times(preset, seed)
    one_s, two_s, counted_s, both_s = scaling_times(preset, seed, steps)
    return {
        "env_speedup_over_tinyrenderer": Figure(bare_s, step_s),
        "env_steps_per_s": rate(step_s),
        "env_steps_per_s_with_resets": Figure(episode_steps, episodes_s, "1/s"),
        "env_process_scaling": Figure(one_s, two_s),
        "env_arithmetic_scaling": Figure(counted_s, both_s),
        "env_reset_cpu_s": seconds(resets_s / _NEW_EPISODES),
        "env_world_cpu_s": seconds(world_time(preset, seed)),
    }


def env_keywords(preset: str) -> dict[str, Any]:
    """Return the keywords of the timed env; ``centre`` steers to keep the target in view."""
    return {
        "scenario": SCENARIO,
        "preset": preset,
        "changes": {"width_px": SIDE_PX, "height_px": SIDE_PX},
        # 500 particles, its written value.
        "tracker": "colour_pf",
        "observation": "both",
        "action": "correction",
        "controller": "centre",
    }


def step_times(preset: str, seed: int, steps: int) -> tuple[float, float]:
    """Return mean CPU seconds of steps and, after every eighth, of a bare call from the same camera."""
    cv2.setNumThreads(1)
    with closing(FollowEnv(**env_keywords(preset))) as env:
        step = partial(env.step, np.zeros(env.action_space.shape or (), dtype=np.float32))
        longest = env.settings.configuration({}).frame_count - 1 - UNTIMED_FRAMES
        check("frames", steps <= longest, f"at most {longest}, which an episode of this preset has", steps)
        # The first of two equal episodes compiles or loads the kernels of the second.
        for _ in range(2):
            env.reset(options={"episode_seed": seed})
            reference = TinyRenderer(cast(Any, env.episode.episode).world)
            bare_calls(reference, env.episode.frame)
            for _ in range(UNTIMED_FRAMES):
                step()
            step_s, bare_s = timed(step, lambda: bare_cpu_s(reference, env.episode.frame), steps)  # noqa: B023
    return float(np.mean(step_s)), float(np.mean(bare_s))


def episode_times(preset: str, seed: int) -> tuple[float, float, int]:
    """Return the CPU seconds of new episodes with their resets, those of the resets alone, and the number of steps."""
    cv2.setNumThreads(1)
    with closing(FollowEnv(**env_keywords(preset))) as env:
        action = np.zeros(env.action_space.shape or (), dtype=np.float32)

        def to_the_end() -> int:
            count, over = 0, False
            while not over:
                _, _, terminated, truncated, _ = env.step(action)
                count, over = count + 1, terminated or truncated
            return count

        # The first episode builds the world that the others take place in.
        env.reset(options={"episode_seed": seed})
        to_the_end()
        began, resets_s, steps = time.thread_time(), 0.0, 0
        for k in range(1, 1 + _NEW_EPISODES):
            resets_s += cpu_s(partial(env.reset, options={"episode_seed": seed + k * WORLDS}))
            steps += to_the_end()
        return time.thread_time() - began, resets_s, steps


def world_time(preset: str, seed: int) -> float:
    """Return the CPU seconds of building a world, 0 for a scenario that cannot keep any."""
    with closing(FollowEnv(**env_keywords(preset))) as env:
        scenario, configuration = catalog.scenario(env.settings.scenario), env.settings.configuration({})
    if scenario.new_world is None:
        return 0.0
    return cpu_s(lambda: scenario.keep_world(configuration, seed))


def scaling_times(preset: str, seed: int, steps: int) -> list[float]:
    """Return wall seconds of as many steps of a single env and of a vector env, and of counting likewise."""
    with (
        closing(FollowEnv(**env_keywords(preset))) as single,
        closing(FollowVectorEnv(_ENVS, workers=_WORKERS, **env_keywords(preset))) as envs,
        ProcessPoolExecutor(_WORKERS, multiprocessing.get_context("spawn")) as counters,
    ):

        def counting(processes: int) -> Callable[[], object]:
            return lambda: list(counters.map(_count, [_COUNTED * _ENVS // processes] * processes))

        # The first episode loads kernels.
        for _ in range(2):
            step, together = _under_way(single, seed), _under_way(envs, seed)
            actors = (step, together, counting(1), counting(_WORKERS))
            single_s, envs_s, *counted_s = seconds_in_turns(actors, steps)
    return [_ENVS * single_s, envs_s, *counted_s]


def seconds_in_turns(actors: Sequence[Callable[[], object]], times: int) -> list[float]:
    """Return the wall seconds of ``times`` calls of each actor.

    They take turns, a few calls each, so that other load on the machine slows all alike.
    """
    taken_s = [0.0] * len(actors)
    for first in range(0, times, _TURN_STEPS):
        for k, act in enumerate(actors):
            began = time.perf_counter()
            for _ in range(min(_TURN_STEPS, times - first)):
                act()
            taken_s[k] += time.perf_counter() - began
    return taken_s


def _under_way(env: FollowEnv | FollowVectorEnv, seed: int) -> Callable[[], object]:
    """Begin the same episode in an env, or in each of several, and return a function that steps."""
    env.reset(options={"episode_seed": seed})
    step = partial(env.step, np.zeros(env.action_space.shape or (), dtype=np.float32))
    for _ in range(UNTIMED_FRAMES):
        step()
    return step


def _count(numbers: int) -> int:
    """Keep a core busy."""
    return sum(k * k for k in range(numbers))


def measure_pictureless(env_id: str, preset: str, cache: Path | None, seed: int) -> dict[str, Figure]:
    """Return the thread's CPU time for a step of one of 1,024 envs without pictures in an episode, resets included.

    Args:
        cache: folder where planned episodes are kept.
    """
    scenario, tracker = catalog.envs()[env_id]
    how: dict[str, Any] = {"preset": preset, "seeds": [seed], "cache": cache, "max_episode_steps": _EPISODE_STEPS}
    with closing(PicturelessVectorEnv(_PICTURELESS_ENVS, scenario, tracker, **how)) as envs:
        envs.reset(seed=0)
        step = partial(envs.step, np.zeros(envs.action_space.shape or ()))
        for _ in range(_WARM_UP):
            step()
        step_s = cpu_s(lambda: [step() for _ in range(_STEPS)]) / (_PICTURELESS_ENVS * _STEPS)
    return {"env_steps_per_s_without_pictures": rate(step_s)}
