"""The report's curves of one tracker, from its rows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.metric import PooledRatios, Quantity
from benchmarks.contract.rows import Row
from benchmarks.statistics import froc
from benchmarks.statistics.pooling import Froc, RestrictedMean, still_waiting
from sim.rng import generator

_RESAMPLES = 1000
FEWEST = 3
"""Least number of frame-outs of a drawn mean."""
RECOVERY_FRAMES = 45
"""Length of the recovery curve."""


@dataclass(frozen=True, eq=False)
class Curve:
    """A line with a 95 % band; all (K,).

    Attributes:
        x, y: the line. low, high: its band.
        count: number of values in each mean, e.g. frame-outs.
    """

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]
    count: NDArray[np.float64]


def offscreen_error(rows: Sequence[Row]) -> Curve | None:
    """Mean error in metres against frames since the exit, over the frame-outs of at least that length.

    The band is a percentile bootstrap over seeds. The curve ends where fewer than ``FEWEST`` frame-outs are left; None
    if it would be empty.
    """
    sums = _sums_by_seed(rows, "offscreen_error_by_frame_m")
    return None if sums is None else _with_band(sums, x=np.arange(sums.numerators.shape[1], dtype=float))


def calibration(rows: Sequence[Row]) -> Curve | None:
    """Share of frames outside whose truth lies in the posterior's p region, against p; None without posterior.

    The band is a percentile bootstrap over seeds. A calibrated posterior gives the diagonal.
    """
    sums = _sums_by_seed(rows, "credible_level_histogram")
    if sums is None:
        return None
    bins = sums.numerators.shape[1]
    cumulative = PooledRatios(sums.seeds, np.cumsum(sums.numerators, axis=1), sums.denominators, lambda ratios: ratios)
    inner = _with_band(cumulative, x=(np.arange(bins) + 1.0) / bins)
    if inner is None:
        return None
    x, y, low, high = (np.concatenate([[0.0], line]) for line in (inner.x, inner.y, inner.low, inner.high))
    return Curve(x, y, low, high, np.concatenate([inner.count[:1], inner.count]))


def recovery(rows: Sequence[Row], until_frames: int = RECOVERY_FRAMES) -> Curve | None:
    """Share of targets found again, against frames since the watch began, up to ``until_frames``.

    Kaplan-Meier, see ``still_waiting``; a target never found is censored at the end of its watch. The band is a
    percentile bootstrap over seeds. None without targets to find.
    """
    times, watched = Quantity("recovery_frames"), Quantity("watched_frames")
    pool = RestrictedMean(until_frames + 1, times, watched).pooled(rows)
    if pool is None:
        return None
    found = replace(pool, finish=lambda hazards: 1.0 - still_waiting(hazards))
    return _with_band(found, x=np.arange(until_frames + 1.0), fewest=0)


def found_at_alarms(rows: Sequence[Row], statistic: Froc, alarms_per_hour: NDArray[np.float64]) -> Curve | None:
    """Return the share found against false alarms an hour (K,), see ``scores.froc``; None without rows.

    The band is a percentile bootstrap over seeds.
    """
    pool = statistic.pooled(rows)
    if pool is None:
        return None

    def points(counts: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.stack([froc.found_at(counts, float(each)) for each in alarms_per_hour], axis=-1)

    sums = replace(pool, finish=points)
    kept, count = np.ones(len(alarms_per_hour), bool), np.full(len(alarms_per_hour), float(len(pool.seeds)))
    return Curve(alarms_per_hour, *_line_and_band(sums, kept), count)


def series_mean(rows: Sequence[Row], metric: str, x: NDArray[np.float64]) -> Curve | None:
    """Return the mean of a series, entry by entry, at ``x``, as long as its longest row; None without rows.

    The band is a percentile bootstrap over seeds.
    """
    sums = _sums_by_seed(rows, metric)
    return None if sums is None else _with_band(sums, x[: sums.numerators.shape[1]], fewest=1)


def _sums_by_seed(rows: Sequence[Row], metric: str) -> PooledRatios | None:
    """Add up the series of a metric by seed, entry by entry; shorter series contribute nothing to later entries."""
    chosen = [row for row in rows if row["metric"] == metric and row["value"] is not None]
    if not chosen:
        return None
    seeds = np.unique([row["seed"] for row in chosen])
    longest = max(len(row["value"]) for row in chosen)
    numerators, denominators = np.zeros((2, len(seeds), longest))
    for row in chosen:
        place = np.searchsorted(seeds, row["seed"])
        values = np.array(row["value"], dtype=float)
        known = np.flatnonzero(np.isfinite(values))
        numerators[place, known] += row["weight"] * values[known]
        denominators[place, known] += row["weight"]
    return PooledRatios(seeds, numerators, denominators, lambda ratios: ratios)


def _with_band(sums: PooledRatios, x: NDArray[np.float64], fewest: int = FEWEST) -> Curve | None:
    count = sums.denominators.sum(axis=0)
    kept = count >= fewest
    if not kept.any():
        return None
    return Curve(x[kept], *_line_and_band(sums, kept), count[kept])


def _line_and_band(
    sums: PooledRatios, kept: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return the entries of a statistic (K,) that are ``kept`` (K,), and the ends of their 95 % band."""
    seed_count = len(sums.seeds)
    rng = generator(seed_count, "report/bootstrap")
    draws = rng.multinomial(seed_count, np.full(seed_count, 1.0 / seed_count), size=_RESAMPLES)
    low, high = np.nanpercentile(sums.value(draws.astype(float))[:, kept], [2.5, 97.5], axis=0)
    return sums.value(np.ones(seed_count))[kept], low, high
