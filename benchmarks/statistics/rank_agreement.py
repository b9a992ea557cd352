"""Agreement of the ranks of trackers on real sequences with those in simulated episodes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import reduce
from itertools import product

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.metric import Metric, PooledRatios
from benchmarks.contract.rows import REAL, Row
from benchmarks.contract.suite import Condition, Suite
from benchmarks.statistics.bootstrap import RESAMPLES, percentile_interval, resample
from benchmarks.statistics.summary import grouped

_LEAST_TRACKERS = 3
"""Two can only agree or disagree."""
_FEWEST_SEEDS = 2


def rank_agreement(suite: Suite, real: Sequence[Row], simulated: Sequence[Row]) -> list[str]:
    """Return lines of text: for each metric of the real leaderboard both orders and Kendall's tau-b between them.

    Only trackers that have run on both count, on the sequences and the seeds that they have in common; there is no line
    for fewer than three, or where all are equal. Speed is left out, as it is the machine's too. tau is 1 for the same
    order and -1 for the opposite one; p tests that tau is 0, see ``scipy.stats.kendalltau``. The 95 % interval is a
    percentile bootstrap over sequences and, apart from these, over seeds: it says how tau varies with what trackers
    were run on, not with which trackers there are.
    Where other frames or events count on real sequences than in simulated episodes both are said.

    Args:
        real, simulated: rows; those of other suites, and simulated ones among ``real``, are left out.
    """
    assert suite.on_sequences is not None
    ours = {where: rows for where, rows in grouped(real).items() if where[:2] == (suite.name, REAL)}
    others = {where: rows for where, rows in grouped(simulated).items() if where[0] == suite.name and where[1] != REAL}
    lines: list[str] = []
    for name, (where, elsewhere) in product(suite.on_sequences.headline, product(ours, others)):
        if name != "frames_per_s":
            found = list(_agreement(suite.metric(name), ours[where], others[elsewhere], (where, elsewhere)))
            lines += [*found, *_conditions(suite, suite.metric(name))] if found else []
    return lines or ["no ranks to compare: they need three trackers that have run on both, and figures that differ"]


def _agreement(
    metric: Metric,
    real: Mapping[str, Sequence[Row]],
    simulated: Mapping[str, Sequence[Row]],
    conditions: tuple[Condition, Condition],
) -> Iterator[str]:
    """Yield tau and both orders in one metric; nothing where there are no ranks."""
    # scipy.stats takes longer to import than all of bench, which needs it for runs on real pictures alone.
    from scipy.stats import kendalltau

    both = [name for name in real if name in simulated]
    pools = [_pools(metric, {name: rows[name] for name in both}) for rows in (real, simulated)]
    names = [name for name in both if all(name in each for each in pools)]
    first, second = ([pool[name].mean for name in names] for pool in pools)
    if len(names) < _LEAST_TRACKERS or len(set(first)) == 1 or len(set(second)) == 1:
        return
    tau, p = kendalltau(first, second)
    sides = dict(zip(("real", "simulated"), pools, strict=True))
    drawn = [_resampled([pool[name] for name in names], f"statistics/ranks/{side}") for side, pool in sides.items()]
    low, high = percentile_interval(tau_b(*drawn)) if all(map(len, drawn)) else (float("nan"),) * 2
    interval = f", {low:.2f} … {high:.2f}" if np.isfinite(low) else ""
    told = " and ".join(_words(each) for each in conditions)
    yield f"{metric.name}, {told}: Kendall's tau {tau:.2f}{interval} (p {p:.2f}, {len(names)} trackers)"
    for side, pool in sides.items():
        best = sorted(names, key=lambda name: pool[name].mean, reverse=metric.better == "higher")
        yield f"  {side}: {', '.join(f'{name} {pool[name].mean:.3g}' for name in best)}"


def _pools(metric: Metric, rows: Mapping[str, Sequence[Row]]) -> dict[str, PooledRatios]:
    """Return the sums of each tracker with a value, on the seeds that all of them have."""
    found = {name: pool for name, own in rows.items() if (pool := metric.statistic.pooled(own)) is not None}
    common = reduce(np.intersect1d, [each.seeds for each in found.values()]) if found else np.empty(0, np.int64)
    shared = {name: each.on(common) for name, each in found.items() if len(common)}
    return {name: each for name, each in shared.items() if np.isfinite(each.mean)}


def _resampled(pools: Sequence[PooledRatios], stream: str) -> NDArray[np.float64]:
    """Return the values of trackers (resamples, T) on seeds drawn with replacement, the same for all; (0, T) of one."""
    count = len(pools[0].seeds)
    drawn = resample(count, RESAMPLES, stream) if count >= _FEWEST_SEEDS else np.empty((0, count))
    return np.stack([pool.value(drawn) for pool in pools], axis=1)


def tau_b(first: NDArray[np.float64], second: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return Kendall's tau-b (R,) between the values (R, T) of T trackers; NaN where all of one side are equal.

    ``tau = sum sign(x_i - x_j) sign(y_i - y_j) / sqrt(n_x n_y)`` over pairs i < j, with n the number of pairs that are
    no tie. Kendall, The treatment of ties in ranking problems, Biometrika 33, 1945.
    """
    i, j = np.triu_indices(first.shape[1], 1)
    signs = [np.sign(values[:, i] - values[:, j]) for values in (first, second)]
    untied = np.prod([np.abs(each).sum(axis=1) for each in signs], axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        return (signs[0] * signs[1]).sum(axis=1) / np.sqrt(untied)


def _conditions(suite: Suite, metric: Metric) -> Iterator[str]:
    """Yield what counts on real sequences and in simulated episodes, where that is not the same."""
    assert suite.on_sequences is not None
    for of in metric.statistic.of:
        words = suite.on_sequences.conditions.get(of.name, of.conditions)
        if words != of.conditions:
            yield f"  {of.name} counts, real: {words}"
            yield f"  {of.name} counts, simulated: {of.conditions}"


def _words(condition: Condition) -> str:
    _, scenario, preset, renderer, steering = condition
    return " ".join(dict.fromkeys(filter(None, (scenario, preset, renderer, steering))))
