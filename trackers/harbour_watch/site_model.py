"""All that is learnt of a site from its pictures without intruders."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.harbour_watch.boxes import CELL_PX
from trackers.harbour_watch.detection import Detector
from trackers.harbour_watch.existence import Clutter
from trackers.harbour_watch.low_rank import learn
from trackers.harbour_watch.memory import PixelMemory
from trackers.harbour_watch.water import WaterLevel, water_of
from trackers.site.reading import Picture, noise_of
from trackers.site.view import SiteView
from trackers.site.volume import WatchedVolume, place

_MOST_REPLAYED = 120
_MOVED = 10.0
"""Deviations of a pixel's noise by which it changes when something that belongs there moves, e.g. a moored boat."""
_MOVES_SHARE = 0.03
"""Share of pictures on which a pixel changes much, from which something moves there."""
_MAIN = 4
"""Components that tell water from what has texture in some weather."""
_FIRST_GUESS = 3.0
"""Times the noise: spread of the background before anything is known of it."""


@dataclass(frozen=True)
class ModelParameters:
    """How a site is learnt.

    Attributes:
        components: of the low-rank background.
        mean_water_m: height of the mean sea level above the quay, from the survey of the site.
        remembered_frames: time constant of a pixel's slow residual. noise_frames: of its noise.
        hidden_frames: in which what a pixel showed is forgotten while an object hides it.
        clip: deviations at which a pixel is cut off.
        least_score: deviations from which a box is a region. piece_score: from which a piece is part of it.
    """

    components: int
    mean_water_m: float
    remembered_frames: float
    noise_frames: float
    hidden_frames: float
    clip: float
    least_score: float
    piece_score: float


class SiteModel:
    """Background, noise, clutter, water and watched area.

    Attributes:
        low_rank, memory, detector, clutter, water_level: see there.
        water: (H, W) where the picture shows water. watched: (H, W) where objects may stand.
    """

    def __init__(self, pictures: Picture, view: SiteView, volume: WatchedVolume, p: ModelParameters) -> None:
        """``pictures`` (T, H, W), T >= 1, counts in order of time."""
        self.shape = pictures.shape[1:]
        flat = pictures.reshape(len(pictures), -1)
        self.low_rank = learn(flat, p.components, noise_of(pictures).ravel())
        left, coefficients = np.empty_like(flat), None
        for k, picture in enumerate(flat):
            coefficients = self.low_rank.coefficients(picture, coefficients)
            left[k] = picture - self.low_rank.explained(coefficients)
        noise = noise_of(left.reshape(pictures.shape)).ravel()
        if len(pictures) == 1:
            first = (_FIRST_GUESS * noise) ** 2
        else:
            first = np.maximum(self.low_rank.spread**2 - noise**2, 0.01 * noise**2)
        self.memory = PixelMemory(
            first,
            noise**2,
            remembered_frames=p.remembered_frames,
            noise_frames=p.noise_frames,
            hidden_frames=p.hidden_frames,
        )
        self.watched = _watched(view, volume, self.shape)
        self.px_per_m = _px_per_m(view, self.shape)
        self.detector = Detector(self.px_per_m, self.shape[1], p.least_score, p.piece_score)
        self.water = water_of(self._looks()) & (len(pictures) > 1)
        self.water_level = WaterLevel(view, self.water, noise.reshape(self.shape), p.mean_water_m)
        self.water_level.settle(pictures)
        self.water = self.water_level.below_quay(self.water)
        self.clutter = self._replayed(left, p)

    def _looks(self) -> Picture:
        """Return the mean picture and what the main causes of change do to it, (K, H, W)."""
        deviations = self.low_rank.deviations
        scene = self.low_rank.basis[len(self.low_rank.basis) - len(deviations) :]
        looks = [each * d for each, d in zip(scene[:_MAIN], deviations[:_MAIN], strict=True)]
        return np.array([self.low_rank.mean, *looks], np.float32).reshape(-1, *self.shape)

    def _replayed(self, left: Picture, p: ModelParameters) -> Clutter:
        """Learn the noise of boxes and the false regions from what the background leaves of its own pictures.

        Steps from one to the next are what remains of noise once the memory follows; the pictures themselves are as
        doubtful as the first one of an episode.
        """
        if len(left) < 2:
            return Clutter(self.shape, p.least_score, [], np.zeros(self.shape, np.float32))
        filters, nobody = self.detector.filters, np.zeros(self.shape, np.uint8)
        every = max(1, (len(left) - 1) // _MOST_REPLAYED)
        noise, all_doubt = np.sqrt(2.0 * self.memory.noise), np.ones(self.shape, np.float32)
        steps = [((left[k + 1] - left[k]) / noise).reshape(self.shape) for k in range(0, len(left) - 1, every)]
        for k, step in enumerate(steps, 1):
            rate = max(1.0 / k, 0.05)
            filters.learn(filters.scaled(filters.filtered(step, p.clip)), nobody, rate)
            deviation = self.memory.deviation(left[(k - 1) * every]).reshape(self.shape)
            filters.learn_slow(filters.scaled(filters.filtered(deviation, p.clip), all_doubt), rate)
        found = [
            self.detector.regions(filters.scaled(filters.filtered(step, p.clip)), step, self.watched) for step in steps
        ]
        changed = _MOVED * np.sqrt(float(np.median(self.memory.noise)))
        moving = np.mean([np.abs(left[k + 1] - left[k]) > changed for k in range(0, len(left) - 1, every)], axis=0)
        return Clutter(self.shape, p.least_score, found, self._moored(moving.reshape(self.shape).astype(np.float32)))

    def _moored(self, moving: Picture) -> Picture:
        """Return the share of pictures (H, W) on which something moored moves, from that on which pixels change much.

        What is moored reaches down to the water.
        """
        _, labels = cv2.connectedComponents((moving > _MOVES_SHARE).astype(np.uint8))
        moored: Picture = moving * np.isin(labels, np.unique(labels[self.water & (labels > 0)]))
        return moored


def _px_per_m(view: SiteView, shape: tuple[int, int]) -> NDArray[np.float64]:
    """Return the pixels (H,) of a metre that stands on the ground at the lower edge of each row."""
    px = np.column_stack([np.full(shape[0], 0.5 * shape[1]), np.arange(1, shape[0] + 1)])
    _, depth_m = view.project(view.on_plane(px, 0.0))
    far = 1e3 if not np.isfinite(depth_m).any() else float(np.nanmax(depth_m))
    return view.camera.focal_px / np.nan_to_num(depth_m, nan=far)


def _watched(view: SiteView, volume: WatchedVolume, shape: tuple[int, int]) -> NDArray[np.bool_]:
    """Return the pixels (H, W) where an object of the watched volume may stand, on the ground or lower."""
    try:
        placed = place(volume, view.camera, view.T_world_camera)
    except ValueError:
        return np.ones(shape, bool)
    rows, columns = np.mgrid[0 : shape[0] : CELL_PX // 2, 0 : shape[1] : CELL_PX // 2]
    px = np.column_stack([columns.ravel() + 0.5, rows.ravel() + 0.5])
    inside = np.zeros(len(px), bool)
    for z_m in (0.0, 0.5 * volume.bottom_m, volume.bottom_m):
        points = view.on_plane(px, z_m)
        inside |= placed.contains(np.nan_to_num(points, nan=1e9))
    small = inside.reshape(rows.shape).astype(np.uint8)
    return cv2.resize(small, shape[::-1], interpolation=cv2.INTER_NEAREST).astype(bool)
