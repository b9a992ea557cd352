"""Similarity of rectangles to the car's box in the first picture (paper A, equations 2.7, 2.8 and section 3.2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.kernels.boxes import box_centre, box_size
from trackers.kernels.histogram import (
    bhattacharyya,
    hs_bins,
    picture_histogram,
    rectangle_histogram,
    rectangle_similarities,
)


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
