"""What moves light between pixels: motion of the camera during the exposure, and the lens."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.optics import PinholeCamera

SMALLEST_BLUR_PX = 0.5
MOST_TAPS = 24


def needs_blur(width: int, height: int, motion: NDArray[np.float64], exposure_share: float) -> bool:
    """Return whether ``blur_by_motion`` changes a picture of that size."""
    return _blur_length_px(width, height, motion, exposure_share) >= SMALLEST_BLUR_PX


def _blur_length_px(width: int, height: int, motion: NDArray[np.float64], exposure_share: float) -> float:
    """Return how far the corner that moves most moves during the exposure."""
    corners = np.array([[0, 0, 1], [width, 0, 1], [0, height, 1], [width, height, 1.0]])
    moved = corners @ motion.T
    if (moved[:, 2] <= 0).any():
        expected = "a homography that keeps the picture before the camera"
        raise ValueError(f"motion: expected {expected}, got {motion.tolist()}")
    return exposure_share * float(np.linalg.norm(moved[:, :2] / moved[:, 2:] - corners[:, :2], axis=1).max())


def blur_by_motion(
    radiance: NDArray[np.float32], motion: NDArray[np.float64], exposure_share: float
) -> NDArray[np.float32]:
    """Return the mean radiance (H, 3, W) over an exposure centred on the picture's instant.

    A pixel p collects light along ``p + s (H(p) - p)``, s in ``exposure_share * [-1/2, 1/2]``.

    Args:
        motion: homography H (3, 3) that takes pixels of this picture to the next one: the camera's own
            motion.
        exposure_share: exposure time over the time between two pictures.

    Returns:
        ``radiance`` itself where no corner moves by half a pixel.
    """
    length_px = _blur_length_px(radiance.shape[2], radiance.shape[0], motion, exposure_share)
    if length_px < SMALLEST_BLUR_PX:
        return radiance
    blurred = np.empty_like(radiance)
    taps = min(1 + int(np.ceil(length_px)), MOST_TAPS)
    _average_along(radiance, motion / motion[2, 2], exposure_share, taps, blurred)
    return blurred


@njit(cache=True, fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def _average_along(
    radiance: NDArray[np.float32], motion: NDArray[np.float64], share: float, taps: int, blurred: NDArray[np.float32]
) -> None:
    """Mean of ``taps`` bilinear samples at the middles of equal pieces of the path of each pixel centre."""
    height, width = radiance.shape[0], radiance.shape[2]
    for row in range(height):
        for column in range(width):
            x, y = column + 0.5, row + 0.5
            w = motion[2, 0] * x + motion[2, 1] * y + motion[2, 2]
            dx = ((motion[0, 0] * x + motion[0, 1] * y + motion[0, 2]) / w - x) * share
            dy = ((motion[1, 0] * x + motion[1, 1] * y + motion[1, 2]) / w - y) * share
            red = green = blue = 0.0
            for tap in range(taps):
                s = (tap + 0.5) / taps - 0.5
                u = min(max(column + s * dx, 0.0), width - 1.0)
                v = min(max(row + s * dy, 0.0), height - 1.0)
                j, i = min(int(u), width - 2), min(int(v), height - 2)
                fu, fv = u - j, v - i
                a, b, c, d = (1 - fu) * (1 - fv), fu * (1 - fv), (1 - fu) * fv, fu * fv
                red += _mix(radiance[:, 0], i, j, a, b, c, d)
                green += _mix(radiance[:, 1], i, j, a, b, c, d)
                blue += _mix(radiance[:, 2], i, j, a, b, c, d)
            blurred[row, 0, column] = red / taps
            blurred[row, 1, column] = green / taps
            blurred[row, 2, column] = blue / taps


@njit(cache=True, inline="always")
def _mix(plane: NDArray[np.float32], i: int, j: int, a: float, b: float, c: float, d: float) -> float:
    return a * plane[i, j] + b * plane[i, j + 1] + c * plane[i + 1, j] + d * plane[i + 1, j + 1]


def distort(radiance: NDArray[np.float32], camera: PinholeCamera) -> NDArray[np.float32]:
    """Return the radiance (H, 3, W) as the lens bends it; ``radiance`` itself for a lens without distortion.

    Light that belongs at the normalised image point x arrives at ``x (1 + k1 r² + k2 r⁴)``, r = |x| (Brown
    1966).
    """
    if camera.radial_distortion == (0.0, 0.0):
        return radiance
    map_x, map_y = _undistorted_positions(camera)
    bent = np.empty_like(radiance)
    for channel in range(3):
        plane = np.ascontiguousarray(radiance[:, channel])
        bent[:, channel] = cv2.remap(plane, map_x, map_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return bent


@lru_cache(maxsize=4)
def _undistorted_positions(camera: PinholeCamera) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return where in the undistorted picture each pixel's light comes from: (column, row) arrays (H, W).

    Solves ``r_d = r (1 + k1 r² + k2 r⁴)`` for r by Newton's method.
    """
    k1, k2 = camera.radial_distortion
    x = (np.arange(camera.width_px) + 0.5 - 0.5 * camera.width_px) / camera.focal_px
    y = (np.arange(camera.height_px) + 0.5 - 0.5 * camera.height_px) / camera.focal_px
    x, y = np.meshgrid(x, y)
    r_distorted = np.hypot(x, y)
    r = r_distorted.copy()
    for _ in range(20):
        error = r * (1 + k1 * r**2 + k2 * r**4) - r_distorted
        r -= error / (1 + 3 * k1 * r**2 + 5 * k2 * r**4)
    scale = np.where(r_distorted > 0, r / np.maximum(r_distorted, 1e-12), 1.0) * camera.focal_px
    map_x = x * scale + 0.5 * camera.width_px - 0.5
    map_y = y * scale + 0.5 * camera.height_px - 0.5
    return map_x.astype(np.float32), map_y.astype(np.float32)
