"""Running mean of overlaid pictures."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True, fastmath=True)
def blend_into(
    mean: NDArray[np.float32],
    rounded: NDArray[np.uint8],
    count: NDArray[np.uint8],
    patch: NDArray[np.uint8],
    weight: NDArray[np.uint8],
    slowest_rate: float,
) -> None:
    """Add ``patch`` to the running mean, in place.

    Where ``weight`` w > 0:  ``mean <- mean + (w / 255) max(1 / (n + 1), slowest_rate) (patch - mean)``, and
    ``n <- min(n + 1, 255)`` if w >= 128. The first time (n = 0) the mean becomes the patch and n = 1
    whatever the weight.

    Args:
        mean: (H, W, 3) running mean; rounded: (H, W, 3) the same in 8 bit; count: (H, W) pictures so far.
        patch: (H, W, 3) new picture; weight: (H, W), 0 = not seen here.
        slowest_rate: in (0, 1], floor of the rate, so that the mean follows the light.
    """
    for i in range(patch.shape[0]):
        for j in range(patch.shape[1]):
            if weight[i, j] == 0:
                continue
            rate = 1.0
            if count[i, j] > 0:
                rate = max(1.0 / (count[i, j] + 1.0), slowest_rate) * weight[i, j] / 255.0
            if count[i, j] == 0 or (weight[i, j] >= 128 and count[i, j] < 255):
                count[i, j] += 1
            for c in range(3):
                value = mean[i, j, c] + rate * (patch[i, j, c] - mean[i, j, c])
                mean[i, j, c] = value
                rounded[i, j, c] = np.uint8(value + 0.5)
