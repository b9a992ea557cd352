"""The loop through an episode: the camera moves, takes a picture, and every tracker answers on it.

Benchmark, videos, envs and recorded runs all use this loop.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from scenarios.command_link import CommandLink
from scenarios.scenario import Episode, Frame
from sim.rng import generator
from trackers.gaps import GapMethod
from trackers.protocols import (
    BridgingTracker,
    Controller,
    DecidingTracker,
    MultiTracker,
    OutsourcingTracker,
    RevisingTracker,
    Tracker,
    begin,
)
from trackers.types import Answer, CameraCommand, Estimate, Start, Track


class LoopTracker(Protocol):
    """Answers on every frame where the target is, or where all targets are."""

    def initialise(self, frame: Frame, start: Start) -> Answer:
        """Start from the scenario's ``Start``, and answer on the first frame."""
        ...

    def update(self, frame: Frame) -> Answer:
        """Answer on the next frame."""
        ...


@runtime_checkable
class OutsourcingLoopTracker(LoopTracker, Protocol):
    """A tracker that others may work for, see ``OutsourcingTracker``."""

    def elsewhere_cpu_s(self) -> float:
        """Return the CPU time in seconds that they spent for it on the latest frame; 0 without them."""
        ...


@runtime_checkable
class ReleasedLoopTracker(LoopTracker, Protocol):
    """A tracker that holds a process."""

    def release(self, whole: bool) -> list[str]:
        """Give it back after the last frame, and return what is odd about it, in words.

        Args:
            whole: whether all went well.
        """
        ...


@runtime_checkable
class ManyLoopTracker(LoopTracker, Protocol):
    """A tracker that answers with the tracks of many targets."""

    def revised(self) -> Sequence[Sequence[Track]] | None:
        """Return all answers as decided with hindsight, after the last frame; None if it does not revise."""
        ...

    def gap_method(self) -> GapMethod | None:
        """Return its method to bridge gaps, if it offers one."""
        ...

    def decides_at(self) -> float:
        """Return the confidence from which on its tracks are its decision; 0 if all that it answers are."""
        ...


class FromPictures:
    """Gives a ``Tracker`` of one target the observation of each frame, never its truth; see ``LoopTracker``."""

    def __init__(self, tracker: Tracker) -> None:
        self._tracker = tracker

    def initialise(self, frame: Frame, start: Start) -> Estimate:
        """See ``LoopTracker``. The answer is the given box."""
        self._tracker.initialise(frame.observation, first_box(start))
        return given(start)

    def update(self, frame: Frame) -> Estimate:
        """See ``LoopTracker``."""
        return self._tracker.update(frame.observation)

    def elsewhere_cpu_s(self) -> float:
        """See ``OutsourcingLoopTracker``."""
        return _elsewhere_cpu_s(self._tracker)


class ManyFromPictures:
    """The same for a ``MultiTracker``, whose tracks are the answer."""

    def __init__(self, tracker: MultiTracker) -> None:
        self._tracker = tracker

    def initialise(self, frame: Frame, start: Start) -> Sequence[Track]:
        """See ``LoopTracker``. No target is given: the first picture is treated like the others."""
        begin(self._tracker, start)
        return self.update(frame)

    def update(self, frame: Frame) -> Sequence[Track]:
        """See ``LoopTracker``."""
        return self._tracker.update(frame.observation)

    def revised(self) -> Sequence[Sequence[Track]] | None:
        """See ``ManyLoopTracker``."""
        return self._tracker.revised() if isinstance(self._tracker, RevisingTracker) else None

    def gap_method(self) -> GapMethod | None:
        """See ``ManyLoopTracker``."""
        return self._tracker.gap_method if isinstance(self._tracker, BridgingTracker) else None

    def decides_at(self) -> float:
        """See ``ManyLoopTracker``."""
        return self._tracker.decides_at if isinstance(self._tracker, DecidingTracker) else 0.0

    def elsewhere_cpu_s(self) -> float:
        """See ``OutsourcingLoopTracker``."""
        return _elsewhere_cpu_s(self._tracker)


def _elsewhere_cpu_s(tracker: Tracker | MultiTracker) -> float:
    return tracker.elsewhere_cpu_s if isinstance(tracker, OutsourcingTracker) else 0.0


def first_box(start: Start) -> NDArray[np.float64]:
    """Return a copy of the target's box (4,) in the first picture. Raises ValueError if ``start`` has none."""
    if start.box_xyxy is None:
        raise ValueError("start: expected the box of a target, got none: this scenario gives no target")
    return start.box_xyxy.copy()


def given(start: Start) -> Estimate:
    """Return a tracker's answer on the first frame: the target's box that it was given."""
    box_xyxy = first_box(start)
    return Estimate(0.5 * (box_xyxy[:2] + box_xyxy[2:]), box_xyxy=box_xyxy, in_view_probability=1.0)


def tracker_stream(seed: int, name: str, repeat: int = 0) -> np.random.Generator:
    """Return the random stream of the tracker ``name`` in an episode; it is the same for every caller."""
    return generator(seed, f"tracker/{name}" if repeat == 0 else f"tracker/{name}/{repeat}")


class Loop:
    """One pass through an episode. Exceptions of trackers and controllers are not caught here.

    Attributes:
        episode: the episode.
        frame: the latest frame; this and the next three do not exist before the first step.
        seen: the frame whose picture has arrived, ``frame`` unless pictures are late: trackers and controllers see it.
        answers: each tracker's answer on ``seen``, in their order.
        obeyed: the command that the carrier received before ``frame``; None for frame 0, and on a set path.
    """

    frame: Frame
    seen: Frame
    answers: list[Answer]
    obeyed: CameraCommand | None

    def __init__(
        self,
        episode: Episode,
        trackers: Sequence[LoopTracker] = (),
        link: CommandLink | None = None,
        picture_delay_frames: int = 0,
    ) -> None:
        """Args:
        link: passes commands on to the carrier; None passes them on unchanged.
        picture_delay_frames: see ``Link``.
        """
        self.episode = episode
        self._trackers, self._link = trackers, link
        # The latest pictures, the one that has arrived first.
        self._sent: deque[Frame] = deque(maxlen=picture_delay_frames + 1)

    def step(self, command: CameraCommand | None = None) -> Frame:
        """Advance by one frame and collect the answers. ``command`` is None before frame 0 and on a set path."""
        self.obeyed = command if command is None or self._link is None else self._link.send(command)
        self.frame = self.episode.step(self.obeyed)
        begins, arrives = not self._sent, len(self._sent) == self._sent.maxlen
        self._sent.append(self.frame)
        self.seen = self._sent[0]
        if begins and self._trackers:
            # It may render hundreds of pictures of the background.
            start = self.episode.start
            self.answers = [each.initialise(self.seen, start) for each in self._trackers]
        elif begins or arrives:
            self.answers = [each.update(self.seen) for each in self._trackers]
        return self.frame

    def frames(self, controller: Controller | None = None, count: int | None = None) -> Iterator[Frame]:
        """Step through the first ``count`` frames, None = all; the controller uses the first tracker's estimates."""
        yield self.step()
        for _ in range(1, self.episode.frame_count if count is None else count):
            command = None if controller is None else controller.command(self.seen.observation, self.estimate)
            yield self.step(command)

    @property
    def is_over(self) -> bool:
        """Whether the latest frame is the last one."""
        return self.frame.truth.frame + 1 >= self.episode.frame_count

    @property
    def estimate(self) -> Estimate:
        """The first tracker's estimate on ``seen``, which a controller steers by; NaN without a tracker."""
        answer = self.answers[0] if self.answers else Estimate(np.full(2, np.nan))
        assert isinstance(answer, Estimate)
        return answer
