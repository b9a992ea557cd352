"""Links as coloured tracks over time: a line for each fish, coloured by the identity that it bears."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.rows import Row
from benchmarks.judges.fish.identity_series import BORNE, GAPS
from benchmarks.show.fish.drawing import colour_of
from benchmarks.show.palette import GRID, INK, QUIET
from benchmarks.show.plots import count_frames, drawn_as, new_figure, svg

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_HEIGHT = 0.72


def plot_timeline(rows: Sequence[Row], name: str) -> str | None:
    """Draw one tracker's identities in one episode, from its rows of this episode; None without any."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    series = {row["metric"]: row["value"] for row in rows if row["metric"].startswith((BORNE, GAPS))}
    count = sum(metric.startswith(BORNE) for metric in series)
    if count == 0:
        return None
    frames = 0.0
    with drawn_as(f"timeline-{name}"):
        figure, axes = new_figure("frame", "fish")
        for fish in range(count):
            borne = np.array(series[f"{BORNE}{fish}"]).reshape(-1, 3)
            gaps = np.array(series[f"{GAPS}{fish}"]).reshape(-1, 2)
            _draw(axes, borne, gaps, count - 1.0 - fish)
            frames = max(frames, borne[:, 1].max(initial=0), gaps[:, 1].max(initial=0))
        axes.set_yticks(np.arange(count)[::-1], [str(fish) for fish in range(count)])
        axes.set_ylim(-0.6, count - 0.4)
        count_frames(axes, frames)
        axes.grid(False)
        signs = [
            Patch(facecolor="none", edgecolor=QUIET, hatch="////", label="not apart", linewidth=0),
            Line2D([], [], color=INK, linewidth=1.6, label="another identity"),
        ]
        figure.legend(handles=signs, loc="outside lower center", ncols=2, frameon=False, fontsize=8)
        return svg(figure)


def _draw(axes: Axes, borne: NDArray[np.float64], gaps: NDArray[np.float64], place: float) -> None:
    low = place - 0.5 * _HEIGHT
    for first, end, identity in borne:
        colour = np.array(colour_of(int(identity))) / 255.0
        axes.broken_barh([(first, end - first)], (low, _HEIGHT), color=tuple(colour), linewidth=0)
    spans = [(first, end - first) for first, end in gaps]
    axes.broken_barh(spans, (low, _HEIGHT), facecolor="none", edgecolor=QUIET, hatch="////", linewidth=0)
    axes.axhline(place - 0.5, color=GRID, linewidth=0.5)
    changes = borne[1:, 0][borne[1:, 2] != borne[:-1, 2]]
    axes.vlines(changes, low - 0.08, low + _HEIGHT + 0.08, color=INK, linewidth=1.6)
