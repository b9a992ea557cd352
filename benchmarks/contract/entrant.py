"""What may take part in a suite: a tracker, or a reference with unfair knowledge."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from scenarios.loop import Contestant
from scenarios.scenario import Episode, Scenario


class Creation(Protocol):
    """Makes a fresh contestant."""

    def __call__(
        self, episode: Episode, scenario: Scenario, rng: np.random.Generator, many: bool = False
    ) -> Contestant:
        """Return a contestant that draws from ``rng``; ``many``: the suite judges tracks of many targets."""
        ...


@dataclass(frozen=True)
class Entrant:
    """A tracker or reference that may take part.

    Attributes:
        name, role, summary, suites: see ``registry.TrackerEntry``; a suite is named in any case.
        reproducible: False if no seed reaches the method's own random numbers; it then runs several times.
        parameters: its settings.
        module: where it is defined. edition: see ``registry.TrackerEntry``; of a reference, of its answers.
        create: makes a fresh contestant, see ``Creation``.
        missing: see ``registry.TrackerEntry``.
    """

    name: str
    role: str
    summary: str
    suites: tuple[str, ...]
    reproducible: bool
    parameters: Any
    module: str
    create: Creation
    missing: Callable[[], str] = lambda: ""
    edition: int = 1

    def available(self) -> bool:
        """Return whether all that it needs is installed."""
        return not self.missing()
