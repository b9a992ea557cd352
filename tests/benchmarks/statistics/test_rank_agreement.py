"""Kendall's tau between real and simulated ranks, against counting pairs and scipy; its interval against resampling."""

from __future__ import annotations

import re
from itertools import combinations
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import kendalltau

from benchmarks.contract.suite import suite
from benchmarks.statistics.rank_agreement import rank_agreement, tau_b

FRAME_OUT = suite("frame-out")
Values = dict[str, float | list[float] | None]


def rows(scenario: str, values: Values, metric: str = "success_auc") -> list[dict[str, Any]]:
    """Return rows of trackers, one for each value of theirs: of seed 0, 1 …"""
    where = {"suite": "frame-out", "scenario": scenario, "preset": "x", "renderer": "real", "metric": metric}
    where |= {"role": "baseline", "controller": None, "frame_out": None, "weight": 1.0}
    return [
        {**where, "tracker": name, "seed": seed, "value": value}
        for name, own in values.items()
        for seed, value in enumerate(own if isinstance(own, list) else [own])
    ]


@pytest.mark.parametrize(("metric", "first"), [("success_auc", "c"), ("centre_error_px", "a")])
def test_tau_is_the_surplus_of_pairs_in_the_same_order(metric: str, first: str) -> None:
    real: Values = {"a": 0.1, "b": 0.2, "c": 0.9, "d": 0.4, "alone": 0.3}
    simulated: Values = {"a": 0.5, "b": 0.4, "c": 0.8, "d": 0.6, "other": 0.9, "blank": None}
    signs = [
        1 if (real[x] - real[y]) * (simulated[x] - simulated[y]) > 0 else -1  # type: ignore[operator]
        for x, y in combinations("abcd", 2)
    ]
    tau = sum(signs) / len(signs)
    assert tau == pytest.approx(2 / 3)
    lines = rank_agreement(FRAME_OUT, rows("real", real, metric), rows("town", simulated, metric))
    # One seed tells nothing of how seeds differ.
    assert lines[0].startswith(f"{metric}, real x and town x real: Kendall's tau {tau:.2f} (p ")
    assert lines[0].endswith(", 4 trackers)")
    assert lines[1].startswith(f"  real: {first} ")
    assert len([line for line in lines if "counts" not in line]) == 3


@given(
    st.integers(2, 7).flatmap(
        lambda count: st.lists(st.lists(st.integers(0, 4), min_size=count, max_size=count), min_size=2, max_size=2)
    )
)
def test_tau_of_many_draws_is_scipy_s_of_each(values: list[list[int]]) -> None:
    """Also where values are equal."""
    first, second = np.array(values, float)
    drawn = tau_b(np.stack([first, first[::-1]]), np.stack([second, second]))
    expected = [kendalltau(first, second)[0], kendalltau(first[::-1], second)[0]]
    np.testing.assert_allclose(drawn, expected, atol=1e-12)


def test_the_interval_is_that_of_drawing_sequences_and_seeds() -> None:
    """Sequences and seeds are drawn apart from each other, and the same ones for all trackers."""
    rng = np.random.default_rng(5)
    level = {"a": 0.3, "b": 0.4, "c": 0.5, "d": 0.6}
    real = {name: (mean + rng.normal(0, 0.15, 9)).tolist() for name, mean in level.items()}
    simulated = {name: (mean + rng.normal(0, 0.15, 14)).tolist() for name, mean in level.items()}
    lines = rank_agreement(FRAME_OUT, rows("real", real), rows("town", simulated))
    found = re.search(r"tau (-?[\d.]+), (-?[\d.]+) … (-?[\d.]+) \(p", lines[0])
    assert found is not None
    tau, low, high = map(float, found.groups())
    assert tau == pytest.approx(
        kendalltau(*(list(map(np.mean, each.values())) for each in (real, simulated)))[0], abs=0.005
    )
    drawn = []
    for _ in range(3000):
        sides = []
        for values, count in ((real, 9), (simulated, 14)):
            places = rng.integers(0, count, count)
            sides.append([np.mean(np.array(own)[places]) for own in values.values()])
        drawn.append(kendalltau(*sides)[0])
    expected = np.percentile(drawn, [2.5, 97.5])
    # tau of four trackers has seven values, a third apart.
    np.testing.assert_allclose([low, high], expected, atol=0.34)
    assert low < tau <= high


def test_trackers_are_ranked_on_what_all_of_them_ran_on() -> None:
    """On sequence 1, which b has not, a would be the last."""
    real: Values = {"a": [0.9, 0.0], "b": [0.5], "c": [0.4, 0.4]}
    lines = rank_agreement(FRAME_OUT, rows("real", real), rows("town", {"a": 0.9, "b": 0.5, "c": 0.4}))
    assert "tau 1.00 (p" in lines[0]


@pytest.mark.parametrize("means", [{"a": 0.1, "b": 0.2}, {"a": 0.1, "b": 0.1, "c": 0.1}])
def test_two_trackers_and_equal_ones_have_no_ranks(means: Values) -> None:
    lines = rank_agreement(FRAME_OUT, rows("real", means), rows("town", {"a": 1.0, "b": 2.0, "c": 3.0}))
    assert lines == ["no ranks to compare: they need three trackers that have run on both, and figures that differ"]


def test_speed_and_rows_of_the_same_kind_are_left_out() -> None:
    means: Values = {"a": 0.1, "b": 0.2, "c": 0.3}
    both = [*rows("real", means), *rows("town", means), *rows("town", means, "frames_per_s")]
    lines = rank_agreement(FRAME_OUT, both, both)
    assert len([line for line in lines if "Kendall" in line]) == 1


def test_what_counts_on_real_pictures_and_in_simulation_is_said_where_it_differs() -> None:
    means: Values = {"a": 0.1, "b": 0.2, "c": 0.3}
    lines = rank_agreement(FRAME_OUT, rows("real", means, "recovered"), rows("town", means, "recovered"))
    told = [line for line in lines if line.startswith("  recovered counts, ")]
    assert len(told) == 2
    assert "IoU of the boxes at least 0.5, or, of a point alone" in told[0]
    assert "half its length on the ground" in told[1]
