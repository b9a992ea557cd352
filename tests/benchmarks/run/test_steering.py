"""Which controllers steer by default."""

from __future__ import annotations

import pytest

from benchmarks.run.experiment import controllers_of
from benchmarks.run.steering import is_made_for


@pytest.mark.parametrize(("scenario", "shipped"), [("road-town-v1", True), ("road-town-v2", False)])
def test_a_shipped_policy_steers_by_default_only_where_it_was_trained(scenario: str, shipped: bool) -> None:
    by_default = [name for name in controllers_of("follow", scenario) if is_made_for(name, scenario)]
    assert {"hold", "centre", "search", "reentry"} <= set(by_default)
    assert ("policy:road-town-follow" in by_default) == shipped
