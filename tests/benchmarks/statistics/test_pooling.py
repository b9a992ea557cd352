from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy import stats

from benchmarks.contract.metric import Mean, Metric, PooledRatios, Quantity, Statistic, collected
from benchmarks.contract.rows import Row
from benchmarks.judges.frame_out.suite import FRAME_OUT
from benchmarks.judges.stereo.suite import STEREO
from benchmarks.statistics.bootstrap import bootstrap_interval
from benchmarks.statistics.long_term import f_score
from benchmarks.statistics.pooling import (
    BestF,
    BestPrecision,
    BestRecall,
    DifferenceOfMedians,
    GeometricMean,
    Median,
    RatioOfMeans,
)
from benchmarks.statistics.summary import paired


def row(seed: int, metric: str, value: Any, weight: float = 1.0, **frame_out: Any) -> dict[str, Any]:
    """Return a row with the columns that pooling reads."""
    of = {"suite": FRAME_OUT.name, "seed": seed, "metric": metric}
    return {**of, "value": value, "weight": weight, "frame_out": frame_out or None}


def of(statistic: type[Statistic], *names: str, kind: str | None = None) -> Statistic:
    return statistic(*map(Quantity, names), kind=kind)


def mean_of(statistic: Statistic, rows: list[dict[str, Any]]) -> float:
    pool = statistic.pooled(rows)
    assert pool is not None
    return pool.mean


def test_a_mean_weighs_rows() -> None:
    rows = [row(0, "a", 1.0, 3.0), row(1, "a", 0.0, 1.0), row(1, "b", 7.0)]
    assert mean_of(of(Mean, "a"), rows) == 0.75


def test_undefined_values_are_left_out_and_their_seed_stays() -> None:
    rows = [row(0, "a", 1.0), row(1, "a", None), row(2, "a", 0.0)]
    pool = of(Mean, "a").pooled(rows)
    assert pool is not None
    assert (pool.mean, pool.seed_count, pool.seeds.tolist()) == (0.5, 2, [0, 1, 2])
    assert of(Mean, "nothing").pooled(rows) is None


def test_kinds_choose_frame_outs() -> None:
    rows = [
        row(0, "recovered", 1.0, kind="road", turned=True),
        row(0, "recovered", 0.0, kind="excursion", turned=False),
        row(1, "recovered", 1.0, kind="road", turned=False),
    ]
    kinds = (None, "road", "excursion", "turned")
    means = {kind: mean_of(of(Mean, "recovered", kind=kind), rows) for kind in kinds}
    assert means == {None: pytest.approx(2 / 3), "road": 1.0, "excursion": 0.0, "turned": 1.0}


@settings(deadline=None)
@given(st.lists(st.tuples(st.integers(0, 3), st.floats(0, 200, allow_nan=False)), min_size=1, max_size=25))
def test_a_median_is_numpys(data: list[tuple[int, float]]) -> None:
    rows = [row(seed, "a", value) for seed, value in data]
    assert mean_of(of(Median, "a"), rows) == pytest.approx(np.median([value for _, value in data]))


def test_a_difference_of_medians_is_of_pairs() -> None:
    rng = np.random.default_rng(1)
    first, second = rng.exponential(size=31), rng.exponential(size=31)
    values = {"a": first, "b": second}
    rows = [row(k, name, float(each[k])) for name, each in values.items() for k in range(31)]
    assert mean_of(of(DifferenceOfMedians, "a", "b"), rows) == pytest.approx(np.median(first) - np.median(second))
    # Seeds are drawn for both together: what is the same on every seed has no spread.
    same = [row(k, name, float(first[k]) + shift) for name, shift in (("a", 0.0), ("b", 0.25)) for k in range(31)]
    pool = of(DifferenceOfMedians, "a", "b").pooled(same)
    assert pool is not None
    assert bootstrap_interval(pool) == pytest.approx((-0.25, -0.25))
    # Compared with another tracker the grid holds the values of both.
    other = [{**each, "value": each["value"] + 0.1} for each in rows if each["metric"] == "a"]
    others = [*other, *(each for each in rows if each["metric"] == "b")]
    found = paired(rows, others, Metric("m", "", "1", "higher", of(DifferenceOfMedians, "a", "b")))
    assert found is not None
    assert found.difference == pytest.approx(-0.1)


class Trimmed(Statistic):
    """The mean of the values without the least and the greatest one; its columns are the values that there are."""

    formula = "mean of {0} without its ends"

    def ratios(self, seeds: NDArray[np.int64], chosen: Sequence[Sequence[Row]]) -> PooledRatios:
        values = np.array([each["value"] for each in chosen[0]])
        grid = np.unique(values)
        parts = (
            [each["seed"] for each in chosen[0]],
            (values[:, None] == grid).astype(float),
            np.ones((len(values), len(grid))),
        )

        def finish(shares: NDArray[np.float64]) -> NDArray[np.float64]:
            below = np.cumsum(shares, axis=-1)
            kept = np.clip(below, 0.2, 0.8) - np.clip(below - shares, 0.2, 0.8)
            return (kept * grid).sum(axis=-1) / 0.6

        return collected(seeds, [parts], finish)


def test_the_p_of_a_statistic_of_values_is_that_of_all_swaps() -> None:
    rng = np.random.default_rng(5)
    first, second = rng.normal(1.0, 1.0, 10), rng.normal(0.0, 1.0, 10)
    rows, others = ([row(k, "a", float(value)) for k, value in enumerate(each)] for each in (first, second))
    found = paired(rows, others, Metric("m", "", "1", "higher", of(Trimmed, "a")))
    assert found is not None
    swaps = np.array(list(product((False, True), repeat=10)))
    mixed = np.where(swaps, second, first), np.where(swaps, first, second)
    differences = stats.trim_mean(mixed[0], 0.2, axis=1) - stats.trim_mean(mixed[1], 0.2, axis=1)
    assert found.difference == pytest.approx(differences[0])
    assert found.p == pytest.approx(np.mean(np.abs(differences) >= abs(differences[0]) - 1e-9), abs=0.02)
    # Seeds that one of the two lacks count in neither.
    fewer = paired(rows, others[3:], Metric("m", "", "1", "higher", of(Trimmed, "a")))
    assert fewer is not None
    assert fewer.n == 7


def test_the_interval_of_a_median_is_scipys() -> None:
    values = np.random.default_rng(0).exponential(5.0, 45)
    pool = of(Median, "a").pooled([row(k, "a", float(value)) for k, value in enumerate(values)])
    assert pool is not None
    rng = np.random.default_rng(1)
    expected = stats.bootstrap(
        (values,), np.median, method="percentile", n_resamples=10_000, rng=rng
    ).confidence_interval
    assert bootstrap_interval(pool) == pytest.approx((expected.low, expected.high), rel=0.06)


def test_a_ratio_of_means_is_that_of_the_pooled_means() -> None:
    rows = [row(0, "far", 9.0, 1.0), row(1, "far", 3.0, 2.0), row(0, "near", 1.0, 1.0), row(1, "near", 4.0, 3.0)]
    assert mean_of(of(RatioOfMeans, "far", "near"), rows) == pytest.approx((15 / 3) / (13 / 4))
    assert of(RatioOfMeans, "far", "near").pooled(rows[:2]) is None


def test_a_geometric_mean_is_that_of_the_pooled_rates() -> None:
    rows = [row(0, "p", 0.5, 10), row(1, "p", 1.0, 30), row(0, "n", 0.2, 5), row(1, "n", None, 0)]
    assert mean_of(of(GeometricMean, "p", "n"), rows) == pytest.approx(np.sqrt(0.875 * 0.2))


def test_f_is_taken_at_the_best_threshold_of_the_mean_curves() -> None:
    rng = np.random.default_rng(2)
    precision, recall = rng.random((6, 21)), rng.random((6, 21))
    rows = [row(k, "precision_curve", precision[k].tolist()) for k in range(6)]
    rows += [row(k, "recall_curve", recall[k].tolist()) for k in range(6)]
    scores = f_score(precision.mean(axis=0), recall.mean(axis=0))
    best = int(np.argmax(scores))
    expected = {BestF: scores[best], BestPrecision: precision.mean(axis=0)[best], BestRecall: recall.mean(axis=0)[best]}
    for statistic, value in expected.items():
        assert mean_of(of(statistic, "precision_curve", "recall_curve"), rows) == pytest.approx(value)


@settings(deadline=None)
@given(st.lists(st.tuples(st.integers(0, 3), st.integers(0, 80), st.integers(0, 90)), min_size=1, max_size=25))
def test_the_restricted_mean_is_the_area_under_scipys_curve_and_under_the_product_by_hand(
    cars: list[tuple[int, int, int]],
) -> None:
    """(seed, frames to recover, watched frames); one that is not recovered while watched is censored."""
    rows, events, censored = [], [], []
    for seed, frames, watched in cars:
        recovered = frames < watched
        rows.append(row(seed, "recovery_frames", float(frames) if recovered else None, kind="road", turned=False))
        rows.append(row(seed, "watched_frames", float(watched), kind="road", turned=False))
        (events if recovered else censored).append(frames if recovered else watched)
    survival = stats.ecdf(stats.CensoredData(uncensored=events, right=censored)).sf
    area = float(np.sum(survival.evaluate(np.arange(60))))
    mean = mean_of(FRAME_OUT.metric("time_to_recover_frames").statistic, rows)
    assert mean == pytest.approx(area, abs=1e-9)
    product, by_hand = 1.0, 0.0
    for t in range(60):
        at_risk = sum(end >= t for end in events + censored)
        product *= 1 - events.count(t) / at_risk if at_risk else 1.0
        by_hand += product
    assert mean == pytest.approx(by_hand, abs=1e-9)


counted = st.lists(st.tuples(st.integers(0, 4), *[st.integers(0, 9)] * 3), min_size=1, max_size=12)


def count_rows(data: list[tuple[int, int, int, int]]) -> list[dict[str, Any]]:
    names = ("right_frames", "wrong_frames", "missed_frames")
    return [row(seed, name, float(count)) for seed, *counts in data for name, count in zip(names, counts, strict=True)]


def brute_force(data: list[tuple[int, int, int, int]]) -> dict[str, float]:
    """Precision, recall and F of sums, by their textbook formulas; NaN where one is undefined."""
    right, wrong, missed = (sum(each[k] for each in data) for k in (1, 2, 3))
    precision = right / (right + wrong) if right + wrong else np.nan
    recall = right / (right + missed) if right + missed else np.nan
    total = precision + recall
    f = 2 * precision * recall / total if total > 0 else 0.0 if right + wrong + missed else np.nan
    found = right / (right + wrong + missed) if right + wrong + missed else np.nan
    both = precision + found
    # Where nothing is right both are 0, whether or not there was an answer.
    f1 = 2 * precision * found / both if both > 0 else 0.0 if right + wrong + missed else np.nan
    return {"precision": precision, "recall": recall, "f_measure": f, "detection_f1": f1}


@settings(deadline=None)
@given(counted)
def test_precision_recall_and_f_of_counts_are_those_of_all_frames_together(
    data: list[tuple[int, int, int, int]],
) -> None:
    for name, expected in brute_force(data).items():
        assert mean_of(STEREO.metric(name).statistic, count_rows(data)) == pytest.approx(expected, nan_ok=True)


def detection_f1(right: int, wrong: int, missed: int) -> float:
    return mean_of(STEREO.metric("detection_f1").statistic, count_rows([(0, right, wrong, missed)]))


@given(st.integers(1, 50), st.integers(0, 50), st.integers(0, 50), st.integers(1, 50))
def test_a_wrong_answer_is_worse_than_none_and_a_right_one_better(
    right: int, wrong: int, missed: int, more: int
) -> None:
    assert detection_f1(right, wrong + more, missed) < detection_f1(right, wrong, missed + more)
    assert detection_f1(right, wrong, missed + more) < detection_f1(right, wrong, missed)
    assert detection_f1(right + more, wrong, missed) >= detection_f1(right, wrong, missed)


def test_a_constant_answer_is_not_ahead_for_never_being_silent() -> None:
    """By the paper's F one that always answers, right on 71 of 100 frames, is far ahead of one that knows 65 and is
    silent on the most of what it does not.
    """
    constant, careful = (71, 29, 0), (65, 5, 30)
    f = {name: brute_force([(0, *counts)])["f_measure"] for name, counts in (("a", constant), ("b", careful))}
    assert f["a"] > f["b"] + 0.04
    assert detection_f1(*constant) < detection_f1(*careful)


@settings(deadline=None, max_examples=30)
@given(counted, counted, st.lists(st.integers(0, 4), min_size=5, max_size=5))
def test_resampled_and_paired_f_is_that_of_the_seeds_drawn(
    first: list[tuple[int, int, int, int]], second: list[tuple[int, int, int, int]], drawn: list[int]
) -> None:
    """For any resample, F comes from the sums over all drawn seeds."""
    for data in (first, second):
        data = data + [(seed, 1, 1, 1) for seed in range(5)]
        pool = STEREO.metric("f_measure").statistic.pooled(count_rows(data))
        assert pool is not None
        times = np.bincount(drawn, minlength=5).astype(float)
        expected = brute_force([each for seed in drawn for each in data if each[0] == seed])["f_measure"]
        assert float(pool.value(times)) == pytest.approx(expected)


def test_a_time_to_recover_in_seconds_is_that_in_frames_by_the_rate() -> None:
    rows = [row(0, "recovery_frames", 6.0, kind="occlusion"), row(0, "watched_frames", 50.0, kind="occlusion")]
    metric = STEREO.metric("time_to_recover_s")
    mine, others = [*rows, row(0, "rate_hz", 10.0)], [*rows, row(0, "rate_hz", 15.0)]
    assert mean_of(metric.statistic, mine) == pytest.approx(0.6)
    # Seconds of one rate are none of another.
    with pytest.raises(ValueError, match=r"rate_hz: expected one rate of all .* got \[10.0, 15.0\]"):
        paired(mine, others, metric)
