"""Paper experiment B.1: do a camera's own settings say how much the light has changed the colours?"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.ticker import FuncFormatter
from numpy.typing import NDArray
from scipy.stats import spearmanr

from benchmarks.papers.claims import Claim
from benchmarks.papers.measured import SCENARIO, SUITE, MeasuredExperiment, Values, mean_series
from benchmarks.papers.sheet_pictures import SheetPicture, next_picture, open_episode
from benchmarks.report.palette import line_styles
from benchmarks.report.pictures import write_picture
from benchmarks.report.plots import drawn_as, new_figure, svg
from benchmarks.run.records import LAST_METRIC, Row
from benchmarks.video import marks
from benchmarks.video.contact_sheet import picture_sheet
from scenarios.scenario import RendererName
from trackers.kernels.boxes import box_centre, box_size
from trackers.kernels.histogram import hs_bins, rectangle_histogram
from trackers.paper_b.light_change import (
    LARGEST_GAIN_STEP,
    LARGEST_SHUTTER_STEP,
    LARGEST_WHITE_BALANCE,
    brightness_change,
    colour_change,
    dissimilarity,
    shutter_and_gain,
)

CURVES = {
    "dissimilarity": "colour dissimilarity",
    "white_balance": "white balance |ΔR| + |ΔB|",
    "shutter": "shutter S / S max",
    "gain": "gain G / G max",
    "change": "P_c + P_l",
}
"""Series of the rows, one for each condition, and their names on the page."""
_PRESET = "paper-b1"
_ROLES = ("ours", "as-written", "as-written", "as-written", "oracle")
_REGION_RGB = (230, 60, 60)


@dataclass(frozen=True, slots=True)
class Condition:
    """Which of the camera's loops stay as they were at the greatest illuminance (Table 2).

    Attributes:
        name: as the paper numbers it.
        fixed_exposure: shutter and gain. fixed_white_balance: red and blue gain.
    """

    name: str
    fixed_exposure: bool
    fixed_white_balance: bool


CONDITIONS = (Condition("I", False, False), Condition("II", True, False), Condition("III", False, True))


def photograph(condition: Condition, seed: int, renderer: RendererName = "raster") -> Iterator[SheetPicture]:
    """Yield a picture for each illuminance, the brightest first; everything else is the same for every condition."""
    with closing(open_episode(_PRESET, seed, renderer)) as episode:
        for _ in range(episode.frame_count):
            yield next_picture(episode)
            episode.hold(exposure=condition.fixed_exposure, white_balance=condition.fixed_white_balance)


def measure(seed: int, renderer: RendererName) -> Values:
    """Return the values of one seed: the experiment under all three conditions."""
    pictures = {condition.name: list(photograph(condition, seed, renderer)) for condition in CONDITIONS}
    curves = {name: _curves(taken) for name, taken in pictures.items()}
    illuminances_lx = [picture.illuminance_lx for picture in pictures["I"]]
    values: dict[str, float | list[float]] = {"illuminance_lx": illuminances_lx}
    for name, condition_curves in curves.items():
        values |= {f"{name}_{curve}": condition_curves[curve].tolist() for curve in CURVES}
    one, two, three = (curves[condition.name] for condition in CONDITIONS)
    brightness = three["shutter"] + three["gain"]
    early = [(c["gain"] > 0) & (c["shutter"] < 1.0) for c in (one, three)]
    values |= {
        "I_change_follows": _rank_correlation(one["change"], one["dissimilarity"]),
        "II_white_balance_follows": _rank_correlation(two["white_balance"], two["dissimilarity"]),
        "III_brightness_follows": _rank_correlation(brightness, three["dissimilarity"]),
        "I_change_proportional": float(np.corrcoef(one["change"], one["dissimilarity"])[0, 1]),
        "blue_gain_at_its_limit": float(np.mean(one["blue"] >= LARGEST_WHITE_BALANCE)),
        "gain_before_longest_shutter": float(np.mean(early)),
    }
    return values | {LAST_METRIC: float(len(CONDITIONS) * len(illuminances_lx))}


EXPERIMENT = MeasuredExperiment(
    name="B1",
    title="Paper B, experiment I: what the camera's settings say of the light",
    setting="A green sheet on a white wall under a light bulb that is dimmed from 609 to 19 lx. Condition I: white "
    "balance, shutter and gain are automatic; II: shutter and gain stay as they were at 609 lx; III: white balance "
    "does.",
    preset=_PRESET,
    claims=(
        Claim(
            "I_change_follows",
            "the change of the settings goes with the change of colour",
            "I: rank correlation of P_c + P_l with the dissimilarity",
            "at least",
            0.9,
        ),
        Claim(
            "II_white_balance_follows",
            "with shutter and gain fixed, white balance alone goes with it",
            "II: rank correlation of |ΔR| + |ΔB| with the dissimilarity",
            "at least",
            0.9,
        ),
        Claim(
            "III_brightness_follows",
            "with white balance fixed, shutter and gain go with it",
            "III: rank correlation of S / S max + G / G max with the dissimilarity",
            "at least",
            0.9,
        ),
        Claim(
            "gain_before_longest_shutter",
            "the gain stays low until the shutter is at its longest",
            "I and III: share of pictures with gain though the shutter is not at its longest",
            "at most",
            0.0,
        ),
        Claim(
            "I_change_proportional",
            "not in the paper",
            "I: linear correlation of P_c + P_l with the dissimilarity",
            "reported",
        ),
        Claim(
            "blue_gain_at_its_limit",
            "not in the paper",
            "I: share of illuminances at which the gain of blue is at its limit",
            "reported",
        ),
    ),
    notes=(
        "Rank correlations say that both go the same way while the lamp is dimmed step by step, not that one is in "
        "proportion to the other: P_l is at 1 long before colours change most.",
        "That the gain waits for the shutter is how this camera is built, as the paper describes the real one.",
        "In the dimmest, reddest light the gain of blue can rise no further: colours then change for that reason too.",
    ),
    measure=measure,
)


def run(out: Path, seeds: range, renderer: RendererName, workers: int) -> None:
    """Run the experiment, print its table beside the paper's words, write rows, plots, pictures and ``out/paper.html``.

    A folder that already holds rows of the other renderer keeps them; the table then shows both.

    Args:
        out: folder. seeds: arrangements of sheet, lamp and camera; 10,000 to 19,999 are the test split.
        renderer: ``raster`` or ``pybullet``.
        workers: processes.
    """
    rows = EXPERIMENT.run(out, seeds, renderer, workers)
    _write_pictures(out, seeds.start, renderer)
    mine = [row for row in rows if row["renderer"] == renderer]
    plots = {f"Condition {condition.name}": _plot(mine, condition.name) for condition in CONDITIONS}
    EXPERIMENT.publish(out, rows, seeds, renderer, "The paper's figure 3, in this world: means over the seeds", plots)


def _curves(pictures: list[SheetPicture]) -> dict[str, NDArray[np.float64]]:
    """Return the series (9,) of one condition, by the names of ``CURVES``, and ``blue``, the register.

    The first picture is the template.
    """
    first = pictures[0].registers
    histograms = [_histogram(picture) for picture in pictures]
    settings = [picture.registers for picture in pictures]
    steps = np.array([shutter_and_gain(now) for now in settings])
    white_balance = [abs(now.red - first.red) + abs(now.blue - first.blue) for now in settings]
    return {
        "dissimilarity": np.array([dissimilarity(histogram, histograms[0]) for histogram in histograms]),
        "white_balance": np.array(white_balance) / LARGEST_WHITE_BALANCE,
        "blue": np.array([now.blue for now in settings]),
        "shutter": steps[:, 0] / LARGEST_SHUTTER_STEP,
        "gain": steps[:, 1] / LARGEST_GAIN_STEP,
        "change": np.array([colour_change(now, first) + brightness_change(now, first) for now in settings]),
    }


def _histogram(picture: SheetPicture) -> NDArray[np.float64]:
    region = picture.region_xyxy
    return rectangle_histogram(hs_bins(picture.image_rgb), box_centre(region), box_size(region))


def _rank_correlation(one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    return float(spearmanr(one, other).statistic)


def _write_pictures(out: Path, seed: int, renderer: RendererName) -> None:
    """Write the paper's figure 2 beside the rows: the sheet at each illuminance, under every condition."""
    rows: list[list[tuple[str, NDArray[np.uint8]]]] = []
    for condition in CONDITIONS:
        rows.append([])
        for picture in photograph(condition, seed, renderer):
            marks.draw_box(picture.image_rgb, picture.region_xyxy, _REGION_RGB)
            rows[-1].append((f"{condition.name}: {picture.illuminance_lx:.0f} lx", picture.image_rgb))
    write_picture(
        out,
        f"{_PRESET}-{renderer}",
        picture_sheet(rows),
        (SUITE, SCENARIO, EXPERIMENT.preset, renderer, ""),
        "The paper's figure 2, in this world",
        f"What the camera sees at each illuminance under conditions I, II and III, and the rectangle whose colours "
        f"are looked at; seed {seed}.",
        made_from=f"seed {seed}",
    )


def _plot(rows: Sequence[Row], condition: str) -> str:
    """Draw dissimilarity and settings against illuminance, the mean over seeds, as the paper's figure 3."""
    styles = line_styles(list(zip(CURVES, _ROLES, strict=True)))
    illuminances_lx = mean_series(rows, "illuminance_lx")
    with drawn_as(f"b1-{condition}"):
        figure, axes = new_figure("illuminance on the sheet, lx", "")
        for name, label in CURVES.items():
            style = styles[name]
            (line,) = axes.plot(
                illuminances_lx, mean_series(rows, f"{condition}_{name}"), "o-", markersize=3, label=label
            )
            line.set(color=style.colour, linewidth=style.width, dashes=style.dashes or (1, 0))
        axes.set_xscale("log")
        axes.invert_xaxis()
        # The second lies so near to the first that their numbers would touch.
        words = ["" if k == 1 else f"{lx:g}" for k, lx in enumerate(illuminances_lx)]
        axes.set_xticks(illuminances_lx, words, fontsize=8)
        axes.minorticks_off()
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.set_ylim(0, 1.2)
        figure.legend(frameon=False, fontsize=8, loc="outside upper left", ncols=3)
        return svg(figure)
