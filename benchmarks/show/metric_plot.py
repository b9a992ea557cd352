"""A figure of one metric: a dot with its interval for each contestant."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes

from benchmarks.contract.suite import Condition, suite
from benchmarks.contract.text import number_text
from benchmarks.show.charts import DotChart
from benchmarks.show.palette import line_styles
from benchmarks.show.plots import ShownFigure, draw_dots, drawn_as
from benchmarks.show.tables import column_of, names_and_roles, rank
from benchmarks.statistics.bootstrap import Interval
from benchmarks.statistics.summary import condition_of, label_of, steering_words
from sim.checks import check

_WIDTH_INCHES, _LINE_INCHES, _FRAME_INCHES = 6.4, 0.28, 0.9
"""Width of the figure, height of a contestant's line, and of what stands above and below a condition's lines."""

Entry = dict[str, Any]


def metric_figure(summary: Sequence[Entry], metric: str) -> ShownFigure:
    """Return a figure of the means and 95 % intervals of a metric, axes for each condition that has it.

    Args:
        summary: the list of ``summary.json``. metric: its name there.

    Raises:
        ValueError: for a metric that no entry has; lists those that there are.
    """
    known = list(dict.fromkeys(entry["metric"] for entry in summary))
    check("metric", metric in known, f"one of {', '.join(known)}", repr(metric))
    groups: dict[Condition, list[Entry]] = {}
    for entry in summary:
        groups.setdefault(condition_of(entry), []).append(entry)
    shown = {
        condition: mine
        for condition, entries in groups.items()
        if (mine := [entry for entry in entries if entry["metric"] == metric])
    }
    heights = [_FRAME_INCHES + _LINE_INCHES * len(entries) for entries in shown.values()]
    with drawn_as(metric):
        figure = ShownFigure(figsize=(_WIDTH_INCHES, sum(heights)), layout="constrained")
        places = figure.subplots(len(shown), squeeze=False, height_ratios=heights)[:, 0]
        for axes, (condition, entries) in zip(places, shown.items(), strict=True):
            _draw(axes, condition, entries, groups[condition])
    return figure


def _draw(axes: Axes, condition: Condition, entries: Sequence[Entry], everything: Sequence[Entry]) -> None:
    """Draw the entries from the top: the better the mean, the higher; one without a mean has no dot.

    Colours are the report's, which depend on all contestants of the condition.
    """
    scores = suite(condition[0])
    metric = scores.metric(entries[0]["metric"])
    styles = line_styles(names_and_roles(scores, everything))
    by_name = {label_of(entry): (styles[scores.names_of(entry)[0]], entry) for entry in entries}
    ranked = sorted(by_name, key=lambda name: rank(metric, by_name[name][1]))
    _, scenario, preset, renderer, _ = condition
    episodes = max(entry["n"] for entry in entries)
    column = column_of(metric)
    unit = f" ({column.unit})" if column.unit and metric.unit != "fraction" else ""
    goal = f"{metric.better} is better"
    if metric.ideal is not None:
        goal = f"ideal: {number_text(metric.ideal, metric.unit)} {column.unit}".rstrip()
    chart = DotChart(
        title=f"{scenario} {preset}, {steering_words(condition)}, {renderer}, {episodes} seeds, 95 % intervals",
        words="",
        lines={name: {name: _interval(by_name[name][1])} for name in ranked},
        x_label=f"{column.title}{unit}, {goal}",
        x_scale="share" if metric.unit == "fraction" else "linear",
    )
    draw_dots(axes, chart, {name: style for name, (style, _) in by_name.items()})
    axes.set_xlabel(chart.x_label)
    axes.set_title(chart.title, loc="left", fontsize=9)


def _interval(entry: Entry) -> Interval:
    mean = math.nan if entry["mean"] is None else entry["mean"]
    return Interval(mean, *(mean if entry[key] is None else entry[key] for key in ("ci_low", "ci_high")))
