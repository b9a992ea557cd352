"""The one loop through an episode: the camera moves, a picture is taken, every contestant is asked about it.

Benchmark, videos, envs and recorded runs all live through episodes by it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from scenarios.command_link import CommandLink
from scenarios.scenario import Episode, Frame
from sim.rng import generator
from trackers.protocols import Controller, MultiTracker, Tracker
from trackers.types import Answer, CameraCommand, Estimate, Start, Track


class Contestant(Protocol):
    """Answers on every frame where the target is, or all targets are."""

    def initialise(self, frame: Frame, start: Start) -> Answer:
        """Start with what the scenario hands over, and answer on the first frame."""
        ...

    def update(self, frame: Frame) -> Answer:
        """Answer on the next frame."""
        ...


class FromPictures:
    """A tracker of one target as a contestant: it is handed the observation of a frame, and nothing of its truth."""

    def __init__(self, tracker: Tracker) -> None:
        self._tracker = tracker

    def initialise(self, frame: Frame, start: Start) -> Estimate:
        """See ``Contestant``. The box that it is given is the answer."""
        self._tracker.initialise(frame.observation, first_box(start))
        return given(start)

    def update(self, frame: Frame) -> Estimate:
        """See ``Contestant``."""
        return self._tracker.update(frame.observation)


class ManyFromPictures:
    """A tracker of many targets as a contestant, see ``FromPictures``."""

    def __init__(self, tracker: MultiTracker) -> None:
        self._tracker = tracker

    def initialise(self, frame: Frame, start: Start) -> Sequence[Track]:
        """See ``Contestant``. No target is pointed at: the first picture is one like the others."""
        self._tracker.start(start.background, start.camera)
        return self.update(frame)

    def update(self, frame: Frame) -> Sequence[Track]:
        """See ``Contestant``."""
        return self._tracker.update(frame.observation)


def first_box(start: Start) -> NDArray[np.float64]:
    """Return a box (4,) of the target in the first picture to keep. Raises ValueError where none is pointed at."""
    if start.box_xyxy is None:
        raise ValueError("start: expected the box of a target, got none: this scenario points at no target")
    return start.box_xyxy.copy()


def given(start: Start) -> Estimate:
    """Return the answer on the first frame of a tracker that is given the target's box."""
    box_xyxy = first_box(start)
    return Estimate(0.5 * (box_xyxy[:2] + box_xyxy[2:]), box_xyxy=box_xyxy, in_view_probability=1.0)


def tracker_stream(seed: int, name: str, repeat: int = 0) -> np.random.Generator:
    """Return what a tracker of this name draws from in the episode of a seed, wherever that is lived through."""
    return generator(seed, f"tracker/{name}" if repeat == 0 else f"tracker/{name}/{repeat}")


class Loop:
    """One pass through an episode. What a contestant or a controller raises is not caught here.

    Attributes:
        episode: the scenario's own.
        frame: the latest one; like the others, there is none before the first step.
        answers: what each contestant says of it, in their order.
        obeyed: the command as the carrier got it on the way to it; None for frame 0, and on a set path.
    """

    frame: Frame
    answers: list[Answer]
    obeyed: CameraCommand | None

    def __init__(
        self, episode: Episode, contestants: Sequence[Contestant] = (), link: CommandLink | None = None
    ) -> None:
        """``link`` takes commands to the carrier; None takes them there as they are."""
        self.episode = episode
        self._contestants, self._link = contestants, link
        self._begun = False

    def step(self, command: CameraCommand | None = None) -> Frame:
        """Move on by one frame and ask about it. On the way to frame 0, and on a set path, there is no command."""
        self.obeyed = command if command is None or self._link is None else self._link.send(command)
        self.frame = self.episode.step(self.obeyed)
        if self._begun:
            self.answers = [each.update(self.frame) for each in self._contestants]
        else:
            start = self.episode.start
            self.answers = [each.initialise(self.frame, start) for each in self._contestants]
            self._begun = True
        return self.frame

    def frames(self, controller: Controller | None = None, count: int | None = None) -> Iterator[Frame]:
        """Step through the first ``count`` frames, None = all; a controller goes by what the first contestant says."""
        yield self.step()
        for _ in range(1, self.episode.frame_count if count is None else count):
            command = None if controller is None else controller.command(self.frame.observation, self.estimate)
            yield self.step(command)

    @property
    def is_over(self) -> bool:
        """Whether this was the last frame."""
        return self.frame.truth.frame + 1 >= self.episode.frame_count

    @property
    def estimate(self) -> Estimate:
        """What the first contestant, one of one target, says of the latest frame: what a controller steers by."""
        answer = self.answers[0]
        assert isinstance(answer, Estimate)
        return answer
