"""Paper experiment B.2: the change of the camera's exposure as a sign of when colour can be learnt."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.rows import LAST_METRIC, Row
from benchmarks.papers.camera_experiment import CameraExperiment, SheetPicture, Values, photograph
from benchmarks.papers.experiment import Plots
from benchmarks.show.charts import Chart, Curve
from benchmarks.show.palette import line_styles
from benchmarks.show.plots import plot_of
from benchmarks.show.video.drawing import picture_sheet
from scenarios.scenario import RendererName
from trackers.light_adaptive_stereo.light_change import LightTrend

_HSV = ("hue", "saturation", "value")
_STYLES = line_styles([("saturation", "ours"), ("value", "as-written"), ("hue", "baseline"), ("D_l", "as-written")])
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
        own = {row["metric"]: row["value"] for row in rows if row["seed"] == seed}
        plots = [plot_of(chart, _STYLES) for chart in _charts(own)]
        return Plots(f"The paper's figures 6 and 7, in this world: seed {seed}", plots)


def _mean_hsv(picture: SheetPicture) -> NDArray[np.float64]:
    """Return mean hue, saturation and value (3,) of the sheet's region, each as a share of its range."""
    left, top, right, bottom = np.rint(picture.region_xyxy).astype(int)
    hsv = cv2.cvtColor(picture.image_rgb[top:bottom, left:right], cv2.COLOR_RGB2HSV)
    mean: NDArray[np.float64] = hsv.mean(axis=(0, 1)) / (180.0, 255.0, 255.0)
    return mean


def _charts(values: dict[str, list[float]]) -> list[Chart]:
    """Return the sheet's colour and D_l over the frames."""
    frames = np.arange(float(len(values["trend"])))
    series = {name: np.array(values[name]) for name in _HSV}
    series["D_l"] = np.clip(values["trend"], -_LARGEST_TREND, _LARGEST_TREND)
    curves = {name: Curve(frames, each, each, each) for name, each in series.items()}
    trend = {"D_l": curves.pop("D_l")}
    how: dict[str, Any] = {"words": "", "x_label": "frame", "x_scale": "frames"}
    cut = f"D_l, cut at {_LARGEST_TREND:g}"
    return [
        Chart(title="Colour of the sheet", curves=curves, y_label="share of its range", **how),
        Chart(title="D_l", curves=trend, y_label=cut, y_scale="linear", rule=(0.0, ""), **how),
    ]
