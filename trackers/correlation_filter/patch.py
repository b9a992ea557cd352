"""Patches of a picture: a grid of samples around a point, at any distance of the samples, also across the border."""

from __future__ import annotations

from math import ceil

import cv2
import numpy as np
from numpy.typing import NDArray

_MOST_FINER = 8


def patch_around(
    image_rgb: NDArray[np.uint8], centre_px: NDArray[np.float64], step_px: NDArray[np.float64], shape: tuple[int, int]
) -> NDArray[np.uint8]:
    """Return a patch (rows, columns, 3) with a given middle.

    A sample is the mean of the pixels that it covers, of 8 x 8 at most, or lies between them where it is smaller than
    one. Beyond the border the nearest pixel of the picture is repeated.

    Args:
        image_rgb: (H, W, 3).
        centre_px: (2,) middle of the patch.
        step_px: (2,) distance of neighbouring samples in x and y, pixels.
        shape: rows and columns of the patch.
    """
    across_px, down_px = (float(step) for step in step_px)
    finer = min(max(ceil(max(across_px, down_px) - 0.25), 1), _MOST_FINER)
    rows, columns = finer * shape[0], finer * shape[1]
    across_px, down_px = across_px / finer, down_px / finer
    # OpenCV's whole numbers are the middles of pixels.
    left = float(centre_px[0]) - 0.5 * across_px * (columns - 1) - 0.5
    top = float(centre_px[1]) - 0.5 * down_px * (rows - 1) - 0.5
    fine = cv2.warpAffine(
        image_rgb,
        np.array([[across_px, 0.0, left], [0.0, down_px, top]]),
        (columns, rows),
        flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
        borderMode=cv2.BORDER_REPLICATE,
    )
    patch = fine if finer == 1 else cv2.resize(fine, shape[::-1], interpolation=cv2.INTER_AREA)
    return np.asarray(patch, np.uint8)
