"""Histograms and bars of a data set as SVG, in the look of the report's plots."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, PercentFormatter
from numpy.typing import NDArray

from benchmarks.data.sets.page.scans import OTHERS, TARGET, ByGroup
from benchmarks.show.palette import LineStyle, line_styles
from benchmarks.show.plots import drawn_as, new_figure, svg

_BINS = 32
_LOG_FROM = 30.0
"""Ratio of the 99th to the first percentile from which on an axis is logarithmic."""
_OF_FRAMES = ""


def _style(group: str) -> LineStyle:
    roles = {TARGET: "ours", OTHERS: "baseline", _OF_FRAMES: "as-written"}
    return line_styles([(group, roles.get(group, "as-written"))])[group]


def draw_histogram(values: ByGroup, x_label: str, y_label: str, ends: tuple[float, float] | None = None) -> str:
    """Draw how often values (K,) of each group occur, in shares of the group.

    ``ends``: of the axis; without them it holds all values and is logarithmic if need be.
    """
    together = np.concatenate(list(values.values()))
    edges, log = _edges(together) if ends is None else (np.linspace(*ends, _BINS + 1), False)
    with drawn_as(x_label):
        figure, axes = new_figure(x_label, y_label)
        # The larger group behind, so that the smaller one is not hidden.
        for group, each in sorted(values.items(), key=lambda item: -len(item[1])):
            shares = np.histogram(each, edges)[0] / len(each)
            style = _style(group)
            axes.stairs(shares, edges, fill=True, color=style.colour, alpha=0.28)
            axes.stairs(shares, edges, color=style.colour, linewidth=1.6, label=group)
        if log:
            axes.set_xscale("log")
            axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if edges[-1] / edges[0] < 1000 else (1.0,)))
            axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            axes.xaxis.set_minor_formatter(FuncFormatter(lambda value, _: ""))
        else:
            axes.xaxis.set_major_locator(MaxNLocator(6, integer=bool((together == np.round(together)).all())))
        axes.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=None))
        axes.set_xlim(edges[0], edges[-1])
        if len(values) > 1:
            axes.legend(frameon=False, fontsize=9)
        return svg(figure)


def draw_shares(shares: Mapping[str, Mapping[str, float]], y_label: str) -> str:
    """Draw the share of each word as a bar, by group."""
    names = list(dict.fromkeys(name for each in shares.values() for name in each))
    places = np.arange(len(names))[::-1].astype(float)
    thickness = 0.72 / len(shares)
    with drawn_as(y_label):
        figure, axes = new_figure(y_label, "")
        for k, (group, each) in enumerate(shares.items()):
            where = places + 0.36 - (k + 0.5) * thickness
            lengths = [each.get(name, 0.0) for name in names]
            axes.barh(where, lengths, thickness * 0.9, color=_style(group).colour, label=group)
            for y, length in zip(where, lengths, strict=True):
                text = "0 %" if not length else "< 0.1 %" if length < 0.0005 else f"{100 * length:.1f} %"
                axes.annotate(text, (length, y), xytext=(3, 0), textcoords="offset points", va="center", fontsize=9)
        axes.set_yticks(places, names)
        axes.xaxis.set_major_formatter(PercentFormatter(1.0))
        longest = max(length for each in shares.values() for length in each.values())
        axes.set_xlim(0, 1.16 * longest)
        axes.grid(False, axis="y")
        if len(shares) > 1:
            axes.legend(frameon=False, fontsize=9, loc="lower right")
        return svg(figure)


def _edges(values: NDArray[Any]) -> tuple[NDArray[np.float64], bool]:
    """Return the edges of bins, and whether they are in equal ratios."""
    low, high = float(values.min()), float(values.max())
    if low == high:
        return np.linspace(low - 0.5, high + 0.5, 4), False
    is_whole = bool((values == np.round(values)).all())
    usual, unusual = np.percentile(values, (1, 99))
    if low > 0 and unusual / usual >= _LOG_FROM:
        return np.geomspace(low, high, _BINS + 1), True
    if is_whole:
        # Whole numbers in each bin, or some bins would have one more than their neighbours.
        step = max(1.0, np.ceil((high - low + 1.0) / _BINS))
        return np.arange(low - 0.5, high + step, step), False
    return np.linspace(low, high, _BINS + 1), False
