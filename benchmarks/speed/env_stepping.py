"""How fast an env steps: a rendered step with a tracker in the loop, against a bare call of PyBullet's renderer.

Both are timed in one run, in turns, on the same view, in CPU time of the one thread that does the work, after a
rehearsal: see ``benchmarks.speed.rendering``. A *step* is one ``env.step`` of ``frameout/RoadTownFollow-v1`` with
pictures of 84 × 84 observed on every step: action to command, everything moved, picture with shadows, light and noise,
``colour_pf`` with 500 particles, belief, truth of the target and reward. The *bare call* is ``getCameraImage`` of
TinyRenderer with shadows. Resets are told separately. *Process scaling* is how many times as fast,
by the clock, four envs in processes of their own step when two may step at a time as when one may; *arithmetic scaling*
is the same of processes that count instead, which use neither memory nor anything of ours and wait for each other as
often: the most that the machine allows.
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
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.speed.rendering import FRAMES_PER_BARE_CALL, UNTIMED_FRAMES, bare_calls, entries_of
from scenarios import catalog
from scenarios.envs.follow_env import FollowEnv
from scenarios.envs.processes import EnvProcesses

ENV_ID, SCENARIO = catalog.DEFAULT_ENV, catalog.envs()[catalog.DEFAULT_ENV][0]
SIDE_PX = 84
_ENVS, _WORKERS = 4, 2
_TURN_STEPS = 10
_COUNTED = 40_000
"""Numbers that take about two thirds as long as a step of one env."""


@dataclass(frozen=True, slots=True)
class EnvSpeedSample:
    """CPU seconds of single steps of one episode.

    Attributes:
        step_s: (N,) of steps.
        bare_s: (M,) of bare calls of TinyRenderer, spread evenly among them.
        reset_s: of a reset.
    """

    step_s: tuple[float, ...]
    bare_s: tuple[float, ...]
    reset_s: float


def env_keywords(preset: str) -> dict[str, Any]:
    """Return the keywords of the env that is timed. ``centre`` steers, so that there is something to see."""
    return {
        "scenario": SCENARIO,
        "preset": preset,
        "changes": {"width_px": SIDE_PX, "height_px": SIDE_PX},
        # 500 particles, as it was written.
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
        if steps > longest:
            raise ValueError(f"frames: expected at most {longest}, which an episode of this preset has, got {steps}")
        # Of two lives of the same episode the first compiles or loads what the second needs.
        for _ in range(2):
            began = time.thread_time()
            env.reset(options={"episode_seed": seed})
            reset_s = time.thread_time() - began
            _bare_call(env)
            for _ in range(UNTIMED_FRAMES):
                env.step(still)
            step_s, bare_s = _timed(env, still, steps)
    return EnvSpeedSample(tuple(step_s), tuple(bare_s), reset_s)


def _timed(env: FollowEnv, still: NDArray[np.float32], steps: int) -> tuple[list[float], list[float]]:
    step_s, bare_s = [], []
    for k in range(steps):
        began = time.thread_time()
        env.step(still)
        step_s.append(time.thread_time() - began)
        if k % FRAMES_PER_BARE_CALL == FRAMES_PER_BARE_CALL - 1:
            bare_s.append(_bare_call(env))
    return step_s, bare_s


def _bare_call(env: FollowEnv) -> float:
    """Return the CPU seconds of a bare call of the env's view; textures and poses are handed over before."""
    episode: Any = env.episode.episode
    episode.world.hand_over()
    began = time.thread_time()
    bare_calls(episode.world, env.episode.frame)
    return time.thread_time() - began


def seconds_in_turns(actors: Sequence[Callable[[], object]], times: int) -> list[float]:
    """Return the wall seconds that each takes to act so many times.

    They take turns, a few times each, so that whatever else the machine does meanwhile slows all alike.
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
    """Begin the same episode in each of the envs and return what steps them all."""
    envs.reset(options={"episode_seed": seed})
    step = partial(envs.step, np.zeros(envs.action_space.shape or (), dtype=np.float32))
    for _ in range(UNTIMED_FRAMES):
        step()
    return step


def _count(numbers: int) -> int:
    """Keep a core busy, and nothing else."""
    total = 0
    for k in range(numbers):
        total += k * k
    return total


def measure_scaling(
    preset: str, seeds: range, steps: int, progress: Callable[[int], None]
) -> list[tuple[float, float, float, float]]:
    """Return wall seconds for each episode: of a vector env's steps, one at a time and two at a time, and of as much
    counting in one process and in two.

    Args:
        steps: of all envs, in each episode.
        progress: called with the number of episodes done.
    """
    make = [partial(FollowEnv, **env_keywords(preset))] * _ENVS
    taken_s = []
    with (
        closing(EnvProcesses(make, max_concurrency=1)) as alone,
        closing(EnvProcesses(make, max_concurrency=_WORKERS)) as shared,
        # Ctrl-C reaches every process of a terminal; the one that holds the others ends them.
        ProcessPoolExecutor(
            _WORKERS,
            multiprocessing.get_context("spawn"),
            initializer=signal.signal,
            initargs=(signal.SIGINT, signal.SIG_IGN),
        ) as counters,
    ):

        def counting(processes: int) -> Callable[[], object]:
            return lambda: list(counters.map(_count, [_COUNTED * _ENVS // processes] * processes))

        # The first lives load kernels.
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
    """Return the entries of ``summary.json`` on the env's speed over these episodes, see ``benchmarks.scores.summary``.

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
    )
    return entries_of(SCENARIO, preset, "env", seeds, figures)
