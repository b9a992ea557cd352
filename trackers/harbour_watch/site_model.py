"""All that is known of a site from its pictures without intruders."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.harbour_watch.boxes import CELL_PX, cells_of
from trackers.harbour_watch.detection import SIZES_M, Detector
from trackers.harbour_watch.existence import Clutter, ClutterRates
from trackers.harbour_watch.existence import cells_of as clutter_cells_of
from trackers.harbour_watch.low_rank import LowRank
from trackers.harbour_watch.memory import PixelMemory
from trackers.harbour_watch.water import WaterLevel
from trackers.site.model_file import Form
from trackers.site.quay import shows_water
from trackers.site.reading import Picture
from trackers.site.survey import Site
from trackers.site.view import SiteView


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
            learnt.first,
            learnt.noise.ravel() ** 2,
            remembered_frames=p.remembered_frames,
            noise_frames=p.noise_frames,
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
