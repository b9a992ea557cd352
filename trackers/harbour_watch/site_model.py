"""All that is known of a site, and how it is learnt from pictures without intruders."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.harbour_watch.background import LowRank, PixelMemory, learn
from trackers.harbour_watch.detection import CELL_PX, SIZES_M, Detector, cells_of
from trackers.harbour_watch.existence import Clutter, ClutterRates, clutter_rates
from trackers.harbour_watch.existence import cells_of as clutter_cells_of
from trackers.harbour_watch.water import WaterLevel
from trackers.site import Picture, Site, SiteView, noise_of, shows_water
from trackers.site_model_file import Form


@dataclass(frozen=True)
class ModelParameters:
    """How a site is learnt.

    Attributes:
        components: of the low-rank background.
        remembered_frames: time constant of a pixel's slow residual. noise_frames: of its noise.
        clip: deviations at which a pixel is cut off.
        least_score: deviations from which a box is a region. piece_score: from which a piece is part of it.
    """

    components: int
    remembered_frames: float
    noise_frames: float
    clip: float
    least_score: float
    piece_score: float


@dataclass(frozen=True, eq=False)
class LearntSite:
    """What is learnt of a site; all else of a ``SiteModel`` follows from it and the camera.

    Attributes:
        low_rank: the background.
        noise: (H, W) float32, from one picture to the next, counts.
        first: (H W,) float32, variance of the slow residual before anything is known, counts squared.
        variance, slow_variance: (K, H / 8, W / 8) float32, of box sums, see ``BoxFilters``.
        mean_rise_px: (), see ``WaterLevel``.
        clutter: false regions.
    """

    low_rank: LowRank
    noise: Picture
    first: Picture
    variance: Picture
    slow_variance: Picture
    mean_rise_px: NDArray[np.float64]
    clutter: ClutterRates

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return all arrays by name."""
        found = {name: getattr(self, name) for name in _OWN}
        for part in (self.low_rank, self.clutter):
            found |= {each.name: getattr(part, each.name) for each in fields(part)}
        return found

    @classmethod
    def of_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> LearntSite:
        """Return what has these arrays, see ``forms``."""
        low_rank, clutter = (kind(**{each.name: arrays[each.name] for each in fields(kind)}) for kind in _PARTS)
        return cls(low_rank=low_rank, clutter=clutter, **{name: arrays[name] for name in _OWN})


_OWN = ("noise", "first", "variance", "slow_variance", "mean_rise_px")
_PARTS: tuple[Any, Any] = (LowRank, ClutterRates)


def forms(shape: tuple[int, int]) -> dict[str, Form]:
    """Return the forms of the arrays of ``LearntSite`` for pictures (H, W)."""
    pixels, boxes = shape[0] * shape[1], (len(SIZES_M), *cells_of(shape))
    return {
        "mean": Form("float32", (pixels,)),
        "basis": Form("float32", ("components", pixels)),
        "prior": Form("float64", ("components",)),
        "spread": Form("float32", (pixels,)),
        "noise": Form("float32", shape),
        "first": Form("float32", (pixels,)),
        "variance": Form("float32", boxes),
        "slow_variance": Form("float32", boxes),
        "mean_rise_px": Form("float64"),
        "per_cell": Form("float32", clutter_cells_of(shape)),
        "tail": Form("float64"),
        "residents": Form("float64", ("residents", 4)),
        "pictures": Form("int64"),
    }


class SiteModel:
    """Background, noise, clutter, water and watched area, which follow the pictures of an episode.

    Attributes:
        low_rank, memory, detector, clutter, water_level: see there.
        water: (H, W) where the picture shows water. watched: (H, W) where objects may stand.
    """

    def __init__(self, learnt: LearntSite, site: Site, p: ModelParameters) -> None:
        """Begin with what was learnt."""
        shape = learnt.noise.shape[0], learnt.noise.shape[1]
        self.shape, self.low_rank = shape, learnt.low_rank
        self.memory = PixelMemory(
            learnt.first, learnt.noise.ravel() ** 2, remembered_frames=p.remembered_frames, noise_frames=p.noise_frames
        )
        self.watched = _watched(site, shape)
        self.detector = Detector(_px_per_m(site.view, shape), shape[1], p.least_score, p.piece_score)
        filters = self.detector.filters
        filters.variance, filters.slow_variance = learnt.variance.copy(), learnt.slow_variance.copy()
        water, rise_px = shows_water(site.survey, site.view), float(learnt.mean_rise_px)
        self.water_level = WaterLevel(site.view, water, learnt.noise, site.survey.mean_water_m, rise_px)
        self.water = self.water_level.below_quay(water)
        self.clutter = Clutter(learnt.clutter, p.least_score)


def _px_per_m(view: SiteView, shape: tuple[int, int]) -> NDArray[np.float64]:
    """Return the pixels (H,) of a metre that stands on the ground at the lower edge of each row."""
    px = np.column_stack([np.full(shape[0], 0.5 * shape[1]), np.arange(1, shape[0] + 1)])
    _, depth_m = view.project(view.on_plane(px, 0.0))
    far = 1e3 if not np.isfinite(depth_m).any() else float(np.nanmax(depth_m))
    return view.camera.focal_px / np.nan_to_num(depth_m, nan=far)


def _watched(site: Site, shape: tuple[int, int]) -> NDArray[np.bool_]:
    """Return the pixels (H, W) where an object of the watched volume may stand, on the ground or lower."""
    rows, columns = np.mgrid[0 : shape[0] : CELL_PX // 2, 0 : shape[1] : CELL_PX // 2]
    px = np.column_stack([columns.ravel() + 0.5, rows.ravel() + 0.5])
    inside = np.zeros(len(px), bool)
    bottom_m = float(site.volume.centre_m[2] - 0.5 * site.volume.size_m[2])
    for z_m in (0.0, 0.5 * bottom_m, bottom_m):
        points = site.view.on_plane(px, z_m)
        inside |= site.volume.contains(np.nan_to_num(points, nan=1e9))
    small = inside.reshape(rows.shape).astype(np.uint8)
    return cv2.resize(small, shape[::-1], interpolation=cv2.INTER_NEAREST).astype(bool)


_MOST_REPLAYED = 120
_MOVED = 10.0
"""Deviations of a pixel's noise by which it changes when something that belongs there moves, e.g. a moored boat."""
_MOVES_SHARE = 0.03
"""Share of pictures on which a pixel changes much, from which something moves there."""
_FIRST_GUESS = 3.0
"""Times the noise: spread of the background before anything is known of it."""


def learn_site(pictures: Picture, site: Site, p: ModelParameters) -> LearntSite:
    """Learn from ``pictures`` (T, H, W), T >= 1, counts in order of time."""
    shape = pictures.shape[1], pictures.shape[2]
    flat = pictures.reshape(len(pictures), -1)
    low_rank = learn(flat, p.components, noise_of(pictures).ravel())
    left, coefficients = np.empty_like(flat), None
    for k, picture in enumerate(flat):
        coefficients = low_rank.coefficients(picture, coefficients)
        left[k] = picture - low_rank.explained(coefficients)
    noise = noise_of(left.reshape(pictures.shape))
    variance = noise.ravel() ** 2
    if len(pictures) == 1:
        first = _FIRST_GUESS**2 * variance
    else:
        first = np.maximum(low_rank.spread**2 - variance, 0.01 * variance)
    level = WaterLevel(site.view, shows_water(site.survey, site.view), noise, site.survey.mean_water_m)
    level.settle(pictures)
    nothing = clutter_rates(shape, p.least_score, [], np.zeros(shape, np.float32))
    boxes = np.ones((len(SIZES_M), *cells_of(shape)), np.float32)
    learnt = LearntSite(low_rank, noise, first, boxes, boxes, np.array(level.mean_rise_px), nothing)
    return learnt if len(pictures) == 1 else _replayed(learnt, left, site, p)


def _replayed(learnt: LearntSite, left: Picture, site: Site, p: ModelParameters) -> LearntSite:
    """Learn the noise of boxes and the false regions from what the background leaves of its own pictures.

    Steps from one to the next are what remains of noise once the memory follows; the pictures themselves are as
    doubtful as the first one of an episode.
    """
    model, shape = SiteModel(learnt, site, p), learnt.noise.shape
    filters, no_object = model.detector.filters, np.zeros(shape, np.uint8)
    every = max(1, (len(left) - 1) // _MOST_REPLAYED)
    noise, all_doubt = np.sqrt(2.0 * model.memory.noise), np.ones(shape, np.float32)
    steps = [((left[k + 1] - left[k]) / noise).reshape(shape) for k in range(0, len(left) - 1, every)]
    for k, step in enumerate(steps, 1):
        rate = max(1.0 / k, 0.05)
        filters.learn(filters.scaled(filters.filtered(step, p.clip)), no_object, rate)
        deviation = model.memory.deviation(left[(k - 1) * every]).reshape(shape)
        filters.learn_slow(filters.scaled(filters.filtered(deviation, p.clip), all_doubt), rate)
    found = [
        model.detector.regions(filters.scaled(filters.filtered(step, p.clip)), step, model.watched) for step in steps
    ]
    changed = _MOVED * np.sqrt(float(np.median(model.memory.noise)))
    moving = np.mean([np.abs(left[k + 1] - left[k]) > changed for k in range(0, len(left) - 1, every)], axis=0)
    moored = _moored(moving.reshape(shape).astype(np.float32), model.water)
    rates = clutter_rates((shape[0], shape[1]), p.least_score, found, moored)
    return replace(learnt, variance=filters.variance, slow_variance=filters.slow_variance, clutter=rates)


def _moored(moving: Picture, water: NDArray[np.bool_]) -> Picture:
    """Return the share of pictures (H, W) on which something moored moves, from that on which pixels change much.

    What is moored reaches down to the water.
    """
    _, labels = cv2.connectedComponents((moving > _MOVES_SHARE).astype(np.uint8))
    moored: Picture = moving * np.isin(labels, np.unique(labels[water & (labels > 0)]))
    return moored
