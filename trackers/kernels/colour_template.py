"""How a place in the picture looks like the car's first rectangle (paper A, equations 2.7, 2.8 and section 3.2)."""

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
        size_px: (2,) width and height of the car's box, at most the picture's, the same ever after.
        rectangle_px: (2,) width and height of the rectangle whose colours are compared, about the same centre.
    """

    histogram: NDArray[np.float64]
    size_px: NDArray[np.float64]
    rectangle_px: NDArray[np.float64]

    @classmethod
    def from_box(
        cls, image_rgb: NDArray[np.uint8], box_xyxy: NDArray[np.float64], share: float = 1.0
    ) -> ColourTemplate:
        """Take the template from a box (4,) of a picture (H, W, 3).

        Args:
            share: of the box's width and height, what the rectangle about its centre has; in (0, 1]. The box of a car
                that stands askew in the picture is half road, the middle of it is car.

        Raises:
            ValueError: if nothing of the rectangle lies inside the picture.
        """
        bins = hs_bins(image_rgb)
        size_px = np.minimum(box_size(box_xyxy), bins.shape[::-1])
        rectangle_px = share * size_px
        histogram = rectangle_histogram(bins, box_centre(box_xyxy), rectangle_px)
        if histogram.sum() == 0.0:
            # The border cuts the middle off: what is left of the box has to do.
            low, high = np.maximum(np.floor(box_xyxy[:2]), 0.0), np.maximum(np.ceil(box_xyxy[2:]), 0.0)
            histogram = rectangle_histogram(bins, 0.5 * (low + high), high - low)
        if histogram.sum() == 0.0:
            raise ValueError(
                f"box_xyxy: expected a box that overlaps the picture of {image_rgb.shape[1]} x {image_rgb.shape[0]} "
                f"pixels, got {np.asarray(box_xyxy).tolist()}"
            )
        return cls(histogram, size_px, rectangle_px)

    @property
    def car_px(self) -> float:
        """Length of the car in pixels: its box's longer side, the unit in which filters measure lengths."""
        return float(self.size_px.max())

    def similarities(self, bins: NDArray[np.uint8], centres_px: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the Bhattacharyya coefficient L (N,) of the rectangles about positions (N, 2) of a binned picture.

        The three cases of section 3.2: fully outside, the whole picture's histogram stands in (3.13); partly outside,
        missing pixels are filled from the visible ones; inside, L = sum sqrt(p q) (2.7).
        """
        outside = bhattacharyya(picture_histogram(bins), self.histogram)
        return rectangle_similarities(bins, centres_px, self.rectangle_px, self.histogram, outside)
