"""Figures in the report's style: charts drawn by matplotlib, on a light ground."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, PercentFormatter
from numpy.typing import NDArray

from benchmarks.show.charts import Chart, CurveChart, DotChart, Scale
from benchmarks.show.palette import GRID, GROUND, INK, QUIET, LineStyle, line_styles
from benchmarks.statistics.bootstrap import Interval

_WIDTH_INCHES, _HEIGHT_INCHES, _ENTRY_INCHES = 5.4, 3.7, 0.2
_ENTRIES_A_LINE = 3
_LINE_INCHES, _FRAME_INCHES = 0.28, 0.9
"""Least height of a line of dots, and of what stands above and below all."""
_GROUP_HEIGHT = 0.6
"""Height of the dots on one line together; 1 is the distance of lines."""
_SETTINGS: dict[str, Any] = {
    "svg.fonttype": "none",
    "font.size": 10,
    "axes.edgecolor": QUIET,
    "axes.labelcolor": QUIET,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": GRID,
    "grid.linewidth": 0.6,
    "xtick.color": QUIET,
    "ytick.color": QUIET,
    "xtick.major.size": 0,
    "ytick.major.size": 0,
    "xtick.minor.size": 0,
    "ytick.minor.size": 0,
    "text.color": INK,
    "figure.facecolor": GROUND,
    "legend.frameon": False,
    "legend.fontsize": 8,
}
_NOTE: dict[str, Any] = {
    "color": QUIET,
    "fontsize": 9,
    "bbox": {"facecolor": GROUND, "alpha": 0.8, "linewidth": 0, "pad": 1.0},
    "zorder": 5,
}
"""Look of text over lines."""

Styles = Mapping[str, LineStyle]


@dataclass(frozen=True, slots=True)
class Plot:
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


@contextmanager
def drawn_as(name: str) -> Iterator[None]:
    """Set the report's style for one figure; ids in its SVG come from ``name``, so that those on one page differ."""
    settings: Any = {**_SETTINGS, "svg.hashsalt": name}
    with matplotlib.rc_context(settings):
        yield


def plot_of(chart: Chart, styles: Styles) -> Plot:
    """Return a chart as a figure of a page."""
    with drawn_as(chart.title):
        return Plot(chart.title, chart.words, svg(figure_of(chart, styles)))


def figure_of(chart: Chart, styles: Styles, *, titled: bool = False) -> ShownFigure:
    """Return a chart as a figure with a legend, ``titled`` or not."""
    with drawn_as(chart.title):
        figure = _draw(chart, styles)
        if titled:
            figure.suptitle(chart.title, fontsize=11)
    return figure


def _draw(chart: Chart, styles: Styles) -> ShownFigure:
    if isinstance(chart, DotChart):
        figure, axes = new_figure(chart.x_label, "")
        figure.set_figheight(max(_HEIGHT_INCHES, _FRAME_INCHES + _LINE_INCHES * len(chart.lines)))
        styles = line_styles(list(chart.roles.items())) if chart.roles else styles
        _draw_dots(axes, chart, styles)
        # A tracker on a line of its own name needs no entry.
        named = {name for line, values in chart.lines.items() for name in values if name != line}
        handles = [
            Line2D([], [], color=style.colour, marker="o", linestyle="", label=name)
            for name, style in styles.items()
            if name in named
        ]
    else:
        figure, axes = new_figure(chart.x_label, chart.y_label)
        handles = [_draw_curve(axes, chart, name, styles[name]) for name in styles if name in chart.curves]
        _annotate(axes, chart)
        if chart.x_scale == "frames":
            count_frames(axes, max(curve.x.max(initial=0.0) for curve in chart.curves.values()))
        else:
            _scale(axes, "x", chart.x_scale)
        _scale(axes, "y", chart.y_scale)
    if handles:
        lines = -(-len(handles) // _ENTRIES_A_LINE)
        figure.set_figheight(figure.get_figheight() + lines * _ENTRY_INCHES)
        figure.legend(handles=handles, loc="outside lower center", ncols=min(len(handles), _ENTRIES_A_LINE))
    return figure


def _draw_curve(axes: Axes, chart: CurveChart, name: str, style: LineStyle) -> Line2D:
    curve, order = chart.curves[name], 4 if style.in_front else 3
    how: Any = {"drawstyle": "steps-post"} if chart.steps else {}
    (line,) = axes.plot(curve.x, curve.mean, color=style.colour, lw=style.width, zorder=order, label=name, **how)
    line.set_dashes(style.dashes or (1, 0))
    if style.banded:
        how = {"step": "post"} if chart.steps else {}
        axes.fill_between(curve.x, curve.low, curve.high, color=style.colour, alpha=0.16, lw=0, zorder=2, **how)
    return line


def _annotate(axes: Axes, chart: CurveChart) -> None:
    if chart.rule is not None:
        y, words = chart.rule
        axes.axhline(y, color=QUIET, linewidth=0.9, dashes=(1, 2))
        place = axes.get_yaxis_transform()
        axes.annotate(words, (1, y), xytext=(0, 3), xycoords=place, textcoords="offset points", ha="right", **_NOTE)
    if chart.shaded is not None:
        end, words = chart.shaded
        axes.axvspan(0, end, color=GRID, alpha=0.5, linewidth=0)
        axes.annotate(words, (end + 0.8, 0.02), **_NOTE)


def _draw_dots(axes: Axes, chart: DotChart, styles: Styles) -> None:
    """Draw the dots of a chart with their intervals, the first line above."""
    names = [name for name in styles if any(name in values for values in chart.lines.values())]
    alone = all(len(values) <= 1 for values in chart.lines.values())
    places = np.arange(len(chart.lines))[::-1]
    for place, values in zip(places, chart.lines.values(), strict=True):
        for offset, name in zip(_offsets(len(names)), names, strict=True):
            if name in values:
                _draw_dot(axes, values[name], place + (0.0 if alone else offset), styles[name].colour)
    for place in places[:-1]:
        axes.axhline(place - 0.5, color=GRID, linewidth=0.6)
    axes.set_yticks(places, list(chart.lines))
    axes.set_ylim(-0.6, len(places) - 0.4)
    axes.grid(False, axis="y")
    if chart.x_scale == "log":
        ends = [each for values in chart.lines.values() for value in values.values() for each in value]
        axes.set_xlim(0.6 * min(ends), 1.6 * max(ends))
    _scale(axes, "x", chart.x_scale)


def _offsets(count: int) -> NDArray[np.float64]:
    return np.linspace(0.5, -0.5, count) * _GROUP_HEIGHT if count > 1 else np.zeros(1)


def _draw_dot(axes: Axes, value: Interval, y: float, colour: str) -> None:
    axes.plot([value.low, value.high], [y, y], color=colour, linewidth=1.8, solid_capstyle="butt")
    axes.plot([value.mean], [y], "o", color=colour, markersize=5, markeredgewidth=0)


def _scale(axes: Axes, which: str, scale: Scale) -> None:
    """Set scale, limits and labels of the axis ``x`` or ``y``."""
    axis: Axis = getattr(axes, f"{which}axis")
    if scale == "share":
        axes.set(**{f"{which}lim": (-0.01, 1.01)})
        axis.set_major_formatter(PercentFormatter(1.0))
    elif scale == "log":
        axes.set(**{f"{which}scale": "log"})
        in_plain_numbers(axis)


def count_frames(axes: Axes, end: float) -> None:
    """Let the x axis run from 0 to ``end`` frames, or to 1, in whole numbers."""
    axes.set_xlim(0, max(end, 1))
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))


def in_plain_numbers(axis: Axis) -> None:
    """Label the marks of a log axis as 0.1, 0.2, 0.5, not as powers."""
    low, high = axis.get_view_interval()
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high < 1000 * low else (1.0,)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(FuncFormatter(lambda value, _: ""))


def new_figure(x_label: str, y_label: str) -> tuple[ShownFigure, Axes]:
    """Return a figure of the report's size with labelled axes."""
    figure = ShownFigure(figsize=(_WIDTH_INCHES, _HEIGHT_INCHES), layout="constrained")
    axes = figure.add_subplot()
    axes.set_xlabel(x_label)
    axes.set_ylabel(y_label)
    return figure, axes


def svg(figure: Figure) -> str:
    """Return the figure as an SVG element without date, prologue or fixed size: the same rows make the same bytes."""
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None}, transparent=True)
    text = buffer.getvalue()
    text = re.sub(r"<metadata>.*?</metadata>", "", text[text.index("<svg") :], flags=re.DOTALL)
    return re.sub(r' width="[^"]*" height="[^"]*"', ' role="img"', text, count=1).strip()
