"""What paper B's experiment I measures: how a green sheet's colours and the camera's settings go with the light."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.stats import spearmanr

from benchmarks.records import LAST_METRIC, Row, rounded
from benchmarks.statistics import PooledRatios, bootstrap_interval
from benchmarks.versions import versions_of_scene
from scenarios.scenario import RendererName
from scenarios.stereo_follow.sheet import CONDITIONS, ILLUMINANCES_LX, SheetPicture, photograph
from sim.rng import episode_seed
from trackers.kernels.boxes import box_centre, box_size
from trackers.kernels.histogram import hs_bins, rectangle_histogram
from trackers.light_change import (
    LARGEST_GAIN,
    LARGEST_SHUTTER,
    LARGEST_WHITE_BALANCE,
    brightness_change,
    colour_change,
    dissimilarity,
    shutter_and_gain,
)

SCENARIO, PRESET = "stereo-follow-v1", "paper-b1"
CURVES = {
    "dissimilarity": "colour dissimilarity",
    "white_balance": "white balance |ΔR| + |ΔB|",
    "shutter": "shutter S / S max",
    "gain": "gain G / G max",
    "change": "P_c + P_l",
}
"""Series of the rows, one for each condition, and their names on the page."""


@dataclass(frozen=True, slots=True)
class Claim:
    """What the paper says, and the number that it comes to here.

    Attributes:
        metric: of the rows. words: what the paper says. counted: what the number is.
        bound: which side of ``level`` agrees with the paper.
    """

    metric: str
    words: str
    counted: str
    bound: Literal["at most", "at least"]
    level: float


CLAIMS = (
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
)


@dataclass(frozen=True, slots=True)
class Finding:
    """A claim and what came out: mean and 95 % interval over seeds.

    Attributes:
        agrees: whether the mean lies on the paper's side.
    """

    claim: Claim
    renderer: str
    mean: float
    ci_low: float
    ci_high: float
    seeds: int
    agrees: bool


def measure(seed: int, renderer: RendererName) -> list[Row]:
    """Return the block of rows of one seed: the experiment under all three conditions."""
    curves = {
        condition.name: _curves(list(photograph(condition, episode_seed(seed, SCENARIO, 0), renderer)))
        for condition in CONDITIONS
    }
    values: dict[str, float | list[float]] = {"illuminance_lx": list(ILLUMINANCES_LX)}
    for name, condition_curves in curves.items():
        values |= {f"{name}_{curve}": condition_curves[curve].tolist() for curve in CURVES}
    one, two, three = (curves[condition.name] for condition in CONDITIONS)
    brightness = three["shutter"] + three["gain"]
    early = [(c["gain"] > 0) & (c["shutter"] < 1.0) for c in (one, three)]
    values |= {
        "I_change_follows": _rank_correlation(one["change"], one["dissimilarity"]),
        "II_white_balance_follows": _rank_correlation(two["white_balance"], two["dissimilarity"]),
        "III_brightness_follows": _rank_correlation(brightness, three["dissimilarity"]),
        "gain_before_longest_shutter": float(np.mean(early)),
        LAST_METRIC: float(len(CONDITIONS) * len(ILLUMINANCES_LX)),
    }
    heading: Row = {
        "suite": "stereo",
        "scenario": SCENARIO,
        "preset": PRESET,
        "tracker": "stereo_wb_shutter_gain",
        "role": "as-written",
        "controller": None,
        "renderer": renderer,
        "seed": seed,
        "repeat": 0,
    }
    ending = {"weight": 1.0, "frame_out": None, "seconds": None, "versions": versions_of_scene()}
    return [{**heading, "metric": metric, "value": rounded(value), **ending} for metric, value in values.items()]


def findings(rows: Sequence[Row]) -> list[Finding]:
    """Return what the rows say of each claim, for each renderer."""
    return [
        _finding(claim, renderer, [r for r in rows if (r["metric"], r["renderer"]) == (claim.metric, renderer)])
        for claim in CLAIMS
        for renderer in dict.fromkeys(row["renderer"] for row in rows)
    ]


def mean_curve(rows: Sequence[Row], condition: str, curve: str) -> NDArray[np.float64]:
    """Return the mean over seeds of a series (9,)."""
    series = [row["value"] for row in rows if row["metric"] == f"{condition}_{curve}"]
    mean: NDArray[np.float64] = np.mean(series, axis=0)
    return mean


def _curves(pictures: list[SheetPicture]) -> dict[str, NDArray[np.float64]]:
    """Return the series (9,) of one condition, by the names of ``CURVES``; the first picture is the template."""
    first = pictures[0].registers
    histograms = [_histogram(picture) for picture in pictures]
    settings = [picture.registers for picture in pictures]
    steps = np.array([shutter_and_gain(now) for now in settings])
    white_balance = [abs(now.red - first.red) + abs(now.blue - first.blue) for now in settings]
    return {
        "dissimilarity": np.array([dissimilarity(histogram, histograms[0]) for histogram in histograms]),
        "white_balance": np.array(white_balance) / LARGEST_WHITE_BALANCE,
        "shutter": steps[:, 0] / LARGEST_SHUTTER,
        "gain": steps[:, 1] / LARGEST_GAIN,
        "change": np.array([colour_change(now, first) + brightness_change(now, first) for now in settings]),
    }


def _histogram(picture: SheetPicture) -> NDArray[np.float64]:
    region = picture.region_xyxy
    return rectangle_histogram(hs_bins(picture.image_rgb), box_centre(region), box_size(region))


def _rank_correlation(one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    return float(spearmanr(one, other).statistic)


def _finding(claim: Claim, renderer: str, rows: Sequence[Row]) -> Finding:
    values = np.array([row["value"] for row in rows], dtype=float)
    seeds = np.array([row["seed"] for row in rows])
    pool = PooledRatios(seeds, values[:, None], np.ones((len(values), 1)), _only)
    low, high = bootstrap_interval(pool)
    agrees = pool.mean <= claim.level if claim.bound == "at most" else pool.mean >= claim.level
    return Finding(claim, renderer, pool.mean, low, high, len(seeds), agrees)


def _only(ratios: NDArray[Any]) -> NDArray[Any]:
    only: NDArray[Any] = ratios[..., 0]
    return only
