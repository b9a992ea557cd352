"""The disparity of a stereo matcher against the true one, pixel by pixel of the left picture.

The true disparity is ``d = f b / z`` with the true depth z of the left camera: that of a perfectly aligned pair. The
small misalignment of a real pair counts as an error, as it does when depth is computed from disparity.
Errors are in pixels of the picture at full size. *Bad N* is the share of errors of more than N pixels, as in the
Middlebury benchmark (D. Scharstein and R. Szeliski, 2002); KITTI counts bad 3.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import truth_as
from scenarios.scenario import Frame
from scenarios.stereo_follow.truth import StereoTruth
from sim.optics import project, rays
from trackers.light_adaptive_stereo.matching import baseline_m

_SAME_PX = 1.0


def disparity_error_px(frame: Frame, matched_depth_m: NDArray[np.float32]) -> NDArray[np.float64]:
    """Return ``|f b / z_matched - f b / z|`` (H, W) at every pixel of the left picture; NaN where nothing is matched.

    Args:
        matched_depth_m: (H', W') of the same view, of any size; NaN where it is unknown.
    """
    truth, camera = truth_as(frame.truth, StereoTruth), frame.observation.camera
    height, width = truth.depth_m.shape
    enlarged_m = cv2.resize(matched_depth_m, (width, height), interpolation=cv2.INTER_NEAREST).astype(float)
    focal_times_baseline = camera.focal_px * baseline_m(camera)
    error_px: NDArray[np.float64] = focal_times_baseline * np.abs(1.0 / enlarged_m - 1.0 / truth.depth_m)
    return error_px


def seen_by_both(frame: Frame) -> NDArray[np.bool_]:
    """Return (H, W): a pixel of the left picture shows a surface that the right camera sees, too.

    A pixel's point is projected by its true depth to the right picture. The right camera sees it if its true depth at
    that pixel gives the same disparity within one pixel; otherwise something else hides the point. Pixels of the sky,
    which has no depth, and points beside the right picture are not seen.
    """
    truth, camera = truth_as(frame.truth, StereoTruth), frame.camera
    height, width = truth.depth_m.shape
    columns, rows = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    is_surface = np.isfinite(truth.depth_m)
    depth_m = np.where(is_surface, truth.depth_m, 1.0).astype(float)
    directions = rays(camera, truth.T_world_camera, np.stack([columns, rows], axis=-1))
    points_m = truth.T_world_camera[:3, 3] + depth_m[..., None] * directions
    right_px, right_depth_m = project(camera, truth.T_world_right, points_m)
    inside = is_surface & (right_depth_m > 0) & ((right_px >= 0) & (right_px < (width, height))).all(axis=-1)
    column, row = np.where(inside[..., None], right_px, 0.0).astype(int).transpose(2, 0, 1)
    there_m = truth.right_depth_m[row, column].astype(float)
    focal_times_baseline = camera.focal_px * baseline_m(frame.observation.camera)
    difference_px = focal_times_baseline * np.abs(1.0 / there_m - 1.0 / np.where(inside, right_depth_m, 1.0))
    return inside & (difference_px <= _SAME_PX)


@dataclass(slots=True)
class DisparityErrors:
    """Sums of errors over pixels of many pictures.

    Attributes:
        pixels: number of pixels. known: number with a disparity.
    """

    pixels: int = 0
    known: int = 0
    _medians_px: float = 0.0
    _beyond_1: int = 0
    _beyond_3: int = 0

    def add(self, error_px: NDArray[np.float64]) -> None:
        """Add the pixels (K,) of one picture; NaN where there is no disparity."""
        known_px = error_px[np.isfinite(error_px)]
        self.pixels += len(error_px)
        self.known += len(known_px)
        if len(known_px):
            self._medians_px += len(known_px) * float(np.median(known_px))
        self._beyond_1 += int((known_px > 1.0).sum())
        self._beyond_3 += int((known_px > 3.0).sum())

    @property
    def median_px(self) -> float | None:
        """Median absolute error of a picture's known disparities, mean over pictures by their known pixels."""
        return self._medians_px / self.known if self.known else None

    @property
    def bad_1(self) -> float | None:
        """Share of the known disparities with an error above 1 pixel, in [0, 1]."""
        return self._beyond_1 / self.known if self.known else None

    @property
    def bad_3(self) -> float | None:
        """Share of the known disparities with an error above 3 pixels, in [0, 1]."""
        return self._beyond_3 / self.known if self.known else None

    @property
    def density(self) -> float | None:
        """Share of the pixels with a disparity, in [0, 1]."""
        return self.known / self.pixels if self.pixels else None
