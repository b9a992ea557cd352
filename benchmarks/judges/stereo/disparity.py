"""The disparity that trackers match from the pair against the true one: rows of an episode.

The true disparity is ``d = f b / z`` with the true depth z of the left camera: that of a perfectly aligned pair. The
small misalignment of a real pair counts as an error, as it does when depth is computed from disparity.
Errors are in pixels of the picture at full size; *density* is the share of the pixels with a disparity, *error* the
median of a picture's known disparities, mean over pictures by their known pixels. *Bad N* is the share of the known
disparities that are off by more than N pixels, as in the Middlebury benchmark (D. Scharstein and R. Szeliski, 2002);
KITTI counts bad 3.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from math import inf

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import Score, truth_as
from benchmarks.contract.metric import Better, Mean, Metric, Quantity
from scenarios.scenario import Frame
from scenarios.stereo_follow.truth import StereoTruth
from sim.optics import project, rays
from trackers.light_adaptive_stereo.matching import StereoMatcher, baseline_m

EVERY_FRAMES = 10
"""Matching costs as much as a tracker, so one picture of ten is measured."""
ALL_PIXELS, TARGET_PIXELS = "all", "target"
_SAME_PX = 1.0


class DisparityMeasurement:
    """Matches every tenth pair of an episode as stereo trackers do, unless the right picture is lost."""

    def __init__(self, target: str) -> None:
        """``target``: name of the object whose pixels are also measured separately."""
        self._target = target
        self._matcher = StereoMatcher()
        self._sums: dict[str, NDArray[np.float64]] = {}

    def see(self, frame: Frame) -> None:
        """Take one frame."""
        seen, truth = frame.observation, truth_as(frame.truth, StereoTruth)
        if truth.frame % EVERY_FRAMES or seen.right_rgb is None:
            return
        error_px = disparity_error_px(frame, self._matcher.depth_m(seen.image_rgb, seen.right_rgb, seen.camera))
        counts = seen_by_both(frame)
        on_target = truth.instance_map == truth.instance_id[truth.index_of(self._target)]
        for group, among in ((ALL_PIXELS, counts), (TARGET_PIXELS, counts & on_target), (truth.place, counts)):
            self._sums[group] = self._sums.get(group, 0.0) + error_sums(error_px[among])

    def scores(self) -> Iterator[Score]:
        """Yield the rows of the episode."""
        for group, (pixels, known, medians_px, beyond_1, beyond_3) in self._sums.items():
            parts = {"error_px": medians_px, "bad_1": beyond_1, "bad_3": beyond_3, "density": known}
            for name, part in parts.items():
                whole = float(pixels if name == "density" else known)
                yield Score(f"disparity_{name}_{group}", float(part) / whole if whole else None, whole)


def error_sums(error_px: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return sums over the pixels (K,) of one picture, NaN where there is no disparity.

    They are the numbers of pixels and of those with a disparity, the median error times the latter, and the numbers of
    errors of more than 1 and 3 pixels.
    """
    known_px = error_px[np.isfinite(error_px)]
    median_px = float(np.median(known_px)) if len(known_px) else 0.0
    beyond = [(known_px > bound).sum() for bound in (1.0, 3.0)]
    return np.array([len(error_px), len(known_px), len(known_px) * median_px, *beyond], dtype=float)


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
    focal_times_baseline = camera.focal_px * baseline_m(camera)
    difference_px = focal_times_baseline * np.abs(1.0 / there_m - 1.0 / np.where(inside, right_depth_m, 1.0))
    return inside & (difference_px <= _SAME_PX)


_PIXELS = "every tenth pair whose right picture is not lost: pixels that both cameras see"
_MIDDLEBURY = "Middlebury: Scharstein and Szeliski, A taxonomy and evaluation of dense two-frame stereo, IJCV 47, 2002"


def _metric(name: str, summary: str, unit: str = "fraction", better: Better = "lower") -> Metric:
    high = 1.0 if unit == "fraction" else inf
    quantity = Quantity(f"disparity_{name}", 0, high, _PIXELS, _MIDDLEBURY, (sys.modules[__name__],))
    return Metric(name, summary, unit, better, Mean(quantity))


DISPARITY = (
    _metric("error_px", "median absolute error", "px"),
    _metric("bad_1", "disparities off by more than 1 pixel"),
    _metric("bad_3", "disparities off by more than 3 pixels"),
    _metric("density", "pixels that have a disparity", better="higher"),
)
"""Metrics of the rows of one line, without its suffix."""
