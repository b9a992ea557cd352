"""Colours that distinguish the target from its surroundings: histograms and look-up tables on a coarse cube.

A colour (r, g, b), 8 bit, lies in cell ``(r >> 3) * 1024 + (g >> 3) * 32 + (b >> 3)`` of 32 x 32 x 32.
"""

from __future__ import annotations

import cv2
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


_SMOOTHING_CELLS = 1.0
_FLOOR = 2e-5
_CLIP = 4.0
_FORGETTING = 0.97


def smooth_counts(counts: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return colour counts (CELLS,) as a density that sums to one, each colour spread over its neighbours."""
    cube = counts.reshape(SIDE, SIDE, SIDE)
    for _ in range(3):
        # Blur along the last axis, then rotate the axes.
        flat = cv2.GaussianBlur(cube.reshape(SIDE * SIDE, SIDE), (7, 1), _SMOOTHING_CELLS)
        cube = np.ascontiguousarray(flat.reshape(SIDE, SIDE, SIDE).transpose(2, 0, 1))
    return cube.ravel() / max(float(cube.sum()), 1e-9)


class ColourModel:
    """Log-ratio of the target's colours to those of the rest of the picture."""

    def __init__(self) -> None:
        self._target = np.zeros(CELLS, np.float32)
        self._rest = np.zeros(CELLS, np.float32)
        self._table = np.zeros(CELLS, np.float32)

    def learn_target(self, rgb: NDArray[np.uint8], weight: NDArray[np.float32]) -> None:
        """Count the pixels of ``rgb`` (H, W, 3) as the target's, with ``weight`` (H, W)."""
        self._target *= _FORGETTING
        count_colours(self._target, rgb, weight, 1)

    def learn_rest(self, rgb: NDArray[np.uint8], weight: NDArray[np.float32]) -> None:
        """Count the pixels of a whole picture as the background's, with ``weight`` (H, W)."""
        self._rest *= 0.8
        count_colours(self._rest, rgb, weight, 3)

    def refresh(self) -> None:
        """Recompute ``log_ratio`` from the counts."""
        target, rest = smooth_counts(self._target), smooth_counts(self._rest)
        self._table = np.clip(np.log((target + _FLOOR) / (rest + _FLOOR)), -_CLIP, _CLIP).astype(np.float32)

    def log_ratio(self, rgb: NDArray[np.uint8]) -> NDArray[np.float32]:
        """Return ``log p(colour | target) / p(colour | rest)`` of every pixel of ``rgb`` (H, W, 3), within
        [-4, 4].
        """
        return look_up(self._table, rgb)
