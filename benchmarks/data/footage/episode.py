"""A user's own footage as an episode: without truth, and of a length that is known at its end."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.rows import REAL
from benchmarks.contract.sequence_truth import truth_in_pixels
from benchmarks.contract.suite import Suite
from benchmarks.data.footage.sources import Picture
from benchmarks.data.sequences import USUAL_FOCAL
from benchmarks.run.episodes import EpisodeSpec
from scenarios.scenario import Episode, Frame
from scenarios.truth import Truth, TruthExtent
from trackers.types import CameraCommand, CameraModel, Observation, Start


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


class FootageEpisode:
    """See ``scenarios.scenario.Episode``; it goes on for as long as ``has_next`` says so.

    Time begins with the first picture.

    Attributes:
        frame_count: as far as it is known; at least 1.
    """

    closed_loop = False

    def __init__(self, spec: FootageSpec) -> None:
        self.frame_count = max(spec.expected or 1, 1)
        self.rate_hz = spec.rate_hz
        self._pictures = chain([spec.first], spec.following)
        self._next: Picture | None = None
        self._index, self._began_s = 0, spec.first.time_s
        height, width = spec.first.image_rgb.shape[:2]
        # Footage does not tell a focal length, as sequences do not.
        self._camera = CameraModel(width, height, USUAL_FOCAL * max(width, height))
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

    def map_of(self) -> Any:
        """See ``Episode``. None is known."""
        return None

    def larger_view(self, scale: float) -> NoReturn:
        """See ``Episode``. Raises ValueError: what surrounds a real picture is not known."""
        raise ValueError(f"scale: expected none for footage, which has no larger view, got {scale:g}")

    def normals(self) -> NDArray[np.float32]:
        """See ``Episode``. None are known, so all are 0."""
        return np.zeros((self._camera.height_px, self._camera.width_px, 3), np.float32)

    def close(self) -> None:
        """See ``Episode``. Whoever opened the footage closes it."""
