"""Ours with unfair knowledge, of the car or of the roads; all else is its own.

They say what ours lacks. No better state at the exit than the true one can come from pictures, and no better
classifier of the ground than a true one of what was seen; the whole road graph includes what no picture has shown. What
is then left is what ours makes of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from benchmarks.contract.tracker_spec import EpisodeName, TrackerSpec
from scenarios.loop import LoopTracker
from scenarios.scenario import Episode


@dataclass(frozen=True)
class Told:
    """What a tracker is told.

    Attributes:
        state: whether position, heading and speed on the first frame outside, as ``oracle_map`` and the blind rows are.
        roads: ``graph`` = the centre lines of all streets, in place of those that it finds in its mosaic; ``seen`` =
            which cells of its mosaic are road, in place of its rule for colours; nothing = its own.
    """

    state: bool = False
    roads: Literal["graph", "seen", ""] = ""


@dataclass(frozen=True, kw_only=True)
class ToldOurs(TrackerSpec):
    """Ours, told what no picture says."""

    role: str = "oracle"
    suites: tuple[str, ...] = ("frame-out",)
    module: str = "benchmarks.judges.frame_out.told"

    def create(
        self, named: EpisodeName, episode: Episode, rng: np.random.Generator, *, many: bool = False
    ) -> LoopTracker:
        """See ``TrackerSpec``."""
        # Who benches another tracker does not import ours.
        from benchmarks.judges.frame_out.told import ToldTracker

        assert named.scenario is not None
        told: Told = self.parameters
        return ToldTracker(episode.map_of().graph, named.scenario.target, rng, state=told.state, roads=told.roads)


TOLD = tuple(
    ToldOurs(name=f"told_{name}", summary=f"ours, told {summary}", parameters=told)
    for name, summary, told in (
        ("state", "the true state at each exit", Told(state=True)),
        ("ground", "which of the ground that it has seen is road", Told(roads="seen")),
        ("graph", "the true road graph", Told(roads="graph")),
        ("state_and_ground", "the state at each exit and the road that it has seen", Told(True, "seen")),
        ("state_and_graph", "the state at each exit and the road graph", Told(True, "graph")),
    )
)
