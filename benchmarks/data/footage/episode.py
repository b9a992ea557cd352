"""A user's own footage as an episode: without truth, and of a length that is known at its end."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.rows import REAL
from benchmarks.contract.sequence_truth import truth_in_pixels
from benchmarks.contract.suite import Suite
from benchmarks.data.footage.sources import Picture
from benchmarks.data.sequences import PicturesEpisode
from benchmarks.run.episodes import EpisodeSpec
from scenarios.scenario import Episode, Frame
from scenarios.truth import Truth, TruthExtent
from trackers.types import CameraCommand, Observation, Start


@dataclass(frozen=True, eq=False)
class FootageSpec(EpisodeSpec):
    """Pictures of a user; they can be opened once.

    Attributes:
        preset: name of the footage.
        first, following: its pictures.
        box_xyxy: (4,) of the target in the first one; None for a tracker of many targets.
        rate_hz: pictures a second, on average.
        expected: number of pictures as far as it is known; None = unknown.
    """

    preset: str
    first: Picture
    following: Iterator[Picture]
    box_xyxy: NDArray[np.float64] | None
    rate_hz: float
    expected: int | None
    scenario = None
    renderer = REAL
    seed = 0
    edition = ""

    @property
    def sequence(self) -> str:
        """See ``EpisodeSpec``."""
        return self.preset

    @property
    def has_one_target(self) -> bool:
        """See ``EpisodeSpec``."""
        return self.box_xyxy is not None

    def open(self, truth: TruthExtent) -> Episode:
        """See ``EpisodeSpec``."""
        return FootageEpisode(self)

    def judge(self, suite: Suite, episode: Episode) -> NoReturn:
        """See ``EpisodeSpec``. Raises ValueError: nothing is known that a judge could compare with."""
        raise ValueError(f"episode: expected one with truth, got {self.preset}")


class FootageEpisode(PicturesEpisode):
    """See ``scenarios.scenario.Episode``; it goes on for as long as ``has_next`` says so.

    Time begins with the first picture; ``frame_count`` is at least 1, and as far as it is known.
    """

    def __init__(self, spec: FootageSpec) -> None:
        height, width = spec.first.image_rgb.shape[:2]
        super().__init__(max(spec.expected or 1, 1), spec.rate_hz, width, height)
        self._pictures = chain([spec.first], spec.following)
        self._next: Picture | None = None
        self._index, self._began_s = 0, spec.first.time_s
        self._box_xyxy = spec.box_xyxy

    @property
    def start(self) -> Start:
        """See ``Episode``."""
        return Start(self._camera, None if self._box_xyxy is None else self._box_xyxy.copy())

    def has_next(self) -> bool:
        """Return whether there is another picture, which ``step`` returns."""
        self._next = self._next or next(self._pictures, None)
        return self._next is not None

    def step(self, command: CameraCommand | None = None) -> Frame:
        """See ``Episode``. Raises StopIteration after the last picture."""
        picture = self._next or next(self._pictures)
        self._next = None
        time_s = picture.time_s - self._began_s
        truth = truth_in_pixels(Truth, self._index, time_s, (), (), np.empty((0, 4)), np.empty(0, "<U8"))
        self._index += 1
        return Frame(Observation(picture.image_rgb, time_s, self._camera), truth)
