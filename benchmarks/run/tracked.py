"""One contestant through one episode, guarded: whatever it does, the episode goes on and is scored."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.run.from_pictures import Contestant
from benchmarks.run.time_limit import Stopwatch, TooSlow, at_most
from benchmarks.suites.judging import Score, ScoreSheet
from scenarios.scenario import Frame
from trackers.estimate_check import check_estimate
from trackers.types import Estimate

_UNTIMED_FRAMES = 5
"""The first updates load compiled code from disk and are left out of the timing."""

SILENT = Estimate(position_px=np.full(2, np.nan))


@dataclass(frozen=True, slots=True)
class Failure:
    """Where and how a tracker failed.

    Attributes:
        tracker, scenario, preset, seed, frame: where; in ``tracker``'s place a controller that failed.
        reason: one line. since: what it has done from there on.
    """

    tracker: str
    scenario: str
    preset: str
    seed: int
    frame: int
    reason: str
    since: str = "said nothing"

    def __str__(self) -> str:
        return (
            f"{self.tracker} failed in {self.scenario} {self.preset}, seed {self.seed}, frame {self.frame}: "
            f"{self.reason}; from there on it has {self.since}"
        )


class TrackedEpisode:
    """Feeds one contestant frame by frame and puts what it says on its score sheet.

    Attributes:
        silent_frames: number of frames on which it said nothing.
        reason: why it failed, None if it did not.
        failed_at_frame: first frame on which it failed.
    """

    def __init__(self, contestant: Contestant, sheet: ScoreSheet, limit_s: float) -> None:
        self._contestant = contestant
        self._sheet = sheet
        self._limit_s = limit_s
        self._frames = 0
        self._cpu_s: list[float] = []
        self.silent_frames = 0
        self.reason: str | None = None
        self.failed_at_frame: int | None = None

    def step(self, frame: Frame, first_box_xyxy: NDArray[np.float64]) -> Estimate:
        """Ask for one frame's estimate; on frame 0 the contestant is given the box, which is the estimate
        then.
        """
        if self.failed_at_frame is not None:
            estimate = SILENT
        elif self._frames == 0:
            estimate = self._start(frame, first_box_xyxy)
        else:
            estimate = self._ask(frame)
        self._sheet.keep(frame, estimate)
        self.silent_frames += bool(np.isnan(np.asarray(estimate.position_px, dtype=float)).any())
        self._frames += 1
        return estimate

    def fail(self, reason: str) -> None:
        """Count the contestant as failed from the coming frame on."""
        self.reason, self.failed_at_frame = reason, self._frames

    @property
    def ms_per_frame(self) -> float | None:
        """Mean CPU time of the thread for an update, the first five left out; None if there were no more."""
        timed = self._cpu_s[_UNTIMED_FRAMES:]
        return 1e3 * float(np.mean(timed)) if timed else None

    def scores(self) -> Iterator[Score]:
        """Yield the sheet's scores, then the times."""
        yield from self._sheet.scores(self.failed_at_frame)
        if self.ms_per_frame is not None:
            yield Score("ms_per_frame", self.ms_per_frame)
            yield Score("frames_per_s", 1e3 / max(self.ms_per_frame, 1e-6))
        if self.failed_at_frame is not None:
            yield Score("failed_at_frame", float(self.failed_at_frame))

    def _start(self, frame: Frame, box_xyxy: NDArray[np.float64]) -> Estimate:
        given = Estimate(0.5 * (box_xyxy[:2] + box_xyxy[2:]), box_xyxy=box_xyxy.copy(), in_view_probability=1.0)
        with self._guarded():
            self._contestant.initialise(frame, box_xyxy.copy())
        return given

    def _ask(self, frame: Frame) -> Estimate:
        estimate = SILENT
        with self._guarded() as watch:
            estimate = self._contestant.update(frame)
            self._cpu_s.append(watch.cpu_s)
            check_estimate(estimate)
        return SILENT if self.failed_at_frame is not None else estimate

    @contextmanager
    def _guarded(self) -> Iterator[Stopwatch]:
        try:
            with at_most(self._limit_s) as watch:
                yield watch
        except TooSlow:
            self.fail(f"took longer than {self._limit_s:g} s over one frame")
        except Exception as error:
            self.fail(f"{type(error).__name__}: {error}".splitlines()[0])
