"""A figure of one metric: a dot with its interval for each contestant."""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from benchmarks.contract.metric import Metric
from benchmarks.contract.suite import Condition, suite
from benchmarks.contract.text import number_text
from benchmarks.show.palette import line_styles, on_light
from benchmarks.show.plots import drawn_on_light, in_percent
from benchmarks.show.tables import column_of, every_metric
from benchmarks.statistics.summary import condition_of, label_of, steering_words
from sim.checks import check

_WIDTH_INCHES, _LINE_INCHES, _FRAME_INCHES = 6.4, 0.28, 0.9
"""Width of the figure, height of a contestant's line, and of what stands above and below a condition's lines."""

Entry = dict[str, Any]


class ShownFigure(Figure):
    """A figure that a notebook shows as a picture, with or without ``matplotlib.pyplot``."""

    def _repr_png_(self) -> bytes:
        buffer = io.BytesIO()
        self.savefig(buffer, format="png", dpi=100)
        return buffer.getvalue()


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
        if entry["metric"] == metric:
            groups.setdefault(condition_of(entry), []).append(entry)
    heights = [_FRAME_INCHES + _LINE_INCHES * len(entries) for entries in groups.values()]
    with drawn_on_light():
        figure = ShownFigure(figsize=(_WIDTH_INCHES, sum(heights)), layout="constrained")
        places = figure.subplots(len(groups), squeeze=False, height_ratios=heights)[:, 0]
        for axes, (condition, entries) in zip(places, groups.items(), strict=True):
            everything = [entry for entry in summary if condition_of(entry) == condition]
            _draw(axes, condition, entries, _colours(condition, everything))
    return figure


def _colours(condition: Condition, everything: Sequence[Entry]) -> dict[str, str]:
    """Return the colour of each contestant: the report's, which depends on all that ran beside it."""
    lines = every_metric(suite(condition[0]), everything).lines
    styles = line_styles(list({line.names[0]: line.role for line in lines}.items()))
    return {"+".join(line.names): on_light(styles[line.names[0]].colour) for line in lines}


def _draw(axes: Axes, condition: Condition, entries: Sequence[Entry], colours: dict[str, str]) -> None:
    """Draw the entries from the top: the better the mean, the higher; one without a mean has no dot."""
    metric = suite(condition[0]).metric(entries[0]["metric"])
    ranked = sorted(entries, key=lambda entry: _worth(metric, entry["mean"]))
    for place, entry in enumerate(ranked):
        if entry["mean"] is None:
            continue
        colour = colours[label_of(entry)]
        ends = [entry["mean"] if entry[key] is None else entry[key] for key in ("ci_low", "ci_high")]
        axes.plot(ends, [place, place], color=colour, linewidth=2, solid_capstyle="butt")
        axes.plot([entry["mean"]], [place], "o", color=colour, markersize=6, markeredgewidth=0)
    axes.set_yticks(range(len(ranked)), [label_of(entry) for entry in ranked])
    axes.set_ylim(-0.6, len(ranked) - 0.4)
    axes.tick_params(length=0)
    axes.grid(False, axis="y")
    axes.set_axisbelow(True)
    axes.set_xlabel(_label(metric))
    _, scenario, preset, renderer, _ = condition
    episodes = max(entry["n"] for entry in entries)
    title = f"{scenario} {preset}, {steering_words(condition)}, {renderer}, {episodes} seeds, 95 % intervals"
    axes.set_title(title, loc="left", fontsize=9)
    if metric.unit == "fraction":
        axes.set_xlim(-0.02, 1.02)
        in_percent(axes.xaxis)


def _worth(metric: Metric, mean: float | None) -> float:
    if mean is None:
        return -math.inf
    if metric.ideal is not None:
        return -abs(mean - metric.ideal)
    return mean if metric.better == "higher" else -mean


def _label(metric: Metric) -> str:
    column = column_of(metric)
    unit = f" ({column.unit})" if column.unit and metric.unit != "fraction" else ""
    goal = f"{metric.better} is better"
    if metric.ideal is not None:
        goal = f"ideal: {number_text(metric.ideal, metric.unit)} {column.unit}".rstrip()
    return f"{column.title}{unit}, {goal}"
