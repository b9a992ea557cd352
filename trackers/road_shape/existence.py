"""Existence probability of a car: pixel classes corrected by the road's shape, beyond the picture too (paper A.3)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from trackers.road_shape.pixel_classes import PixelClassifier, mean_existence
from trackers.road_shape.road_model import RoadCurve
from trackers.road_shape.spline import evaluate_spline

_PAVEMENT_SHARE = 0.5
"""Reading: building pixels beside the road count as road (pavement, cars) up to this share of its half width."""

_FARTHEST_PX = 2000.0


class ExistenceMap:
    """Existence probability of a car on the pixels of one picture and around it."""

    def __init__(
        self,
        image_rgb: NDArray[np.uint8],
        classifier: PixelClassifier,
        road: RoadCurve | None,
        centre_px: NDArray[np.float64],
    ) -> None:
        """Classify a picture (H, W, 3) with its centre (2,); a known road is in pixels from the centre."""
        self._classes = classifier.classify(image_rgb)
        self._road = road
        self._centre_px = centre_px

    def mean_over(self, centres_px: NDArray[np.float64], size_px: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the mean probability (N,) over rectangles of a size (2,) around positions (N, 2), at least 0.1."""
        width, height = (max(int(side), 1) for side in np.rint(size_px))
        near = np.clip(np.nan_to_num(centres_px), -_FARTHEST_PX, _FARTHEST_PX)
        corners = np.floor(near - 0.5 * np.array([width, height]) + 0.5).astype(np.int64)
        axis = 0 if self._road is None else self._road.axis
        start, line, half = self._road_line(corners, axis, max(width, height))
        pavement_px = 0.0 if self._road is None else _PAVEMENT_SHARE * self._road.half_width_px
        # Particles in the same pixel share a rectangle.
        distinct, which = np.unique(corners, axis=0, return_inverse=True)
        means = mean_existence(self._classes, distinct, width, height, axis, line, start, half, pavement_px)
        return means[which]

    def _road_line(
        self, corners: NDArray[np.int64], axis: int, extent: int
    ) -> tuple[int, NDArray[np.float64], NDArray[np.float64]]:
        """Return the first pixel along the axis, and the road's position and half width across it from there on."""
        if self._road is None:
            return 0, np.empty(0), np.empty(0)
        start = int(corners[:, axis].min())
        along = np.arange(start, int(corners[:, axis].max()) + extent) + 0.5 - self._centre_px[axis]
        values, slopes = evaluate_spline(self._road.knots, self._road.pieces, along)
        return start, values + self._centre_px[1 - axis], self._road.half_width_px * np.hypot(1.0, slopes)
