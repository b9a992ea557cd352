"""The report's figures of the suite ``follow``: a line for each controller, a mark for each tracker."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from benchmarks.contract.rows import Row
from benchmarks.judges.follow.suite import LONGEST_SEARCH_FRAMES
from benchmarks.judges.view_time import LOSS_S, TIME_SEEN
from benchmarks.show import curves, plots
from benchmarks.show.dot_plot import draw_share, lay_out_lines, offsets_of
from benchmarks.show.palette import GROUND, QUIET, LineStyle, line_styles
from benchmarks.show.plots import Plot
from benchmarks.statistics.bootstrap import intervals_of

_LINE_HEIGHT = 0.4
"""Height of a controller's trackers together; 1 is the distance of controllers."""
_MARKERS = ("o", "s", "^", "D", "v")
"""Shapes of trackers' marks."""

ByTracker = Mapping[str, Mapping[str, Sequence[Row]]]
Mark = Mapping[str, Any]


def figures(drawn: Mapping[str, Sequence[Row]], styles: Mapping[str, LineStyle]) -> list[Plot]:
    """Return the time seen by tracker and controller, and for each tracker the time to find targets again."""
    by_tracker: dict[str, dict[str, Sequence[Row]]] = {}
    for rows in drawn.values():
        by_tracker.setdefault(rows[0]["tracker"], {})[rows[0]["controller"]] = rows
    roles = {tracker: str(next(iter(mine.values()))[0]["tracker_role"]) for tracker, mine in by_tracker.items()}
    roles = dict(sorted(roles.items(), key=lambda item: (item[1] != "ours", item[1] != "external")))
    by_tracker = {tracker: by_tracker[tracker] for tracker in roles}
    return [*_time_seen(by_tracker, marks(roles), styles), *_found_again(by_tracker, styles)]


def marks(roles: Mapping[str, str]) -> dict[str, Mark]:
    """Return the mark of each tracker by its role: the first is full, a user's own has a colour, others are hollow."""
    made: dict[str, Mark] = {}
    for (tracker, role), marker in zip(roles.items(), itertools.cycle(_MARKERS), strict=False):
        if role == "external":
            own = line_styles([(tracker, role)])[tracker].colour
            made[tracker] = {"marker": marker, "markerfacecolor": own, "markeredgecolor": own}
        else:
            made[tracker] = {"marker": marker, **({"markerfacecolor": GROUND} if made else {})}
    return made


def _time_seen(by_tracker: ByTracker, tracker_marks: Mapping[str, Mark], styles: Mapping[str, LineStyle]) -> list[Plot]:
    shares = {tracker: intervals_of(TIME_SEEN.statistic, mine) for tracker, mine in by_tracker.items()}
    if not any(shares.values()):
        return []
    words = (
        "Seen: the target's centre is in the picture, its box at least 12 pixels long, and at least half of it "
        "visible. Marks: all episodes; bars: 95 % bootstrap over seeds."
    )
    return [Plot("How long is the target seen?", words, plot_shares(shares, tracker_marks, styles, "time seen"))]


def plot_shares(
    shares: Mapping[str, Mapping[str, tuple[float, float, float]]],
    tracker_marks: Mapping[str, Mark],
    styles: Mapping[str, LineStyle],
    x_label: str,
) -> str:
    """Draw shares (mean, low, high) by tracker and controller: a line for each controller, a mark for each tracker."""
    controllers = [name for name in styles if any(name in mine for mine in shares.values())]
    offsets = offsets_of(len(shares), _LINE_HEIGHT)
    with plots.drawn_as("shares"):
        figure, axes = plots.new_figure(x_label, "")
        places = dict(zip(controllers, np.arange(len(controllers))[::-1], strict=True))
        for offset, (tracker, mine) in zip(offsets, shares.items(), strict=True):
            for controller, share in mine.items():
                colour = styles[controller].colour
                dot = {"markersize": 5.5, "markeredgecolor": colour, **tracker_marks[tracker]}
                draw_share(axes, share, places[controller] + offset, colour, dot)
        for name in shares:
            mark = {"markeredgecolor": QUIET, **tracker_marks[name]}
            axes.plot([], [], color=QUIET, linestyle="", label=f"by {name}", **mark)
        lay_out_lines(axes, np.array(list(places.values())), controllers)
        figure.legend(loc="outside lower center", ncols=2, frameon=False, fontsize=8)
        return plots.svg(figure)


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
                f"Losses longer than {LOSS_S:g} s. Kaplan–Meier: a target that is never in view again counts as lost "
                "to the end of the episode. Bands: 95 % bootstrap over seeds."
            )
            svg = plots.plot_search(lines, styles, LONGEST_SEARCH_FRAMES)
            made.append(Plot(f"How soon is the target found again by {tracker}?", words, svg))
    return made
