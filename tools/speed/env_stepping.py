"""Speed of an env: a rendered step with a tracker in the loop, against a bare call of PyBullet's renderer.

Both are timed in one run, alternately, on the same view, in CPU time of the working thread, after a rehearsal:
see ``tools.speed.rendering``. A *step* is one ``env.step`` of ``frameout/RoadTownFollow-v2`` with
pictures of 84 × 84 observed on every step: action to command, everything moved, picture with shadows, light and noise,
``colour_pf`` with 500 particles, belief, truth of the target and reward. The *bare call* is ``getCameraImage`` of
TinyRenderer with shadows. Resets are timed separately: to another episode, as a training makes them, and to the same
one again, whose town the scenario has kept. *Process scaling* is the wall-clock speed of
four envs in separate processes with two at a time over that with one at a time; *arithmetic scaling* is the same for
processes that only count, without memory access or our code, and synchronise as often: the limit of the machine.
"""

from __future__ import annotations

import multiprocessing
import signal
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from typing import Any, cast

import cv2
import numpy as np

from scenarios import catalog
from scenarios.envs.follow_env import FollowEnv
from scenarios.envs.processes import EnvProcesses
from sim.bullet import TinyRenderer
from sim.checks import check
from tools.speed.rendering import UNTIMED_FRAMES, bare_cpu_s, entries_of, timed

ENV_ID, SCENARIO = catalog.DEFAULT_ENV, catalog.envs()[catalog.DEFAULT_ENV][0]
SIDE_PX = 84
_ENVS, _WORKERS = 4, 2
_TURN_STEPS = 10
_COUNTED = 40_000
"""Counting to this number takes about two thirds of the time of a step of one env."""


@dataclass(frozen=True, slots=True)
class EnvSpeedSample:
    """CPU seconds of single steps of one episode.

    Attributes:
        step_s: (N,) of steps.
        bare_s: (M,) of bare calls of TinyRenderer, spread evenly among them.
        reset_s: of a reset to another episode, as in a training. cached_reset_s: to the same one, whose town is kept.
    """

    step_s: tuple[float, ...]
    bare_s: tuple[float, ...]
    reset_s: float
    cached_reset_s: float


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


def measure_env_steps(preset: str, seed: int, steps: int) -> EnvSpeedSample:
    """Time steps and, after every eighth, a bare call from the same camera.

    Raises:
        ValueError: if the preset's episodes have fewer steps.
    """
    cv2.setNumThreads(1)
    with closing(FollowEnv(**env_keywords(preset))) as env:
        still = np.zeros(env.action_space.shape or (), dtype=np.float32)
        longest = env.settings.configuration({}).frame_count - 1 - UNTIMED_FRAMES
        check("frames", steps <= longest, f"at most {longest}, which an episode of this preset has", steps)
        # The first of two equal episodes compiles or loads the kernels of the second.
        for _ in range(2):
            # In another town: what the scenario keeps of its latest one must not help.
            env.reset(options={"episode_seed": seed + 1})
            reset_s = _reset_s(env, seed)
            reference = TinyRenderer(cast(Any, env.episode.episode).world)
            _bare_call(reference, env)
            for _ in range(UNTIMED_FRAMES):
                env.step(still)
            step_s, bare_s = timed(partial(env.step, still), partial(_bare_call, reference, env), steps)
        cached_reset_s = _reset_s(env, seed)
    return EnvSpeedSample(tuple(step_s), tuple(bare_s), reset_s, cached_reset_s)


def _bare_call(reference: TinyRenderer, env: FollowEnv) -> float:
    return bare_cpu_s(reference, env.episode.frame)


def _reset_s(env: FollowEnv, seed: int) -> float:
    """Return the CPU seconds of a reset to an episode."""
    began = time.thread_time()
    env.reset(options={"episode_seed": seed})
    return time.thread_time() - began


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


def _under_way(envs: EnvProcesses, seed: int) -> Callable[[], object]:
    """Begin the same episode in each of the envs and return a function that steps all."""
    envs.reset(options={"episode_seed": seed})
    step = partial(envs.step, np.zeros(envs.action_space.shape or (), dtype=np.float32))
    for _ in range(UNTIMED_FRAMES):
        step()
    return step


def _count(numbers: int) -> int:
    """Keep a core busy."""
    total = 0
    for k in range(numbers):
        total += k * k
    return total


def measure_scaling(
    preset: str, seeds: range, steps: int, progress: Callable[[int], None]
) -> list[tuple[float, float, float, float]]:
    """Return wall seconds for each episode: of envs' steps, one and two at a time, and of counting likewise.

    Args:
        steps: of all envs, in each episode.
        progress: called with the number of episodes done.
    """
    make = [partial(FollowEnv, **env_keywords(preset))] * _ENVS
    taken_s = []
    with (
        closing(EnvProcesses(make, max_concurrency=1)) as alone,
        closing(EnvProcesses(make, max_concurrency=_WORKERS)) as shared,
        # Ctrl-C reaches all processes of a terminal; this one ends the others.
        ProcessPoolExecutor(
            _WORKERS,
            multiprocessing.get_context("spawn"),
            initializer=signal.signal,
            initargs=(signal.SIGINT, signal.SIG_IGN),
        ) as counters,
    ):

        def counting(processes: int) -> Callable[[], object]:
            return lambda: list(counters.map(_count, [_COUNTED * _ENVS // processes] * processes))

        # The first episode loads kernels.
        for number, seed in enumerate((seeds[0], *seeds)):
            one_s, two_s, counted_s, both_s = seconds_in_turns(
                (_under_way(alone, seed), _under_way(shared, seed), counting(1), counting(_WORKERS)), steps
            )
            if number > 0:
                taken_s.append((one_s, two_s, counted_s, both_s))
            progress(number)
    return taken_s


def measure_env(
    preset: str, seeds: range, steps: int, progress: Callable[[int, int], None] = lambda done, of: None
) -> list[dict[str, Any]]:
    """Return the entries of ``summary.json`` on the env's speed over these episodes, see ``statistics.summary``.

    Args:
        steps: timed in each episode.
        progress: called with (parts done, parts in all).
    """
    of = 2 * len(seeds)
    samples = []
    for k, seed in enumerate(seeds):
        progress(k, of)
        samples.append(measure_env_steps(preset, seed, steps))
    scaling = measure_scaling(preset, seeds, steps, lambda done: progress(len(seeds) + done, of))
    bare, step = ([float(np.mean(getattr(each, name))) for each in samples] for name in ("bare_s", "step_s"))
    one_s, two_s, counted_s, both_s = (list(column) for column in zip(*scaling, strict=True))
    ones = [1.0] * len(samples)
    figures = (
        ("env_speedup_over_tinyrenderer", "ratio", "higher", bare, step),
        ("env_steps_per_s", "1/s", "higher", ones, step),
        ("env_process_scaling", "ratio", "higher", one_s, two_s),
        ("env_arithmetic_scaling", "ratio", "higher", counted_s, both_s),
        ("env_tinyrenderer_cpu_ms", "ms", "lower", [1e3 * each for each in bare], ones),
        ("env_reset_cpu_s", "s", "lower", [each.reset_s for each in samples], ones),
        ("env_cached_reset_cpu_s", "s", "lower", [each.cached_reset_s for each in samples], ones),
    )
    return entries_of(SCENARIO, preset, "env", seeds, figures)
