"""Paper experiment B.2: the change of the camera's exposure as a sign of when colour can be learnt."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.rows import LAST_METRIC, Row
from benchmarks.papers.camera_experiment import CameraExperiment, SheetPicture, Values, photograph
from benchmarks.papers.experiment import Plots
from benchmarks.show.palette import GRID, line_styles
from benchmarks.show.plots import Plot, count_frames, drawn_as, new_figure, svg
from benchmarks.show.video.drawing import picture_sheet
from scenarios.scenario import RendererName
from trackers.light_adaptive_stereo.light_change import LightTrend

_HSV = ("hue", "saturation", "value")
_CEILING_LIGHT_FRAMES = 300
_SHOWN_FRAMES = (60, 200, 320, 385, 420, 560, 760, 920)
_SHOWN_IN_A_ROW = 4
_LARGEST_TREND = 3.0
"""Limit of D_l in the plot; it reaches hundreds where the gain is nearly 0."""


class Drive(CameraExperiment):
    """A drive under lights of a brightness and colour that the seed draws."""

    def measure(self, seed: int, renderer: RendererName) -> Values:
        """See ``CameraExperiment``: the drive's series, and saturation and value by the sign of D_l."""
        trend = LightTrend()
        pictures = photograph(self.preset, seed, renderer)
        seen = np.array([(trend.update(p.registers), *_mean_hsv(p), p.illuminance_lx) for p in pictures])
        values: dict[str, float | list[float]] = {"trend": seen[:, 0].tolist(), "illuminance_lx": seen[:, 4].tolist()}
        values |= {name: seen[:, 1 + k].tolist() for k, name in enumerate(_HSV)}
        for where, part in (("", seen), ("_under_ceiling_lights", seen[:_CEILING_LIGHT_FRAMES])):
            gained = part[part[:, 0] > 0].mean(axis=0) - part[part[:, 0] < 0].mean(axis=0)
            values |= {f"saturation_gained{where}": float(gained[2]), f"value_gained{where}": float(gained[3])}
        return values | {
            "hue_against_value": float(seen[:, 1].std() / seen[:, 3].std()),
            LAST_METRIC: float(len(seen)),
        }

    def show(self, out: Path, rows: Sequence[Row], seeds: range, renderer: RendererName) -> Plots:
        """See ``PaperExperiment``: the camera's pictures during the drive, and the series, of one seed."""
        seed = seeds.start
        pictures = enumerate(photograph(self.preset, seed, renderer))
        cells = [(f"frame {frame}", each.marked_rgb) for frame, each in pictures if frame in _SHOWN_FRAMES]
        sheet = picture_sheet([cells[:_SHOWN_IN_A_ROW], cells[_SHOWN_IN_A_ROW:]], 320)
        caption = f"The camera's pictures during the drive, with the measured rectangle; seed {seed}."
        self.write_figure(out, sheet, seed, renderer, "figure 5", caption)
        own = {r["metric"]: r["value"] for r in rows if (r["renderer"], r["seed"]) == (renderer, seed)}
        plots = [Plot("Colour of the sheet (grey: D_l < 0)", "", _plot_colour(own)), Plot("D_l", "", _plot_trend(own))]
        return Plots(f"The paper's figures 6 and 7, in this world: seed {seed}", plots)


def _mean_hsv(picture: SheetPicture) -> NDArray[np.float64]:
    """Return mean hue, saturation and value (3,) of the sheet's region, each as a share of its range."""
    left, top, right, bottom = np.rint(picture.region_xyxy).astype(int)
    hsv = cv2.cvtColor(picture.image_rgb[top:bottom, left:right], cv2.COLOR_RGB2HSV)
    mean: NDArray[np.float64] = hsv.mean(axis=(0, 1)) / (180.0, 255.0, 255.0)
    return mean


def _plot_colour(values: dict[str, list[float]]) -> str:
    """Draw the sheet's colour over the frames; grey where D_l is negative."""
    styles = line_styles([("saturation", "ours"), ("value", "as-written"), ("hue", "baseline")])
    with drawn_as("b2-colour"):
        figure, axes = new_figure("frame", "share of its range")
        for name, style in styles.items():
            axes.plot(values[name], color=style["color"], linewidth=0.7 * style["linewidth"], label=name)
        negative = np.array(values["trend"]) < 0
        axes.fill_between(np.arange(len(negative)), 0, 1, where=negative, color=GRID, alpha=0.6, linewidth=0, zorder=1)
        axes.set_ylim(0, 1)
        count_frames(axes, len(negative) - 1)
        figure.legend(frameon=False, fontsize=8, loc="outside upper left", ncols=3)
        return svg(figure)


def _plot_trend(values: dict[str, list[float]]) -> str:
    """Draw D_l over the frames."""
    with drawn_as("b2-trend"):
        figure, axes = new_figure("frame", f"D_l, cut at {_LARGEST_TREND:g}")
        style = line_styles([("D_l", "as-written")])["D_l"]
        axes.plot(np.clip(values["trend"], -_LARGEST_TREND, _LARGEST_TREND), color=style["color"], linewidth=1.0)
        axes.axhline(0.0, color=line_styles([("0", "oracle")])["0"]["color"], linewidth=0.8)
        count_frames(axes, len(values["trend"]) - 1)
        return svg(figure)
