"""What the measurements of speed share: the figures of one episode, and their entries over several."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, NamedTuple

import numpy as np

from benchmarks.contract.metric import PooledRatios
from benchmarks.statistics.bootstrap import bootstrap_interval
from scenarios.scenario import Frame
from sim.bullet import TinyRenderer

UNTIMED_FRAMES = 5
"""Number at the start of an episode, while static shadows are drawn and the exposure settles."""
FRAMES_PER_BARE_CALL = 8
_NEAR_M, _FAR_M = 0.2, 1000.0


class Figure(NamedTuple):
    """One figure of one episode, a numerator and a denominator: several episodes have the ratio of their sums."""

    above: float
    below: float = 1.0
    unit: str = "ratio"
    better: Literal["higher", "lower"] = "higher"


def seconds(above: float) -> Figure:
    """Return a time in seconds."""
    return Figure(above, unit="s", better="lower")


def milliseconds(seconds: float) -> Figure:
    """Return a time in milliseconds."""
    return Figure(1e3 * seconds, unit="ms", better="lower")


def rate(seconds: float) -> Figure:
    """Return how many there are in a second of what takes ``seconds``."""
    return Figure(1.0, seconds, "1/s")


def entries_of(
    scenario: str, preset: str, subject: str, seeds: range, measured: Sequence[Mapping[str, Figure]]
) -> list[dict[str, Any]]:
    """Return the entries of ``summary.json`` of measurements, with 95 % bootstrap intervals over episodes.

    Args:
        scenario: catalogue id with its version. subject: what is measured, in the place of the tracker.
        measured: by metric, for each of the seeds.
    """
    entries = []
    for metric, first in measured[0].items():
        above, below = (np.array([[each[metric][k]] for each in measured]) for k in (0, 1))
        pool = PooledRatios(np.array(seeds), above, below, lambda ratios: ratios[..., 0])
        low, high = bootstrap_interval(pool)
        entries.append(
            {"suite": "speed", "scenario": scenario, "preset": preset, "tracker": subject, "role": "ours"}
            | {"renderer": "raster", "metric": metric, "unit": first.unit, "better": first.better}
            | {"mean": pool.mean, "ci_low": low, "ci_high": high, "n": len(seeds)}
        )
    return entries


def timed(step: Callable[[], object], bare_call: Callable[[], float], count: int) -> tuple[list[float], list[float]]:
    """Return the CPU seconds of ``count`` steps, and those that ``bare_call`` returns after every eighth."""
    step_s, bare_s = [], []
    for k in range(count):
        step_s.append(cpu_s(step))
        if k % FRAMES_PER_BARE_CALL == FRAMES_PER_BARE_CALL - 1:
            bare_s.append(bare_call())
    return step_s, bare_s


def cpu_s(act: Callable[[], object]) -> float:
    """Return the CPU seconds of a call in this thread: wall times of short calls depend on other processes."""
    began = time.thread_time()
    act()
    return time.thread_time() - began


def bare_cpu_s(reference: TinyRenderer, frame: Frame, shadows: bool = True) -> float:
    """Return the CPU seconds of the bare calls of a frame; textures and poses are handed over before."""
    reference.hand_over()
    return cpu_s(lambda: bare_calls(reference, frame, shadows))


def bare_calls(reference: TinyRenderer, frame: Frame, shadows: bool = True) -> None:
    """Draw a frame's views, of a stereo pair both, with TinyRenderer, and drop the pictures."""
    aside_m = frame.observation.camera.baseline_m
    for shift_m in (0.0,) if aside_m is None else (0.0, aside_m):
        T_world_camera = frame.truth.T_world_camera.copy()
        T_world_camera[:3, 3] += shift_m * T_world_camera[:3, 0]
        reference.camera_image(frame.camera, T_world_camera, near_m=_NEAR_M, far_m=_FAR_M, shadows=shadows, lit=True)
