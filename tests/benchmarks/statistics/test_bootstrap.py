from __future__ import annotations

import numpy as np
import pytest
from scipy import stats
from statsmodels.stats.multitest import multipletests

from benchmarks.contract.metric import PooledRatios
from benchmarks.statistics.bootstrap import bootstrap_interval, compare, holm


def pool_of(values: np.ndarray, weights: np.ndarray | None = None, seeds: np.ndarray | None = None) -> PooledRatios:
    """Return the pool of a weighted mean."""
    weights = np.ones(len(values)) if weights is None else weights
    seeds = np.arange(len(values)) if seeds is None else seeds
    return PooledRatios(seeds, (values * weights)[:, None], weights[:, None], lambda ratios: ratios[..., 0])


def test_interval_of_a_mean_is_scipys_but_for_the_draws() -> None:
    rng = np.random.default_rng(0)
    values = rng.exponential(3.0, 40)
    expected = stats.bootstrap((values,), np.mean, method="percentile", n_resamples=20_000, rng=rng).confidence_interval
    low, high = bootstrap_interval(pool_of(values))
    width = expected.high - expected.low
    assert low == pytest.approx(expected.low, abs=0.05 * width)
    assert high == pytest.approx(expected.high, abs=0.05 * width)


def test_interval_of_a_pooled_rate_resamples_seeds_not_frame_outs() -> None:
    """Against SciPy's paired bootstrap of a ratio of sums."""
    rng = np.random.default_rng(1)
    counts = rng.integers(1, 6, 30).astype(float)
    hits = rng.binomial(counts.astype(int), 0.7)
    expected = stats.bootstrap(
        (hits, counts),
        lambda a, b, axis: a.sum(axis=axis) / b.sum(axis=axis),
        paired=True,
        vectorized=True,
        method="percentile",
        n_resamples=20_000,
        rng=rng,
    ).confidence_interval
    pool = pool_of(hits / counts, counts)
    assert pool.mean == pytest.approx(hits.sum() / counts.sum())
    low, high = bootstrap_interval(pool)
    assert (low, high) == pytest.approx((expected.low, expected.high), abs=0.02)


def test_paired_difference_is_scipys_paired_bootstrap() -> None:
    rng = np.random.default_rng(2)
    base = rng.normal(10.0, 5.0, 35)
    first, second = base + rng.normal(0.5, 0.5, 35), base
    expected = stats.bootstrap(
        (first, second),
        lambda a, b, axis: a.mean(axis=axis) - b.mean(axis=axis),
        paired=True,
        vectorized=True,
        method="percentile",
        n_resamples=20_000,
        rng=rng,
    ).confidence_interval
    found = compare(pool_of(first), pool_of(second))
    assert found.difference == pytest.approx((first - second).mean())
    assert (found.ci_low, found.ci_high) == pytest.approx((expected.low, expected.high), abs=0.03)
    # Unpaired, the spread between episodes would hide it.
    assert found.ci_low > 0


def test_p_is_that_of_scipys_permutation_test() -> None:
    rng = np.random.default_rng(3)
    second = rng.normal(0.0, 1.0, 12)
    first = second + rng.normal(0.45, 1.0, 12)
    expected = stats.permutation_test(
        (first, second), lambda a, b: np.mean(a) - np.mean(b), permutation_type="samples", n_resamples=np.inf
    )
    assert compare(pool_of(first), pool_of(second)).p == pytest.approx(expected.pvalue, abs=0.025)


def test_p_is_uniform_where_there_is_no_difference() -> None:
    """A test at 5 % errs in 5 % of cases: 3.5 standard errors allowed."""
    rng = np.random.default_rng(4)
    trials = 300
    p = [compare(pool_of(rng.normal(size=14)), pool_of(rng.normal(size=14)), resamples=400).p for _ in range(trials)]
    assert np.mean(np.array(p) < 0.05) == pytest.approx(0.05, abs=3.5 * np.sqrt(0.05 * 0.95 / trials))


def test_equal_trackers_do_not_differ() -> None:
    values = np.random.default_rng(5).normal(size=20)
    found = compare(pool_of(values), pool_of(values))
    assert (found.difference, found.ci_low, found.ci_high, found.p) == (0.0, 0.0, 0.0, 1.0)


def test_only_common_seeds_count() -> None:
    first = pool_of(np.array([1.0, 2.0, 3.0]), seeds=np.array([1, 2, 3]))
    second = pool_of(np.array([5.0, 5.0]), seeds=np.array([2, 9]))
    found = compare(first, second)
    assert (found.difference, found.n) == (-3.0, 1)
    with pytest.raises(ValueError, match="seeds: expected some that both"):
        compare(first, pool_of(np.array([1.0]), seeds=np.array([7])))


def test_seeds_that_say_nothing_are_not_counted() -> None:
    pool = pool_of(np.array([1.0, 0.0, 0.5]), weights=np.array([1.0, 0.0, 1.0]))
    assert pool.seed_count == 2
    assert pool.mean == 0.75


def test_a_single_seed_has_no_interval() -> None:
    """Also one beside others that say nothing."""
    one, other = pool_of(np.array([1.0])), pool_of(np.array([0.5]))
    assert np.isnan(bootstrap_interval(one)).all()
    assert np.isnan(bootstrap_interval(pool_of(np.array([1.0, 0.3]), weights=np.array([1.0, 0.0])))).all()
    found = compare(one, other)
    assert (found.difference, found.n) == (0.5, 1)
    assert np.isnan([found.ci_low, found.ci_high]).all()


def test_the_same_rows_give_the_same_interval() -> None:
    values = np.random.default_rng(6).normal(size=20)
    assert bootstrap_interval(pool_of(values)) == bootstrap_interval(pool_of(values.copy()))


@pytest.mark.heavy
def test_holm_is_statsmodels_and_textbook() -> None:
    p = np.array([0.01, 0.04, 0.03, 0.005])
    # By hand: sorted 0.005 x 4, 0.01 x 3, 0.03 x 2, 0.04 x 1, then the running maximum.
    np.testing.assert_allclose(holm(p), [0.03, 0.06, 0.06, 0.02])
    np.testing.assert_allclose(holm(p), multipletests(p, method="holm")[1])
    assert len(holm(np.array([]))) == 0
