"""The references of the suite ``frame-out``, with unfair knowledge."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.contract.tracker_spec import TrackerSpec
from benchmarks.judges.frame_out.oracle_map import OracleMap, OracleParameters
from scenarios.loop import LoopTracker
from scenarios.road_town.road_map import RoadMap
from scenarios.scenario import Episode, Scenario


@dataclass(frozen=True, kw_only=True)
class MapOracle(TrackerSpec):
    """Knows the road graph and the state at the exit; gets no picture until the car is back."""

    role: str = "oracle"
    suites: tuple[str, ...] = ("frame-out",)
    module: str = OracleMap.__module__

    def create(
        self, episode: Episode, scenario: Scenario | None, rng: np.random.Generator, *, many: bool = False
    ) -> LoopTracker:
        """See ``TrackerSpec``."""
        assert scenario is not None
        return OracleMap(self.parameters, RoadMap(episode.map_of().graph), scenario.target, rng)


ORACLES = (
    MapOracle(
        name="oracle_map",
        summary="knows the road graph and the state at the exit; no picture until the car is back",
        parameters=OracleParameters(),
    ),
    MapOracle(
        name="oracle_driver",
        summary="oracle_map that also knows the driver model: an upper bound",
        parameters=OracleParameters(slows_off_road=True),
    ),
)
