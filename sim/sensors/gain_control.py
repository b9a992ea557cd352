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


def right_tone(
    found: NDArray[np.int64], *, plateau: float, linear: float, largest_per_bin: float
) -> NDArray[np.float32]:
    """Return the grey level (BINS,) of each bin that fits a histogram.

    Args:
        plateau: share of the picture that a bin may stand for at most.
        linear: share of the levels that are spread evenly.
        largest_per_bin: greatest step from one bin to the next.
    """
    total = int(found.sum())
    first, last = bins_at(found, (_OUTLIERS, 1.0 - _OUTLIERS))
    weight = np.minimum(found, max(plateau * total, 1.0)).astype(float)
    weight[:first], weight[last + 1 :] = 0.0, 0.0
    share = (1.0 - linear) * weight / weight.sum()
    share[first : last + 1] += linear / (last + 1 - first)
    steps = np.minimum(_WHITE * share, largest_per_bin)
    # Where the largest gain leaves levels over, the picture lies in the middle of them.
    unused = _WHITE - steps.sum()
    return (0.5 * unused + np.cumsum(steps) - 0.5 * steps).astype(np.float32)


def bins_at(found: NDArray[np.int64], shares: tuple[float, ...]) -> list[int]:
    """Return the bins below which these shares of a histogram lie."""
    return [int(each) for each in np.searchsorted(np.cumsum(found), np.array(shares) * found.sum())]


@njit(cache=True)
def apply_tone(counts: NDArray[np.uint16], grey_of_bin: NDArray[np.uint8], grey: NDArray[np.uint8]) -> None:
    """Write the grey level (H, W) of each count (H, W)."""
    for row in range(counts.shape[0]):
        for column in range(counts.shape[1]):
            grey[row, column] = grey_of_bin[counts[row, column] // BIN_COUNTS]
