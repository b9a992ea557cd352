"""Kendall's tau between real and simulated ranks, against counting pairs."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import pytest

from benchmarks.contract.suite import suite
from benchmarks.statistics.rank_agreement import rank_agreement

FRAME_OUT = suite("frame-out")


def entries(scenario: str, means: dict[str, float | None], metric: str = "success_auc") -> list[dict[str, Any]]:
    where = {"suite": "frame-out", "scenario": scenario, "preset": "x", "renderer": "real", "metric": metric}
    return [{**where, "tracker": name, "mean": mean} for name, mean in means.items()]


@pytest.mark.parametrize(("metric", "first"), [("success_auc", "c"), ("centre_error_px", "a")])
def test_tau_is_the_surplus_of_pairs_in_the_same_order(metric: str, first: str) -> None:
    real = {"a": 0.1, "b": 0.2, "c": 0.9, "d": 0.4, "alone": 0.3}
    simulated = {"a": 0.5, "b": 0.4, "c": 0.8, "d": 0.6, "other": 0.9, "blank": None}
    signs = [
        1 if (real[x] - real[y]) * (simulated[x] - simulated[y]) > 0 else -1  # type: ignore[operator]
        for x, y in combinations("abcd", 2)
    ]
    tau = sum(signs) / len(signs)
    assert tau == pytest.approx(2 / 3)
    lines = rank_agreement(FRAME_OUT, entries("real", real, metric), entries("town", simulated, metric))
    assert lines[0].startswith(f"{metric}, real x and town x real: Kendall's tau {tau:.2f} (p ")
    assert lines[0].endswith(", 4 trackers)")
    assert lines[1].startswith(f"  real: {first} ")
    assert len(lines) == 3


@pytest.mark.parametrize("means", [{"a": 0.1, "b": 0.2}, {"a": 0.1, "b": 0.1, "c": 0.1}])
def test_two_trackers_and_equal_ones_have_no_ranks(means: dict[str, float]) -> None:
    lines = rank_agreement(FRAME_OUT, entries("real", means), entries("town", {"a": 1.0, "b": 2.0, "c": 3.0}))
    assert lines == ["no ranks to compare: they need three trackers that have run on both, and figures that differ"]


def test_speed_and_rows_of_the_same_kind_are_left_out() -> None:
    means = {"a": 0.1, "b": 0.2, "c": 0.3}
    both = [*entries("real", means), *entries("town", means), *entries("town", means, "frames_per_s")]
    assert len(rank_agreement(FRAME_OUT, both, both)) == 3
