"""Plots of shares with their intervals, one line below the other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.show.palette import GRID
from benchmarks.show.plots import Styles, drawn_as, in_percent, new_figure, svg

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_GROUP_HEIGHT = 0.6
"""Height of a group's trackers together; 1 is the distance of groups."""

Values = Mapping[str, tuple[float, float, float]]


def plot_groups(groups: Mapping[str, Values], styles: Styles, x_label: str) -> str:
    """Draw shares (mean, low, high) of each tracker as a dot with its interval, one group below the other."""
    names = list(dict.fromkeys(name for values in groups.values() for name in values))
    offsets = offsets_of(len(names), _GROUP_HEIGHT)
    with drawn_as("groups"):
        figure, axes = new_figure(x_label, "")
        places = np.arange(len(groups))[::-1]
        for place, values in zip(places, groups.values(), strict=True):
            for offset, name in zip(offsets, names, strict=True):
                if name in values:
                    dot = {"marker": "o", "linestyle": "", "markersize": 4.5, "markeredgewidth": 0}
                    draw_share(axes, values[name], place + offset, styles[name].colour, dot)
        lay_out_lines(axes, places, list(groups))
        return svg(figure)


def offsets_of(count: int, height: float) -> NDArray[np.float64]:
    """Return the vertical offsets (count,) of dots on one line, from the top."""
    return np.linspace(0.5, -0.5, count) * height if count > 1 else np.zeros(1)


def draw_share(axes: Axes, share: tuple[float, float, float], y: float, colour: str, dot: Mapping[str, Any]) -> None:
    """Draw a share (mean, low, high) at height ``y`` as a dot with its interval."""
    mean, low, high = share
    axes.plot([low, high], [y, y], color=colour, linewidth=1.6, solid_capstyle="butt")
    axes.plot([mean], [y], color=colour, **dot)


def lay_out_lines(axes: Axes, places: NDArray[np.int64], names: Sequence[str]) -> None:
    """Set the axes for shares on named lines at heights ``places``, from the top, with rules between them."""
    for place in places[:-1]:
        axes.axhline(place - 0.5, color=GRID, linewidth=0.6)
    axes.set_yticks(places, names)
    axes.set_ylim(-0.5, len(names) - 0.5)
    axes.set_xlim(0, 1.01)
    in_percent(axes.xaxis)
    axes.grid(False, axis="y")
