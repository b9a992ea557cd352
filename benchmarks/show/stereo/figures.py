"""The report's figures of the suite ``stereo``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from benchmarks.contract.rows import Row
from benchmarks.judges.stereo.judge import OCCLUSION_WINDOW_FRAMES
from benchmarks.judges.stereo.metrics.people_events import LIGHT_KINDS, NEAR, NOBODY_NEAR
from benchmarks.judges.stereo.suite import event_f1
from benchmarks.show import curves, dot_plot, plots
from benchmarks.show.palette import LineStyle
from benchmarks.show.plots import Plot
from benchmarks.show.stereo import timelines as strips
from benchmarks.statistics.bootstrap import intervals_of

_GROUPS = {**{f"after {kind}": kind for kind in LIGHT_KINDS}, NEAR: NEAR, NOBODY_NEAR: NOBODY_NEAR}
"""Words of the plot → kind of event."""


def figures(drawn: Mapping[str, Sequence[Row]], styles: Mapping[str, LineStyle]) -> list[Plot]:
    """Return F1 by kind of event, the time to recover, and every frame of one episode."""
    made = []
    groups = {words: intervals_of(event_f1("f1", "", kind).statistic, drawn) for words, kind in _GROUPS.items()}
    groups = {words: values for words, values in groups.items() if values}
    if groups:
        words = (
            "F1, in which a wrong answer is a miss too, over the frames of the 2 s after a change of light, and of "
            "those with and without another person within 1.5 m. Dots: all episodes; bars: 95 % bootstrap over seeds."
        )
        svg = dot_plot.plot_groups(groups, styles, "F1 of right, wrong and missing answers")
        made.append(Plot("When is the person lost?", words, svg))
    lines = {name: curve for name, rows in drawn.items() if (curve := curves.recovery(rows)) is not None}
    if lines:
        words = (
            "Kaplan–Meier: a person who is never found again counts as lost to the next occlusion or the end. "
            "Bands: 95 % bootstrap over seeds."
        )
        svg = plots.plot_recovery(lines, styles, "half of the person is seen again", OCCLUSION_WINDOW_FRAMES)
        made.append(Plot("How soon is the person found again?", words, svg))
    return [*made, *_strips(drawn)]


def _strips(drawn: Mapping[str, Sequence[Row]]) -> list[Plot]:
    """Return the strips of the first seed, of all trackers that ran on it."""
    seed = min((row["seed"] for rows in drawn.values() for row in rows), default=None)
    mine = {name: [row for row in rows if row["seed"] == seed and row["repeat"] == 0] for name, rows in drawn.items()}
    strip = {name: strips.strip_of(rows) for name, rows in mine.items() if rows}
    if not strip:
        return []
    words = (
        "Each line a tracker, each frame a mark. White: nothing of the person is visible, or no answer while "
        "hardly anything is. Above: the person's visible share, and when the light begins to change."
    )
    return [Plot(f"Frame by frame, seed {seed}", words, strips.plot_strips(strip))]
