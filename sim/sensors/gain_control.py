"""Automatic gain control of thermal cameras: from 14-bit counts to 8 bits.

Plateau equalisation (Vickers, "Plateau equalization algorithm for real-time display of high-quality infrared imagery",
Optical Engineering 35, 1996): grey levels are shared out by the histogram, of which no count gets more than a plateau,
so that wide, even surfaces leave levels to the rest. A share of the levels is spread evenly over the range in use. No
step is steeper than the largest gain. The curve in use follows at a rate of its own.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

BIN_COUNTS = 4
BINS = (1 << 14) // BIN_COUNTS
SAMPLED = 2
"""Every second pixel of every second row is in the histogram."""
_OUTLIERS = 0.001
"""Share of the picture beyond either end of the range."""
_WHITE = 255.0


@njit(cache=True)
def histogram(counts: NDArray[np.uint16]) -> NDArray[np.int64]:
    """Return how many of the sampled pixels are in each bin (BINS,)."""
    found = np.zeros(BINS, np.int64)
    for row in range(0, counts.shape[0], SAMPLED):
        for column in range(0, counts.shape[1], SAMPLED):
            found[counts[row, column] // BIN_COUNTS] += 1
    return found


@njit(cache=True)
def right_tone(found: NDArray[np.int64], plateau: float, linear: float, largest_per_bin: float) -> NDArray[np.float32]:
    """Return the grey level (BINS,) of each bin that fits a histogram.

    Args:
        plateau: share of the picture that a bin may stand for at most.
        linear: share of the levels that are spread evenly.
        largest_per_bin: greatest step from one bin to the next.
    """
    total = found.sum()
    first, last = bin_at(found, _OUTLIERS), bin_at(found, 1.0 - _OUTLIERS)
    most, counted = max(plateau * total, 1.0), 0.0
    for k in range(first, last + 1):
        counted += min(float(found[k]), most)
    tone, even, used = np.zeros(found.shape[0]), linear / (last + 1 - first), 0.0
    for k in range(first, last + 1):
        share = (1.0 - linear) * min(float(found[k]), most) / counted + even
        step = min(_WHITE * share, largest_per_bin)
        tone[k] = used + 0.5 * step
        used += step
    tone[last + 1 :] = used
    # Where the largest gain leaves levels over, the picture lies in the middle of them.
    return (tone + 0.5 * (_WHITE - used)).astype(np.float32)


@njit(cache=True)
def bin_at(found: NDArray[np.int64], share: float) -> int:
    """Return the bin in which a share of a histogram is reached."""
    wanted, below = share * found.sum(), 0
    for k in range(found.shape[0]):
        below += found[k]
        if below >= wanted:
            return k
    return found.shape[0] - 1


@njit(cache=True)
def apply_tone(counts: NDArray[np.uint16], grey_of_bin: NDArray[np.uint8], grey: NDArray[np.uint8]) -> None:
    """Write the grey level (H, W) of each count (H, W)."""
    for row in range(counts.shape[0]):
        for column in range(counts.shape[1]):
            grey[row, column] = grey_of_bin[counts[row, column] // BIN_COUNTS]
