"""What a paper's experiment is: its setting, its figure, its claims."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from trackers import registry


@dataclass(frozen=True, slots=True)
class Claim:
    """What the paper says of one method, and the number that it comes to here.

    Attributes:
        tracker: the method. words: what the paper says.
        metric: of the suite. counted: what it counts, in words.
        bound: which side of ``level`` agrees with the paper. level: in [0, 1].
    """

    tracker: str
    words: str
    metric: str
    counted: str
    bound: Literal["at most", "at least"]
    level: float


@dataclass(frozen=True, slots=True)
class PaperExperiment:
    """An experiment as the paper describes it.

    Attributes:
        name: what users type. title, setting: in words.
        preset: of ``road-town``. trackers: in the order of the paper's figure.
        frames: shown in the paper's figure.
        controller: steers by the estimate; None on a set path.
        claims: what the paper says.
    """

    name: str
    title: str
    setting: str
    preset: str
    trackers: tuple[str, ...]
    frames: tuple[int, ...]
    controller: str | None
    claims: tuple[Claim, ...]

    @property
    def settings(self) -> dict[str, dict[str, Any]]:
        """Method → the values it was written with: a paper's experiment is repeated without tuning."""
        return {name: registry.entry(name).written() for name in self.trackers}
