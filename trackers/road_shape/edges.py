"""Detection of white lines across a direction of travel (paper A, section 3.1)."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True)
def line_profile(
    grey: NDArray[np.uint8],
    centre_px: NDArray[np.float64],
    direction_rad: float,
    reach_px: int,
    thickness_px: int,
    along_px: int,
) -> NDArray[np.float64]:
    """Return the contrast of a white line at offsets -reach ... reach across a direction.

    ``E(s) = I(s) - max(I(s - t), I(s + t))`` where positive: brighter than both sides. I(s) is the mean grey value of
    2 along + 1 points in a row along the direction, at offset s to its right (clockwise as seen).

    Args:
        grey: (H, W).
        centre_px: (2,) where s = 0, in pixels from the top left corner.
        thickness_px: t.

    Returns:
        (2 reach + 1,) grey values >= 0; zero where a needed point lies outside the picture.
    """
    rows, columns = grey.shape
    cosine, sine = np.cos(direction_rad), np.sin(direction_rad)
    count = 2 * (reach_px + thickness_px) + 1
    brightness = np.empty(count)
    for k in range(count):
        s = k - reach_px - thickness_px
        total = 0.0
        for a in range(-along_px, along_px + 1):
            x = centre_px[0] - sine * s + cosine * a - 0.5
            y = centre_px[1] + cosine * s + sine * a - 0.5
            j, i = int(np.floor(x)), int(np.floor(y))
            if i < 0 or j < 0 or i + 1 >= rows or j + 1 >= columns:
                total = np.nan
                break
            fx, fy = x - j, y - i
            upper = (1.0 - fx) * grey[i, j] + fx * grey[i, j + 1]
            lower = (1.0 - fx) * grey[i + 1, j] + fx * grey[i + 1, j + 1]
            total += (1.0 - fy) * upper + fy * lower
        brightness[k] = total / (2 * along_px + 1)
    profile = np.zeros(2 * reach_px + 1)
    for k in range(profile.size):
        contrast = brightness[k + thickness_px] - max(brightness[k], brightness[k + 2 * thickness_px])
        if contrast > 0.0:
            profile[k] = contrast
    return profile


@njit(cache=True)
def line_positions(
    profile: NDArray[np.float64], low_px: float, high_px: float, least_contrast: float
) -> NDArray[np.float64]:
    """Return the sub-pixel offsets (K,) within [low, high] of a profile's peaks above a contrast.

    A peak at s is moved to the vertex of the parabola through E(s - 1), E(s), E(s + 1).
    """
    reach = profile.size // 2
    found = np.empty(profile.size)
    count = 0
    first = max(int(np.ceil(low_px)) + reach, 1)
    last = min(int(np.floor(high_px)) + reach, profile.size - 2)
    for k in range(first, last + 1):
        before, here, after = profile[k - 1], profile[k], profile[k + 1]
        if here > least_contrast and here > before and here >= after:
            found[count] = k - reach + 0.5 * (before - after) / (before - 2.0 * here + after)
            count += 1
    return found[:count].copy()
