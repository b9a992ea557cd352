"""One contestant through one episode, guarded: whatever it does, the episode goes on and is scored."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.contestants import Contestant
from benchmarks.estimate_check import check_estimate
from benchmarks.metrics import posterior
from benchmarks.metrics.series import EstimateSeries, estimated_box
from benchmarks.time_limit import Stopwatch, TooSlow, at_most
from scenarios.scenario import Frame
from sim.optics import intersect_plane
from trackers.types import Estimate

_UNTIMED_FRAMES = 5
"""The first updates load compiled code from disk and are left out of the timing."""

SILENT = Estimate(position_px=np.full(2, np.nan))


@dataclass(frozen=True, slots=True)
class Failure:
    """Where and how a tracker failed.

    Attributes:
        tracker, scenario, preset, seed, frame: where.
        reason: one line.
    """

    tracker: str
    scenario: str
    preset: str
    seed: int
    frame: int
    reason: str

    def __str__(self) -> str:
        return (
            f"{self.tracker} failed in {self.scenario} {self.preset}, seed {self.seed}, frame {self.frame}: "
            f"{self.reason}; the rest of the episode counts as its worst score"
        )


class TrackedEpisode:
    """Feeds one contestant frame by frame and keeps what it says.

    Attributes:
        reason: why it failed, None if it did not.
        failed_at_frame: first frame on which it failed.
    """

    def __init__(self, contestant: Contestant, limit_s: float) -> None:
        self._contestant = contestant
        self._limit_s = limit_s
        self._first_box = np.full(4, np.nan)
        self._said: list[Estimate] = []
        self._position_m: list[NDArray[np.float64]] = []
        self._calibrations: list[posterior.Calibration] = []
        self._cpu_s: list[float] = []
        self.reason: str | None = None
        self.failed_at_frame: int | None = None

    def step(self, frame: Frame, first_box_xyxy: NDArray[np.float64]) -> Estimate:
        """Ask for one frame's estimate; on frame 0 the contestant is given the box, which is the estimate
        then.
        """
        if self.failed_at_frame is not None:
            estimate = SILENT
        elif not self._said:
            estimate = self._start(frame, first_box_xyxy)
        else:
            estimate = self._ask(frame)
        self._keep(frame, estimate)
        return estimate

    def fail(self, reason: str) -> None:
        """Count the contestant as failed from the coming frame on."""
        self.reason, self.failed_at_frame = reason, len(self._said)

    @property
    def latest(self) -> Estimate:
        """The estimate of the latest frame, without its posterior."""
        return self._said[-1]

    @property
    def silent_frames(self) -> int:
        """Number of frames on which it said nothing."""
        return sum(bool(np.isnan(np.asarray(e.position_px, dtype=float)).any()) for e in self._said)

    @property
    def ms_per_frame(self) -> float | None:
        """Mean CPU time of the thread for an update, the first five left out; None if there were no more."""
        timed = self._cpu_s[_UNTIMED_FRAMES:]
        return 1e3 * float(np.mean(timed)) if timed else None

    def series(self) -> EstimateSeries:
        """Return everything said so far as arrays."""
        return EstimateSeries(
            position_px=np.array([np.asarray(e.position_px, dtype=float) for e in self._said]),
            position_m=np.array(self._position_m),
            box_xyxy=np.array([estimated_box(e, self._first_box) for e in self._said]),
            in_view_probability=np.array([_or_nan(e.in_view_probability) for e in self._said]),
            credible_level=np.array([c.credible_level for c in self._calibrations]),
            nees=np.array([c.nees for c in self._calibrations]),
        )

    def _start(self, frame: Frame, box_xyxy: NDArray[np.float64]) -> Estimate:
        self._first_box = box_xyxy
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

    def _keep(self, frame: Frame, estimate: Estimate) -> None:
        camera, truth = frame.camera, frame.truth
        target = truth.target
        height_m = float(truth.T_world_object[target, 2, 3] + 0.5 * truth.size_m[target, 2])
        position = np.asarray(estimate.position_px, dtype=float)
        self._said.append(_without_posterior(estimate))
        self._position_m.append(intersect_plane(camera, truth.T_world_camera, position, height_m))
        outside = truth.state == "out"
        self._calibrations.append(posterior.calibration(estimate, truth, camera) if outside else posterior.NO_POSTERIOR)


def _without_posterior(estimate: Estimate) -> Estimate:
    """Return an estimate without its particles, which are judged at once and would fill the memory."""
    return Estimate(estimate.position_px, box_xyxy=estimate.box_xyxy, in_view_probability=estimate.in_view_probability)


def _or_nan(value: float | None) -> float:
    return float("nan") if value is None else float(value)
