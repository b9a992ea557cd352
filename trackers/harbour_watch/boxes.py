"""Matched filter over boxes of the size that an object has at each place, and its noise by place.

A box sum over a picture of independent unit noise, over the root of its area, has unit variance: what it exceeds that
by in pictures without intruders (waves, edges of boats, flicker) is learnt for each 8 x 8 cell, a constant false-alarm
rate (CFAR; H. Rohling, IEEE Trans. Aerospace and Electronic Systems 19(4), 1983).
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

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
