"""A plot of values with their intervals, by group and tracker."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.ticker import PercentFormatter

from benchmarks.report.palette import GRID
from benchmarks.report.plots import Styles, drawn_as, new_figure, svg

_GROUP_HEIGHT = 0.6
"""Of a group's trackers together; 1 is the distance of groups."""

Values = Mapping[str, tuple[float, float, float]]


def plot_groups(groups: Mapping[str, Values], styles: Styles, x_label: str) -> str:
    """Draw shares (mean, low, high) of each tracker as a dot with its interval, one group below the other."""
    names = list(dict.fromkeys(name for values in groups.values() for name in values))
    offsets = np.linspace(0.5, -0.5, len(names)) * _GROUP_HEIGHT if len(names) > 1 else np.zeros(1)
    with drawn_as("groups"):
        figure, axes = new_figure(x_label, "")
        places = np.arange(len(groups))[::-1]
        for place, values in zip(places, groups.values(), strict=True):
            for offset, name in zip(offsets, names, strict=True):
                if name in values:
                    mean, low, high = values[name]
                    style = styles[name]
                    y = place + offset
                    axes.plot([low, high], [y, y], color=style.colour, linewidth=1.6, solid_capstyle="butt")
                    axes.plot([mean], [y], "o", color=style.colour, markersize=4.5, markeredgewidth=0)
        for place in places[:-1]:
            axes.axhline(place - 0.5, color=GRID, linewidth=0.6)
        axes.set_yticks(places, list(groups))
        axes.set_ylim(-0.5, len(groups) - 0.5)
        axes.set_xlim(0, 1.01)
        axes.xaxis.set_major_formatter(PercentFormatter(1.0))
        axes.grid(False, axis="y")
        return svg(figure)
