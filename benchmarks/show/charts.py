"""Charts of the report as numbers: curves with bands, and dots with intervals; ``plots`` draws them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import zip_longest
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.metric import Metric, PooledRatios, Quantity, Statistic, collected
from benchmarks.contract.rows import Row
from benchmarks.contract.text import interval_text, number_text
from benchmarks.show.tables import UNRANKED_ROLES
from benchmarks.statistics import froc
from benchmarks.statistics.bootstrap import Interval, intervals_of
from benchmarks.statistics.pooling import Froc, RestrictedMean, still_waiting
from sim.rng import generator

_RESAMPLES = 1000
FEWEST = 3
"""Least number of frame-outs of a drawn mean."""
RECOVERY_FRAMES = 45
"""Length of the recovery curve."""

Scale = Literal["share", "log", "linear", "frames"]
"""``share``: 0 to 1, labelled in per cent; ``frames``: whole numbers from 0 to the last one."""


class Curve(NamedTuple):
    """A line with a 95 % band; all (K,)."""

    x: NDArray[np.float64]
    mean: NDArray[np.float64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]


class Points(NamedTuple):
    """Points that belong together, with their 95 % intervals in both directions, and a text beside each."""

    x: Sequence[Interval]
    y: Sequence[Interval]
    texts: Sequence[str]


@dataclass(frozen=True, eq=False, kw_only=True)
class Chart:
    """A curve for each tracker, dots with intervals on named lines, or points. One without values is not drawn.

    Attributes:
        title, words: text above and below the figure.
        curves: by tracker.
        lines: in place of curves: name of a line → tracker → value.
        points: in place of curves: by tracker.
        labels: tracker → its text in the legend, in the legend's order; those that are missing have their names.
        legend: what stands above them.
        x_label, y_label, x_scale, y_scale: of the axes; lines have no y axis.
        steps: whether a curve's value holds until the next one.
        shaded: part of the x axis from 0 on, and what it means.
        rule: a value on the y axis with a line of its own, and what it means. mark: the same of the x axis.
    """

    title: str
    words: str
    curves: Mapping[str, Curve] | None = None
    lines: Mapping[str, Mapping[str, Interval]] | None = None
    points: Mapping[str, Points] | None = None
    labels: Mapping[str, str] = field(default_factory=dict)
    legend: str = ""
    x_label: str
    y_label: str = ""
    x_scale: Scale
    y_scale: Scale = "share"
    steps: bool = False
    shaded: tuple[float, str] | None = None
    rule: tuple[float, str] | None = None
    mark: tuple[float, str] | None = None

    @property
    def values(self) -> Mapping[str, object]:
        """The curves, the lines or the points."""
        return self.curves or self.lines or self.points or {}


def curves_of(drawn: Mapping[str, Sequence[Row]], compute: Callable[[Sequence[Row]], Curve | None]) -> dict[str, Curve]:
    """Return the curve of each tracker that has one."""
    return {name: curve for name, rows in drawn.items() if (curve := compute(rows)) is not None}


def scored(drawn: Mapping[str, Sequence[Row]], metric: Metric) -> dict[str, str]:
    """Return the labels of trackers that have a metric: their names with it and its interval, the best first, then
    references.
    """
    found = intervals_of(metric.statistic, drawn)
    order = sorted(found, key=lambda name: found[name].mean, reverse=metric.better == "higher")
    order.sort(key=lambda name: drawn[name][0]["role"] in UNRANKED_ROLES)
    texts = {name: number_text(found[name].mean, metric.unit) for name in order}
    spans = {name: interval_text(*found[name][1:], metric.unit).replace(" … ", "–") for name in order}
    return {name: f"{name} {text}" + (f" ({spans[name]})" if spans[name] else "") for name, text in texts.items()}


def lines_of(statistics: Mapping[str, Statistic], drawn: Mapping[str, Sequence[Row]]) -> dict[str, dict[str, Interval]]:
    """Return for each line its statistic of each tracker; lines without any are left out."""
    lines = {name: intervals_of(statistic, drawn) for name, statistic in statistics.items()}
    return {name: values for name, values in lines.items() if values}


def curve_of(points: Iterable[tuple[float, Interval | None]]) -> Curve | None:
    """Return the curve through values with intervals, each at its x; None without any."""
    known = [(x, *value) for x, value in points if value is not None]
    return Curve(*np.array(known).T) if known else None


def recovery(rows: Sequence[Row]) -> Curve | None:
    """Share of targets found again, against frames since the watch began, up to ``RECOVERY_FRAMES``.

    Kaplan-Meier, see ``still_waiting``; a target never found is censored at the end of its watch. The band is a
    percentile bootstrap over seeds. None without targets to find.
    """
    times, watched = Quantity("recovery_frames"), Quantity("watched_frames")
    pool = RestrictedMean(RECOVERY_FRAMES + 1, times, watched).pooled(rows)
    if pool is None:
        return None
    found = replace(pool, finish=lambda hazards: 1.0 - still_waiting(hazards))
    return _with_band(found, np.arange(RECOVERY_FRAMES + 1.0))


def found_at_alarms(rows: Sequence[Row], statistic: Froc, alarms_per_hour: NDArray[np.float64]) -> Curve | None:
    """Return the share found against false alarms an hour (K,), see ``statistics.froc``; None without rows.

    The band is a percentile bootstrap over seeds.
    """
    pool = statistic.pooled(rows)
    if pool is None:
        return None

    def points(counts: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.stack([froc.found_at(counts, float(each)) for each in alarms_per_hour], axis=-1)

    return _with_band(replace(pool, finish=points), alarms_per_hour)


def series_mean(
    rows: Sequence[Row], metric: str, first_x: float = 0.0, step_x: float = 1.0, fewest: float = 1.0
) -> Curve | None:
    """Return the mean of a series, entry by entry, at ``first_x`` and on in steps of ``step_x``; None without rows.

    An entry with less weight than ``fewest``, summed over all rows that are long enough, is left out. The band is a
    percentile bootstrap over seeds.
    """
    chosen = [row for row in rows if row["metric"] == metric and row["value"] is not None]
    if not chosen:
        return None
    values = np.array(list(zip_longest(*(row["value"] for row in chosen))), dtype=float).T
    weights = np.isfinite(values) * np.array([row["weight"] for row in chosen])[:, None]
    of_rows = [row["seed"] for row in chosen]
    sums = collected(np.unique(of_rows), [(of_rows, weights * np.nan_to_num(values), weights)], lambda ratios: ratios)
    kept = weights.sum(axis=0) >= fewest
    return _with_band(sums, first_x + step_x * np.arange(float(len(kept))), kept) if kept.any() else None


def _with_band(sums: PooledRatios, x: NDArray[np.float64], kept: NDArray[np.bool_] | slice = slice(None)) -> Curve:
    """Return the entries of a statistic that are ``kept`` with the ends of their 95 % band."""
    seed_count = len(sums.seeds)
    rng = generator(seed_count, "report/bootstrap")
    draws = rng.multinomial(seed_count, np.full(seed_count, 1.0 / seed_count), size=_RESAMPLES)
    low, high = np.nanpercentile(sums.value(draws.astype(float))[:, kept], [2.5, 97.5], axis=0)
    return Curve(x[kept], sums.value(np.ones(seed_count))[kept], low, high)
