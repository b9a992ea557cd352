"""Which controllers steer by default."""

from __future__ import annotations

from benchmarks.run.selection import Asked, parties
from benchmarks.run.steering import default_controllers
from benchmarks.suites.registry import suite


def test_all_controllers_of_the_carrier_steer_by_default() -> None:
    scenario = "road-town-v2"
    (party,) = parties(suite("follow"), Asked(scenarios=(scenario,)), variants=False)
    assert {"hold", "centre", "search", "reentry"} <= set(party.controllers)
    assert party.controllers == default_controllers(scenario)


def test_ablations_steer_only_if_they_are_asked_for() -> None:
    assert "centre_as_written" not in default_controllers("road-town")
    assert "centre_as_written" in default_controllers("road-town", variants=True)
