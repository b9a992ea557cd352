"""Metrics of users: what is wrong with one is refused by its name, and one that is right stands where it is wanted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from benchmarks.contract import suite as registry
from benchmarks.contract.metric import Mean, Metric, Quantity
from scenarios import catalog


@pytest.fixture(autouse=True)
def own_registry(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry, "_SUITES", dict(registry.suites()))


class Unsaid(Mean):
    """A mean that does not say its formula."""

    formula = None  # type: ignore[assignment]


def metric(value: Any = lambda truth, estimate: 0.5, name: str = "near", statistic: Any = None) -> Metric:
    return Metric("near", "nearness", "fraction", "higher", statistic or Mean(Quantity(name, 0, 1)), value=value)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (lambda: metric(name="naer"), r"quantity of metric near: expected one of naer; got 'near' \(did you mean naer"),
        (
            lambda: registry.add_metric("frame-out", metric(statistic=Unsaid(Quantity("near")))),
            "formula of metric near",
        ),
        (lambda: registry.add_metric("fish", metric()), "value of metric near: expected None, as the judge of fish"),
        (
            lambda: metric(lambda *of: 40.0).value_of(1, 2),
            "value of metric near: expected a number from 0 to 1.* got 40",
        ),
        (
            lambda: metric(lambda *of: np.zeros(3)).value_of(1, 2),
            "value of metric near: expected a number .* got array",
        ),
    ],
)
def test_what_is_wrong_is_named(wrong: Callable[[], Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        wrong()


def test_a_metric_is_compared_where_it_is_wanted() -> None:
    registry.add_metric("frame-out", metric(), compared=True)
    judged = registry.suite("frame-out")
    assert judged.compared[-1] == "near"
    assert [each.name for each in judged.events.episodes] == ["near"]
    assert "near" not in judged.headline


def test_a_copied_suite_has_the_functions_of_its_own_metrics() -> None:
    copied = replace(
        registry.suite("frame-out"), name="mine", metrics=(metric(),), headline=(), compared=(), tuned_for={}
    )
    registry.register_suite(replace(copied, on_sequences=None))
    scenario = catalog.scenario("road-town")
    judge: Any = registry.suite("mine").judge_of(scenario.episode("quick", 0), scenario)
    assert [each.name for each in judge.functions] == ["near"]
    assert registry.suite("frame-out").judge_of(scenario.episode("quick", 0), scenario).functions == ()  # type: ignore[attr-defined]
