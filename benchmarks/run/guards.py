"""Guards of contestants and controllers: after any failure the episode continues and is scored."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import astuple, replace
from functools import partial
from typing import Any, TypeVar, cast

import numpy as np

from benchmarks.contract.judging import Ending, Score
from benchmarks.run.failures import ENDED_PROCESS, place_of, reason_of
from benchmarks.run.oddities import AnswerWatch
from benchmarks.run.own_inputs import check_unchanged, own
from benchmarks.run.process_state import ProcessState
from benchmarks.run.time_limit import Stopwatch, Taken, TooSlow, at_most
from scenarios.loop import Contestant, ManyContestant, OutsourcingContestant, given
from scenarios.scenario import Frame
from trackers.estimate_check import check_estimate, check_probability, check_tracks
from trackers.gaps import Bridge, GapMethod, Piece, Surroundings, check_bridge
from trackers.protocols import Controller
from trackers.types import Answer, CameraCommand, Estimate, Observation, Start, Track

_UNTIMED_FRAMES = 5
"""The first updates load compiled code from disk and are left out of the timing."""

FAILED_AT = "failed_at_frame"
MS_PER_FRAME = "ms_per_frame"

SILENT = Estimate(position_px=np.full(2, np.nan))
"""Answer of a failed contestant of one target."""
_Made = TypeVar("_Made")


class Guard:
    """Detects failures of a component, which is not called again after one.

    Attributes:
        reason: cause of the failure, None without one. error: type of what was raised; None if nothing was.
        failed_at_frame: first frame on which it failed.
        place: file and line of a user's own code that raised; empty if none did.
        left: what it has left running, in words, see ``ProcessState``; known once it is closed.
    """

    place = ""
    left: Sequence[str] = ()

    def __init__(
        self,
        limit_s: float,
        answer: str,
        *,
        note: Callable[[int], None] = lambda frame: None,
        ends_process_at: int | None = None,
    ) -> None:
        """``note`` is called before each frame. On frame ``ends_process_at`` an earlier attempt ended its process: the
        component fails there without being called.
        """
        self._limit_s, self._answer = limit_s, answer
        self._note, self._ends_process_at = note, ends_process_at
        self._state = ProcessState()
        self.reason: str | None = None
        self.error: type[BaseException] | None = None
        self.failed_at_frame: int | None = None

    def fail(self, frame: int, reason: str) -> None:
        """Count it as failed from a frame on."""
        self.reason, self.failed_at_frame = reason, frame

    def begins(self, frame: int) -> bool:
        """Note that it runs on a frame, the number of frames for after the last one; return whether it may."""
        if frame == self._ends_process_at:
            self.fail(frame, ENDED_PROCESS)
        self._note(frame)
        return self.reason is None

    def made(self, create: Callable[[], _Made]) -> _Made | None:
        """Return what a function makes before frame 0; None if that fails, or has ended the process before."""
        if self.begins(0):
            with self.guarded(0, "construction"):
                return create()
        return None

    def close(self) -> None:
        """Drop it and end the processes that it has left running; call once, last of all."""
        self.left = self._state.close()

    @contextmanager
    def guarded(self, frame: int, answer: str = "") -> Iterator[Stopwatch]:
        """Catch failures and time-outs of the code in this context, which gives an ``answer`` for a frame."""
        try:
            with self._state.applied(), at_most(self._limit_s) as watch:
                yield watch
        except TooSlow as slow:
            self.fail(frame, f"took longer than {slow} over one {answer or self._answer}")
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            self.place, self.error = place_of(error), type(error)
            self.fail(frame, reason_of(error))


class GuardedContestant(Guard):
    """A guarded and timed contestant; after a failure it gives no answers.

    Attributes:
        silent_frames: number of frames without an answer about its one target. watch: counts odd answers.
        taken: time of each update that gave an answer, from frame 1 on; its CPU time with that of other processes, as
            told by the tracker. revision: time of the revision at the end.
        decides_at: see ``Ending``.
    """

    def __init__(
        self, create: Callable[[], Contestant], limit_s: float, *, needs_depth: bool = False, **how: Any
    ) -> None:
        """``create`` makes it. ``needs_depth``: see ``AnswerWatch``. ``how``: see ``Guard``."""
        super().__init__(limit_s, "frame", **how)
        self._silence: Answer = SILENT
        self._check: Callable[[Any], Answer] = check_estimate
        self.taken: list[Taken] = []
        self._frames, self.revision = 0, Taken(0.0, 0.0)
        self.silent_frames, self.watch = 0, AnswerWatch(needs_depth)
        self.decides_at = 0.0
        contestant = self.made(create)
        if contestant is not None:
            self._contestant = contestant

    def initialise(self, frame: Frame, start: Start) -> Answer:
        """See ``Contestant``. A given box is kept as the answer if the contestant fails on it."""
        k, given_box = frame.truth.frame, self._silence is SILENT and start.box_xyxy is not None
        answer = fallback = given(start) if given_box else self._silence
        if self._runs_on(k):
            its_frame, its_start = _own(frame), own(start)
            with self.guarded(k):
                answer = self._check(self._contestant.initialise(its_frame, its_start))
                check_unchanged(start, its_start, "start")
                _check_unchanged(frame, its_frame)
        return answer if self.reason is None else fallback

    def update(self, frame: Frame) -> Answer:
        """See ``Contestant``."""
        k, answer = frame.truth.frame, self._silence
        if self._runs_on(k):
            its_frame = _own(frame)
            with self.guarded(k) as watch:
                answered = self._contestant.update(its_frame)
                taken = watch.taken
                self.taken.append(taken._replace(cpu_s=taken.cpu_s + self._elsewhere_cpu_s()))
                answer = self._check(answered)
                _check_unchanged(frame, its_frame)
        answer = answer if self.reason is None else self._silence
        self.watch.see(frame, answer)
        if isinstance(answer, Estimate):
            self.silent_frames += bool(np.isnan(answer.position_px).any())
        return answer

    def scores(self) -> Iterator[Score]:
        """Yield the times per frame, see ``times``, and the frame of failure."""
        yield from times(self.taken, self.revision, self._frames)
        if self.failed_at_frame is not None:
            yield Score(FAILED_AT, float(self.failed_at_frame))

    def ending(self) -> Ending:
        """Return what is known of the contestant after the last frame."""
        return Ending(self.failed_at_frame)

    def close(self) -> None:
        """See ``Guard``."""
        vars(self).pop("_contestant", None)
        super().close()

    def _elsewhere_cpu_s(self) -> float:
        each = self._contestant
        return each.elsewhere_cpu_s() if isinstance(each, OutsourcingContestant) else 0.0

    def _runs_on(self, frame: int) -> bool:
        self._frames = frame + 1
        return self.begins(frame)


def _own(frame: Frame) -> Frame:
    """Return a frame with an observation of the contestant's own. Trackers get nothing of its truth."""
    return replace(frame, observation=own(frame.observation))


def _check_unchanged(frame: Frame, its_frame: Frame) -> None:
    check_unchanged(frame.observation, its_frame.observation, "observation")


def times(taken: Sequence[Taken], revision: Taken, frame_count: int) -> Iterator[Score]:
    """Yield CPU time and wall time per frame, the larger of the two, ``ms_per_frame``, and ``frames_per_s``, 1,000 over
    it; nothing if there were too few updates.

    Each is the mean per update, without the first five, and a frame's share of a revision at the end. CPU time is that
    of all threads of the process and, as told by the tracker, of other processes and of results that it shares with
    other trackers; so one that computes in parallel gains nothing. Wall time holds what one waits for: a device, a
    process, a sleep. The time in which the thread waited for a core that others held is left out on Linux. Elsewhere,
    where the host of a virtual machine is loaded, and where what it waits for had to wait for a core, a loaded machine
    makes a tracker look slow: on one of 2 cores with 25 busy processes wall time was 3 times CPU time.
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


class GuardedMany(GuardedContestant):
    """See ``GuardedContestant``. This one answers with tracks of many targets, and may revise them at the end."""

    _contestant: ManyContestant

    def __init__(self, create: Callable[[], ManyContestant], limit_s: float, **how: Any) -> None:
        """See ``GuardedContestant``."""
        super().__init__(create, limit_s, **how)
        self._silence, self._check = (), check_tracks
        self._follows = False
        self._gap_method: GapMethod | None = None

    def initialise(self, frame: Frame, start: Start) -> Answer:
        """See ``Contestant``. The gap method is copied before the first picture: gaps are cut out of what follows."""
        k = frame.truth.frame
        if self.begins(k):
            with self.guarded(k, "threshold"):
                check_probability("decides_at", decides_at := self._contestant.decides_at())
                self.decides_at = decides_at
        if self.reason is None:
            with self.guarded(k, "gap method"):
                self._gap_method = copy.deepcopy(self._contestant.gap_method())
        return super().initialise(frame, start)

    def close(self) -> None:
        """See ``Guard``."""
        self._gap_method = None
        super().close()

    def update(self, frame: Frame) -> Answer:
        """See ``Contestant``."""
        answer = super().update(frame)
        self._follows = self._follows or bool(answer)
        return answer

    def scores(self) -> Iterator[Score]:
        """See ``GuardedContestant``. One that follows nothing, and bridges gaps alone, has no times."""
        return (score for score in super().scores() if self._follows or score.metric == FAILED_AT)

    def ending(self) -> Ending:
        """Return what is known of the contestant after the last frame; call once. It revises its answers here."""
        revised, method = self._revised(), self._gap_method
        self._follows = self._follows or any(revised or ())
        if method is None or self.reason is not None:
            return Ending(self.failed_at_frame, revised, decides_at=self.decides_at)
        bridges = partial(GuardedGapMethod, method, self, self._frames)
        return Ending(self.failed_at_frame, revised, bridges, self.decides_at)

    def _revised(self) -> Sequence[Sequence[Track]] | None:
        revised = None
        if self.begins(self._frames):
            with self.guarded(self._frames, "revision") as watch:
                revised = self._contestant.revised()
                if revised is not None:
                    self.revision = watch.taken
                    revised = _check_revised(revised, self._frames)
        return revised if self.reason is None else None


def guarded(create: Callable[[], Contestant], limit_s: float, *, many: bool = False, **how: Any) -> GuardedContestant:
    """Return a guarded contestant of one target or of ``many``; the rest: see ``GuardedContestant``."""
    if many:
        return GuardedMany(cast("Callable[[], ManyContestant]", create), limit_s, **how)
    return GuardedContestant(create, limit_s, **how)


def _check_revised(revised: Sequence[Sequence[Track]], frame_count: int) -> Sequence[Sequence[Track]]:
    if not isinstance(revised, Sequence):
        raise ValueError(f"revised: expected a sequence of answers, got {type(revised).__name__}")
    if len(revised) != frame_count:
        raise ValueError(f"revised: expected an answer on each of {frame_count} pictures, got {len(revised)}")
    return [check_tracks(tracks) for tracks in revised]


class GuardedGapMethod:
    """A guarded ``GapMethod``: after a failure of its contestant it predicts NaN."""

    def __init__(self, method: GapMethod, guard: Guard, frame: int) -> None:
        """``method`` is copied, so that what it learns ends with this object. ``frame``: on which a failure counts."""
        self._guard, self._frame = guard, frame
        if guard.reason is None:
            with guard.guarded(frame, "copy"):
                self._method = copy.deepcopy(method)

    def learn(self, pieces: Sequence[Piece]) -> None:
        """See ``GapMethod``."""
        if self._guard.reason is None:
            with self._guard.guarded(self._frame, "lesson"):
                self._method.learn(own(pieces))

    def extrapolate(self, past: Piece, count: int, around: Surroundings) -> Bridge | None:
        """See ``GapMethod``."""
        return self._bridge(lambda: self._method.extrapolate(own(past), count, own(around)), count)

    def interpolate(self, past: Piece, future: Piece, around: Surroundings) -> Bridge | None:
        """See ``GapMethod``."""
        count = future.first_frame - past.end_frame
        return self._bridge(lambda: self._method.interpolate(own(past), own(future), own(around)), count)

    def _bridge(self, bridged: Callable[[], Bridge | None], count: int) -> Bridge | None:
        bridge = None
        if self._guard.reason is None:
            with self._guard.guarded(self._frame, "gap"):
                bridge = bridged()
                if bridge is not None:
                    bridge = check_bridge(bridge, count)
        return bridge if self._guard.reason is None else Bridge(np.full((count, 2), np.nan))


class GuardedController(Guard):
    """A guarded controller; after a failure it commands nothing, from the frame that its command should lead to."""

    def __init__(self, create: Callable[[], Controller], limit_s: float, **how: Any) -> None:
        """``create`` makes it. ``how``: see ``Guard``."""
        super().__init__(limit_s, "command", **how)
        self._controller = self.made(create)
        self._frame = 0

    def close(self) -> None:
        """See ``Guard``."""
        self._controller = None
        super().close()

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """See ``Controller``."""
        self._frame += 1
        wanted = CameraCommand()
        if self.begins(self._frame) and self._controller is not None:
            its_observation, its_estimate = own(observation), own(estimate)
            with self.guarded(self._frame):
                wanted = self._controller.command(its_observation, its_estimate)
                check_unchanged(observation, its_observation, "observation")
                if not np.isfinite(astuple(wanted)).all():
                    raise ValueError(f"command: expected finite numbers, got {wanted}")
        return wanted if self.reason is None else CameraCommand()
