"""What level water mirrors: the world as it is seen from the camera's image below the water.

The image of a camera in a plane sees through each pixel of the plane what that pixel mirrors. It looks up, so that row
r of the picture is row H - r of its own. A picture of a third of the size is enough, as waves blur it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.optics import Camera, Intrinsics, principal_point, ray_of_pixel
from sim.render.compilation import row_kernel

_SHRINK = 3
_HALF, _ONE, _TWO, _ZERO = np.float32(0.5), np.float32(1.0), np.float32(2.0), np.float32(0.0)
_TAP = np.float32(1.2)
_MIDDLE_WEIGHT = np.float32(0.305)
"""Three slopes in place of all fine ones: ``1.2`` deviations either side, with weights that keep their variance."""
_USUAL_REACH = np.float32(0.06)
"""Share of the way from the camera that lies beyond the water, where the smooth sea would mirror the sky."""
_FARTHEST_STIR = 0.05
"""Angle by which waves may move what is mirrored, seen from the camera's image: slopes of 0.2 with things that stand an
eighth of the way beyond the water.
"""
_FARTHEST_M = np.float32(1e6)
CELL = 8
_PROBE_STEP_PX = 32
_LEVEL_WITHIN_M = 0.05


class MirrorArrays(NamedTuple):
    """A mirrored picture for kernels.

    Attributes:
        depth_m: (h, w) float32, from the camera's image; inf for the sky. Lower rows, which mirror nothing, are left
            out.
        radiance: (h, w) float32, without air.
        shows: (h / CELL, w / CELL) bool, the cells that may show more than sky, in which waves may stir it.
        focal_px: of the mirrored picture. scale: its size over the picture's.
        across, down: (x, y) of the picture is at ``(across + scale x, down - scale y)``.
    """

    depth_m: NDArray[np.float32]
    radiance: NDArray[np.float32]
    shows: NDArray[np.bool_]
    focal_px: np.float32
    scale: np.float32
    across: np.float32
    down: np.float32


NO_MIRROR = MirrorArrays(
    np.empty((0, 0), np.float32), np.empty((0, 0), np.float32), np.empty((0, 0), np.bool_), _ONE, _ONE, _ONE, _ONE
)


def image_of(camera: Camera, T_world_camera: NDArray[np.float64], level_m: float) -> tuple[Camera, NDArray[np.float64]]:
    """Return a camera's image in the plane z = ``level_m``, with a third of its resolution, and its pose (4, 4)."""
    small = Intrinsics(camera.width_px // _SHRINK, camera.height_px // _SHRINK, camera.focal_px / _SHRINK)
    T = T_world_camera.copy()
    T[2] *= -1.0
    T[2, 3] += 2.0 * level_m
    # A mirrored frame is left-handed; with its rows turned round it is not.
    T[:3, 1] *= -1.0
    return small, T


def rows_mirrored(
    depth_m: NDArray[np.float32], camera: Camera, T_world_camera: NDArray[np.float64], level_m: float
) -> int:
    """Return how many rows of the image's picture, from the top, may be seen in level water.

    Args:
        depth_m: (H, W) of the picture; every 32nd column is looked at.
    """
    upward = T_world_camera[2, :3] @ ray_of_pixel(camera)
    columns = np.arange(_HALF, camera.width_px, _PROBE_STEP_PX)
    rise = upward[0] * columns + (upward[1] * np.arange(_HALF, camera.height_px)[:, None] + upward[2])
    height_m = T_world_camera[2, 3] + depth_m[:, ::_PROBE_STEP_PX] * rise
    rows = np.flatnonzero((np.abs(height_m - level_m) < _LEVEL_WITHIN_M).any(axis=1))
    if not len(rows):
        return 0
    stirred = int(camera.focal_px * _FARTHEST_STIR)
    return min((camera.height_px - int(rows[0]) + stirred) // _SHRINK + 2, camera.height_px // _SHRINK)


def mirror_arrays(
    image: Camera, camera: Camera, depth_m: NDArray[np.float32], radiance: NDArray[np.float32]
) -> MirrorArrays:
    """Return the upper rows (h, w) of a picture of the image of a camera."""
    shows = np.zeros((-(-len(depth_m) // CELL), -(-depth_m.shape[1] // CELL)), np.bool_)
    _find_shown(depth_m, int(np.ceil(image.focal_px * _FARTHEST_STIR / CELL)), shows)
    scale = 1.0 / _SHRINK
    across, down = principal_point(image) + scale * principal_point(camera) * (-1.0, 1.0)
    numbers = (np.float32(each) for each in (image.focal_px, scale, across, down))
    return MirrorArrays(depth_m, radiance, shows, *numbers)


@njit(cache=True)
def _find_shown(depth_m: NDArray[np.float32], stirred: int, shows: NDArray[np.bool_]) -> None:
    """Set the cells of ``shows`` in which something is, and those up to ``stirred`` cells above and below."""
    for row in range(depth_m.shape[0]):
        for column in range(depth_m.shape[1]):
            if depth_m[row, column] < _FARTHEST_M:
                i, j = row // CELL, column // CELL
                if not shows[i, j] or row % CELL == 0:
                    for k in range(max(i - stirred, 0), min(i + stirred + 1, shows.shape[0])):
                        shows[k, j] = True


@row_kernel(error_model="numpy")
def may_show(mirror: MirrorArrays, x: np.float32, y: np.float32) -> bool:
    """Return whether water at pixel coordinates (x, y) may mirror more than sky."""
    height, width = mirror.shows.shape
    i = np.int32(mirror.down - y * mirror.scale) // np.int32(CELL)
    j = np.int32(mirror.across + x * mirror.scale) // np.int32(CELL)
    return 0 <= i < height and 0 <= j < width and mirror.shows[i, j]


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def mirrored(
    mirror: MirrorArrays,
    x: np.float32,
    y: np.float32,
    depth_m: np.float32,
    slope: np.float32,
    fine_slope: np.float32,
    share: np.float32,
    sky: np.float32,
) -> np.float32:
    """Return the radiance that water mirrors at pixel coordinates (x, y).

    A facet with slope s along the line of sight mirrors what is ``2 s`` higher, seen from itself; seen from the
    camera's image that angle is less, by the share of the way that lies beyond the water.

    Args:
        depth_m: of the water. slope: of the waves that are seen. fine_slope: deviation of the others.
        share: that water reflects. sky: reflected radiance where it mirrors the sky.
    """
    height, width = mirror.depth_m.shape
    column = min(max(np.int32(mirror.across + x * mirror.scale), np.int32(0)), np.int32(width - 1))
    row = mirror.down - y * mirror.scale
    level = np.int32(min(max(row, _ZERO), np.float32(height - 1)))
    straight_m = min(mirror.depth_m[level, column], _FARTHEST_M)
    is_hit = depth_m < straight_m < _FARTHEST_M
    reach = (straight_m - depth_m) / straight_m if is_hit else _USUAL_REACH
    per_slope = _TWO * mirror.focal_px * reach
    total = _ZERO
    for tap in range(-1, 2):
        weight = _MIDDLE_WEIGHT if tap == 0 else _HALF * (_ONE - _MIDDLE_WEIGHT)
        at = row - per_slope * (slope + np.float32(tap) * _TAP * fine_slope)
        i = np.int32(min(max(at, _ZERO), np.float32(height - 1)))
        there_m = mirror.depth_m[i, column]
        if depth_m < there_m < _FARTHEST_M:
            total += weight * share * mirror.radiance[i, column]
        else:
            total += weight * sky
    return total
