"""The report's figures of the suite ``harbour``."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

import numpy as np

from benchmarks.contract.metric import Mean, Quantity
from benchmarks.contract.rows import Row
from benchmarks.judges.harbour.alarms import CAUSES
from benchmarks.judges.harbour.few_pictures import TAUGHT_BY_FEW
from benchmarks.judges.harbour.suite import CURVE, FOUND, MANY_ALARMS
from benchmarks.judges.harbour.visits import SEEABLE
from benchmarks.show import curves, plots
from benchmarks.show.palette import LineStyle
from benchmarks.show.plots import Plot
from benchmarks.statistics.bootstrap import Interval, bootstrap_interval, interval_of
from benchmarks.statistics.pooling import Froc
from scenarios import catalog

_ALARMS = np.geomspace(0.1, 500.0, 75)
_CONTRASTS = SEEABLE * 2.0 ** np.arange(-2, 12)
"""Ends of the classes of contrast to noise, octaves."""


def figures(contestants: Mapping[str, Sequence[Row]], styles: Mapping[str, LineStyle]) -> list[Plot]:
    """Return the FROC curves, detection by contrast to noise and by number of pictures, and false alarms by cause.

    Trackers that learn from few pictures stand in the figure about these alone.
    """
    few = {each.name for each in TAUGHT_BY_FEW.values()}
    drawn = {name: rows for name, rows in contestants.items() if name not in few}
    made = []
    lines = {name: curve for name, rows in drawn.items() if (curve := froc_curve(rows)) is not None}
    if lines:
        words = (
            "Share of the intruders that can be seen, found four frames running, chance taken off, against false "
            "alarms an hour, as the least confidence that is answered falls. Bands: 95 % bootstrap over seeds."
        )
        svg = plots.plot_shares(lines, styles, "false alarms an hour", "found")
        made.append(Plot("How many false alarms does a find cost?", words, svg))
    lines = {name: curve for name, rows in drawn.items() if (curve := by_contrast(rows)) is not None}
    if lines:
        words = (
            "Share found, chance taken off, of intruders in classes of contrast to noise, an octave each; the contrast "
            f"is the most that an intruder has on four frames running. Below {SEEABLE:g} nobody could see them. "
            "Bands: 95 % bootstrap over seeds."
        )
        svg = plots.plot_shares(lines, styles, "contrast to noise", "found")
        made.append(Plot("What contrast does it take?", words, svg))
    lines = {name: curve for name in drawn if (curve := by_pictures(contestants, name)) is not None}
    if lines:
        words = (
            "Detection rate, mean over the logarithm of the false alarms from 1 to 100 an hour, of trackers that get "
            "so many pictures without intruders. Bands: 95 % bootstrap over seeds."
        )
        svg = plots.plot_shares(lines, styles, "pictures without intruders", "area under the FROC curve")
        made.append(Plot("How many pictures does it take?", words, svg))
    causes = {name: _causes(rows) for name, rows in drawn.items()}
    causes = {name: each for name, each in causes.items() if each}
    if causes:
        words = "False alarms an hour at each tracker's own threshold, by what lies there. Bars: 95 % over seeds."
        made.append(Plot("What raises false alarms?", words, _plot_causes(causes, styles)))
    return made


def froc_curve(rows: Sequence[Row]) -> curves.Curve | None:
    """Return the share found against false alarms an hour; None without rows."""
    return curves.found_at_alarms(rows, Froc(*CURVE, high=1.0), _ALARMS)


def by_contrast(rows: Sequence[Row]) -> curves.Curve | None:
    """Return the share found against contrast to noise; None without rows."""
    found = []
    both = [row | {"metric": "found"} for row in rows if row["metric"] in ("found", "found_unseen")]
    for low, high in itertools.pairwise(_CONTRASTS):
        mine = [row for row in both if low <= row["event"]["contrast_to_noise"] < high]
        share = interval_of(Mean(FOUND), mine) if mine else None
        if share is not None:
            found.append((np.sqrt(low * high), *share, float(len(mine))))
    return curves.Curve(*np.array(found).T) if found else None


def by_pictures(drawn: Mapping[str, Sequence[Row]], tracker: str) -> curves.Curve | None:
    """Return the area under the FROC curve against the number of pictures; None if it is known for one number."""
    first = drawn[tracker][0]
    all_pictures = catalog.scenario(first["scenario"]).presets[first["preset"]].background
    names = {count: each.name for (of, count), each in TAUGHT_BY_FEW.items() if of == tracker and count < all_pictures}
    found = []
    for count, name in sorted({**names, all_pictures: tracker}.items()):
        pool = MANY_ALARMS.statistic.pooled(drawn[name]) if name in drawn else None
        if pool is not None:
            found.append((float(count), pool.mean, *bootstrap_interval(pool), float(pool.seed_count)))
    return curves.Curve(*np.array(found).T) if len(found) > 1 else None


def _causes(rows: Sequence[Row]) -> dict[str, Interval]:
    found = {cause: interval_of(Mean(Quantity(f"false_alarms_per_hour_{cause}")), rows) for cause in CAUSES}
    return {cause: each for cause, each in found.items() if each is not None}


def _plot_causes(
    causes: Mapping[str, Mapping[str, tuple[float, float, float]]], styles: Mapping[str, LineStyle]
) -> str:
    """Draw the alarms of each cause (mean, low, high) as dots, one cause below the other, on an axis of roots."""
    with plots.drawn_as("alarms-by-cause"):
        figure, axes = plots.new_figure("false alarms an hour", "")
        places = np.arange(len(CAUSES))[::-1]
        offsets = np.linspace(0.3, -0.3, len(causes)) if len(causes) > 1 else [0.0]
        for offset, (name, values) in zip(offsets, causes.items(), strict=True):
            for place, cause in zip(places, CAUSES, strict=True):
                mean, low, high = values[cause]
                axes.plot([low, high], [place + offset] * 2, color=styles[name].colour, linewidth=1.6)
                axes.plot([mean], [place + offset], "o", color=styles[name].colour, markersize=4.5, markeredgewidth=0)
        axes.set_xscale("symlog", linthresh=1.0)
        axes.set_xlim(left=0.0)
        axes.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
        axes.set_yticks(places, [cause.replace("_", " ") for cause in CAUSES])
        axes.grid(False, axis="y")
        return plots.svg(figure)
