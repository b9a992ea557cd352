"""Speed of rendering: a picture, and a finished frame with all its truth, against a bare call of PyBullet's renderer.

All are timed in one run, alternately, on the same scene, camera and size, in CPU time of the working thread (wall
times of short calls depend on other processes). A *finished frame* is one ``Episode.step``:
everything moved, picture (or both of a stereo pair) with shadows, light and sensor noise, boxes, visible fractions and
all other truth. The *picture* is the part of it from bodies in their places to light and sensor noise, with ids and
depth. The *bare call* is ``getCameraImage`` of TinyRenderer, with shadows and without, one for each picture: no noise,
no exposure, no truth but ids and depth.

A kernel is compiled, or loaded from disk, at the first frame that needs it, which may be a late one (the first with
motion blur). So every process first runs the timed frames once in another instance of the town.
"""

from __future__ import annotations

import multiprocessing
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import Any, Protocol

import cv2
import numpy as np

from benchmarks.contract.metric import PooledRatios
from benchmarks.statistics.bootstrap import bootstrap_interval
from scenarios import catalog
from scenarios.scenario import Frame
from sim.bullet import TinyRenderer
from sim.checks import check
from sim.world import World

UNTIMED_FRAMES = 5
"""Number at the start of an episode, while static shadows are drawn and the exposure settles."""
FRAMES_PER_BARE_CALL = 8
_NEAR_M, _FAR_M = 0.2, 1000.0
_PATIENCE_S = 300.0

Figure = tuple[str, str, str, Sequence[float], Sequence[float]]
"""Metric, unit, better direction, numerators and denominators of the towns."""


class Subject(Protocol):
    """A measured episode, whose world other renderers can draw."""

    frame_count: int

    @property
    def world(self) -> World:
        """The bodies, where they are now."""
        ...

    def step(self) -> Frame:
        """Return the next finished frame."""
        ...

    def close(self) -> None:
        """Free what it holds."""
        ...


@dataclass(frozen=True, slots=True)
class SpeedSample:
    """CPU seconds of single frames of one episode.

    Attributes:
        frame_s: (N,) of finished frames.
        picture_s: (N,) of their pictures alone (both of a pair); empty if the episode's cameras are not ours.
        bare_s: (M,) of bare calls of TinyRenderer (two for a pair) with shadows, spread evenly among them.
        shadowless_s: (M,) the same without shadows.
        wall_frame_s: wall time of a finished frame, mean.
    """

    frame_s: tuple[float, ...]
    picture_s: tuple[float, ...]
    bare_s: tuple[float, ...]
    shadowless_s: tuple[float, ...]
    wall_frame_s: float

    @property
    def speedup(self) -> float:
        """Mean bare call over mean finished frame."""
        return float(np.mean(self.bare_s) / np.mean(self.frame_s))


def measure(build: Callable[[], Subject], frames: int) -> SpeedSample:
    """Time finished frames and, after every eighth, bare calls from the same camera.

    Args:
        build: builds the episode; the same one each time.
        frames: how many, at least ``FRAMES_PER_BARE_CALL``.

    Raises:
        ValueError: if the episode has fewer.
    """
    cv2.setNumThreads(1)
    episode, frame = _rehearsed(build, frames)
    reference = TinyRenderer(episode.world)
    for shadows in (True, False):
        bare_calls(reference, frame, shadows)
    picture_s, shadowless_s, wall_s = _time_pictures(episode), [], 0.0

    def step() -> None:
        nonlocal frame, wall_s
        began = time.perf_counter()
        frame = episode.step()
        wall_s += time.perf_counter() - began

    def bare_call() -> float:
        shadowless_s.append(bare_cpu_s(reference, frame, shadows=False))
        return bare_cpu_s(reference, frame)

    frame_s, bare_s = timed(step, bare_call, frames)
    episode.close()
    return SpeedSample(tuple(frame_s), tuple(picture_s), tuple(bare_s), tuple(shadowless_s), wall_s / frames)


def _time_pictures(episode: Any) -> list[float]:
    """Return a list that gets the CPU seconds of the pictures of each frame from now on, one number a frame.

    It stays empty for an episode that is no ``scenarios.stage.Stage``.
    """
    taken_s: list[float] = []
    camera = getattr(episode, "_camera", None)
    if camera is None:
        return taken_s
    take = camera.take

    def timed_take(*args: Any, **options: Any) -> Any:
        began = time.thread_time()
        taken = take(*args, **options)
        taken_s.append(time.thread_time() - began)
        return taken

    camera.take = timed_take
    return taken_s


def timed(step: Callable[[], object], bare_call: Callable[[], float], count: int) -> tuple[list[float], list[float]]:
    """Return the CPU seconds of ``count`` steps, and those that ``bare_call`` returns after every eighth."""
    step_s, bare_s = [], []
    for k in range(count):
        began = time.thread_time()
        step()
        step_s.append(time.thread_time() - began)
        if k % FRAMES_PER_BARE_CALL == FRAMES_PER_BARE_CALL - 1:
            bare_s.append(bare_call())
    return step_s, bare_s


def bare_cpu_s(reference: TinyRenderer, frame: Frame, shadows: bool = True) -> float:
    """Return the CPU seconds of the bare calls of a frame; textures and poses are handed over before."""
    reference.hand_over()
    began = time.thread_time()
    bare_calls(reference, frame, shadows)
    return time.thread_time() - began


def _rehearsed(build: Callable[[], Subject], frames: int) -> tuple[Subject, Frame]:
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


def bare_calls(reference: TinyRenderer, frame: Frame, shadows: bool) -> None:
    """Draw a frame's views, of a stereo pair both, with TinyRenderer, and drop the pictures."""
    aside_m = frame.observation.camera.baseline_m
    for shift_m in (0.0,) if aside_m is None else (0.0, aside_m):
        T_world_camera = frame.truth.T_world_camera.copy()
        T_world_camera[:3, 3] += shift_m * T_world_camera[:3, 0]
        reference.camera_image(frame.camera, T_world_camera, near_m=_NEAR_M, far_m=_FAR_M, shadows=shadows, lit=True)


def process_throughput(scenario: str, preset: str, seed: int, frames: int, processes: int) -> float:
    """Return finished frames a second of wall time, summed over processes that each run the episode.

    They start together, each after its rehearsal.
    """
    context = multiprocessing.get_context("spawn")
    start, results = context.Barrier(processes), context.Queue()
    workers = [
        context.Process(target=_work, args=(scenario, preset, seed, frames, start, results)) for _ in range(processes)
    ]
    for worker in workers:
        worker.start()
    seconds = [results.get(timeout=_PATIENCE_S) for _ in workers]
    for worker in workers:
        worker.join()
    return sum(frames / each for each in seconds)


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
    return lambda: catalog.scenario(scenario).episode(preset, seed)


def measure_scenario(
    scenario: str,
    preset: str,
    seeds: range,
    frames: int,
    progress: Callable[[int, int], None] = lambda done, of: None,
) -> list[dict[str, Any]]:
    """Return the entries of ``summary.json`` on speed over towns of these seeds, see ``benchmarks.statistics.summary``.

    Args:
        frames: finished frames timed in each town.
        progress: called with (parts done, parts in all).
    """
    of = 3 * len(seeds)
    samples, one, two = [], [], []
    for k, seed in enumerate(seeds):
        progress(3 * k, of)
        samples.append(measure(_builder(scenario, preset, seed), frames))
        progress(3 * k + 1, of)
        one.append(process_throughput(scenario, preset, seed, frames, 1))
        progress(3 * k + 2, of)
        two.append(process_throughput(scenario, preset, seed, frames, 2))
    progress(of, of)
    finished, bare, shadowless = (
        [float(np.mean(getattr(sample, name))) for sample in samples] for name in ("frame_s", "bare_s", "shadowless_s")
    )
    ones, walls = [1.0] * len(samples), [sample.wall_frame_s for sample in samples]
    figures: list[Figure] = [
        ("speedup_over_tinyrenderer", "ratio", "higher", bare, finished),
        ("speedup_over_tinyrenderer_without_shadows", "ratio", "higher", shadowless, finished),
        ("frames_per_s", "1/s", "higher", ones, walls),
        ("process_scaling", "ratio", "higher", two, one),
        ("frame_cpu_ms", "ms", "lower", [1e3 * each for each in finished], ones),
        ("tinyrenderer_cpu_ms", "ms", "lower", [1e3 * each for each in bare], ones),
        ("tinyrenderer_without_shadows_cpu_ms", "ms", "lower", [1e3 * each for each in shadowless], ones),
    ]
    if all(sample.picture_s for sample in samples):
        pictures = [float(np.mean(sample.picture_s)) for sample in samples]
        figures += [
            ("picture_speedup_over_tinyrenderer", "ratio", "higher", bare, pictures),
            ("picture_speedup_over_tinyrenderer_without_shadows", "ratio", "higher", shadowless, pictures),
            ("picture_cpu_ms", "ms", "lower", [1e3 * each for each in pictures], ones),
        ]
    return entries_of(scenario, preset, "raster", seeds, figures)


def entries_of(
    scenario: str, preset: str, subject: str, seeds: range, figures: Iterable[Figure]
) -> list[dict[str, Any]]:
    """Return the entries of ``summary.json`` of measurements in these towns; ``subject`` stands for the tracker."""
    id_of = catalog.scenario(scenario).id
    return [
        {"suite": "speed", "scenario": id_of, "preset": preset, "tracker": subject, "role": "ours"}
        | {"renderer": "raster", "metric": metric, "unit": unit, "better": better}
        | dict(_statistic(np.array(seeds), np.array(above), np.array(below)))
        for metric, unit, better, above, below in figures
    ]


def _statistic(seeds: np.ndarray, above: np.ndarray, below: np.ndarray) -> Iterator[tuple[str, float]]:
    """Yield the ratio of sums over towns, with the 95 % bootstrap interval over towns."""
    pool = PooledRatios(seeds, above[:, None], below[:, None], lambda ratios: ratios[..., 0])
    low, high = bootstrap_interval(pool)
    yield from (("mean", pool.mean), ("ci_low", low), ("ci_high", high), ("n", len(seeds)))
