"""Mosaic of the ground: all pictures so far, at half size, stitched into one growing picture."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from trackers.kernels.ground_camera import CENTRE_HEIGHT_M, GroundCamera
from trackers.mosaic_graph.kernels.oriented_box import UNKNOWN

SHRINK = 2
"""Full resolution over that of the small picture."""
_FAR_PX = 10_000


def shrink(image_rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the picture at 1 / SHRINK of its size, by averaging."""
    height, width = image_rgb.shape[:2]
    return cv2.resize(image_rgb, small_size(width, height), interpolation=cv2.INTER_AREA)


def small_size(width_px: int, height_px: int) -> tuple[int, int]:
    """Return width and height of the shrunk picture, at least one pixel each."""
    return max(width_px // SHRINK, 1), max(height_px // SHRINK, 1)


def to_full(small: NDArray[np.floating]) -> NDArray[np.float64]:
    """Convert OpenCV's indices in the small picture (whole numbers are centres) to pixels of the full one."""
    return (small.astype(np.float64) + 0.5) * SHRINK


def to_small(full: NDArray[np.float64]) -> NDArray[np.float64]:
    """Convert pixels of the full picture to OpenCV's indices in the small one."""
    return full / SHRINK - 0.5


def draw_disc(picture: NDArray[Any], centre: NDArray[np.float64], radius_px: float, value: float) -> None:
    """Set the pixels of ``picture`` (H, W) within ``radius_px`` of ``centre`` (2,), in place; none if the centre is not
    finite or far outside.
    """
    if np.isfinite(radius_px) and np.isfinite(centre).all() and np.abs(centre).max() < _FAR_PX:
        radius_px = min(radius_px, _FAR_PX)
        cv2.circle(picture, tuple(np.round(centre).astype(int).tolist()), int(radius_px) + 1, value, -1)


@njit(cache=True, fastmath=True)
def blend_into(
    mean: NDArray[np.float32],
    rounded: NDArray[np.uint8],
    count: NDArray[np.uint8],
    patch: NDArray[np.uint8],
    weight: NDArray[np.uint8],
    slowest_rate: float,
) -> None:
    """Add ``patch`` to the running mean, in place.

    Where ``weight`` w > 0:  ``mean <- mean + (w / 255) max(1 / (n + 1), slowest_rate) (patch - mean)``, and
    ``n <- min(n + 1, 255)`` if w >= 128. The first time (n = 0) the mean becomes the patch and n = 1
    whatever the weight.

    Args:
        mean: (H, W, 3) running mean; rounded: (H, W, 3) the same in 8 bit; count: (H, W) pictures so far.
        patch: (H, W, 3) new picture; weight: (H, W), 0 = not seen here.
        slowest_rate: in (0, 1], floor of the rate, so that the mean follows the light.
    """
    for i in range(patch.shape[0]):
        for j in range(patch.shape[1]):
            if weight[i, j] == 0:
                continue
            rate = 1.0
            if count[i, j] > 0:
                rate = max(1.0 / (count[i, j] + 1.0), slowest_rate) * weight[i, j] / 255.0
            if count[i, j] == 0 or (weight[i, j] >= 128 and count[i, j] < 255):
                count[i, j] += 1
            for c in range(3):
                value = mean[i, j, c] + rate * (patch[i, j, c] - mean[i, j, c])
                mean[i, j, c] = value
                rounded[i, j, c] = np.uint8(value + 0.5)


_GROW_CELLS = 256
_SLOWEST_RATE = 0.06
_WIDEST_VIEW_M = 400.0
_MOST_CELLS, _LONGEST_SIDE_CELLS = 2**25, 2**15 - 1
"""Half a gigabyte, and the longest side that OpenCV can warp."""
_SUDDEN_LEVELS, _SUDDEN_WEIGHT = 30, 70


class Mosaic:
    """Running mean of the colours seen at every cell of the ground.

    Cell (row i, column j) covers the map from ``origin_m + cell_m * (j, i)`` to one cell further in x and y.

    Attributes:
        cell_m: side of a cell.
        origin_m: (2,) map position of the corner of cell (0, 0).
        rgb: (H, W, 3) uint8.
        count: (H, W) uint8, pictures that showed each cell; 255 = that many or more.
    """

    def __init__(self, cell_m: float) -> None:
        self.cell_m = cell_m
        self.origin_m = np.zeros(2)
        self.rgb = np.zeros((0, 0, 3), np.uint8)
        self.count = np.zeros((0, 0), np.uint8)
        self._mean = np.zeros((0, 0, 3), np.float32)

    def add(self, small_rgb: NDArray[np.uint8], camera: GroundCamera, weight: NDArray[np.uint8]) -> None:
        """Add a picture, except one whose erroneous pose has the horizon in view or is too far off.

        Args:
            small_rgb: (H, W, 3), shrunk by ``SHRINK``.
            camera: of the picture at full size.
            weight: (H, W) 1-255, see ``standing_ground``.
        """
        corners_m = camera.footprint_m()
        # Corners above the horizon are NaN.
        if not np.ptp(corners_m, axis=0).max() < _WIDEST_VIEW_M:
            return
        window = self._window(corners_m)
        if window is None:
            return
        (left, top), (right, bottom) = window
        H = picture_from_cells(camera, self.cell_m, self.origin_m + self.cell_m * np.array([left, top]))
        size = (right - left, bottom - top)
        patch = cv2.warpPerspective(small_rgb, H, size, flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP)
        inside = weight.copy()
        # The outermost pixels are mixed with the black beyond the border.
        inside[[0, -1], :] = inside[:, [0, -1]] = 0
        patch_weight = cv2.warpPerspective(inside, H, size, flags=cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP)
        cells = slice(top, bottom), slice(left, right)
        blend_into(self._mean[cells], self.rgb[cells], self.count[cells], patch, patch_weight, _SLOWEST_RATE)

    def render(self, camera: GroundCamera) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
        """Return the mosaic as ``camera`` would see it, shrunk by ``SHRINK``: rgb (H, W, 3) and count (H, W)."""
        size = small_size(camera.model.width_px, camera.model.height_px)
        if self.count.size == 0:
            return np.zeros((*size[::-1], 3), np.uint8), np.zeros(size[::-1], np.uint8)
        H = picture_from_cells(camera, self.cell_m, self.origin_m)
        rgb = cv2.warpPerspective(self.rgb, H, size, flags=cv2.INTER_LINEAR)
        count = cv2.warpPerspective(self.count, H, size, flags=cv2.INTER_NEAREST)
        return rgb, count

    def cells_of(self, map_m: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return (column, row) (N, 2) of the cells of map points (N, 2), which may lie outside the mosaic."""
        return np.floor((map_m - self.origin_m) / self.cell_m).astype(np.int64)

    def _window(self, corners_m: NDArray[np.float64]) -> tuple[list[int], list[int]] | None:
        """Grow the mosaic to hold map points (N, 2); return their first (column, row) and the one after the last.

        Return None if the mosaic would become too large.
        """
        low = np.floor((corners_m.min(axis=0) - self.origin_m) / self.cell_m).astype(int)
        high = np.ceil((corners_m.max(axis=0) - self.origin_m) / self.cell_m).astype(int) + 1
        height, width = self.count.shape
        if (low < 0).any() or high[0] > width or high[1] > height:
            before = np.where(low < 0, -low + _GROW_CELLS, 0)
            after = np.maximum(high - [width, height] + _GROW_CELLS, 0) * (high > [width, height])
            size = before + after + [width, height]
            if size.max() > _LONGEST_SIDE_CELLS or size.prod() > _MOST_CELLS:
                return None
            self._grow(before, after)
            low, high = low + before, high + before
        return low.tolist(), high.tolist()

    def _grow(self, before: NDArray[np.int64], after: NDArray[np.int64]) -> None:
        pad = ((before[1], after[1]), (before[0], after[0]))
        self.rgb = np.pad(self.rgb, (*pad, (0, 0)))
        self._mean = np.pad(self._mean, (*pad, (0, 0)))
        self.count = np.pad(self.count, pad)
        self.origin_m = self.origin_m - self.cell_m * before


def standing_ground(
    camera: GroundCamera, difference: NDArray[np.uint8] | None, target_m: NDArray[np.float64] | None, length_m: float
) -> NDArray[np.uint8]:
    """Return the weight (H, W) 1-255 of each pixel of a shrunk picture as static ground: 70 where it changed suddenly,
    1 on the target.

    Args:
        difference: (H, W) from the mosaic, or ``UNKNOWN``; None = unknown everywhere.
        target_m: (2,) place of the target on the map, of ``length_m``; None = not in the picture.
    """
    width, height = small_size(camera.model.width_px, camera.model.height_px)
    weight = np.full((height, width), 255, np.uint8)
    if difference is not None:
        weight[(difference > _SUDDEN_LEVELS) & (difference != UNKNOWN)] = _SUDDEN_WEIGHT
    if target_m is not None:
        pixel = to_small(camera.to_picture(target_m[None], CENTRE_HEIGHT_M))[0]
        draw_disc(weight, pixel, 0.7 * length_m / (SHRINK * camera.metres_per_pixel()), 1)
    return weight


def picture_from_cells(camera: GroundCamera, cell_m: float, origin_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the homography (3, 3) from indices (column, row) of a grid on the map, with its corner at ``origin_m``, to
    those of the picture shrunk by ``SHRINK``. In both, whole numbers are centres, as in OpenCV.
    """
    map_from_cells = np.array(
        [[cell_m, 0.0, origin_m[0] + 0.5 * cell_m], [0.0, cell_m, origin_m[1] + 0.5 * cell_m], [0.0, 0.0, 1.0]]
    )
    shrunk = np.array([[1.0 / SHRINK, 0.0, -0.5], [0.0, 1.0 / SHRINK, -0.5], [0.0, 0.0, 1.0]])
    return shrunk @ camera.H_picture_map() @ map_from_cells
