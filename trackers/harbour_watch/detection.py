"""Regions of a picture that the background does not explain, each about one object.

A box sum over a picture of independent unit noise, over the root of its area, has unit variance: what it exceeds that
by in pictures without intruders (waves, edges of boats, flicker) is learnt for each 8 x 8 cell, a constant false-alarm
rate (CFAR; H. Rohling, IEEE Trans. Aerospace and Electronic Systems 19(4), 1983).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

_PAD_PX = 3
_NOISE = 1.5
"""Deviations that are taken off: less is noise."""
_ACROSS, _UPRIGHT, _LOW = 0.25, 0.15, 0.3
"""Share of the high values of a profile at which an edge lies: of the columns, and of the rows of a body that is higher
than wide, whose head is narrow and whose legs are cold, and of others."""
_CLEAR = 4.5
"""Deviations beyond the noise from which a pixel of a low body is surely of it: windows differ less than a bonnet."""
_HALO = 0.3
"""Share of a neighbour's deviation below which a pixel shows its blur."""
_TWO_M, _TALL = (0.75, 1.5), 0.7
"""Widths of two people side by side, from shoulder in shoulder to an arm's length apart; least height by width."""
_ONE_M = 0.3
"""Least width of each."""
_VALLEY = 0.6
"""Depth of the profile between them, by the lower of both."""
_HIGH = 80.0
"""Percentile of the profile that stands for the body."""


def refined(deviation: NDArray[np.float32], box_xyxy: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a region's box (4,) with edges where the profiles of its deviations fall off.

    Args:
        deviation: (H, W) standard deviations from the background. box_xyxy: (4,) about the region, in pixels.
    """
    h, w = deviation.shape
    x0, y0 = np.maximum(np.floor(box_xyxy[:2]).astype(int) - _PAD_PX, 0)
    x1, y1 = np.minimum(np.ceil(box_xyxy[2:]).astype(int) + _PAD_PX, [w, h])
    part = np.abs(deviation[y0:y1, x0:x1])
    strong = part[part > 2 * _NOISE]
    if strong.size < 4:
        return box_xyxy
    mass = np.maximum(np.minimum(part, np.median(strong)) - _NOISE, 0.0)
    is_upright = box_xyxy[3] - box_xyxy[1] > box_xyxy[2] - box_xyxy[0]
    columns = _ends(mass.sum(axis=0), _ACROSS)
    rows = _ends(mass.sum(axis=1), _UPRIGHT) if is_upright else _ends(_clearest(part), _LOW)
    if columns is None or rows is None:
        return box_xyxy
    return np.array([x0 + columns[0], y0 + rows[0], x0 + columns[1], y0 + rows[1]])


def _clearest(part: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the mean (H,) of the third of each row that deviates most: a narrow cabin counts as a whole bonnet does.

    ``part`` (H, W): deviations without their sign.
    """
    is_body = part > _HALO * cv2.dilate(part, np.ones((3, 1), np.uint8))
    seen = np.sort(np.clip(np.where(is_body, part, 0.0) - _NOISE, 0.0, _CLEAR), axis=1)
    profile: NDArray[np.float32] = seen[:, -max(1, seen.shape[1] // 3) :].mean(axis=1)
    return profile


def side_by_side(
    deviation: NDArray[np.float32], box_xyxy: NDArray[np.float64], px_per_m: float
) -> list[NDArray[np.float64]]:
    """Return the boxes (4,) of two people who walk side by side, or the one box.

    A region as wide as two people is parted where the profile of its columns has a valley.
    """
    x0, y0, x1, y1 = np.round(box_xyxy).astype(int)
    x0, y0 = max(x0, 0), max(y0, 0)
    low, high = (round(each * px_per_m) for each in _TWO_M)
    if not (low <= x1 - x0 <= high and y1 - y0 >= _TALL * (x1 - x0)):
        return [box_xyxy]
    part = np.abs(deviation[y0:y1, x0:x1])
    profile = np.maximum(part - _NOISE, 0.0).sum(axis=0)
    quarter = len(profile) // 4
    at = quarter + int(profile[quarter : len(profile) - quarter].argmin())
    if not 0 < at < len(profile) - 1 or profile[at] > _VALLEY * min(profile[:at].max(), profile[at + 1 :].max()):
        return [box_xyxy]
    middle, least = x0 + at + 0.5, _ONE_M * px_per_m
    if min(middle - box_xyxy[0], box_xyxy[2] - middle) < least:
        return [box_xyxy]
    return [np.array([box_xyxy[0], y0, middle - 0.5, y1]), np.array([middle + 0.5, y0, box_xyxy[2], y1])]


def _ends(profile: NDArray[np.float32], share: float) -> tuple[float, float] | None:
    """Return where a profile (N,) rises and falls through a share of its high values; pixel n covers [n, n + 1)."""
    high = profile[profile > 0.1 * profile.max()]
    level = share * float(np.percentile(high, _HIGH)) if len(high) else 0.0
    above = np.flatnonzero(profile >= level)
    if level <= 0.0 or not len(above):
        return None
    first, last = int(above[0]), int(above[-1])
    return first + 1.0 - _covered(profile, first, -1, level), last + _covered(profile, last, 1, level)


def _covered(profile: NDArray[np.float32], at: int, outwards: int, level: float) -> float:
    """Return how far an edge lies beyond the inner side of pixel ``at``, by linear interpolation, 0.5 to 1.5."""
    beyond = at + outwards
    if not 0 <= beyond < len(profile):
        return 1.0
    return 0.5 + float((profile[at] - level) / max(float(profile[at] - profile[beyond]), 1e-6))


Picture = NDArray[np.float32]

CELL_PX = 8
_HIGHEST = 4.0
"""Deviations at which a box's square is cut off before it enters the noise of its place."""


@njit(cache=True)
def _sums(deviation: Picture, clip: float) -> NDArray[np.float64]:
    """Return the summed-area table (H + 1, W + 1) of deviations clipped to +-clip."""
    h, w = deviation.shape
    table = np.zeros((h + 1, w + 1))
    for i in range(h):
        row = 0.0
        for j in range(w):
            row += min(max(deviation[i, j], -clip), clip)
            table[i + 1, j + 1] = table[i, j + 1] + row
    return table


@njit(cache=True)
def _filtered(table: NDArray[np.float64], half_w: NDArray[np.int64], tall: NDArray[np.int64], out: Picture) -> None:
    """``out[i, j] = sum of the box / sqrt(area)``; the box stands on row i, ``2 half_w + 1`` wide, ``tall`` high."""
    h, w = out.shape
    for i in range(h):
        top = max(0, i + 1 - tall[i])
        for j in range(w):
            left, right = max(0, j - half_w[i]), min(w, j + half_w[i] + 1)
            area = (i + 1 - top) * (right - left)
            total = table[i + 1, right] - table[top, right] - table[i + 1, left] + table[top, left]
            out[i, j] = total / math.sqrt(area)


@njit(cache=True)
def _scaled(filtered: Picture, scale: Picture) -> None:
    h, w = filtered.shape
    for i in range(h):
        for j in range(w):
            filtered[i, j] /= scale[i // CELL_PX, j // CELL_PX]


class BoxFilters:
    """Deviations filtered with boxes of several sizes, each in units of its noise at the place.

    Attributes:
        half_px, tall_px: (K, H) half width and height of each box by the row on which it stands.
        variance, slow_variance: (K, H / 8, W / 8) of box sums of the pictures' noise, and of the background's slow
            residual; 1 where pixels are independent.
    """

    def __init__(self, sizes_m: NDArray[np.float64], px_per_m: NDArray[np.float64], width_px: int) -> None:
        """``sizes_m`` (K, 2): width and height of boxes; ``px_per_m`` (H,) of an object that stands on each row."""
        wide, tall = (sizes_m[:, k, None] * px_per_m for k in (0, 1))
        self.half_px = np.maximum(np.round((wide - 1) / 2), 0).astype(np.int64)
        self.tall_px = np.maximum(np.round(tall), 2).astype(np.int64)
        cells = cells_of((len(px_per_m), width_px))
        self.variance, self.slow_variance = (np.ones((len(sizes_m), *cells), np.float32) for _ in range(2))
        self._out = np.empty((len(sizes_m), len(px_per_m), width_px), np.float32)

    def filtered(self, deviation: Picture, clip: float) -> Picture:
        """Return box sums (K, H, W) of deviations (H, W), over the root of their area: unit variance if independent."""
        table = _sums(deviation, clip)
        for k, out in enumerate(self._out):
            _filtered(table, self.half_px[k], self.tall_px[k], out)
        return self._out

    def scaled(self, filtered: Picture, doubtful: Picture | None = None) -> Picture:
        """Divide box sums (K, H, W) in place by their noise at each place and return them.

        ``doubtful`` (H, W): share of the slow residual in the variance of each pixel; None = none.
        """
        share = np.float32(0.0) if doubtful is None else by_cell(doubtful) / by_cell(np.ones_like(doubtful))
        for each, fast, slow in zip(filtered, self.variance, self.slow_variance, strict=True):
            _scaled(each, np.sqrt((1.0 - share) * fast + share * slow))
        return filtered

    def learn(self, scaled: Picture, claimed: NDArray[np.uint8], rate: float) -> None:
        """Take the squares of scaled box sums into the noise of their places, but for claimed pixels (H, W)."""
        _grow(self.variance, scaled, 1.0 - claimed.astype(np.float32), rate)

    def learn_slow(self, scaled: Picture, rate: float) -> None:
        """Take the squares of box sums that are scaled by the slow variance into it."""
        _grow(self.slow_variance, scaled, np.ones(scaled.shape[1:], np.float32), rate)


def _grow(variances: Picture, scaled: Picture, free: Picture, rate: float) -> None:
    counts = by_cell(free)
    for each, variance in zip(scaled, variances, strict=True):
        seen = by_cell(np.minimum(each * each, _HIGHEST**2) * free) / np.maximum(counts, 1.0)
        growth = np.where(counts >= 0.5 * CELL_PX**2, rate * (seen - 1.0), 0.0)
        np.maximum(variance * (1.0 + growth), 1.0, out=variance, casting="same_kind")


def cells_of(shape: tuple[int, int]) -> tuple[int, int]:
    """Return the rows and columns of cells of a picture (H, W)."""
    return -(-shape[0] // CELL_PX), -(-shape[1] // CELL_PX)


def by_cell(picture: Picture) -> Picture:
    """Return the sums (H / 8, W / 8), rounded up, of a picture (H, W) over its cells."""
    rows, columns = (np.arange(0, n, CELL_PX) for n in picture.shape)
    sums: Picture = np.add.reduceat(np.add.reduceat(picture, rows, axis=0), columns, axis=1)
    return sums


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
        self, scaled: Picture, deviation: Picture, watched: NDArray[np.bool_], known: Sequence[NDArray[np.float64]] = ()
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
