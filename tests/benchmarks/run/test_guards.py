"""An episode continues after any failure of a controller; a tracker's time is all that is spent and waited for."""

from __future__ import annotations

import asyncio
import ctypes
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.judges.tracker_speed import TIMES, times
from benchmarks.run.failures import ENDED_PROCESS
from benchmarks.run.guards import Guard, GuardedController, GuardedTracker
from benchmarks.run.time_limit import Taken, at_most
from scenarios.command_link import CommandLink, Link
from scenarios.loop import FromPictures, Loop
from scenarios.road_town.flight import HELICOPTER
from tests.benchmarks.fake_episode import FakeEpisode, FakeTracker
from trackers.types import CameraCommand, CameraModel, Estimate, Observation

PICTURE = Observation(np.zeros((4, 4, 3), np.uint8), 0.0, CameraModel(4, 4, 4.0))
SOMEWHERE = Estimate(np.zeros(2))


@dataclass
class Scripted:
    """Returns the given commands; raises the given exceptions."""

    answers: list[object]
    asked: list[Estimate] = field(default_factory=list)

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the next answer."""
        self.asked.append(estimate)
        answer = self.answers[len(self.asked) - 1]
        if isinstance(answer, BaseException):
            raise answer
        if answer == "sleeps":
            time.sleep(5.0)
        return answer  # type: ignore[return-value]


AHEAD = CameraCommand(forward_mps=5.0)


class Odd(BaseException):
    """No ``Exception``."""


@pytest.mark.parametrize(
    ("answer", "reason"),
    [
        (RuntimeError("a bug\nin two lines"), "RuntimeError: a bug"),
        (CameraCommand(yaw_rate_rad_s=float("nan")), "ValueError: command: expected finite numbers, got"),
        (None, "TypeError"),
        (SystemExit("bye"), "SystemExit: bye"),
        (asyncio.CancelledError(), "CancelledError: "),
        (Odd("a bug"), "Odd: a bug"),
        ("sleeps", "took longer than 0.2 s over one command"),
    ],
)
def test_one_that_fails_commands_nothing_from_there_on(answer: object, reason: str) -> None:
    controller = Scripted([AHEAD, answer, AHEAD])
    guard = GuardedController(lambda: controller, limit_s=0.02)
    given = [guard.command(PICTURE, SOMEWHERE) for _ in range(3)]
    assert given == [AHEAD, CameraCommand(), CameraCommand()]
    assert len(controller.asked) == 2
    assert guard.failed_at_frame == 2
    assert str(guard.reason).startswith(reason)


def test_who_interrupts_a_run_is_no_failure_of_a_tracker() -> None:
    guard = GuardedController(lambda: Scripted([KeyboardInterrupt()]), limit_s=1.0)
    with pytest.raises(KeyboardInterrupt):
        guard.command(PICTURE, SOMEWHERE)
    assert guard.reason is None


@pytest.mark.parametrize(
    ("create", "reason"),
    [
        (lambda: sys.exit("no weights"), "SystemExit: no weights"),
        (lambda: time.sleep(5.0), "took longer than 0.1 s over one construction"),
    ],
)
@pytest.mark.parametrize("many", [False, True])
def test_one_that_cannot_be_made_fails_on_the_first_frame(create: Any, reason: str, many: bool) -> None:
    notes: list[int] = []
    guard, episode = GuardedTracker(create, 0.01, many=many, note=notes.append), FakeEpisode()
    assert (guard.failed_at_frame, notes) == (0, [0])
    first = guard.initialise(episode.step(), episode.start)
    assert (first == ()) if many else np.isfinite(first.position_px).all()  # type: ignore[union-attr]
    guard.update(episode.step())
    assert (guard.failed_at_frame, str(guard.reason)) == (0, reason)
    guard.close()
    controller = GuardedController(create, 0.01)
    assert controller.command(PICTURE, SOMEWHERE) == CameraCommand()
    assert (controller.failed_at_frame, str(controller.reason)) == (0, reason)
    controller.close()


@pytest.mark.parametrize("many", [False, True])
def test_one_that_ended_its_process_when_it_was_made_is_not_made_again(many: bool) -> None:
    made: list[None] = []
    guards: list[Guard] = [GuardedTracker(lambda: made.append(None), 1.0, many=many, ends_process_at=0)]  # type: ignore[arg-type, return-value]
    guards += [GuardedController(lambda: made.append(None), 1.0, ends_process_at=0)]  # type: ignore[arg-type, return-value]
    assert [(each.failed_at_frame, each.reason) for each in guards] == [(0, ENDED_PROCESS)] * 2
    assert made == []


class Overwrites:
    """Writes past NumPy into what it gets."""

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Overwrite the picture and the position."""
        for array in (observation.image_rgb, estimate.position_px):
            ctypes.memset(array.ctypes.data, 77, array.nbytes)
        return AHEAD


def test_a_controller_that_overwrites_the_picture_fails_and_changes_nothing_of_others() -> None:
    guard = GuardedController(Overwrites, limit_s=60.0)
    assert guard.command(PICTURE, SOMEWHERE) == CameraCommand()
    assert str(guard.reason).startswith("ValueError: observation.image_rgb: expected it as it was given")
    assert not PICTURE.image_rgb.any()
    assert not SOMEWHERE.position_px.any()


@dataclass
class Outside:
    """A tracker whose work is not on its own thread: it sleeps, or another thread computes for it."""

    work: Callable[[], None]

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """Start nothing."""

    def update(self, observation: Observation) -> Estimate:
        """Wait for the work."""
        self.work()
        return SOMEWHERE


def burn(seconds: float) -> None:
    """Keep a core busy for so much of this thread's CPU time."""
    until = time.thread_time() + seconds
    while time.thread_time() < until:
        pass


def in_a_second_thread() -> None:
    """Let another thread burn, and wait for it."""
    helper = threading.Thread(target=burn, args=(0.03,))
    helper.start()
    helper.join()


@pytest.mark.parametrize("work", [lambda: time.sleep(0.03), in_a_second_thread])
def test_one_that_waits_is_no_faster_than_what_it_waits_for(work: Callable[[], None]) -> None:
    guard, episode = GuardedTracker(lambda: FromPictures(Outside(work)), 30.0), FakeEpisode()
    guard.initialise(episode.step(), episode.start)
    for _ in range(8):
        guard.update(episode.step())
    assert guard.reason is None
    told = {score.metric: score.value for score in guard.scores()}
    assert all(isinstance(told[name], float) for name in TIMES)
    assert told["ms_per_frame"] == max(told["cpu_ms_per_frame"], told["wall_ms_per_frame"]) >= 30.0  # type: ignore[operator, type-var]
    assert told["frames_per_s"] <= 1 / 0.03  # type: ignore[operator]


def test_cpu_time_is_that_of_all_threads() -> None:
    """Two threads at a time do twice the work of one; the rate is that of one core."""
    with at_most(30.0) as watch:
        burn(0.02)
        in_a_second_thread()
    assert watch.taken.cpu_s >= 0.05


def test_the_larger_of_both_times_counts_and_a_revision_is_shared_among_frames() -> None:
    taken = [Taken(9.0, 9.0)] * 5 + [Taken(0.010, 0.002), Taken(0.030, 0.004)]
    told = {score.metric: score.value for score in times(taken, Taken(0.1, 1.0), 10)}
    expected = {"cpu_ms_per_frame": 30.0, "wall_ms_per_frame": 103.0, "ms_per_frame": 103.0}
    assert told == pytest.approx(expected | {"frames_per_s": 1e3 / 103.0})
    assert list(times(taken[:5], Taken(0.0, 0.0), 10)) == []


def test_the_link_is_between_controller_and_carrier() -> None:
    episode = FakeEpisode(rate_hz=10.0)
    loop = Loop(episode, [FromPictures(FakeTracker())], CommandLink(HELICOPTER, 10.0, Link(), np.random.default_rng(0)))
    guard = GuardedController(lambda: Scripted([CameraCommand(forward_mps=1e3), RuntimeError()]), limit_s=1.0)
    obeyed = [loop.obeyed for _ in loop.frames(guard, 3)]
    assert obeyed[0] is None
    assert obeyed == episode.commands
    # After a failure nothing is commanded: the carrier comes to rest at its limits.
    forward = HELICOPTER.axes[0]
    speeds = [command.forward_mps for command in obeyed[1:] if command is not None]
    assert speeds == pytest.approx([forward.slew_per_s / 10.0, 0.0])
    assert guard.reason == "RuntimeError: "
