"""Intervals and comparisons over seeds.

Seeds are resampled, not frames or frame-outs, which are correlated within an episode. What is resampled are
``contract.metric.PooledRatios``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.metric import PooledRatios, Statistic
from benchmarks.contract.rows import Row
from sim.checks import check
from sim.rng import generator

RESAMPLES = 4000
CONFIDENCE = 0.95
_FEWEST_SEEDS = 2


@dataclass(frozen=True, slots=True)
class Comparison:
    """A paired difference of two trackers.

    Attributes:
        difference: first minus second.
        ci_low, ci_high: 95 % percentile bootstrap interval over the common seeds; NaN for fewer than two of them.
        p: two-sided, of the paired permutation test (swaps the trackers' names within seeds).
        n: number of common seeds that contribute to both.
    """

    difference: float
    ci_low: float
    ci_high: float
    p: float
    n: int


class Interval(NamedTuple):
    """A statistic with the ends of its 95 % bootstrap interval, NaN for fewer than two seeds."""

    mean: float
    low: float
    high: float


def interval_of(statistic: Statistic, rows: Sequence[Row]) -> Interval | None:
    """Return a statistic of the rows of one tracker; None where no seed contributes."""
    pool = statistic.pooled(rows)
    if pool is None or pool.seed_count == 0:
        return None
    return Interval(pool.mean, *bootstrap_interval(pool))


def intervals_of(statistic: Statistic, rows: Mapping[str, Sequence[Row]]) -> dict[str, Interval]:
    """Return a statistic of each tracker's rows, without those of which no seed contributes."""
    found = {name: interval_of(statistic, own) for name, own in rows.items()}
    return {name: each for name, each in found.items() if each is not None}


def bootstrap_interval(pool: PooledRatios) -> tuple[float, float]:
    """Return the 95 % percentile bootstrap interval over seeds (Efron 1979); the same rows give the same interval.

    It is NaN where fewer than two seeds contribute, which tell nothing of how seeds differ.
    """
    if pool.seed_count < _FEWEST_SEEDS:
        return float("nan"), float("nan")
    return percentile_interval(pool.value(resample(len(pool.seeds), RESAMPLES)))


def compare(first: PooledRatios, second: PooledRatios, resamples: int = RESAMPLES) -> Comparison:
    """Return the paired comparison of two trackers on the seeds both have.

    Raises:
        ValueError: if they have none in common.
    """
    seeds = np.intersect1d(first.seeds, second.seeds)
    check("seeds", len(seeds) > 0, "some that both trackers ran on", "none in common")
    a, b = first.on(seeds), second.on(seeds)
    both = int(((a.denominators.sum(axis=1) > 0) & (b.denominators.sum(axis=1) > 0)).sum())
    counts = resample(len(seeds), resamples)
    low, high = percentile_interval(a.value(counts) - b.value(counts)) if both >= _FEWEST_SEEDS else (float("nan"),) * 2
    return Comparison(a.mean - b.mean, low, high, _permutation_p(a, b, resamples), both)


def holm(p_values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return p-values (K,) adjusted for K comparisons by Holm's step-down method (Holm 1979; statsmodels)."""
    if len(p_values) == 0:
        return p_values
    # It takes longer to import than all of bench, which needs it where trackers are compared.
    from statsmodels.stats.multitest import multipletests

    return multipletests(p_values, method="holm")[1]


def _permutation_p(a: PooledRatios, b: PooledRatios, resamples: int) -> float:
    """Return ``(1 + #{|d*| >= |d|}) / (1 + resamples)`` over random swaps of the trackers' names within seeds."""
    rng = generator(len(a.seeds), "statistics/permutation")
    kept = rng.integers(0, 2, (resamples, len(a.seeds))).astype(float)

    def mixed(x: PooledRatios, y: PooledRatios) -> NDArray[np.float64]:
        return x.finished(
            kept @ x.numerators + (1 - kept) @ y.numerators,
            kept @ x.denominators + (1 - kept) @ y.denominators,
        )

    observed = abs(a.mean - b.mean)
    swapped = np.abs(mixed(a, b) - mixed(b, a))
    # Sums in another order differ in their last bits, which must not count as smaller.
    return float((1 + np.count_nonzero(swapped >= observed - 1e-9 * max(1.0, observed))) / (1 + resamples))


@lru_cache(maxsize=4)
def resample(seed_count: int, resamples: int, stream: str = "statistics/bootstrap") -> NDArray[np.float64]:
    """Return how often each seed is drawn in each resample (resamples, S), with replacement; streams have their own."""
    rng = generator(seed_count, stream)
    drawn = rng.integers(0, seed_count, (resamples, seed_count))
    counts = np.zeros((resamples, seed_count))
    np.add.at(counts, (np.arange(resamples)[:, None], drawn), 1.0)
    counts.flags.writeable = False
    return counts


def percentile_interval(values: NDArray[np.float64]) -> tuple[float, float]:
    """Return the ends of the middle 95 % of values (R,), without those that are not finite; NaN without any."""
    usable = values[np.isfinite(values)]
    if len(usable) == 0:
        return float("nan"), float("nan")
    tail = 50 * (1 - CONFIDENCE)
    low, high = np.percentile(usable, [tail, 100 - tail])
    return float(low), float(high)
