"""Which controllers steer by default."""

from __future__ import annotations

import pytest

from benchmarks.results.published import tables_named
from benchmarks.results.table_runs import run_of
from benchmarks.run.selection import parties
from benchmarks.run.steering import default_controllers
from benchmarks.suites.registry import suite


@pytest.mark.parametrize(("scenario", "shipped"), [("road-town-v1", True), ("road-town-v2", False)])
def test_a_shipped_policy_steers_by_default_only_where_it_was_trained(scenario: str, shipped: bool) -> None:
    (party,) = parties(suite("follow"), (scenario,), (), (), (), variants=False)
    assert {"hold", "centre", "search", "reentry"} <= set(party.controllers)
    assert ("policy:road-town-follow" in party.controllers) == shipped
    assert party.controllers == default_controllers(scenario)


def test_published_tables_of_the_latest_scenes_have_no_policy_of_the_first_ones() -> None:
    for table in tables_named(("follow-road-town", "follow-stereo-follow")):
        assert "policy:" not in run_of(table).command


def test_ablations_steer_only_if_they_are_asked_for() -> None:
    assert "centre_as_written" not in default_controllers("road-town")
    assert "centre_as_written" in default_controllers("road-town", variants=True)
