"""What a paper's experiment with trackers is: its setting, its figure, its claims."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from benchmarks.papers.claims import Claim
from trackers import registry


@dataclass(frozen=True, slots=True)
class PaperExperiment:
    """An experiment as the paper describes it.

    Attributes:
        name: what users type. title, setting: in words.
        preset: of the suite's scenario. trackers: in the order of the paper's figure.
        frames: shown in the paper's figure; none where it names none.
        controller: steers by the estimate; None on a set path.
        claims: what the paper says.
        suite: whose metrics they are about.
    """

    name: str
    title: str
    setting: str
    preset: str
    trackers: tuple[str, ...]
    frames: tuple[int, ...]
    controller: str | None
    claims: tuple[Claim, ...]
    suite: str = "frame-out"

    @property
    def settings(self) -> dict[str, dict[str, Any]]:
        """Method → the values it was written with: a paper's experiment is repeated without tuning."""
        return {name: registry.entry(name).written() for name in self.trackers}
