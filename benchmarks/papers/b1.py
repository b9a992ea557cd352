"""Paper experiment B.1: a camera's own settings as a measure of colour change by light."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from matplotlib.ticker import FuncFormatter
from numpy.typing import NDArray
from scipy.stats import spearmanr

from benchmarks.contract.rows import LAST_METRIC, Row
from benchmarks.papers.camera_experiment import CameraExperiment, SheetPicture, Values, photograph
from benchmarks.papers.experiment import Plots, TextTable
from benchmarks.show.palette import line_styles
from benchmarks.show.plots import Plot, drawn_as, new_figure, svg
from benchmarks.show.video.drawing import picture_sheet
from scenarios.scenario import RendererName
from trackers.kernels.boxes import box_centre, box_size
from trackers.kernels.histogram import hs_bins, rectangle_histogram
from trackers.light_adaptive_stereo.light_change import (
    LARGEST_GAIN_STEP,
    LARGEST_SHUTTER_STEP,
    LARGEST_WHITE_BALANCE,
    brightness_change,
    colour_change,
    dissimilarity,
    shutter_and_gain,
    white_balance_change,
)
from trackers.light_adaptive_stereo.stereo_colour import StereoColourParameters

CURVES = {
    "dissimilarity": "colour dissimilarity",
    "white_balance": "white balance |ΔR| + |ΔB|",
    "shutter": "shutter S / S max",
    "gain": "gain G / G max",
    "colour_change": "P_c",
    "brightness_change": "P_l",
}
"""Series of the rows, one for each condition, and their names on the page."""
_ROLES = ("ours", "as-written", "as-written", "as-written", "oracle", "baseline")
_UNIT = StereoColourParameters().white_balance_unit
_OTHER_UNITS = {1.0: "P_c if register values counted as they are", LARGEST_WHITE_BALANCE: "P_c by shares of the range"}
"""Units of the white balance that the method's ``_UNIT`` was preferred to."""
CONDITIONS: dict[str, dict[str, bool]] = {"I": {}, "II": {"exposure": True}, "III": {"white_balance": True}}
"""Settings of the camera that stay as at the greatest illuminance (Table 2), see ``photograph``."""


class DimmedLamp(CameraExperiment):
    """A picture for each illuminance, the brightest first; everything else is the same for every condition."""

    def measure(self, seed: int, renderer: RendererName) -> Values:
        """See ``CameraExperiment``: the values of all three conditions."""
        pictures = {name: list(photograph(self.preset, seed, renderer, **held)) for name, held in CONDITIONS.items()}
        curves = {name: _curves(taken) for name, taken in pictures.items()}
        illuminances_lx = [picture.illuminance_lx for picture in pictures["I"]]
        values: dict[str, float | list[float]] = {"illuminance_lx": illuminances_lx}
        for name, condition_curves in curves.items():
            values |= {f"{name}_{curve}": condition_curves[curve].tolist() for curve in CURVES}
        one, two, three = (curves[name] for name in CONDITIONS)
        brightness = three["shutter"] + three["gain"]
        change = one["colour_change"] + one["brightness_change"]
        early = [(c["gain"] > 0) & (c["shutter"] < 1.0) for c in (one, three)]
        return values | {
            "I_change_follows": _rank_correlation(change, one["dissimilarity"]),
            "II_white_balance_follows": _rank_correlation(two["white_balance"], two["dissimilarity"]),
            "III_brightness_follows": _rank_correlation(brightness, three["dissimilarity"]),
            "I_change_proportional": float(np.corrcoef(change, one["dissimilarity"])[0, 1]),
            "I_colour_change_largest": float(one["colour_change"].max()),
            "II_colour_change_off": float(np.abs(two["colour_change"] - two["dissimilarity"]).mean()),
            "blue_gain_at_its_limit": float(np.mean(one["blue"] >= LARGEST_WHITE_BALANCE)),
            "gain_before_longest_shutter": float(np.mean(early)),
            LAST_METRIC: float(len(CONDITIONS) * len(illuminances_lx)),
        }

    def sensitivity(self, out: Path, rows: Sequence[Row], seeds: range, renderer: RendererName) -> TextTable | None:
        """See ``PaperExperiment``: P_c and P_l of condition I at each illuminance, and P_c by other units."""
        if not rows:
            return None
        changes = LARGEST_WHITE_BALANCE * _mean(rows, "I_white_balance")
        columns = {
            "illuminance on the sheet, lx": [f"{lx:.0f}" for lx in _mean(rows, "illuminance_lx")],
            CURVES["dissimilarity"]: _two_digits(_mean(rows, "I_dissimilarity")),
            "P_l": _two_digits(_mean(rows, "I_brightness_change")),
            "P_c": _two_digits(_mean(rows, "I_colour_change")),
        }
        columns |= {
            words: _two_digits([colour_change(change, unit) for change in changes])
            for unit, words in _OTHER_UNITS.items()
        }
        words = f"Condition I, means over the seeds. The method counts a change by {_UNIT:g} register values as 1."
        rows_of_text = tuple(zip(*columns.values(), strict=True))
        return TextTable("P_c and P_l at each illuminance", words, tuple(columns), rows_of_text)

    def show(self, out: Path, rows: Sequence[Row], seeds: range, renderer: RendererName) -> Plots:
        """See ``PaperExperiment``: the sheet at each illuminance, a row of pictures and a plot for each condition."""
        cells = [
            [
                (f"{name}: {each.illuminance_lx:.0f} lx", each.marked_rgb)
                for each in photograph(self.preset, seeds.start, renderer, **held)
            ]
            for name, held in CONDITIONS.items()
        ]
        caption = (
            "The camera's picture at each illuminance under conditions I, II and III, with the measured rectangle; "
            f"seed {seeds.start}."
        )
        self.write_figure(out, picture_sheet(cells), seeds.start, renderer, "figure 2", caption)
        plots = [Plot(f"Condition {name}", "", _plot(rows, name)) for name in CONDITIONS]
        return Plots("The paper's figure 3, in this world: means over the seeds", plots)


def _curves(pictures: list[SheetPicture]) -> dict[str, NDArray[np.float64]]:
    """Return the series (9,) of one condition, by the names of ``CURVES``, and ``blue``, the register.

    The first picture is the template.
    """
    first = pictures[0].registers
    histograms = [_histogram(picture) for picture in pictures]
    settings = [picture.registers for picture in pictures]
    steps = np.array([shutter_and_gain(now) for now in settings])
    white_balance = [white_balance_change(now, first) for now in settings]
    return {
        "dissimilarity": np.array([dissimilarity(histogram, histograms[0]) for histogram in histograms]),
        "white_balance": np.array(white_balance) / LARGEST_WHITE_BALANCE,
        "blue": np.array([now.blue for now in settings]),
        "shutter": steps[:, 0] / LARGEST_SHUTTER_STEP,
        "gain": steps[:, 1] / LARGEST_GAIN_STEP,
        "colour_change": np.array([colour_change(change, _UNIT) for change in white_balance]),
        "brightness_change": np.array([brightness_change(now, first) for now in settings]),
    }


def _histogram(picture: SheetPicture) -> NDArray[np.float64]:
    region = picture.region_xyxy
    return rectangle_histogram(hs_bins(picture.image_rgb), box_centre(region), box_size(region))


def _rank_correlation(one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    return float(spearmanr(one, other).statistic)


def _mean(rows: Sequence[Row], metric: str) -> NDArray[np.float64]:
    """Return the mean over seeds of a series."""
    mean: NDArray[np.float64] = np.mean([row["value"] for row in rows if row["metric"] == metric], axis=0)
    return mean


def _two_digits(values: Iterable[float]) -> list[str]:
    return [f"{value:.2f}" for value in values]


def _plot(rows: Sequence[Row], condition: str) -> str:
    """Draw dissimilarity and settings against illuminance, the mean over seeds, as the paper's figure 3."""
    styles = line_styles(list(zip(CURVES, _ROLES, strict=True)))
    illuminances_lx = _mean(rows, "illuminance_lx")
    with drawn_as(f"b1-{condition}"):
        figure, axes = new_figure("illuminance on the sheet, lx", "")
        for name, label in CURVES.items():
            means = _mean(rows, f"{condition}_{name}")
            axes.plot(illuminances_lx, means, marker="o", markersize=3, label=label, **styles[name])
        axes.set_xscale("log")
        axes.invert_xaxis()
        # The label of the second would touch that of the first.
        words = ["" if k == 1 else f"{lx:g}" for k, lx in enumerate(illuminances_lx)]
        axes.set_xticks(illuminances_lx, words, fontsize=8)
        axes.minorticks_off()
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.set_ylim(0, 1.2)
        figure.legend(frameon=False, fontsize=8, loc="outside upper left", ncols=3)
        return svg(figure)
