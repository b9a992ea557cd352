"""Hue x saturation histograms of rectangles, their similarity, and the template that a car's box is compared with.

Source: paper A, equations 2.7, 2.8, 3.13 and section 3.2.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from trackers.kernels.boxes import box_centre, box_size

HUE_BINS = 16
SATURATION_BINS = 8
BINS = HUE_BINS * SATURATION_BINS

# OpenCV's 8-bit HSV: hue 0-179 (two degrees a step), saturation 0-255.
_HUE_OFFSET = (np.minimum(np.arange(256) * HUE_BINS // 180, HUE_BINS - 1) * SATURATION_BINS).astype(np.uint8)
_SATURATION_OFFSET = (np.arange(256) * SATURATION_BINS // 256).astype(np.uint8)


def hs_bins(image_rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return for each pixel of a picture (H, W, 3) the index of its bin (H, W): ``hue bin * 8 + saturation bin``."""
    return _combine(cv2.cvtColor(image_rgb, cv2.COLOR_RGB2HSV), _HUE_OFFSET, _SATURATION_OFFSET)


@njit(cache=True)
def _combine(
    image_hsv: NDArray[np.uint8], hue_offset: NDArray[np.uint8], saturation_offset: NDArray[np.uint8]
) -> NDArray[np.uint8]:
    height, width, _ = image_hsv.shape
    bins = np.empty((height, width), np.uint8)
    for i in range(height):
        for j in range(width):
            bins[i, j] = hue_offset[image_hsv[i, j, 0]] + saturation_offset[image_hsv[i, j, 1]]
    return bins


def rectangle_histogram(
    bins: NDArray[np.uint8], centre_px: NDArray[np.float64], size_px: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the histogram (128,), sum 1, of the visible part of one rectangle; zeros if no part is visible.

    The rectangle is placed as in ``rectangle_similarities``.
    """
    left, top = np.floor(centre_px - 0.5 * np.rint(size_px) + 0.5).astype(int)
    width, height = np.rint(size_px).astype(int)
    visible = bins[max(top, 0) : max(top + height, 0), max(left, 0) : max(left + width, 0)]
    return histogram_of(visible)


def histogram_of(bins: NDArray[np.uint8]) -> NDArray[np.float64]:
    """Return the histogram (128,), sum 1, of bins from ``hs_bins`` of any shape; zeros if there are none."""
    counts = np.bincount(bins.ravel(), minlength=BINS).astype(float)
    return counts / max(counts.sum(), 1.0)


def bhattacharyya(p: NDArray[np.float64], q: NDArray[np.float64]) -> float:
    """Return the coefficient ``L = sum sqrt(p q)`` of two histograms (B,) of sum 1: 0 for disjoint, 1 for equal."""
    return float(np.sqrt(p * q).sum())


def rectangle_similarities(
    bins: NDArray[np.uint8],
    centres_px: NDArray[np.float64],
    size_px: NDArray[np.float64],
    template: NDArray[np.float64],
    outside_similarity: float,
) -> NDArray[np.float64]:
    """Return ``L_n = sum_b sqrt(p_b q_b(x_n))`` of a rectangle around each of N positions (equation 2.7).

    Args:
        bins: (H, W) from ``hs_bins``.
        centres_px: (N, 2), inside the picture or not; NaN counts as outside.
        size_px: (2,) width and height, rounded to whole pixels; the corner is rounded to the nearest pixel corner.
        template: (128,) histogram p, sum 1.
        outside_similarity: L of a rectangle without a visible pixel (equation 3.13).

    Returns:
        (N,) in [0, 1]. The histogram of a rectangle cut by the border is that of its visible pixels.
    """
    width, height = (max(round(side), 1) for side in size_px.tolist())
    return _similarities(bins, np.ascontiguousarray(centres_px), width, height, np.sqrt(template), outside_similarity)


@njit(cache=True)
def picture_histogram(bins: NDArray[np.uint8]) -> NDArray[np.float64]:
    """Return the histogram (128,), sum 1, of a binned picture (H, W)."""
    counts = np.zeros(BINS, np.int64)
    for i in range(bins.shape[0]):
        for j in range(bins.shape[1]):
            counts[bins[i, j]] += 1
    return counts / bins.size


_MOST_REMEMBERED = 1 << 14
"""Largest number of cached similarities."""


@njit(cache=True)
def _similarities(bins, centres_px, width, height, root_template, outside_similarity):  # type: ignore[no-untyped-def]
    rows, columns = bins.shape
    similarities = np.empty(len(centres_px))
    corners = np.empty((len(centres_px), 2), np.int64)
    first_left, first_top, last_left, last_top = columns, rows, -width, -height
    for n in range(len(centres_px)):
        x, y = centres_px[n]
        corners[n] = columns, rows
        if -1e6 < x < 1e6 and -1e6 < y < 1e6:
            left = int(np.floor(x - 0.5 * width + 0.5))
            top = int(np.floor(y - 0.5 * height + 0.5))
            if -width < left < columns and -height < top < rows:
                corners[n] = left, top
                first_left, last_left = min(first_left, left), max(last_left, left)
                first_top, last_top = min(first_top, top), max(last_top, top)
    # Rectangles on the same pixels share one similarity.
    pitch, lines = max(last_left - first_left + 1, 0), max(last_top - first_top + 1, 0)
    remembered = np.full(pitch * lines if pitch * lines <= _MOST_REMEMBERED else 0, np.nan)
    counts = np.empty(2 * root_template.size, np.int32)
    for n in range(len(centres_px)):
        left, top = corners[n]
        if left == columns:
            similarities[n] = outside_similarity
            continue
        k = (top - first_top) * pitch + left - first_left
        if remembered.size == 0:
            similarities[n] = _similarity(bins, left, top, width, height, root_template, counts)
            continue
        if np.isnan(remembered[k]):
            remembered[k] = _similarity(bins, left, top, width, height, root_template, counts)
        similarities[n] = remembered[k]
    return similarities


@njit(cache=True, fastmath={"nsz", "contract", "reassoc"})
def _similarity(bins, left, top, width, height, root_template, counts):  # type: ignore[no-untyped-def]
    rows, columns = bins.shape
    half = root_template.size
    first_column, last_column = max(left, 0), min(left + width, columns)
    first_row, last_row = max(top, 0), min(top + height, rows)
    counts[:] = 0
    # Two counters alternate: neighbours share a bin, and a single counter would wait for its last store.
    even_end = first_column + (last_column - first_column) // 2 * 2
    for i in range(first_row, last_row):
        for j in range(first_column, even_end, 2):
            counts[bins[i, j]] += 1
            counts[half + bins[i, j + 1]] += 1
        if even_end < last_column:
            counts[bins[i, even_end]] += 1
    total = 0.0
    for b in range(half):
        total += np.sqrt(np.float64(counts[b] + counts[half + b])) * root_template[b]
    return total / np.sqrt((last_row - first_row) * (last_column - first_column))


@dataclass(frozen=True)
class ColourTemplate:
    """HS histogram of the car's box in the first picture.

    Attributes:
        histogram: (128,), sum 1: p.
        size_px: (2,) width and height of the car's box, at most the picture's: the rectangle whose colours are
            compared; it stays constant.
    """

    histogram: NDArray[np.float64]
    size_px: NDArray[np.float64]

    @classmethod
    def from_box(cls, image_rgb: NDArray[np.uint8], box_xyxy: NDArray[np.float64]) -> ColourTemplate:
        """Take the template from a box (4,) of a picture (H, W, 3).

        Raises:
            ValueError: if the box does not overlap the picture.
        """
        bins = hs_bins(image_rgb)
        size_px = np.minimum(box_size(box_xyxy), bins.shape[::-1])
        histogram = rectangle_histogram(bins, box_centre(box_xyxy), size_px)
        if histogram.sum() == 0.0:
            # The middle is outside the picture: use the visible part of the box.
            low, high = np.maximum(np.floor(box_xyxy[:2]), 0.0), np.maximum(np.ceil(box_xyxy[2:]), 0.0)
            histogram = rectangle_histogram(bins, 0.5 * (low + high), high - low)
        if histogram.sum() == 0.0:
            raise ValueError(
                f"box_xyxy: expected a box that overlaps the picture of {image_rgb.shape[1]} x {image_rgb.shape[0]} "
                f"pixels, got {np.asarray(box_xyxy).tolist()}"
            )
        return cls(histogram, size_px)

    @property
    def car_px(self) -> float:
        """Length of the car in pixels, the longer side of its box: the filters' unit of length."""
        return float(self.size_px.max())

    def similarities(self, bins: NDArray[np.uint8], centres_px: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the Bhattacharyya coefficient L (N,) of the rectangles around positions (N, 2) of a binned picture.

        The three cases of section 3.2: inside, L = sum sqrt(p q) (2.7); partly outside, missing pixels are filled in
        proportion to the visible ones; fully outside, the whole picture's histogram is used (3.13).
        """
        outside = bhattacharyya(picture_histogram(bins), self.histogram)
        return rectangle_similarities(bins, centres_px, self.size_px, self.histogram, outside)
