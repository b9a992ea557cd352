"""Histograms and look-up tables of colours on a coarse cube.

A colour (r, g, b), 8 bit, lies in cell ``(r >> 3) * 1024 + (g >> 3) * 32 + (b >> 3)`` of 32 x 32 x 32.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

SIDE = 32
CELLS = SIDE**3


@njit(cache=True)
def count_colours(counts: NDArray[np.float32], rgb: NDArray[np.uint8], weight: NDArray[np.float32], step: int) -> None:
    """Add ``weight`` (H, W) of every ``step``-th pixel of ``rgb`` (H, W, 3), in rows and columns, to
    ``counts`` (CELLS,) in place.
    """
    for i in range(0, rgb.shape[0], step):
        for j in range(0, rgb.shape[1], step):
            cell = (int(rgb[i, j, 0]) >> 3) * 1024 + (int(rgb[i, j, 1]) >> 3) * 32 + (int(rgb[i, j, 2]) >> 3)
            counts[cell] += weight[i, j]


@njit(cache=True)
def look_up(table: NDArray[np.float32], rgb: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Return ``table`` (CELLS,) at the colour of every pixel of ``rgb`` (H, W, 3): (H, W)."""
    result = np.empty(rgb.shape[:2], np.float32)
    for i in range(rgb.shape[0]):
        for j in range(rgb.shape[1]):
            cell = (int(rgb[i, j, 0]) >> 3) * 1024 + (int(rgb[i, j, 1]) >> 3) * 32 + (int(rgb[i, j, 2]) >> 3)
            result[i, j] = table[cell]
    return result
