"""What a site's trackers read of an observation, and the noise of it."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.types import Observation

Picture = NDArray[np.float32]

_MEDIAN_TO_SIGMA = 1.4826
_LEAST_NOISE = 0.5
"""Counts; a picture is rounded to whole ones."""
_SINGLE = 1.5
"""Noise beside that of what a median filter of 3 x 3 pixels takes away."""


def reading_of(observation: Observation, use_counts: bool) -> Picture:
    """Return the counts (H, W), or the 8 bits if there are none or they are not wanted."""
    counts = observation.counts
    if counts is not None and use_counts and counts.shape == observation.image_rgb.shape[:2]:
        return counts.astype(np.float32)
    grey: Picture = observation.image_rgb[..., 0].astype(np.float32)
    return grey


def noise_of(pictures: Picture) -> Picture:
    """Return the standard deviation (H, W) of each pixel from one picture (T, H, W) to the next, T >= 1.

    1.48 times the median absolute step, over the root of 2; what all pixels step together is left out. It is at least
    half a count. One picture alone has one noise, that of its fine structure.
    """
    if len(pictures) == 1:
        fine = pictures[0] - cv2.medianBlur(pictures[0], 3)
        sigma = _MEDIAN_TO_SIGMA * float(np.median(np.abs(fine))) * _SINGLE
        return np.full(fine.shape, max(sigma, _LEAST_NOISE), np.float32)
    steps = np.diff(pictures.reshape(len(pictures), -1), axis=0)
    steps -= np.median(steps[:, ::7], axis=1)[:, None]
    np.abs(steps, out=steps)
    sigma = _MEDIAN_TO_SIGMA / np.sqrt(2.0) * np.partition(steps, len(steps) // 2, axis=0)[len(steps) // 2]
    smooth = cv2.blur((sigma**2).reshape(pictures.shape[1:]), (3, 3))
    noise: Picture = np.sqrt(np.maximum(smooth, _LEAST_NOISE**2)).astype(np.float32)
    return noise
