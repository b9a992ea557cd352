"""A tracker's speed, and what it missed because of it: rows and metrics, the same in every suite."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import inf

import numpy as np

from benchmarks.contract.judging import Score
from benchmarks.contract.metric import OWN, Better, Mean, Metric, Quantity
from benchmarks.statistics.pooling import Median

_UNTIMED_FRAMES = 5
"""The first updates load compiled code from disk and are left out of the timing."""
MS_PER_FRAME = "ms_per_frame"
FRAMES_SEEN = "frames_seen"
_VOT = "real-time experiment of VOT: Kristan et al., The visual object tracking VOT2017 challenge results, 2017"


def times(taken: Sequence[tuple[float, float]], revision: tuple[float, float], frame_count: int) -> Iterator[Score]:
    """Yield CPU time and wall time per frame, the larger of the two, ``ms_per_frame``, and ``frames_per_s``, 1,000 over
    it; nothing if there were too few updates.

    Each is the mean per update, without the first five, and a frame's share of a revision at the end. CPU time is that
    of all threads of the process and, as reported by the tracker, of other processes and of results that it shares with
    other trackers; so one that computes in parallel gains nothing. Wall time holds what one waits for: a device, a
    process, a sleep. The time in which the thread waited for a core that others held is left out on Linux. Elsewhere,
    where the host of a virtual machine is loaded, and where what it waits for had to wait for a core, a loaded machine
    makes a tracker look slow: on one of 2 cores with 25 busy processes wall time was 3 times CPU time.

    Args:
        taken: CPU time and wall time of each update, seconds. revision: the same of the revision.
    """
    timed = taken[_UNTIMED_FRAMES:]
    if timed:
        means = np.mean(timed, axis=0) + np.array(revision) / frame_count
        cpu_ms, wall_ms = (1e3 * float(mean_s) for mean_s in means)
        ms_per_frame = max(cpu_ms, wall_ms)
        yield Score(MS_PER_FRAME, ms_per_frame)
        yield Score("cpu_ms_per_frame", cpu_ms)
        yield Score("wall_ms_per_frame", wall_ms)
        yield Score("frames_per_s", 1e3 / max(ms_per_frame, 1e-6))


def frames_seen(updates: int, pictures: int, failed_at_frame: int | None) -> Score:
    """Return ``frames_seen``: of the pictures up to a failure, the share that the tracker got.

    Args:
        updates: number of those that gave an answer; the first picture is got at the start.
        pictures: number of all in the episode. failed_at_frame: None without a failure, which is of one that was got.
    """
    failed = failed_at_frame is not None and 0 < failed_at_frame < pictures
    last = failed_at_frame if failed_at_frame is not None else pictures - 1
    return Score(FRAMES_SEEN, (1 + updates + failed) / (1 + min(last, pictures - 1)))


def _speed(name: str, summary: str, unit: str = "ms", better: Better = "lower") -> Metric:
    quantity = Quantity(name, 0, inf, "every frame but the tracker's first five", OWN, (times,))
    return Metric(name, summary, unit, better, Median(quantity))


_TIMED = (
    _speed(MS_PER_FRAME, "time of the tracker per frame: its CPU time or its wall time, whichever is larger"),
    _speed("frames_per_s", "frames a second of the tracker, at the larger of CPU time and wall time", "1/s", "higher"),
    _speed("cpu_ms_per_frame", "CPU time of the tracker per frame, of all its threads and processes"),
    _speed(
        "wall_ms_per_frame",
        "wall time of the tracker per frame, with what it waits for; a loaded machine makes it larger, on Linux less, "
        "where its waiting for a core is left out: where it is far above the CPU time, measure on an idle one",
    ),
)
SPEED = (
    *_TIMED,
    Metric(
        FRAMES_SEEN,
        "pictures that the tracker saw in real time (--real-time); the others came while it worked on an earlier one",
        "fraction",
        "higher",
        Mean(Quantity(FRAMES_SEEN, 0, 1, "all pictures up to a failure, in real time alone", _VOT, (frames_seen,))),
    ),
)
TIMES = tuple(metric.name for metric in _TIMED)
"""Rows that differ from run to run."""
