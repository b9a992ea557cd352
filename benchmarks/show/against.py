"""One metric against another: a point for each tracker, joined where one tracker has several values of a parameter."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import inf
from typing import Any

from benchmarks.contract.metric import Metric
from benchmarks.contract.varied import varied
from benchmarks.show.charts import Chart, Points, Scale
from benchmarks.show.tables import column_of
from benchmarks.statistics.bootstrap import Interval
from benchmarks.statistics.summary import label_of


def points_of(entries: Iterable[Mapping[str, Any]], y: str, x: str) -> dict[str, Points]:
    """Return the point of each tracker; those of one with several values of a parameter together, in their order.

    Args:
        entries: of the summary, of one condition. y, x: names of metrics.
    """
    known: dict[str, dict[str, Interval]] = {}
    for entry in entries:
        if entry["mean"] is not None:
            ends = (entry["mean"] if entry[end] is None else entry[end] for end in ("ci_low", "ci_high"))
            known.setdefault(label_of(entry), {})[entry["metric"]] = Interval(entry["mean"], *ends)
    groups: dict[str, list[str]] = {}
    for name in sorted((name for name, own in known.items() if {x, y} <= own.keys()), key=_order):
        found = varied(name)
        groups.setdefault(name if found is None else found.curve, []).append(name)
    return {
        curve: Points([known[name][x] for name in own], [known[name][y] for name in own], [*map(_text, own)])
        for curve, own in groups.items()
    }


def _order(name: str) -> tuple[float, str]:
    """Return the place of a tracker among those that differ in the value of a parameter; text comes after numbers."""
    try:
        return float(_text(name) or "-inf"), ""
    except ValueError:
        return inf, _text(name)


def _text(name: str) -> str:
    found = varied(name)
    return "" if found is None else found.value


def against(points: Mapping[str, Points], y: Metric, x: Metric, title: str) -> Chart:
    """Return the chart of one metric against another."""
    beside = (
        " Beside points of one curve: the value of the parameter."
        if any(any(each.texts) for each in points.values())
        else ""
    )
    return Chart(
        title=title,
        words=f"{y.summary[:1].upper()}{y.summary[1:]}; against it: {x.summary}. With 95 % intervals.{beside}",
        points=points,
        x_label=_label(x),
        x_scale=_scale(x),
        y_label=_label(y),
        y_scale=_scale(y),
    )


def _label(metric: Metric) -> str:
    column = column_of(metric)
    unit = f" ({column.unit})" if column.unit and metric.unit != "fraction" else ""
    return f"{column.title}{unit}, {metric.better} is better"


def _scale(metric: Metric) -> Scale:
    return "share" if metric.unit == "fraction" else "log" if metric.unit in ("ms", "1/s") else "linear"
