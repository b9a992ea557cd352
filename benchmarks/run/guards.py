"""Guards of trackers and controllers: after any failure the episode continues and is scored."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator, Sequence
from dataclasses import astuple, replace
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from benchmarks.contract.judging import Ending, Score
from benchmarks.judges.tracker_speed import times
from benchmarks.run.failures import ENDED_PROCESS, reason_of
from benchmarks.run.outcome import AnswerWatch
from benchmarks.run.own_inputs import check_unchanged, own
from benchmarks.run.own_modules import users_line
from benchmarks.run.process_state import ProcessState
from benchmarks.run.time_limit import Stopwatch, Taken, TooSlow, at_most
from scenarios.loop import LoopTracker, ManyLoopTracker, OutsourcingLoopTracker, ReleasedLoopTracker, given
from scenarios.scenario import Frame
from sim.checks import check
from trackers.estimate_check import check_estimate, check_probability, check_tracks
from trackers.gaps import Bridge, GapMethod, Piece, Surroundings, check_bridge
from trackers.protocols import Controller
from trackers.types import Answer, CameraCommand, CameraModel, Estimate, Observation, Start, Track

FAILED_AT = "failed_at_frame"
SILENT = Estimate(position_px=np.full(2, np.nan))
"""Answer of a failed tracker of one target."""
_Made = TypeVar("_Made")


class Guard:
    """Detects failures of a component, which is not called again after one.

    Attributes:
        since: what a failed one does from there on, in words.
        reason: cause of the failure, None without one. error: type of what was raised; None if nothing was.
        failed_at_frame: first frame on which it failed.
        place: file and line of a user's own code that raised; empty if none did.
        oddities: what is odd about it, in words, e.g. what it has left running; known once it is closed.
    """

    since = "answered nothing"

    def __init__(
        self,
        limit_s: float,
        *,
        note: Callable[[int], object] = lambda frame: None,
        ends_process_at: int | None = None,
    ) -> None:
        """``note`` is called before each frame. On frame ``ends_process_at`` an earlier attempt ended its process: the
        component fails there, or on the next frame that it gets, without being called.
        """
        self._limit_s, self._note, self._ends_process_at = limit_s, note, ends_process_at
        self._state, self._watch = ProcessState(), Stopwatch()
        self.reason: str | None = None
        self.error: type[BaseException] | None = None
        self.failed_at_frame: int | None = None
        self.place = ""
        self.oddities: list[str] = []

    def call(
        self, frame: int, answer: str, function: Callable[[], _Made], otherwise: _Made, limit_s: float | None = None
    ) -> _Made:
        """Return what a function answers on a frame, the number of frames for after the last one.

        Args:
            answer: what it makes, in words.
            otherwise: returned if it raises, changes its inputs or takes too long, and after any failure.
            limit_s: None = that of the guard.
        """
        if self.reason is None and self._ends_process_at is not None and frame >= self._ends_process_at:
            self.reason, self.failed_at_frame = ENDED_PROCESS, frame
        self._note(frame)
        if self.reason is not None:
            return otherwise
        try:
            with self._state.applied(), at_most(limit_s or self._limit_s) as self._watch:
                return function()
        except TooSlow as slow:
            self.reason = f"took longer than {slow} over one {answer}"
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            self.reason, self.error, line = reason_of(error), type(error), users_line(error)
            self.place = f"{Path(line[0]).name}, line {line[1]}" if line else ""
        self.failed_at_frame = frame
        return otherwise

    def close(self) -> None:
        """Drop the component and end the processes that it has left running; call once, last of all."""
        self.oddities = self._state.close()


class GuardedTracker(Guard):
    """A guarded and timed tracker, see ``scenarios.loop.Tracker``; after a failure it gives no answers.

    One of many targets may also revise its answers at the end, and offer a method to bridge gaps.

    Attributes:
        silent_frames: number of frames without an answer about its one target.
        taken: frame, from 1 on → time of the update that gave an answer; its CPU time with that of other processes, as
            reported by the tracker. took: time of the latest start or update. revision: of the revision at the end.
        decides_at: see ``Ending``.
        gap_method: as it is before the first picture: gaps are cut out of what follows. None if there is none.
    """

    def __init__(
        self,
        create: Callable[[], LoopTracker],
        limit_s: float,
        *,
        many: bool = False,
        needs_depth: bool = False,
        timed: bool = True,
        start_limit_s: float | None = None,
        **how: Any,
    ) -> None:
        """``create`` makes it, in ``start_limit_s``, None = as for a frame. ``needs_depth``: see ``AnswerWatch``.
        ``timed``: whether times are scored. ``how``: see ``Guard``.
        """
        super().__init__(limit_s, **how)
        self._many, self._follows, self._timed = many, not many, timed
        self._silence: Answer = () if many else SILENT
        self._check: Callable[[Any, CameraModel], Answer] = check_tracks if many else check_estimate
        self._frames, self.silent_frames, self._answers = 0, 0, AnswerWatch(needs_depth)
        self.taken: dict[int, Taken] = {}
        self.took = self.revision = Taken(0.0, 0.0)
        self.decides_at = 0.0
        self.gap_method: GapMethod | None = None
        self._tracker: LoopTracker | None = self.call(0, "construction", create, None, limit_s=start_limit_s)
        if isinstance(tracker := self._tracker, ManyLoopTracker) and many:
            self.decides_at = self.call(0, "threshold", lambda: _threshold(tracker), 0.0)
            self.gap_method = self.call(0, "gap method", lambda: copy.deepcopy(tracker.gap_method()), None)

    def initialise(self, frame: Frame, start: Start) -> Answer:
        """See ``LoopTracker``. A given box is kept as the answer if the tracker fails on it."""
        its_start = own(start)

        def begun(tracker: LoopTracker, its_frame: Frame) -> Answer:
            answer = tracker.initialise(its_frame, its_start)
            self.took = self._watch.taken
            check_unchanged(start, its_start, "start")
            return answer

        return self._answered(frame, begun, self.before(start))

    def before(self, start: Start) -> Answer:
        """Return what is known before the tracker has started: a given box, or nothing."""
        return self._silence if self._many or start.box_xyxy is None else given(start)

    def update(self, frame: Frame) -> Answer:
        """See ``LoopTracker``."""
        answer = self._answered(frame, self._updated, self._silence)
        if self.reason is None:
            self.taken[frame.truth.frame] = self.took
        return self.watched(frame, answer)

    def watched(self, frame: Frame, answer: Answer) -> Answer:
        """Return an answer on a frame, after a look at whether it is one."""
        self._answers.see(frame, answer)
        if isinstance(answer, Estimate):
            self.silent_frames += bool(np.isnan(answer.position_px).any())
        self._follows = self._follows or bool(answer)
        return answer

    def _updated(self, tracker: LoopTracker, frame: Frame) -> Answer:
        answer = tracker.update(frame)
        self.took = self._with_elsewhere(self._watch.taken)
        return answer

    def _with_elsewhere(self, taken: Taken) -> Taken:
        elsewhere = isinstance(self._tracker, OutsourcingLoopTracker) and self._tracker.elsewhere_cpu_s()
        return taken._replace(cpu_s=taken.cpu_s + elsewhere)

    def _answered(self, frame: Frame, answer: Callable[[LoopTracker, Frame], Answer], otherwise: Answer) -> Answer:
        """Return a checked answer to a frame with an observation of the tracker's own."""
        self._frames = frame.truth.frame + 1
        its_frame = frame if self.reason else replace(frame, observation=own(frame.observation))

        def checked() -> Answer:
            assert self._tracker is not None
            made = self._check(answer(self._tracker, its_frame), frame.observation.camera)
            check_unchanged(frame.observation, its_frame.observation, "observation")
            return made

        return self.call(frame.truth.frame, "frame", checked, otherwise)

    def ending(self) -> Ending:
        """Return what is known of the tracker after the last frame; call once. It revises its answers here."""
        revised = self.call(self._frames, "revision", self._revised, None) if self.revises() else None
        self._follows = self._follows or any(revised or ())
        if self.gap_method is None or self.reason is not None:
            return Ending(self.failed_at_frame, revised, decides_at=self.decides_at)
        bridges = partial(GuardedGapMethod, self.gap_method, self, max(self._frames, 1))
        return Ending(self.failed_at_frame, revised, bridges, self.decides_at)

    def revises(self) -> bool:
        """Return whether it may revise its answers. On tracks there are no frames: nothing was answered."""
        return self._many and self._frames > 0

    def _revised(self) -> Sequence[Sequence[Track]] | None:
        revised = self._tracker.revised() if isinstance(self._tracker, ManyLoopTracker) else None
        if revised is None:
            return None
        self.revision = self._with_elsewhere(self._watch.taken)
        check("revised", isinstance(revised, Sequence), "a sequence of answers", type(revised).__name__)
        wanted = f"an answer on each of {self._frames} pictures"
        check("revised", len(revised) == self._frames, wanted, len(revised))
        return [check_tracks(tracks) for tracks in revised]

    def scores(self) -> Iterator[Score]:
        """Yield the times per frame, see ``tracker_speed.times``, and the frame of failure.

        One that follows nothing, and bridges gaps alone, has no times.
        """
        if self._follows and self._timed:
            yield from times([*self.taken.values()], self.revision, self._frames)
        if self.failed_at_frame is not None:
            yield Score(FAILED_AT, float(self.failed_at_frame))

    def close(self) -> None:
        """See ``Guard``."""
        held = self._tracker.release(self.reason is None) if isinstance(self._tracker, ReleasedLoopTracker) else []
        self._tracker = self.gap_method = None
        super().close()
        self.oddities += held + self._answers.in_words()


def _threshold(tracker: ManyLoopTracker) -> float:
    check_probability("decides_at", decides_at := tracker.decides_at())
    return decides_at


class GuardedGapMethod:
    """A guarded ``GapMethod``: after a failure of its tracker it predicts NaN."""

    def __init__(self, method: GapMethod, guard: Guard, frame: int) -> None:
        """``method`` is copied, so that what it learns ends with this object. ``frame``: on which a failure counts."""
        self._guard, self._frame = guard, frame
        self._method = guard.call(frame, "copy", lambda: copy.deepcopy(method), method)

    def learn(self, pieces: Sequence[Piece]) -> None:
        """See ``GapMethod``."""
        self._guard.call(self._frame, "lesson", lambda: self._method.learn(own(pieces)), None)

    def extrapolate(self, past: Piece, count: int, around: Surroundings) -> Bridge | None:
        """See ``GapMethod``."""
        return self._bridge(lambda: self._method.extrapolate(own(past), count, own(around)), count)

    def interpolate(self, past: Piece, future: Piece, around: Surroundings) -> Bridge | None:
        """See ``GapMethod``."""
        count = future.first_frame - past.end_frame
        return self._bridge(lambda: self._method.interpolate(own(past), own(future), own(around)), count)

    def _bridge(self, bridged: Callable[[], Bridge | None], count: int) -> Bridge | None:
        def checked() -> Bridge | None:
            bridge = bridged()
            return None if bridge is None else check_bridge(bridge, count)

        silent: Bridge | None = Bridge(np.full((count, 2), np.nan))
        return self._guard.call(self._frame, "gap", checked, silent)


class GuardedController(Guard):
    """A guarded controller; after a failure it commands nothing, from the frame that its command should lead to."""

    since = "commanded nothing"

    def __init__(self, create: Callable[[], Controller], limit_s: float, **how: Any) -> None:
        """``create`` makes it. ``how``: see ``Guard``."""
        super().__init__(limit_s, **how)
        self._controller: Controller | None = self.call(0, "construction", create, None)
        self._frame = 0

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """See ``Controller``."""
        self._frame += 1

        def commanded() -> CameraCommand:
            assert self._controller is not None
            its_observation = own(observation)
            wanted = self._controller.command(its_observation, own(estimate))
            check_unchanged(observation, its_observation, "observation")
            check("command", bool(np.isfinite(astuple(wanted)).all()), "finite numbers", wanted)
            return wanted

        return self.call(self._frame, "command", commanded, CameraCommand())

    def close(self) -> None:
        """See ``Guard``."""
        self._controller = None
        super().close()
