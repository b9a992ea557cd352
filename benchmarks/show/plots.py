"""The report's plots, as SVG for the page: same rows, same bytes."""

from __future__ import annotations

import io
import re
from collections.abc import Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from benchmarks.show.curves import RECOVERY_FRAMES, Curve
from benchmarks.show.palette import GRID, GROUND, INK, PLACEHOLDERS, QUIET, LineStyle, on_light

# matplotlib takes as long to import as numba; workers and commands without a report do not need it.
if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

CAR_LENGTH_M = 4.5
_SIZE_INCHES = (5.4, 3.7)
_LEAST_ERROR_M = 0.05
"""Lower end of the log axis."""
_SETTINGS: dict[str, Any] = {
    "svg.fonttype": "none",
    "font.size": 10,
    "axes.edgecolor": QUIET,
    "axes.labelcolor": QUIET,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": GRID,
    "grid.linewidth": 0.6,
    "xtick.color": QUIET,
    "ytick.color": QUIET,
    "text.color": INK,
}

_BACKED = {"facecolor": GROUND, "alpha": 0.8, "linewidth": 0, "pad": 1.0}
"""Text over lines has a translucent patch of the page's ground."""


@dataclass(frozen=True, slots=True)
class Plot:
    """A figure of the report with its text; ``svg`` as ``report.plots.svg`` returns it."""

    title: str
    words: str
    svg: str


Curves = Mapping[str, Curve]
Styles = Mapping[str, LineStyle]


def plot_offscreen_error(curves: Curves, styles: Styles) -> str:
    """Draw mean error in metres (log) against frames since exit, with bands for ours and the oracle."""
    with drawn_as("offscreen-error"):
        figure, axes = new_figure("frames since the car left the picture", "error on the ground, m")
        axes.set_yscale("log")
        for name, curve in curves.items():
            y, low, high = (np.maximum(each, _LEAST_ERROR_M) for each in (curve.y, curve.low, curve.high))
            _draw(axes, Curve(curve.x, y, low, high, curve.count), styles[name])
        axes.axhline(CAR_LENGTH_M, color=QUIET, linewidth=0.9, dashes=(1, 2))
        end = max(curve.x[-1] for curve in curves.values())
        axes.annotate(
            "one car length",
            (end, CAR_LENGTH_M),
            xytext=(0, 3),
            textcoords="offset points",
            ha="right",
            color=QUIET,
            fontsize=9,
            bbox=_BACKED,
            zorder=5,
        )
        in_plain_numbers(axes.yaxis)
        count_frames(axes, end)
        return svg(figure)


def plot_recovery(curves: Curves, styles: Styles, since: str, window_frames: int) -> str:
    """Draw the share found again against frames ``since`` (in words) the return, as steps.

    The first ``window_frames``, within which a target counts as recovered, are shaded.
    """
    with drawn_as("recovery"):
        figure, axes = _found_again(curves, styles, since, RECOVERY_FRAMES)
        axes.axvspan(0, window_frames, color=GRID, alpha=0.5, linewidth=0)
        words = (window_frames + 0.8, 0.02)
        axes.annotate("← counts as recovered", words, color=QUIET, fontsize=9, bbox=_BACKED, zorder=5)
        return svg(figure)


def plot_search(curves: Curves, styles: Styles, until_frames: int) -> str:
    """Draw the share found again against frames since the target left view, as steps."""
    with drawn_as("search"):
        return svg(_found_again(curves, styles, "the target left view", until_frames)[0])


def _found_again(curves: Curves, styles: Styles, since: str, until_frames: int) -> tuple[Figure, Axes]:
    figure, axes = new_figure(f"frames since {since}", "found again")
    for name, curve in curves.items():
        _draw(axes, curve, styles[name], steps=True)
    in_percent(axes.yaxis)
    count_frames(axes, until_frames)
    axes.set_ylim(0, 1.01)
    return figure, axes


def count_frames(axes: Axes, end: float) -> None:
    """Let the x axis run from 0 to ``end`` frames, or to 1, in whole numbers."""
    from matplotlib.ticker import MaxNLocator

    axes.set_xlim(0, max(end, 1))
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))


def plot_errors(curves: Curves, styles: Styles, x_label: str, y_label: str) -> str:
    """Draw mean errors (log) against ``x_label``, with bands for ours and references."""
    with drawn_as(x_label.replace(" ", "-")):
        figure, axes = new_figure(x_label, y_label)
        axes.set_yscale("log")
        for name, curve in curves.items():
            _draw(axes, curve, styles[name])
        _mark_one_two_five(axes.yaxis)
        in_plain_numbers(axes.yaxis)
        count_frames(axes, max(curve.x[-1] for curve in curves.values()))
        return svg(figure)


def plot_shares(curves: Curves, styles: Styles, x_label: str, y_label: str) -> str:
    """Draw shares against ``x_label`` (log), with bands for ours and references."""
    with drawn_as(x_label.replace(" ", "-")):
        figure, axes = new_figure(x_label, y_label)
        axes.set_xscale("log")
        for name, curve in curves.items():
            _draw(axes, curve, styles[name])
        in_plain_numbers(axes.xaxis)
        in_percent(axes.yaxis)
        axes.margins(x=0)
        axes.set_ylim(0, 1.01)
        return svg(figure)


def plot_calibration(curves: Curves, styles: Styles) -> str:
    """Draw the share of truths inside the p region against p, and the diagonal of a calibrated posterior."""
    with drawn_as("calibration"):
        figure, axes = new_figure("region of the posterior", "holds the car")
        axes.plot([0, 1], [0, 1], color=QUIET, linewidth=0.9, dashes=(1, 2))
        axes.annotate("calibrated", (0.3, 0.3), xytext=(5, -11), textcoords="offset points", color=QUIET, fontsize=9)
        for name, curve in curves.items():
            _draw(axes, curve, styles[name])
        for axis in (axes.xaxis, axes.yaxis):
            in_percent(axis)
        axes.set_xlim(0, 1)
        axes.set_ylim(0, 1.01)
        return svg(figure)


def plot_speed(speeds: Mapping[str, tuple[float, float, float]], styles: Styles) -> str:
    """Draw frames a second (mean, low, high) of each tracker as a dot with its interval, on a log scale."""
    with drawn_as("speed"):
        figure, axes = new_figure("frames a second on one core", "")
        places = np.arange(len(speeds))[::-1]
        for place, (name, (mean, low, high)) in zip(places, speeds.items(), strict=True):
            colour = styles[name].colour
            axes.plot([low, high], [place, place], color=colour, linewidth=2, solid_capstyle="butt")
            axes.plot([mean], [place], "o", color=colour, markersize=6, markeredgewidth=0)
        axes.set_xscale("log")
        ends = np.array(list(speeds.values()))
        axes.set_xlim(0.6 * ends.min(), 1.6 * ends.max())
        _mark_one_two_five(axes.xaxis)
        in_plain_numbers(axes.xaxis)
        axes.set_yticks(places, list(speeds))
        axes.grid(False, axis="y")
        axes.margins(y=0.12)
        return svg(figure)


def drawn_as(name: str) -> AbstractContextManager[None]:
    """Set matplotlib's style for one plot; ids come from its name, so that plots on one page do not clash."""
    import matplotlib

    settings: Any = {**_SETTINGS, "svg.hashsalt": name}
    return matplotlib.rc_context(settings)


def drawn_on_light() -> AbstractContextManager[None]:
    """Set matplotlib's style for figures that stand alone, in the page's colours on a light ground."""
    import matplotlib

    settings: Any = {name: on_light(value) if isinstance(value, str) else value for name, value in _SETTINGS.items()}
    return matplotlib.rc_context(settings)


def new_figure(x_label: str, y_label: str) -> tuple[Figure, Axes]:
    """Return a figure of the report's size with labelled axes."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    figure = Figure(figsize=_SIZE_INCHES, layout="constrained")
    FigureCanvasSVG(figure)
    axes = figure.add_subplot()
    figure.patch.set_alpha(0)
    axes.patch.set_alpha(0)
    axes.set_axisbelow(True)
    axes.tick_params(length=0)
    axes.set_xlabel(x_label)
    axes.set_ylabel(y_label)
    return figure, axes


def in_percent(axis: Axis) -> None:
    """Label shares as percentages."""
    from matplotlib.ticker import PercentFormatter

    axis.set_major_formatter(PercentFormatter(1.0))


def in_plain_numbers(axis: Axis) -> None:
    """Label the marks of a log axis as 0.1 and 10, not as powers."""
    axis.set_major_formatter(lambda value, _: f"{value:g}")
    axis.set_minor_formatter(lambda value, _: "")


def _mark_one_two_five(axis: Axis) -> None:
    from matplotlib.ticker import LogLocator

    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))


def _draw(axes: Axes, curve: Curve, style: LineStyle, *, steps: bool = False) -> None:
    order = 4 if style.in_front else 3
    where = "steps-post" if steps else "default"
    (line,) = axes.plot(curve.x, curve.y, color=style.colour, linewidth=style.width, drawstyle=where, zorder=order)
    if style.dashes:
        line.set_dashes(style.dashes)
    if style.in_front or style.variable == "ink":
        step: Literal["post"] | None = "post" if steps else None
        axes.fill_between(
            curve.x, curve.low, curve.high, color=style.colour, alpha=0.16, linewidth=0, step=step, zorder=2
        )


def svg(figure: Figure) -> str:
    """Return the figure as an SVG element without date, prologue or fixed size, in the page's own colours."""
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    text = buffer.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(r'(<svg[^>]*?) width="[^"]*"', r"\1", text, count=1)
    text = re.sub(r'(<svg[^>]*?) height="[^"]*"', r'\1 role="img"', text, count=1)
    for colour, variable in PLACEHOLDERS.items():
        text = text.replace(colour, f"var(--{variable})")
    return text.strip()
