"""Pictures are laid down and searched at half their size: how to get there and back."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

SHRINK = 2
"""Small pictures have 1 / SHRINK of the resolution."""


def shrink(image_rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the picture at 1 / SHRINK of its size, by averaging."""
    height, width = image_rgb.shape[:2]
    return cv2.resize(image_rgb, (width // SHRINK, height // SHRINK), interpolation=cv2.INTER_AREA)


def to_full(small: NDArray[np.floating]) -> NDArray[np.float64]:
    """Take OpenCV's indices in the small picture (whole numbers are centres) to pixels of the full one."""
    return (small.astype(np.float64) + 0.5) * SHRINK


def to_small(full: NDArray[np.float64]) -> NDArray[np.float64]:
    """Take pixels of the full picture to OpenCV's indices in the small one."""
    return full / SHRINK - 0.5
