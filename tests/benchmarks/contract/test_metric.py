"""Metrics of users: what is wrong with one is refused by its name, and one that is right stands where it is wanted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.contract import suite as registry
from benchmarks.contract.metric import Mean, Metric, Quantity
from benchmarks.run.jobs import run_job
from benchmarks.run.selection import job_on
from scenarios import catalog
from tests.fakes_scenario import FAKE_TOWN


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
        (lambda: metric(lambda *of: None).value_of(1, 2), "value of metric near: expected a number .* got None"),
        (lambda: metric(lambda *of: "0.5").value_of(1, 2), "value of metric near: expected a number .* got '0.5'"),
        (
            lambda: metric(lambda *of: {}["none"]).value_of(1, 2),
            "value of metric near: expected a number .* got KeyError: 'none'",
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


def test_a_metric_that_raises_is_named_with_the_episode_and_the_line(tmp_path: Path) -> None:
    file = tmp_path / "wild.py"
    file.write_text("def wild(truth, estimate):\n    return 1 / 0\n")
    names: dict[str, Any] = {}
    exec(compile(file.read_text(), str(file), "exec"), names)
    registry.add_metric("frame-out", metric(names["wild"]))
    told = r"value of metric near: .* got ZeroDivisionError: .* \(wild.py, line 2\), in fake-town-v1 tiny, seed 1$"
    job = job_on("frame-out", FAKE_TOWN.id, "tiny", 1, ("hold",))
    with pytest.raises(ValueError, match=told):
        run_job(job)


def test_a_metric_of_a_user_stands_beside_the_one_that_ranks() -> None:
    before = registry.suite("frame-out").headline
    registry.add_metric("frame-out", metric(), headline=True)
    assert registry.suite("frame-out").headline == (before[0], "near", *before[1:])
