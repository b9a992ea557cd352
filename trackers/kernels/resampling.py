"""Resampling of weighted particles."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True)
def systematic_indices(weights: NDArray[np.float64], offset: float) -> NDArray[np.int64]:
    """Return the ancestors of N equally weighted particles: systematic resampling with one uniform number.

    ``a_i = min{j : w_0 + ... + w_j > W (i + u) / N}``, W the sum of the weights. Particle j is taken floor(N w_j / W)
    or ceil(N w_j / W) times, on average N w_j / W times, and never where w_j = 0.

    Args:
        weights: (N,) non-negative, finite, not all zero; need not sum to one.
        offset: u in [0, 1).

    Returns:
        (N,) indices, ascending.

    Source: Kitagawa 1996, "Monte Carlo filter and smoother"; paper A draws with replacement, of which this is the
    version with the least variance.
    """
    count = weights.size
    total = weights.sum()
    last = count - 1
    while last > 0 and weights[last] == 0.0:
        last -= 1
    ancestors = np.empty(count, np.int64)
    j = 0
    cumulative = weights[0]
    for i in range(count):
        threshold = total * (i + offset) / count
        while cumulative <= threshold and j < last:
            j += 1
            cumulative += weights[j]
        ancestors[i] = j
    return ancestors
