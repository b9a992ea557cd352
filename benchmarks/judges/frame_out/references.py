"""The references of the suite ``frame-out``, with unfair knowledge."""

from __future__ import annotations

from benchmarks.contract.entrant import Entrant
from benchmarks.judges.frame_out.oracle_map import OracleMap, OracleParameters
from scenarios.road_town.road_map import RoadMap


def _oracle(name: str, summary: str, parameters: OracleParameters) -> Entrant:
    return Entrant(
        name=name,
        role="oracle",
        summary=summary,
        suites=("frame-out",),
        reproducible=True,
        parameters=parameters,
        module=OracleMap.__module__,
        create=lambda episode, scenario, rng, many=False: OracleMap(
            parameters, RoadMap(episode.map_of().graph), scenario.target, rng
        ),
    )


ORACLES = (
    _oracle(
        "oracle_map",
        "knows the road graph and the state at the exit; no picture until the car is back",
        OracleParameters(),
    ),
    _oracle(
        "oracle_driver",
        "oracle_map that also knows the driver model: an upper bound",
        OracleParameters(slows_off_road=True),
    ),
)
