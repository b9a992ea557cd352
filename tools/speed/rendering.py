"""Speed of rendering: a picture, and a finished frame with all its truth, against a bare call of PyBullet's renderer.

All are timed in one run, alternately, on the same scene, camera and size, in CPU time of the working thread. A
*finished frame* is one ``Episode.step``: everything moved, picture (or both of a stereo pair) with shadows, light and
sensor noise, boxes, visible fractions and all other truth. The *picture* is the part of it from bodies in their places
to light and sensor noise, with ids and depth. The *bare call* is ``getCameraImage`` of TinyRenderer, with shadows and
without, one for each picture: no noise, no exposure, no truth but ids and depth.

A kernel is compiled, or loaded from disk, at the first frame that needs it, which may be a late one (the first with
motion blur). So every process first runs the timed frames once in another instance of the town.
"""

from __future__ import annotations

import multiprocessing
import time
from collections.abc import Callable
from contextlib import closing
from functools import partial
from typing import Any

import cv2
import numpy as np

from scenarios import catalog
from scenarios.scenario import Frame
from sim.bullet import TinyRenderer
from sim.checks import check
from tools.speed.figures import UNTIMED_FRAMES, Figure, bare_calls, bare_cpu_s, milliseconds, rate, timed

_PATIENCE_S = 300.0


def measure_rendering(scenario: str, preset: str, frames: int, seed: int) -> dict[str, Figure]:
    """Return the figures of an episode.

    Args:
        frames: finished frames that are timed, at least ``FRAMES_PER_BARE_CALL``.

    Raises:
        ValueError: if the episode has fewer.
    """
    frame_s, wall_s, picture_s, bare_s, shadowless_s = frame_times(_builder(scenario, preset, seed), frames)
    one, two = (process_throughput(scenario, preset, seed, frames, count) for count in (1, 2))
    return {
        "speedup_over_tinyrenderer": Figure(bare_s, frame_s),
        "speedup_over_tinyrenderer_without_shadows": Figure(shadowless_s, frame_s),
        "frames_per_s": rate(wall_s),
        "process_scaling": Figure(two, one),
        "frame_cpu_ms": milliseconds(frame_s),
        "tinyrenderer_cpu_ms": milliseconds(bare_s),
        "picture_speedup_over_tinyrenderer": Figure(bare_s, picture_s),
        "picture_cpu_ms": milliseconds(picture_s),
    }


def frame_times(build: Callable[[], Any], frames: int) -> tuple[float, ...]:
    """Return mean seconds of an episode's frames; after every eighth follow bare calls from the same camera.

    They are of a finished frame in CPU and in wall time, of its pictures alone (both of a pair), and of the bare calls
    (two for a pair) with shadows and without.

    Args:
        build: builds the episode, a ``scenarios.stage.Stage``; the same one each time.
    """
    cv2.setNumThreads(1)
    episode, frame = _rehearsed(build, frames)
    picture_s, shadowless_s, wall_s = list[float](), list[float](), list[float]()
    take = episode._camera.take

    def timed_take(*args: Any, **options: Any) -> Any:
        began = time.thread_time()
        taken = take(*args, **options)
        picture_s.append(time.thread_time() - began)
        return taken

    def step() -> None:
        nonlocal frame
        began = time.perf_counter()
        frame = episode.step()
        wall_s.append(time.perf_counter() - began)

    def bare_call() -> float:
        shadowless_s.append(bare_cpu_s(reference, frame, shadows=False))
        return bare_cpu_s(reference, frame)

    with closing(episode):
        reference = TinyRenderer(episode.world)
        for shadows in (True, False):
            bare_calls(reference, frame, shadows)
        episode._camera.take = timed_take
        frame_s, bare_s = timed(step, bare_call, frames)
    return tuple(float(np.mean(each)) for each in (frame_s, wall_s, picture_s, bare_s, shadowless_s))


def _rehearsed(build: Callable[[], Any], frames: int) -> tuple[Any, Frame]:
    """Return an episode whose next ``frames`` frames need no new kernel, and the last of its untimed frames."""
    with closing(build()) as rehearsal:
        longest = rehearsal.frame_count - UNTIMED_FRAMES
        check("frames", frames <= longest, f"at most {longest}, which an episode of this preset has", frames)
        for _ in range(UNTIMED_FRAMES + frames):
            rehearsal.step()
    episode = build()
    for _ in range(UNTIMED_FRAMES):
        frame = episode.step()
    return episode, frame


def process_throughput(scenario: str, preset: str, seed: int, frames: int, processes: int) -> float:
    """Return finished frames a second of wall time, summed over processes that each run the episode.

    They start together, each after its rehearsal.
    """
    context = multiprocessing.get_context("spawn")
    start, results = context.Barrier(processes), context.Queue()
    given = (scenario, preset, seed, frames, start, results)
    workers = [context.Process(target=_work, args=given) for _ in range(processes)]
    for worker in workers:
        worker.start()
    taken_s = [results.get(timeout=_PATIENCE_S) for _ in workers]
    for worker in workers:
        worker.join()
    return sum(frames / each for each in taken_s)


def _work(scenario: str, preset: str, seed: int, frames: int, start: Any, results: Any) -> None:
    cv2.setNumThreads(1)
    episode, _ = _rehearsed(_builder(scenario, preset, seed), frames)
    start.wait(_PATIENCE_S)
    began = time.perf_counter()
    for _ in range(frames):
        episode.step()
    results.put(time.perf_counter() - began)
    episode.close()


def _builder(scenario: str, preset: str, seed: int) -> Callable[[], Any]:
    return partial(catalog.scenario(scenario).episode, preset, seed)
