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
from trackers.protocols import Controller, Tracker
from trackers.types import CameraCommand, Estimate


class Contestant(Protocol):
    """One that is asked at every frame where the target is."""

    def initialise(self, frame: Frame, box_xyxy: NDArray[np.float64]) -> None:
        """Start on the target inside ``box_xyxy`` (4,) of the first frame."""
        ...

    def update(self, frame: Frame) -> Estimate:
        """Say where the target is on the next frame."""
        ...


class FromPictures:
    """A tracker as a contestant: it is handed the observation of a frame, and nothing of its truth."""

    def __init__(self, tracker: Tracker) -> None:
        self._tracker = tracker

    def initialise(self, frame: Frame, box_xyxy: NDArray[np.float64]) -> None:
        """See ``Contestant``."""
        self._tracker.initialise(frame.observation, box_xyxy)

    def update(self, frame: Frame) -> Estimate:
        """See ``Contestant``."""
        return self._tracker.update(frame.observation)


def tracker_stream(seed: int, name: str, repeat: int = 0) -> np.random.Generator:
    """Return what a tracker of this name draws from in the episode of a seed, wherever that is lived through."""
    return generator(seed, f"tracker/{name}" if repeat == 0 else f"tracker/{name}/{repeat}")


class Loop:
    """One pass through an episode. What a contestant or a controller raises is not caught here.

    Attributes:
        episode: the scenario's own.
        frame: the latest one; like the others, there is none before the first step.
        estimates: what each contestant says of it, in their order.
        obeyed: the command as the carrier got it on the way to it; None for frame 0, and on a set path.
    """

    frame: Frame
    estimates: list[Estimate]
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
        ask = self._update if self._begun else self._start
        self.estimates = [ask(each) for each in self._contestants]
        self._begun = True
        return self.frame

    def frames(self, controller: Controller | None = None, count: int | None = None) -> Iterator[Frame]:
        """Step through the first ``count`` frames, None = all; a controller goes by what the first contestant says."""
        yield self.step()
        for _ in range(1, self.episode.frame_count if count is None else count):
            command = None if controller is None else controller.command(self.frame.observation, self.estimates[0])
            yield self.step(command)

    @property
    def is_over(self) -> bool:
        """Whether this was the last frame."""
        return self.frame.truth.frame + 1 >= self.episode.frame_count

    def _start(self, contestant: Contestant) -> Estimate:
        """Give the target's box, which is the estimate of frame 0."""
        box_xyxy = self.episode.target_box_xyxy
        contestant.initialise(self.frame, box_xyxy.copy())
        return Estimate(0.5 * (box_xyxy[:2] + box_xyxy[2:]), box_xyxy=box_xyxy.copy(), in_view_probability=1.0)

    def _update(self, contestant: Contestant) -> Estimate:
        return contestant.update(self.frame)
