"""A tracker on a user's own footage: a video of what it answers, and its answers in a file."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from types import FrameType

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.suite import Suite, suites
from benchmarks.contract.tracker_spec import TrackerSpec
from benchmarks.data.footage.answers import Answers
from benchmarks.data.footage.episode import FootageEpisode, FootageSpec
from benchmarks.run.experiment import Progress
from benchmarks.run.jobs import Job, OpenJob, opened
from benchmarks.show.video.drawing import Instant, OfFootage
from benchmarks.show.video.episode_video import Caption, write_mp4
from benchmarks.show.video.surroundings import surrounded


@dataclass(frozen=True)
class Wanted:
    """What is made of footage.

    Attributes:
        video: the MP4.
        answers: keeps the estimates; None = not kept.
        scale: size of the view over that of the picture.
        frames: most pictures; None = all.
        show: is given each picture of the video; False ends it.
    """

    video: Path
    answers: Answers | None = None
    scale: float = 1.5
    frames: int | None = None
    show: Callable[[NDArray[np.uint8]], bool] = lambda image_rgb: True


@dataclass
class Made:
    """What became of it.

    Attributes:
        frames: pictures in the video.
        failure: why the tracker failed, on the last of them; "" if it did not.
        stopped: whether the user ended it before its end.
    """

    frames: int = 0
    failure: str = ""
    stopped: bool = False


def suite_of(tracker: TrackerSpec, many: bool) -> Suite:
    """Return a suite of one target or of ``many``, one of the tracker's own first; it tells how trackers are run."""
    own = [each for name, each in suites().items() if name in tracker.suites]
    known = (each for each in (*own, *suites().values()) if not each.judges_controllers)
    return next(each for each in known if each.follows_many == many)


def track(job: Job, wanted: Wanted, progress: Progress = lambda done, of: None) -> Made:
    """Run the job's tracker, the only one, on its footage, a ``FootageSpec``; write what is wanted.

    Ctrl-C ends it after the present picture, and so does a failure of the tracker: what was made before is written.
    Where there is no picture yet, nothing is.

    Args:
        progress: called with the number of pictures so far, and of all as far as it is known.
    """
    spec = job.episode
    assert isinstance(spec, FootageSpec)
    made = Made()
    drawing = OfFootage()
    caption = Caption(drawing, " · ".join([spec.preset, *job.trackers]), wanted.frames or spec.expected)
    with opened(job) as live, _Interruption() as interruption:
        instants = surrounded(_instants(live, wanted, made, interruption), spec.rate_hz, wanted.scale)

        def pictures(first: Instant) -> Iterator[tuple[NDArray[np.uint8], float]]:
            for instant in chain([first], instants):
                picture = caption.below(drawing.picture(instant), instant)
                yield picture, instant.frame.truth.time_s
                progress(made.frames, max(wanted.frames or spec.expected or 0, made.frames))
                if not wanted.show(picture):
                    made.stopped = True
                    return

        # There is none if the tracker cannot be made.
        if (first := next(instants, None)) is not None:
            try:
                write_mp4(wanted.video, pictures(first), spec.rate_hz, is_even=False)
            finally:
                if wanted.answers is not None:
                    wanted.answers.write()
        for failure in live.failures():
            where = f"on frame {failure.frame} of {spec.preset}"
            place = f" ({failure.place})" if failure.place else ""
            made.failure = f"{failure.tracker} failed {where}: {failure.reason}{place}"
    made.stopped = made.stopped or interruption.asked
    return made


def _instants(live: OpenJob, wanted: Wanted, made: Made, interruption: _Interruption) -> Iterator[Instant]:
    """Yield instants until the footage, the wanted number of them, the tracker or the user's patience ends."""
    episode, guard = live.loop.episode, live.runs[0].guard
    assert isinstance(episode, FootageEpisode)
    while made.frames != wanted.frames and guard.reason is None:
        frame = None
        with interruption.heeded():
            frame = live.loop.step() if episode.has_next() else None
        if frame is None or (interruption.asked and made.frames):
            # Of a picture at which work was broken off nothing is known.
            return
        answer = live.loop.answers[0]
        if wanted.answers is not None:
            wanted.answers.keep(frame.truth.frame, frame.truth.time_s, answer)
        made.frames += 1
        yield Instant(frame, (), answer, frame.observation.image_rgb, guard.decides_at)


class _Interruption:
    """Ctrl-C, which may come at any time, breaks off what is ``heeded``; a second one breaks off everything.

    Attributes:
        asked: whether it came.
    """

    asked = False

    def __init__(self) -> None:
        self._heeded = False

    def __enter__(self) -> _Interruption:
        self._is_main = threading.current_thread() is threading.main_thread()
        self._before = signal.signal(signal.SIGINT, self._ask) if self._is_main else None
        return self

    def __exit__(self, *_: object) -> None:
        if self._is_main:
            signal.signal(signal.SIGINT, self._before)

    def _ask(self, number: int, frame: FrameType | None) -> None:
        again, self.asked = self.asked, True
        if again or self._heeded:
            raise KeyboardInterrupt

    @contextmanager
    def heeded(self) -> Iterator[None]:
        """End the context at once at Ctrl-C."""
        self._heeded = True
        try:
            yield
        except KeyboardInterrupt:
            self.asked = True
        finally:
            self._heeded = False
