"""The report's figures of the suite ``fish``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from benchmarks.contract.metric import Mean, Quantity
from benchmarks.contract.rows import Row
from benchmarks.judges.fish.gap_scores import GAP_FRAMES, TURNS_DEG
from benchmarks.show import curves, dot_plot, plots
from benchmarks.show.fish.timelines import plot_timeline
from benchmarks.show.palette import LineStyle
from benchmarks.show.plots import Plot
from benchmarks.statistics.bootstrap import Interval, interval_of, intervals_of

_LINK_GROUPS = {
    "up to 50 frames": "50",
    "fish cross": "crossing_50",
    "fish touch": "touching_50",
    "two fish": "pair_50",
    "three or more": "crowd_50",
    "up to 200 frames": "200",
}
"""Words of the plot → group of gaps."""


def figures(drawn: Mapping[str, Sequence[Row]], styles: Mapping[str, LineStyle]) -> list[Plot]:
    """Return the error over the length of a gap and over the change of heading, links by kind of gap, and tracks."""
    made = []
    lines = {name: curve for name, rows in drawn.items() if (curve := gap_error(rows)) is not None}
    if lines:
        words = (
            f"Mean distance to the true place on each frame of gaps of {GAP_FRAMES[-1]} frames, the far end unknown. "
            "Bands: 95 % bootstrap over seeds."
        )
        svg = plots.plot_errors(lines, styles, "frames since the track was lost", "error, px")
        made.append(Plot("How far off is a lost fish?", words, svg))
    for count in GAP_FRAMES:
        turned = {name: curve for name, rows in drawn.items() if (curve := turn_error(rows, count)) is not None}
        if turned:
            words = (
                f"Error on the last of {count} lost frames, by the change of heading meanwhile (the paper's figure 4)."
            )
            svg = plots.plot_errors(turned, styles, "change of heading, degrees", "error, px")
            made.append(Plot(f"What does a turn cost over {count} frames?", words, svg))
    groups = {words: _precision(drawn, group) for words, group in _LINK_GROUPS.items()}
    groups = {words: values for words, values in groups.items() if values}
    if groups:
        words = (
            "Right links of those made, over the gaps on which a fish touches, crosses or hides behind another. "
            "Dots: all episodes; bars: 95 % bootstrap over seeds."
        )
        made.append(Plot("Which links are right?", words, dot_plot.plot_groups(groups, styles, "right links")))
    return [*made, *_timelines(drawn)]


def gap_error(rows: Sequence[Row]) -> curves.Curve | None:
    """Return the mean error against frames since the track was lost; None for a tracker that bridges none."""
    return curves.series_mean(rows, "gap_error_by_frame_px", np.arange(1.0, GAP_FRAMES[-1] + 1.0))


def turn_error(rows: Sequence[Row], count: int) -> curves.Curve | None:
    """Return the mean error after ``count`` frames against the middle of each class of change of heading."""
    found = []
    for low in TURNS_DEG:
        name = f"gap_error_{count}_turn_{low}_px"
        error = interval_of(Mean(Quantity(name)), rows)
        if error is not None:
            found.append((low + 0.5 * (TURNS_DEG[1] - TURNS_DEG[0]), *error, 1.0))
    return curves.Curve(*np.array(found).T) if found else None


def _precision(drawn: Mapping[str, Sequence[Row]], group: str) -> dict[str, Interval]:
    return intervals_of(Mean(Quantity(f"link_precision_{group}")), drawn)


def _timelines(drawn: Mapping[str, Sequence[Row]]) -> list[Plot]:
    """Return the tracks of each tracker in the first episode."""
    seed = min((row["seed"] for rows in drawn.values() for row in rows), default=None)
    made = []
    for name, rows in drawn.items():
        svg = plot_timeline([row for row in rows if row["seed"] == seed and row["repeat"] == 0], name)
        if svg is not None:
            words = (
                "Each line a fish, each colour an identity, in the places where the tracker has it. Hatched: the fish "
                "touches, crosses or hides behind another. Bars: the fish has another identity from here on."
            )
            made.append(Plot(f"{name}: who is who, seed {seed}", words, svg))
    return made
