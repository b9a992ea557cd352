"""Looking up colours in textures."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

LANES = np.uint64(0x00FF00FF00FF00FF)
LOW_LANES = np.uint64(0x00FF00FF)
HALF = np.uint64(0x0080008000800080)
SHIFT_8, SHIFT_32 = np.uint64(8), np.uint64(32)


@njit(cache=True, inline="always")
def lanes_of(texel: np.uint32) -> np.uint64:
    """Return a packed texel's four bytes in four 16-bit lanes, in the order R, B, G, X from the lowest."""
    wide = np.uint64(texel)
    return (wide & LOW_LANES) | (((wide >> SHIFT_8) & LOW_LANES) << SHIFT_32)


@njit(cache=True, fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def sample_smooth(
    texels: NDArray[np.uint32],
    width: int,
    height: int,
    u_plane: tuple[np.float32, np.float32],
    v_plane: tuple[np.float32, np.float32],
    first_column: int,
    depth_m: NDArray[np.float32],
    colour_rgb: NDArray[np.uint8],
) -> None:
    """Write interpolated colours (n, 3) of a run of pixels.

    Texel (i, j) has its centre at ``(u width, v height) = (j + 1/2, i + 1/2)``; beyond the outermost
    centres the edge goes on. Weights are in 1/256, and their sum is exactly 256.

    Args:
        texels: (height * width,) packed texels of one mip level.
        u_plane, v_plane: (per column, at column 0) of ``u / depth`` and ``v / depth`` in this row.
        depth_m: (n,).
    """
    half, zero = np.float32(0.5), np.float32(0.0)
    u_step, u_base = u_plane[0] * np.float32(width), u_plane[1] * np.float32(width)
    v_step, v_base = v_plane[0] * np.float32(height), v_plane[1] * np.float32(height)
    x_last, y_last = np.float32(width - 1), np.float32(height - 1)
    scale = np.float32(256.0)
    for k in range(depth_m.shape[0]):
        column = np.float32(first_column + k)
        x = min(max((u_base + u_step * column) * depth_m[k] - half, zero), x_last)
        y = min(max((v_base + v_step * column) * depth_m[k] - half, zero), y_last)
        j, i = np.int32(x), np.int32(y)
        fx, fy = np.int32((x - np.float32(j)) * scale), np.int32((y - np.float32(i)) * scale)
        both = (fx * fy + 128) >> 8
        at = np.uint64(i * width + j)
        right = np.uint64(1) if j + 1 < width else np.uint64(0)
        below = np.uint64(width) if i + 1 < height else np.uint64(0)
        mixed = (
            lanes_of(texels[at]) * np.uint64(256 - fx - fy + both)
            + lanes_of(texels[at + right]) * np.uint64(fx - both)
            + lanes_of(texels[at + below]) * np.uint64(fy - both)
            + lanes_of(texels[at + right + below]) * np.uint64(both)
            + HALF
        ) >> SHIFT_8
        colour_rgb[k, 0] = np.uint8(mixed & np.uint64(255))
        colour_rgb[k, 1] = np.uint8((mixed >> SHIFT_32) & np.uint64(255))
        colour_rgb[k, 2] = np.uint8((mixed >> np.uint64(16)) & np.uint64(255))


@njit(cache=True, fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def sample_nearest(
    texels: NDArray[np.uint32],
    width: int,
    height: int,
    u_plane: tuple[np.float32, np.float32],
    v_plane: tuple[np.float32, np.float32],
    first_column: int,
    depth_m: NDArray[np.float32],
    colour_rgb: NDArray[np.uint8],
) -> None:
    """Write the colours (n, 3) of the texels that a run of pixels falls into. Arguments as for
    ``sample_smooth``.
    """
    u_step, u_base = u_plane[0] * np.float32(width), u_plane[1] * np.float32(width)
    v_step, v_base = v_plane[0] * np.float32(height), v_plane[1] * np.float32(height)
    for k in range(depth_m.shape[0]):
        column = np.float32(first_column + k)
        j = min(max(np.int32((u_base + u_step * column) * depth_m[k]), 0), width - 1)
        i = min(max(np.int32((v_base + v_step * column) * depth_m[k]), 0), height - 1)
        texel = texels[np.uint64(i * width + j)]
        colour_rgb[k, 0] = texel & np.uint32(255)
        colour_rgb[k, 1] = (texel >> np.uint32(8)) & np.uint32(255)
        colour_rgb[k, 2] = (texel >> np.uint32(16)) & np.uint32(255)


@njit(cache=True)
def mip_level(texels_per_pixel: float, level_count: int) -> int:
    """Return the level at which a pixel covers between 1/2 and 2 texels; its area in level 0 is given.

    A level has a quarter of the texels of the one before.
    """
    level = 0
    while texels_per_pixel > 2.0 and level + 1 < level_count:
        texels_per_pixel *= 0.25
        level += 1
    return level
