"""How long an episode takes, from a few of its frames."""

from __future__ import annotations

import time

import cv2
import numba

from benchmarks.run.jobs import Job, opened, take_in

_UNTIMED_FRAMES = 5
_TIMED_FRAMES = 15
_LOADED: set[tuple[str, ...]] = set()
"""Trackers whose kernels this process has loaded, with those of a scene."""


def seconds_of_episode(job: Job) -> float:
    """Return about how many seconds a job takes with all of its trackers, on a core that does nothing else.

    It is the CPU time of this process until the first frame is through, and the mean of frames 6 to 20 for each frame
    of the episode. Not in it: what judge and trackers do after the last frame. What is compiled or loaded once is
    left out by a first pass over three frames.
    """
    cv2.setNumThreads(1)
    numba.set_num_threads(1)
    if tuple(job.trackers) not in _LOADED:
        _timed(job, 1, 2)
        _LOADED.add(tuple(job.trackers))
    before_s, frame_s, frame_count = _timed(job, _UNTIMED_FRAMES, _TIMED_FRAMES)
    return before_s + frame_s * frame_count


def _timed(job: Job, untimed: int, timed: int) -> tuple[float, float, int]:
    """Return the seconds until frame 0 is through, the mean of a timed frame, and the number of all frames."""
    judging = job.suite
    started = time.process_time()
    with opened(job, judging.truth) as live:
        judge = job.episode.judge(judging, live.loop.episode)
        sheets = [judge.sheet() for _ in live.runs]
        moments = [started]
        for _ in live.frames(min(1 + untimed + timed, live.loop.episode.frame_count)):
            take_in(live.loop, judge, sheets)
            moments.append(time.process_time())
        frame_count = live.loop.episode.frame_count
    first = min(1 + untimed, len(moments) - 2)
    return moments[1] - started, (moments[-1] - moments[first]) / (len(moments) - 1 - first), frame_count
