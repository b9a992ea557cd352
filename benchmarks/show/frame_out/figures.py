"""The report's figures of the suite ``frame-out``."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from benchmarks.contract.rows import Row
from benchmarks.judges.recovery import RECOVERY_WINDOW_FRAMES
from benchmarks.show import curves, plots
from benchmarks.show.palette import LineStyle
from benchmarks.show.plots import Plot


def figures(drawn: Mapping[str, Sequence[Row]], styles: Mapping[str, LineStyle]) -> list[Plot]:
    """Return the error while outside, the time to recover, and the calibration of posteriors."""
    kinds: tuple[tuple[str, str, Callable[..., Any], Callable[..., str]], ...] = (
        (
            "Where is the car while outside the picture?",
            "Mean error over all frame-outs of at least this length; a lost or silent tracker counts with the capped "
            "worst error. Bands: 95 % bootstrap over seeds.",
            curves.offscreen_error,
            plots.plot_offscreen_error,
        ),
        (
            "How soon is it found again?",
            "Kaplan–Meier: a car that is never found counts as lost for as long as it was watched. "
            "Bands: 95 % bootstrap over seeds.",
            curves.recovery,
            _plot_recovery,
        ),
        (
            "Is the posterior calibrated?",
            "Share of the frames outside on which the car lies in the posterior's region of that size. "
            "Above the diagonal: too wide; below: too narrow. A frame without a posterior is a miss; trackers that "
            "never give one are not shown.",
            curves.calibration,
            plots.plot_calibration,
        ),
    )
    made = []
    for title, words, compute, draw in kinds:
        lines = {name: curve for name, rows in drawn.items() if (curve := compute(rows)) is not None}
        if lines:
            made.append(Plot(title, words, draw(lines, styles)))
    return made


def _plot_recovery(lines: plots.Curves, styles: plots.Styles) -> str:
    return plots.plot_recovery(lines, styles, "the car was back in full", RECOVERY_WINDOW_FRAMES)
