"""Motion of the camera during the exposure."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

SMALLEST_BLUR_PX = 0.5
MOST_TAPS = 24
BLOCK = 32
"""Neighbouring pixels of a row with one common motion."""


def needs_blur(width: int, height: int, motion: NDArray[np.float64], exposure_share: float) -> bool:
    """Return whether ``blur_by_motion`` changes a picture of that size."""
    return _blur_length_px(width, height, motion, exposure_share) >= SMALLEST_BLUR_PX


def blur_by_motion(
    radiance: NDArray[np.float32], motion: NDArray[np.float64], exposure_share: float
) -> NDArray[np.float32]:
    """Return the mean radiance (H, 3, W) over an exposure centred on the picture's instant.

    A pixel p collects light along ``p + s (H(p) - p)``, s in ``exposure_share * [-1/2, 1/2]``.

    Args:
        motion: homography H (3, 3) that takes pixels of this picture to the next one: the camera's own motion.
        exposure_share: exposure time over the time between two pictures.

    Returns:
        ``radiance`` itself where no corner moves by half a pixel.
    """
    length_px = _blur_length_px(radiance.shape[2], radiance.shape[0], motion, exposure_share)
    if length_px < SMALLEST_BLUR_PX:
        return radiance
    blurred = np.zeros_like(radiance)
    taps = min(1 + int(np.ceil(length_px)), MOST_TAPS)
    _average_along(radiance, motion / motion[2, 2], exposure_share, taps, blurred)
    return blurred


def _blur_length_px(width: int, height: int, motion: NDArray[np.float64], exposure_share: float) -> float:
    """Return the largest motion of a corner during the exposure."""
    (a, b, c), (d, e, f), (g, h, i) = motion.tolist()
    length_px = 0.0
    for x, y in ((0, 0), (width, 0), (0, height), (width, height)):
        w = g * x + h * y + i
        if w <= 0:
            expected = "a homography that keeps the picture before the camera"
            raise ValueError(f"motion: expected {expected}, got {motion.tolist()}")
        length_px = max(length_px, math.hypot((a * x + b * y + c) / w - x, (d * x + e * y + f) / w - y))
    return exposure_share * length_px


@njit(cache=True)
def _average_along(
    radiance: NDArray[np.float32], motion: NDArray[np.float64], share: float, taps: int, blurred: NDArray[np.float32]
) -> None:
    """Add up ``taps`` bilinear samples at the middles of equal pieces of the path of each block's middle.

    Outside the picture its border is repeated.
    """
    height, width = radiance.shape[0], radiance.shape[2]
    # Numbers into flat arrays: to slice a line costs as much as to add up a block.
    lines, out = radiance.reshape(-1), blurred.reshape(-1)
    padded = np.empty(2 * (BLOCK + 1), np.float32)
    for row in range(height):
        for first in range(0, width, BLOCK):
            last = min(first + BLOCK, width)
            count = last - first
            x, y = 0.5 * (first + last), row + 0.5
            w = motion[2, 0] * x + motion[2, 1] * y + motion[2, 2]
            dx = ((motion[0, 0] * x + motion[0, 1] * y + motion[0, 2]) / w - x) * share
            dy = ((motion[1, 0] * x + motion[1, 1] * y + motion[1, 2]) / w - y) * share
            for tap in range(taps):
                s = (tap + 0.5) / taps - 0.5
                column, line = first + s * dx, row + s * dy
                j, i = int(np.floor(column)), int(np.floor(line))
                fx, fy = np.float32(column - j), line - i
                here, after = np.float32((1.0 - fy) / taps), np.float32(fy / taps)
                upper, lower = min(max(i, 0), height - 1), min(max(i + 1, 0), height - 1)
                is_inside = j >= 0 and j + count + 1 <= width
                for channel in range(3):
                    above, below = (3 * upper + channel) * width + j, (3 * lower + channel) * width + j
                    to = (3 * row + channel) * width + first
                    if is_inside:
                        _add_shifted(lines, above, fx, here, out, to, count)
                        _add_shifted(lines, below, fx, after, out, to, count)
                        continue
                    for k in range(count + 1):
                        away = min(max(j + k, 0), width - 1) - j
                        padded[k], padded[BLOCK + 1 + k] = lines[above + away], lines[below + away]
                    _add_shifted(padded, 0, fx, here, out, to, count)
                    _add_shifted(padded, BLOCK + 1, fx, after, out, to, count)


@njit(cache=True, fastmath={"contract", "arcp", "nsz"}, inline="never")
def _add_shifted(
    line: NDArray[np.float32],
    start: int,
    shift: np.float32,
    weight: np.float32,
    out: NDArray[np.float32],
    to: int,
    count: int,
) -> None:
    """Add ``weight ((1 - shift) line[start + k] + shift line[start + k + 1])`` to each of ``count`` ``out[to + k]``."""
    a, b = weight * (np.float32(1.0) - shift), weight * shift
    first, into, one = np.uint64(start), np.uint64(to), np.uint64(1)
    for k in range(np.uint64(count)):
        out[into + k] += a * line[first + k] + b * line[first + k + one]
