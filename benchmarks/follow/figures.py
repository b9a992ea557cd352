"""The report's figures of the suite ``follow``: lines are controllers, trackers lie beside each other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from benchmarks import pooling
from benchmarks.follow.events import COMPARED, LONGEST_SEARCH_FRAMES
from benchmarks.metrics.following import LOSS_S
from benchmarks.records import Row
from benchmarks.report import curves, dot_plot, plots
from benchmarks.report.palette import LineStyle
from benchmarks.statistics import bootstrap_interval
from benchmarks.suites import Plot

ByTracker = Mapping[str, Mapping[str, Sequence[Row]]]


def figures(drawn: Mapping[str, Sequence[Row]], styles: Mapping[str, LineStyle]) -> list[Plot]:
    """Return the time in view by tracker and controller, and for each tracker how soon targets are found again."""
    by_tracker: dict[str, dict[str, Sequence[Row]]] = {}
    for rows in drawn.values():
        by_tracker.setdefault(rows[0]["tracker"], {})[rows[0]["controller"]] = rows
    return [_time_in_view(by_tracker, styles), *_found_again(by_tracker, styles)]


def _time_in_view(by_tracker: ByTracker, styles: Mapping[str, LineStyle]) -> Plot:
    groups = {
        f"by {tracker}": {
            controller: (pool.mean, *bootstrap_interval(pool))
            for controller, rows in mine.items()
            if (pool := pooling.pooled(rows, COMPARED[0])) is not None
        }
        for tracker, mine in by_tracker.items()
    }
    words = (
        "In view: the target's centre is in the picture and its box at least 12 pixels long. Dots: all episodes; bars: "
        "95 % bootstrap over seeds."
    )
    return Plot("How long is it in view?", words, dot_plot.plot_groups(groups, styles, "time in view"))


def _found_again(by_tracker: ByTracker, styles: Mapping[str, LineStyle]) -> list[Plot]:
    made = []
    for tracker, mine in by_tracker.items():
        lines = {
            controller: curve
            for controller, rows in mine.items()
            if (curve := curves.recovery(rows, LONGEST_SEARCH_FRAMES)) is not None
        }
        if lines:
            words = (
                f"Losses are longer than {LOSS_S:g} s. Kaplan–Meier: a target that is never seen again counts as lost "
                "for as long as the episode went on. Bands: 95 % bootstrap over seeds."
            )
            svg = plots.plot_search(lines, styles, LONGEST_SEARCH_FRAMES)
            made.append(Plot(f"How soon is it found again, by {tracker}?", words, svg))
    return made
