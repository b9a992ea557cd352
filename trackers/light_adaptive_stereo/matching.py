"""Distance at every pixel of a rectified stereo pair (paper B, section 3.1: the disparity picture)."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.types import CameraModel


@dataclass(frozen=True)
class MatchingParameters:
    """Settings of semi-global matching; pixels are those of the reduced pictures.

    Attributes:
        width_px: pictures are reduced by the whole number that gives a width nearest to this one, which also reduces
            errors of the cameras' alignment and the noise of dark pictures.
        disparities: number of disparities, a multiple of 16; the largest one is the nearest distance.
        block_px: side of the compared blocks, odd.
        small_step_cost, large_step_cost: cost of a change of the disparity by one, and by more, from one pixel to the
            next, per pixel of the block.
        gradient_limit: limit of the horizontal gradients, which are compared instead of grey levels, so that a
            difference of the cameras' brightness has little effect.
        uniqueness_percent: margin of the best disparity's cost over any other but its neighbours.
        check_px: largest difference from the disparity matched from right to left.
        speckle_px, speckle_step: regions below this size that differ by this from their surroundings are unknown.
        correction_block_px: side of the blocks of ``correction_px``.
    """

    width_px: int = 320
    disparities: int = 64
    block_px: int = 5
    small_step_cost: int = 8
    large_step_cost: int = 32
    gradient_limit: int = 31
    uniqueness_percent: int = 5
    check_px: int = 1
    speckle_px: int = 60
    speckle_step: int = 2
    correction_block_px: int = 15


_LEAST_SLOPE = 0.7
"""Slope in grey levels a pixel below which texture is noise."""
_EDGE_PX = 5


def baseline_m(camera: CameraModel) -> float:
    """Return the distance between the two cameras of a pair.

    Raises:
        ValueError: for a single camera.
    """
    if camera.baseline_m is None or not camera.baseline_m > 0.0:
        raise ValueError(
            "camera.baseline_m: expected the distance of the stereo pair's cameras in metres, > 0, "
            f"got {camera.baseline_m}"
        )
    return camera.baseline_m


class StereoMatcher:
    """Semi-global matching (H. Hirschmüller, 2008; OpenCV's version along three directions) of reduced pictures.

    Block matching at full size takes twice as long and leaves holes in uniform clothes and walls. Here smoothness fills
    them, and also fills a uniform sky with the depth of what is in front of it.

    Attributes:
        parameters: its settings.
    """

    def __init__(self, parameters: MatchingParameters | None = None) -> None:
        p = self.parameters = parameters or MatchingParameters()
        self._matcher = cv2.StereoSGBM.create(
            minDisparity=0,
            numDisparities=p.disparities,
            blockSize=p.block_px,
            P1=p.small_step_cost * p.block_px**2,
            P2=p.large_step_cost * p.block_px**2,
            disp12MaxDiff=p.check_px,
            preFilterCap=p.gradient_limit,
            uniquenessRatio=p.uniqueness_percent,
            speckleWindowSize=p.speckle_px,
            speckleRange=p.speckle_step,
            mode=cv2.STEREO_SGBM_MODE_SGBM_3WAY,
        )

    def smaller(self, image: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Return a picture (H, W) or (H, W, 3) at the depth picture's size (H', W'), each pixel a mean."""
        shrink = max(round(image.shape[1] / self.parameters.width_px), 1)
        size = (image.shape[1] // shrink, image.shape[0] // shrink)
        smaller: NDArray[np.uint8] = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
        return smaller

    def depth_m(
        self, left_rgb: NDArray[np.uint8], right_rgb: NDArray[np.uint8], camera: CameraModel
    ) -> NDArray[np.float32]:
        """Return ``z = f b / d`` along the left camera's axis (H', W') float32, NaN where unknown.

        Args:
            left_rgb, right_rgb: (H, W, 3).

        Raises:
            ValueError: for pictures of different sizes or a camera without a baseline.
        """
        if left_rgb.shape != right_rgb.shape:
            raise ValueError(
                f"right_rgb: expected a picture of the left one's shape {left_rgb.shape}, got {right_rgb.shape}"
            )
        left, right = (self._widened(image) for image in (left_rgb, right_rgb))
        sixteenths: NDArray[np.int16] = self._matcher.compute(left, right)[:, self.parameters.disparities :]
        known = sixteenths > 0
        disparity_px = sixteenths.astype(np.float32) / np.float32(16)
        cut = self.parameters.disparities
        disparity_px += correction_px(left[:, cut:], right[:, cut:], disparity_px, self.parameters.correction_block_px)
        disparity_px = np.where(known, np.maximum(disparity_px, 1e-3), np.nan).astype(np.float32)
        focal_px = camera.focal_px * disparity_px.shape[1] / camera.width_px
        depth: NDArray[np.float32] = np.float32(focal_px * baseline_m(camera)) / disparity_px
        return depth

    def _widened(self, image_rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Return the reduced grey picture, widened on the left by the columns for which the matcher has no result."""
        grey = self.smaller(cv2.cvtColor(image_rgb, cv2.COLOR_RGB2GRAY))
        wider: NDArray[np.uint8] = cv2.copyMakeBorder(grey, 0, 0, self.parameters.disparities, 0, cv2.BORDER_REPLICATE)
        return wider


def correction_px(
    left: NDArray[np.uint8], right: NDArray[np.uint8], disparity_px: NDArray[np.float32], block_px: int
) -> NDArray[np.float32]:
    """Return the sub-pixel correction of a disparity d (H', W'), in [-0.5, 0.5].

    Semi-global matching biases disparities towards whole pixels. One least-squares step corrects them (B. D. Lucas and
    T. Kanade, 1981): with ``R_d(x) = R(x - d)``, ``L = R_d - delta R_d'`` over a block, minus its mean there, so that a
    difference of the cameras' brightness has no effect: ``delta = sum R_d' (R_d - L) / (sum R_d'² + c)``. With little
    texture c keeps the correction near 0.
    """
    columns, rows = np.meshgrid(*(np.arange(size, dtype=np.float32) for size in left.shape[::-1]))
    moved = cv2.remap(
        right.astype(np.float32), columns - disparity_px, rows, cv2.INTER_LINEAR, None, cv2.BORDER_REPLICATE
    )
    # Blocks near the edges of objects are matched to the background; they are left out.
    around = np.ones((_EDGE_PX, _EDGE_PX), np.uint8)
    inner = (cv2.dilate(disparity_px, around) - cv2.erode(disparity_px, around) <= 1.0).astype(np.float32)

    def block_mean(values: NDArray[np.float32]) -> NDArray[np.float32]:
        mean: NDArray[np.float32] = cv2.blur(values, (block_px, block_px))
        return mean

    share = np.maximum(block_mean(inner), np.float32(1e-3))
    difference = moved - left
    difference = inner * (difference - block_mean(inner * difference) / share)
    slope = cv2.Sobel(moved, cv2.CV_32F, 1, 0, ksize=3, scale=1.0 / 8.0)
    strength = block_mean(inner * slope * slope) + share * _LEAST_SLOPE**2
    return np.clip(block_mean(slope * difference) / strength, -0.5, 0.5)
