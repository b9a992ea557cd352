"""Pictures at half size, in which the tracker works, and conversion of their coordinates."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

SHRINK = 2
"""Full resolution over that of the small picture."""
_FAR_PX = 10_000


def shrink(image_rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the picture at 1 / SHRINK of its size, by averaging."""
    height, width = image_rgb.shape[:2]
    return cv2.resize(image_rgb, small_size(width, height), interpolation=cv2.INTER_AREA)


def small_size(width_px: int, height_px: int) -> tuple[int, int]:
    """Return width and height of the shrunk picture, at least one pixel each."""
    return max(width_px // SHRINK, 1), max(height_px // SHRINK, 1)


def to_full(small: NDArray[np.floating]) -> NDArray[np.float64]:
    """Convert OpenCV's indices in the small picture (whole numbers are centres) to pixels of the full one."""
    return (small.astype(np.float64) + 0.5) * SHRINK


def to_small(full: NDArray[np.float64]) -> NDArray[np.float64]:
    """Convert pixels of the full picture to OpenCV's indices in the small one."""
    return full / SHRINK - 0.5


def draw_disc(picture: NDArray[Any], centre: NDArray[np.float64], radius_px: float, value: float) -> None:
    """Set the pixels of ``picture`` (H, W) within ``radius_px`` of ``centre`` (2,), in place; none if the centre is not
    finite or far outside.
    """
    if np.isfinite(radius_px) and np.isfinite(centre).all() and np.abs(centre).max() < _FAR_PX:
        radius_px = min(radius_px, _FAR_PX)
        cv2.circle(picture, tuple(np.round(centre).astype(int).tolist()), int(radius_px) + 1, value, -1)
