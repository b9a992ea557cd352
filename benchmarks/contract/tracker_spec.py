"""A tracker, or a reference with unfair knowledge, that may take part in a suite."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from benchmarks.contract.rows import Row
from scenarios.loop import LoopTracker
from scenarios.scenario import Episode, Scenario


class EpisodeName(Protocol):
    """What names an episode in rows, see ``benchmarks.run.episodes.EpisodeSpec``, which is one."""

    @property
    def scenario(self) -> Scenario | None:
        """Its scenario; None for what is real."""
        ...

    @property
    def preset(self) -> str:
        """Preset of the scenario; of what is real the collection."""
        ...

    @property
    def seed(self) -> int:
        """Seed; of what is real the number in its collection."""
        ...


@dataclass(frozen=True, kw_only=True)
class TrackerSpec(ABC):
    """What is known of a tracker before it runs; workers receive it.

    Attributes:
        name, role, summary, suites: see ``trackers.registry.TrackerEntry``; without a suite, the default one.
        parameters: its settings.
        module: where it is defined. edition: of its answers, see ``registry.TrackerEntry``.
        reproducible: False if no seed reaches the method's own random numbers; it then runs several times.
        takes_all: whether it gets all pictures of an episode before its first answer.
        start_limit_s, frame_limit_s: of its construction and of its work on a frame, see ``Guard``; None = the run's.
        timed: whether its speed is measured.
    """

    name: str
    role: str
    summary: str
    suites: tuple[str, ...]
    parameters: Any
    module: str
    edition: int = 1
    reproducible: bool = True
    takes_all: bool = False
    start_limit_s: float | None = None
    frame_limit_s: float | None = None
    timed: bool = True

    @property
    def columns(self) -> Row:
        """Columns of its rows that others do not have."""
        return {}

    @abstractmethod
    def create(
        self, named: EpisodeName, episode: Episode, rng: np.random.Generator, *, many: bool = False
    ) -> LoopTracker:
        """Return a fresh tracker that draws from ``rng``.

        Args:
            named: the episode by its name. episode: the same, before its first frame.
            many: whether the suite judges tracks of many targets.
        """

    def content(self, named: EpisodeName) -> str:
        """Return a digest of what else its answers in an episode are made of; "" for its code and parameters alone."""
        return ""

    def missing(self) -> str:
        """Return what it needs that is not installed, and how to install it; "" if nothing."""
        return ""
