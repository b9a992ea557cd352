"""Regions of a picture that the background does not explain, each about one object."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.harbour_watch.boxes import BoxFilters
from trackers.harbour_watch.edges import refined, side_by_side

Picture = NDArray[np.float32]

SIZES_M = np.array([[0.35, 0.35], [0.45, 0.8], [0.5, 1.7], [1.9, 1.5], [4.0, 1.6]])
"""Width and height of boxes: a piece, half a person, a person, a car from ahead, a car or boat from the side."""

_PIECE = 0
_GAP_M = 0.35
"""Pieces nearer to each other than this are one region: a bare head and hands are warmer than what is between."""
_MOST_REGIONS = 60
_SAME = 0.4
"""Share of the smaller of two boxes beyond which they are of one region."""


@dataclass(frozen=True, eq=False)
class Region:
    """A region of a picture.

    Attributes:
        box_xyxy: (4,) its extent, in pixels.
        score: deviations of its best box from the background, in units of the noise at the place.
        sign: 1 if warmer than the background, -1 if colder.
        pixels: how many of its pixels deviate on their own.
    """

    box_xyxy: NDArray[np.float64]
    score: float
    sign: int
    pixels: int


class Detector:
    """Finds regions by boxes of several sizes, and their extents by the pieces that deviate on their own."""

    def __init__(self, px_per_m: NDArray[np.float64], width_px: int, least_score: float, piece_score: float) -> None:
        """``px_per_m`` (H,) of what stands on each row; scores in deviations: of a region, and of its pieces."""
        self.filters = BoxFilters(SIZES_M, px_per_m, width_px)
        self._px_per_m, self._least, self._piece = px_per_m, least_score, piece_score
        self._lift = (self.filters.tall_px[_PIECE] - 1) // 2

    def regions(
        self,
        scaled: Picture,
        deviation: Picture,
        watched: NDArray[np.bool_],
        known: Sequence[NDArray[np.float64]] = (),
    ) -> list[Region]:
        """Return the regions, the strongest first, whose boxes stand on watched pixels (H, W).

        Args:
            scaled: (K, H, W) box sums in units of their noise. deviation: (H, W) that of each pixel.
            watched: where an object may stand.
            known: boxes (4,) of objects whose place is known: what touches one from outside is another region.
        """
        strength = np.abs(scaled)
        best = np.where(watched, strength.max(axis=0), 0.0).astype(np.float32)
        peaks = np.argwhere((best >= self._least) & (best == cv2.dilate(best, np.ones((5, 3), np.uint8))))
        if not len(peaks):
            return []
        owner = _owners(best.shape, known)
        labels, pieces = self._pieces(strength[_PIECE], known)
        found: list[Region] = []
        for i, j in peaks[np.argsort(-best[tuple(peaks.T)], kind="stable")]:
            k = int(strength[:, i, j].argmax())
            region, whose = self._region(scaled[k, i, j], k, i, j, labels, pieces, owner)
            if not any(_shared(region.box_xyxy, other.box_xyxy) > _SAME for other in found):
                alone = deviation if not known else np.where(owner == whose, deviation, np.float32(0.0))
                boxes = [refined(alone, region.box_xyxy)]
                if whose < 0:
                    boxes = side_by_side(alone, boxes[0], float(self._px_per_m[i]))
                found += [replace(region, box_xyxy=box) for box in boxes]
            if len(found) >= _MOST_REGIONS:
                break
        return found

    def _pieces(
        self, strength: Picture, known: Sequence[NDArray[np.float64]]
    ) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """Return labels (H, W) of pieces that deviate on their own, near ones joined, and (N, 5) boxes and areas."""
        strong = np.zeros(strength.shape, np.uint8)
        for lift in np.unique(self._lift):
            rows = np.flatnonzero(self._lift == lift)
            strong[np.maximum(rows - lift, 0)] |= (strength[rows] > self._piece).astype(np.uint8)
        reach = max(1, round(0.5 * _GAP_M * float(np.median(self._px_per_m))))
        closed = cv2.morphologyEx(strong, cv2.MORPH_CLOSE, np.ones((2 * reach + 1, 2 * reach + 1), np.uint8))
        for x0, y0, x1, y1 in (np.round(box).astype(int).tolist() for box in known):
            cv2.rectangle(closed, (x0 - 2, y0 - 2), (x1 + 1, y1 + 1), 0)
        _, labels, stats, _ = cv2.connectedComponentsWithStats(closed)
        return labels, stats

    def _region(
        self,
        value: float,
        k: int,
        i: int,
        j: int,
        labels: NDArray[np.int32],
        pieces: NDArray[np.int32],
        owner: NDArray[np.int16],
    ) -> tuple[Region, int]:
        """Return the region of a peak, the pieces under its box, or the box itself if there are none; and its owner."""
        half, tall = int(self.filters.half_px[k, i]), int(self.filters.tall_px[k, i])
        x0, y0, x1, y1 = max(0, j - half), max(0, i + 1 - tall), min(labels.shape[1], j + half + 1), i + 1
        under = np.bincount(labels[y0:y1, x0:x1].ravel(), minlength=len(pieces))[: len(pieces)]
        under[0] = 0
        hit = np.flatnonzero(under >= 2)
        box, whose = np.array([x0, y0, x1, y1], float), int(owner[(y0 + y1) // 2, j])
        if len(hit):
            left, top, wide, high, _ = pieces[hit].T
            owners = owner[top + high // 2, left + wide // 2]
            whose = int(owners[under[hit].argmax()])
            left, top, wide, high = (each[owners == whose] for each in (left, top, wide, high))
            box = np.array([left.min(), top.min(), (left + wide).max(), (top + high).max()], float)
        return Region(box, float(abs(value)), 1 if value > 0 else -1, int(under.sum())), whose


def _owners(shape: tuple[int, ...], known: Sequence[NDArray[np.float64]]) -> NDArray[np.int16]:
    """Return the index (H, W) of the known box in which a pixel lies; -1 outside."""
    owner = np.full(shape, -1, np.int16)
    for k, box in enumerate(known):
        x0, y0, x1, y1 = np.clip(np.round(box), -10, max(shape) + 10).astype(int).tolist()
        cv2.rectangle(owner, (x0 - 1, y0 - 1), (x1, y1), k, cv2.FILLED)
    return owner


def _shared(one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    """Return the area that two boxes share over that of the smaller one."""
    sides = np.minimum(one[2:], other[2:]) - np.maximum(one[:2], other[:2])
    if (sides <= 0).any():
        return 0.0
    areas = [float(np.prod(each[2:] - each[:2])) for each in (one, other)]
    return float(np.prod(sides)) / max(min(areas), 1e-9)
