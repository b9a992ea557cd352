"""From the rows of one tracker to the pooled ratios of one metric."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.metric import Statistic
from benchmarks.contract.rows import Row
from benchmarks.contract.suite import Metric, event_of
from benchmarks.statistics import average_precision, froc, long_term
from benchmarks.statistics.bootstrap import PooledRatios


def pooled(rows: Sequence[Row], metric: Metric, grid: NDArray[np.float64] | None = None) -> PooledRatios | None:
    """Return the sums over the rows of each seed whose ratios make a metric, and how they make it.

    Statistics:
        mean: ``sum w v / sum w`` of values v and weights w (the frames that a value is a mean of, else 1).
        median: of the values, one for each row.
        difference of medians: that of the first kind of row minus that of the second.
        froc: see ``scores.froc``: the share found, of the sums of what was found and what was to find at each
            threshold, with at most so many false alarms an hour; over a range of them its mean on a log axis. The last
            two kinds of row are the alarms at each threshold and the hours watched.
        froc at a tenth: of a pair alone, see ``at_a_tenth``.
        average precision: see ``scores.average_precision``, of the sums of boxes that are right, of all that count,
            both at each threshold, and of true boxes.
        geometric mean: root of the product of the means of two kinds of row.
        ratio of means: the mean of the first kind of row over that of the second.
        precision, recall, f: of the mean curves, at the confidence at which F is greatest.
        precision, recall, f of counts: ``A / (A + B)``, ``A / (A + C)`` and ``2 A / (2 A + B + C)`` of the sums A, B
            and C of right, wrong and missed frames.
        restricted mean: area under the Kaplan-Meier curve of the times, from 0 to the metric's horizon; a time of null
            is censored at ``watched_frames``. Frames, or seconds where there are rows ``rate_hz``.

    Args:
        rows: of one tracker under one condition. Every seed in them counts, also one without a row of the metric.
        grid: possible values of medians, ``values`` of all compared trackers; None = of these rows.

    Returns:
        None without a row of the metric, and for a metric of pairs.
    """
    seeds = np.unique([row["seed"] for row in rows])
    chosen = [_chosen(rows, name, metric.kind) for name in metric.rows]
    if not all(chosen) or metric.statistic == OF_A_PAIR:
        return None
    if metric.statistic in OF_MEDIANS:
        grid = values(rows, metric) if grid is None else grid
        parts = [_indicator_parts(some, grid) for some in chosen]
        return _collect(seeds, parts, _median_of(grid) if len(parts) == 1 else _difference_of_medians(grid))
    if metric.statistic == "froc":
        found, findable, alarms, hours = chosen
        return _collect(seeds, [_sum_parts(found, findable), _sum_parts(alarms, hours)], _froc_of(metric))
    if metric.statistic == "average precision":
        right, told, true = chosen
        return _collect(seeds, [_sum_parts(right, true), _sum_parts(right, told)], average_precision.average)
    if metric.statistic == "restricted mean":
        times, watched, *rates = chosen
        # One condition has one rate.
        frames_per_unit = rates[0][0]["value"] if rates else 1.0
        return _collect(
            seeds,
            [_survival_parts(times, watched, metric.horizon_frames)],
            lambda hazards: still_waiting(hazards).sum(axis=-1) / frames_per_unit,
        )
    if metric.statistic in _COUNTED:
        return _collect(seeds, [_count_parts(chosen, *_COUNTED[metric.statistic])], _only)
    finish = {
        "mean": _only,
        "geometric mean": _geometric_mean,
        "ratio of means": lambda ratios: ratios[..., 0] / ratios[..., 1],
        "precision": lambda ratios: _at_best(ratios)[0],
        "recall": lambda ratios: _at_best(ratios)[1],
        "f": lambda ratios: long_term.f_score(*_at_best(ratios)),
    }[metric.statistic]
    return _collect(seeds, [_mean_parts(some) for some in chosen], finish)


def at_a_tenth(
    first: Sequence[Row], second: Sequence[Row], metric: Metric
) -> tuple[PooledRatios | None, PooledRatios | None]:
    """Return the sums of two trackers, on the seeds that both ran on, for the statistic ``froc at a tenth``.

    The first one's is the share found, see ``froc``, at any threshold with at most a tenth of the false alarms an hour
    that the second one raises where it decides; the second one's is what that finds there. None without rows.

    Args:
        metric: its rows are those of ``froc``, then the false alarms an hour, and what is found, where it decides.
    """
    both = set(np.intersect1d([row["seed"] for row in first], [row["seed"] for row in second]).tolist())

    def chosen(rows: Sequence[Row], name: str) -> list[Row]:
        return [row for row in _chosen(rows, name, metric.kind) if row["seed"] in both]

    *curve, rate, decided = metric.rows
    raised = chosen(second, rate)

    def sums(rows: Sequence[Row], finish: Callable[[NDArray[np.float64]], NDArray[np.float64]]) -> PooledRatios | None:
        (found, findable, alarms, hours), own = (chosen(rows, name) for name in curve), chosen(rows, decided)
        if not (found and own and raised):
            return None
        points = [_sum_parts(found, findable), _sum_parts(alarms, hours)]
        return _collect(np.array(sorted(both)), [*points, _mean_parts(raised), _mean_parts(own)], finish)

    return (
        sums(first, lambda ratios: froc.found_at(ratios[..., :-2], 0.1 * ratios[..., -2:-1])),
        sums(second, lambda ratios: ratios[..., -1]),
    )


def values(rows: Sequence[Row], metric: Metric) -> NDArray[np.float64]:
    """Return the distinct values (K,) of a metric's rows, sorted."""
    return np.unique([row["value"] for name in metric.rows for row in _chosen(rows, name, metric.kind)])


FORMULAS: dict[Statistic, str] = {
    "mean": "Σ w v / Σ w of {0}",
    "median": "median of {0}",
    "geometric mean": "√(mean of {0} × mean of {1})",
    "ratio of means": "mean of {0} / mean of {1}",
    "precision": "mean of {0} at the confidence at which F of the mean curves {0} and {1} is greatest",
    "recall": "mean of {1} at the confidence at which F of the mean curves {0} and {1} is greatest",
    "f": "the greatest 2 P R / (P + R) over confidences of the mean curves P = {0} and R = {1}",
    "precision of counts": "A / (A + B) of the sums A of {0}, B of {1}",
    "recall of counts": "A / (A + C) of the sums A of {0}, C of {2}",
    "f of counts": "2 A / (2 A + B + C) of the sums A of {0}, B of {1}, C of {2}",
    "detection f1 of counts": "2 A / (2 A + 2 B + C) of the sums A of {0}, B of {1}, C of {2}",
    "restricted mean": "area under the Kaplan-Meier curve of {0}, censored at {1}, from 0 to {horizon} frames",
    "difference of medians": "median of {0} − median of {1}",
    "froc": "the largest Σ {0} / Σ {1} at any threshold with Σ {2} / Σ {3} at most {alarms}",
    "average precision": "mean over recalls Σ {0} / Σ {2} of the greatest precision Σ {0} / Σ {1} with as much recall",
    "froc at a tenth": (
        "Σ {0} / Σ {1} over thresholds, with at most a tenth of the other's {4}, − the other's mean of {5}"
    ),
}
"""Statistic -> formula of a metric, with its rows in place of the numbers; v are values, w weights of rows."""
OF_MEDIANS = ("median", "difference of medians")
"""Statistics whose pools have a grid of values."""
OF_A_PAIR = "froc at a tenth"
_COUNTED = {
    "precision of counts": ((1.0, 0.0, 0.0), (1.0, 1.0, 0.0)),
    "recall of counts": ((1.0, 0.0, 0.0), (1.0, 0.0, 1.0)),
    "f of counts": ((2.0, 0.0, 0.0), (2.0, 1.0, 1.0)),
    "detection f1 of counts": ((2.0, 0.0, 0.0), (2.0, 2.0, 1.0)),
}
"""Weights of a right, a wrong and a missing answer in numerator and denominator: ``A / (A + B)``, ``A / (A + C)``,
``2 P R / (P + R) = 2 A / (2 A + B + C)``, and the same with ``R = A / (A + B + C)``, see ``metrics.people``.
"""

_Parts = tuple[list[int], NDArray[np.float64], NDArray[np.float64]]
"""Seed, numerator (D,) and denominator (D,) of each row."""


def _chosen(rows: Sequence[Row], name: str, kind: str | None) -> list[Row]:
    return [
        row
        for row in rows
        if row["metric"] == name
        and (row["value"] is not None or name == "recovery_frames")
        and (kind is None or _is(event_of(row), kind))
    ]


def _is(event: dict[str, Any] | None, kind: str) -> bool:
    return event is not None and (event["kind"] == kind or event.get(kind) is True)


def _mean_parts(rows: Sequence[Row]) -> _Parts:
    """``a = weight * value, b = weight``: ratios are weighted means, series entry by entry."""
    weights = np.array([row["weight"] for row in rows])[:, None]
    numbers = np.array([np.atleast_1d(row["value"]) for row in rows], dtype=float)
    return [row["seed"] for row in rows], weights * numbers, np.broadcast_to(weights, numbers.shape)


def _indicator_parts(rows: Sequence[Row], grid: NDArray[np.float64]) -> _Parts:
    """``a_g = [value <= grid_g], b_g = 1``: ratios are the distribution function on the grid."""
    numbers = np.array([row["value"] for row in rows], dtype=float)[:, None]
    below = (numbers <= grid).astype(float)
    return [row["seed"] for row in rows], below, np.ones_like(below)


def _sum_parts(above: Sequence[Row], below: Sequence[Row]) -> _Parts:
    """``a = value of the one kind, b = value of the other`` of the same seeds: ratios are those of the sums."""
    numerators, denominators = (
        np.array([np.atleast_1d(row["value"]) for row in rows], float) for rows in (above, below)
    )
    return [row["seed"] for row in above], numerators, np.broadcast_to(denominators, numerators.shape)


def _survival_parts(times: Sequence[Row], watched: Sequence[Row], horizon_frames: int) -> _Parts:
    """``a_t = [recovered at step t], b_t = [not recovered and watched until step t]``: ratios are the hazards
    of Kaplan-Meier.
    """
    steps = np.arange(horizon_frames)
    never = np.array([row["value"] is None for row in times])
    ends = np.array([w["value"] if t["value"] is None else t["value"] for t, w in zip(times, watched, strict=True)])
    at = ends[:, None]
    events = (at == steps) & ~never[:, None]
    return [row["seed"] for row in times], events.astype(float), (at >= steps).astype(float)


def _count_parts(counts: Sequence[Sequence[Row]], above: Sequence[float], below: Sequence[float]) -> _Parts:
    """``a = above_k * count, b = below_k * count`` for rows of the k-th kind: ratios are those of the sums."""
    seeds = [row["seed"] for some in counts for row in some]
    values = np.array([[row["value"]] for some in counts for row in some], dtype=float)
    lengths = [len(some) for some in counts]
    numerators, denominators = (values * np.repeat(factors, lengths)[:, None] for factors in (above, below))
    return seeds, numerators, denominators


def _collect(
    seeds: NDArray[np.int64],
    parts: Sequence[_Parts],
    finish: Callable[[NDArray[np.float64]], NDArray[np.float64]],
) -> PooledRatios:
    sums: tuple[list[NDArray[np.float64]], list[NDArray[np.float64]]] = ([], [])
    for row_seeds, numerators, denominators in parts:
        places = np.searchsorted(seeds, row_seeds)
        for collected, each in zip(sums, (numerators, denominators), strict=True):
            total = np.zeros((len(seeds), each.shape[1]))
            np.add.at(total, places, each)
            collected.append(total)
    return PooledRatios(seeds, np.hstack(sums[0]), np.hstack(sums[1]), finish)


def _only(ratios: NDArray[np.float64]) -> NDArray[np.float64]:
    return ratios[..., 0]


def _geometric_mean(ratios: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.sqrt(ratios[..., 0] * ratios[..., 1])


def _at_best(ratios: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return precision and recall (...) at the threshold of the greatest F."""
    precision, recall = np.split(ratios, 2, axis=-1)
    best = long_term.best_f_score(precision, recall)[..., None]
    return np.take_along_axis(precision, best, -1)[..., 0], np.take_along_axis(recall, best, -1)[..., 0]


def _median_of(grid: NDArray[np.float64]) -> Callable[[NDArray[np.float64]], NDArray[np.float64]]:
    def median(below: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the mean of lower and upper median: half of the values are <= the one, half >= the other."""
        lower = grid[np.argmax(below >= 0.5 - 1e-12, axis=-1)]
        upper = grid[np.argmax(below > 0.5 + 1e-12, axis=-1)]
        return np.where(np.isnan(below[..., -1]), np.nan, 0.5 * (lower + upper))

    return median


def _difference_of_medians(grid: NDArray[np.float64]) -> Callable[[NDArray[np.float64]], NDArray[np.float64]]:
    median = _median_of(grid)

    def difference(below: NDArray[np.float64]) -> NDArray[np.float64]:
        first, second = np.split(below, 2, axis=-1)
        return median(first) - median(second)

    return difference


def _froc_of(metric: Metric) -> Callable[[NDArray[np.float64]], NDArray[np.float64]]:
    if len(metric.alarms_per_hour) == 1:
        return lambda counts: froc.found_at(counts, *metric.alarms_per_hour)
    return lambda counts: froc.area(counts, *metric.alarms_per_hour)


def still_waiting(hazards: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return Kaplan and Meier's ``S(t) = prod_{u <= t} (1 - h_u)`` (..., T) of hazards h (..., T), ``h_u = d_u / n_u``:
    d_u found at frame u among the n_u still missing; NaN (nothing is missing) leaves S unchanged.

    Its sum over t is the restricted mean. (statsmodels computes one curve a call, not one for each of thousands of
    resamples; the tests compare this function with it.)
    """
    survival: NDArray[Any] = np.cumprod(1.0 - np.nan_to_num(hazards), axis=-1)
    return survival
