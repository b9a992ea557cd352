"""Every scenario by its catalogue id."""

from __future__ import annotations

from scenarios.road_town.scenario import ROAD_TOWN
from scenarios.scenario import Scenario
from scenarios.stereo_follow.scenario import STEREO_FOLLOW

_SCENARIOS: tuple[Scenario, ...] = (ROAD_TOWN, STEREO_FOLLOW)
"""In order of publication: of two versions of one scenario, the later stands later."""


def names() -> tuple[str, ...]:
    """Return the ids of all scenarios, with their versions."""
    return tuple(scenario.id for scenario in _SCENARIOS)


def scenario(name: str) -> Scenario:
    """Return a scenario by id; without a version (``road-town``) the latest.

    Raises:
        ValueError: for an unknown name; lists the known ones.
    """
    for known in reversed(_SCENARIOS):
        if name in (known.id, known.id.rsplit("-v", 1)[0]):
            return known
    raise ValueError(f"scenario: expected one of {', '.join(names())}; got {name!r}")
