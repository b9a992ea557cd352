"""Figures of charts by matplotlib, in the report's style (``report.mplstyle``)."""

from __future__ import annotations

import io
import re
from collections.abc import Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, PercentFormatter

from benchmarks.show.charts import Chart, Points, Scale
from benchmarks.show.palette import BANDED, GRID, GROUND, QUIET, LineStyles

_STYLE = Path(__file__).with_name("report.mplstyle")
_ENTRY_INCHES, _ENTRIES_A_LINE = 0.2, 3
_HANDLE_INCHES, _LETTER_INCHES = 0.5, 0.06
"""Width of an entry of a legend beside its text, and of a letter of that."""
_MARKERS = "osD^vP*X<>ph"
"""Of the points of trackers of one colour."""
_LINE_INCHES, _FRAME_INCHES = 0.28, 0.9
"""Least height of a line of dots, and of what stands above and below all."""
_DECADES = 1e4
"""Largest value of a log axis over its least one; what is smaller lies outside."""
_GROUP_HEIGHT = 0.6
"""Height of the dots on one line together; 1 is the distance of lines."""
_NOTE: dict[str, Any] = {
    "color": QUIET,
    "fontsize": 9,
    "bbox": {"facecolor": GROUND, "alpha": 0.8, "linewidth": 0, "pad": 1.0},
    "zorder": 5,
}
"""Look of text over lines."""


class Plot(NamedTuple):
    """A figure of a page with its text; ``svg`` as the function of that name returns it."""

    title: str
    words: str
    svg: str


class ShownFigure(Figure):
    """A figure that a notebook shows as a picture, with or without ``matplotlib.pyplot``."""

    def _repr_png_(self) -> bytes:
        buffer = io.BytesIO()
        self.savefig(buffer, format="png", dpi=100)
        return buffer.getvalue()


def drawn_as(name: str) -> AbstractContextManager[None]:
    """Set the report's style for one figure; ids in its SVG come from ``name``, so that those on one page differ."""
    return matplotlib.rc_context({"svg.hashsalt": name}, _STYLE)


def plot_of(chart: Chart, styles: LineStyles) -> Plot:
    """Return a chart as a figure of a page."""
    figure = figure_of(chart, styles)
    with drawn_as(chart.title):
        return Plot(chart.title, chart.words, svg(figure))


def figure_of(chart: Chart, styles: LineStyles, *, titled: bool = False) -> ShownFigure:
    """Return a chart as a figure with a legend, ``titled`` or not."""
    with drawn_as(chart.title):
        figure, axes = new_figure(chart.x_label, chart.y_label)
        if chart.lines is None:
            _draw_curves(axes, chart, styles)
            _draw_points(axes, chart.points or {}, styles)
            _scale(axes, "y", chart.y_scale)
        else:
            figure.set_figheight(max(figure.get_figheight(), _FRAME_INCHES + _LINE_INCHES * len(chart.lines)))
            _draw_dots(axes, chart, styles)
        _scale(axes, "x", chart.x_scale)
        if entries := len(labels := axes.get_legend_handles_labels()[1]):
            fitting = figure.get_figwidth() / (_HANDLE_INCHES + _LETTER_INCHES * max(map(len, labels)))
            a_line = max(1, min(_ENTRIES_A_LINE, int(fitting)))
            lines = bool(chart.legend) - (-entries // a_line)
            figure.set_figheight(figure.get_figheight() + lines * _ENTRY_INCHES)
            figure.legend(loc="outside lower center", ncols=min(entries, a_line), title=chart.legend, title_fontsize=8)
        if titled:
            figure.suptitle(chart.title, fontsize=11)
    return figure


def _draw_curves(axes: Axes, chart: Chart, styles: LineStyles) -> None:
    curves = chart.curves or {}
    for name in dict.fromkeys((*chart.labels, *styles)):
        if name in curves:
            (x, mean, low, high), style = curves[name], styles[name]
            label = chart.labels.get(name, name)
            axes.plot(x, mean, label=label, drawstyle="steps-post" if chart.steps else "default", **style)
            if style["zorder"] >= BANDED:
                step: Any = "post" if chart.steps else None
                axes.fill_between(x, low, high, step=step, color=style["color"], alpha=0.16, lw=0, zorder=2)
    if chart.rule is not None:
        y, words = chart.rule
        axes.axhline(y, color=QUIET, linewidth=0.9, dashes=(1, 2))
        place = axes.get_yaxis_transform()
        axes.annotate(words, (1, y), xytext=(0, 3), xycoords=place, textcoords="offset points", ha="right", **_NOTE)
    if chart.mark is not None:
        at_x, words = chart.mark
        axes.axvline(at_x, color=QUIET, linewidth=0.9, dashes=(1, 2))
        place = axes.get_xaxis_transform()
        axes.annotate(words, (at_x, 0.02), xytext=(3, 0), xycoords=place, textcoords="offset points", **_NOTE)
    if chart.shaded is not None:
        end, words = chart.shaded
        axes.axvspan(0, end, color=GRID, alpha=0.5, linewidth=0)
        axes.annotate(words, (end + 0.8, 0.02), **_NOTE)


def _draw_points(axes: Axes, points: Mapping[str, Points], styles: LineStyles) -> None:
    """Draw points with their intervals; those of a tracker are joined, each with its text."""
    drawn = [name for name in styles if name in points]
    for name in drawn:
        own, colour = points[name], styles[name]["color"]
        alike = [each for each in drawn if styles[each]["color"] == colour]
        marker = _MARKERS[alike.index(name) % len(_MARKERS)]
        x, y = ([interval.mean for interval in some] for some in (own.x, own.y))
        # Ends that are not known, of a single seed, are drawn as the value itself.
        away_x, away_y = (
            np.nan_to_num([(each.mean - each.low, each.high - each.mean) for each in some]).clip(0).T
            for some in (own.x, own.y)
        )
        look = {"color": colour, "marker": marker, "markersize": 6, "markeredgewidth": 0, "linewidth": 1.4}
        axes.errorbar(x, y, away_y, away_x, label=name, elinewidth=1.0, **look)
        note = {"color": colour, "fontsize": 8, "ha": "center", "textcoords": "offset points"}
        for place, text in enumerate(own.texts):
            # Neighbours stand on both sides of the line.
            beside = (7, 6 if place % 2 == 0 else -12)
            axes.annotate(text, (x[place], y[place]), xytext=beside, **note)


def _draw_dots(axes: Axes, chart: Chart, styles: LineStyles) -> None:
    """Draw the dots of a chart with their intervals, the first line above; a tracker on its own line has no entry."""
    lines = chart.lines or {}
    names = [name for name in styles if any(name in values for values in lines.values())]
    alone = all(len(values) <= 1 for values in lines.values())
    height = 0.0 if alone or len(names) == 1 else 0.5 * _GROUP_HEIGHT
    for name, offset in zip(names, np.linspace(-height, height, len(names)), strict=True):
        own = [(place + offset, *lines[line][name]) for place, line in enumerate(lines) if name in lines[line]]
        y, mean, low, high = np.array(own).T
        label = "" if alone and name in lines else name
        axes.hlines(y, low, high, color=styles[name]["color"], linewidth=1.8)
        axes.plot(mean, y, "o", color=styles[name]["color"], label=label, markersize=5, markeredgewidth=0)
    axes.set_yticks(range(len(lines)), list(lines))
    axes.set_ylim(len(lines) - 0.4, -0.6)
    axes.grid(False, axis="y")
    if chart.x_scale == "log":
        axes.set_xlim(0.6 * axes.dataLim.x0, 1.6 * axes.dataLim.x1)
    for place in range(1, len(lines)):
        axes.axhline(place - 0.5, color=GRID, linewidth=0.6)


def _scale(axes: Axes, which: str, scale: Scale) -> None:
    """Set scale, limits and labels of the axis ``x`` or ``y``."""
    axis: Axis = getattr(axes, f"{which}axis")
    if scale == "frames":
        axes.set_xlim(0, max(axes.dataLim.x1, 1))
        axis.set_major_locator(MaxNLocator(integer=True))
    elif scale == "share":
        axes.set(**{f"{which}lim": (-0.01, 1.01)})
        axis.set_major_formatter(PercentFormatter(1.0))
    elif scale == "log":
        axes.set(**{f"{which}scale": "log"})
        low, high = axis.get_view_interval()
        # An error of almost nothing would squeeze all others.
        low = max(low, high / _DECADES)
        axes.set(**{f"{which}lim": (low, high)})
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high < 1000 * low else (1.0,)))
        # Plain numbers, not powers.
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter("")


def new_figure(x_label: str, y_label: str) -> tuple[ShownFigure, Axes]:
    """Return a figure of the report's size with labelled axes."""
    figure = ShownFigure()
    return figure, figure.add_subplot(xlabel=x_label, ylabel=y_label)


def svg(figure: Figure) -> str:
    """Return the figure as an SVG element without date, prologue or fixed size: the same rows make the same bytes."""
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None}, transparent=True)
    text = buffer.getvalue()
    text = re.sub(r"<metadata>.*?</metadata>", "", text[text.index("<svg") :], flags=re.DOTALL)
    return re.sub(r' width="[^"]*" height="[^"]*"', ' role="img"', text, count=1).strip()
