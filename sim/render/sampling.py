"""Looking up colours in textures, for runs of neighbouring pixels.

Texels lie in tiles of 4x4, one cache line each: texel (i, j) is number
``(i // 4) * 16 tiles_per_row + (i % 4) * 4 + (j // 4) * 16 + j % 4``, the sum of a part of its row and one of its
column. Loops over pixels that compute, fetch and mix stand apart, so that the first and the last become vector code.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

BLOCK = 64
"""Pixels that are sampled at a time, with one mip level."""

RED_BLUE, GREEN = np.uint32(0x00FF00FF), np.uint32(0x0000FF00)
LOW_BYTE = np.uint32(0x000000FF)
HALVES = np.uint32(0x00800080)
TWO, THREE, FOUR, EIGHT = np.uint32(2), np.uint32(3), np.uint32(4), np.uint32(8)


@njit(cache=True, fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def sample_smooth(
    texels: NDArray[np.uint32],
    size: tuple[int, int],
    u_plane: tuple[np.float32, np.float32],
    v_plane: tuple[np.float32, np.float32],
    first_column: int,
    depth_m: NDArray[np.float32],
    room: NDArray[np.uint32],
    colour: NDArray[np.uint32],
) -> None:
    """Write interpolated colours of a run of n <= ``BLOCK`` pixels.

    Texel (i, j) has its centre at ``(u width, v height) = (j + 1/2, i + 1/2)``; beyond the outermost centres the
    edge goes on. Weights are in 1/256 and their sum is exactly 256.

    Args:
        texels: packed texels of one mip level.
        size: its width and height.
        u_plane, v_plane: (per column, at column 0) of ``u / depth`` and ``v / depth`` in this row.
        depth_m: (n,).
        room: (6, BLOCK) for numbers of texels and their weights.
        colour: (n,), packed like texels.
    """
    width, height = size
    half, zero, one_256 = np.float32(0.5), np.float32(0.0), np.float32(256.0)
    u_step, u_base = u_plane[0] * np.float32(width), u_plane[1] * np.float32(width)
    v_step, v_base = v_plane[0] * np.float32(height), v_plane[1] * np.float32(height)
    x_last, y_last = np.float32(width - 1), np.float32(height - 1)
    j_last, i_last = np.int32(width - 1), np.int32(height - 1)
    row_pitch = np.int32(16 * ((width + 3) // 4))
    n = depth_m.shape[0]
    at_00, at_01, at_10, at_11 = room[0, :n], room[1, :n], room[2, :n], room[3, :n]
    part_x, part_y = room[4, :n], room[5, :n]
    for k in range(n):
        column = np.float32(np.int32(first_column) + np.int32(k))
        x = min(max((u_base + u_step * column) * depth_m[k] - half, zero), x_last)
        y = min(max((v_base + v_step * column) * depth_m[k] - half, zero), y_last)
        j, i = np.int32(x), np.int32(y)
        part_x[k] = np.uint32((x - np.float32(j)) * one_256)
        part_y[k] = np.uint32((y - np.float32(i)) * one_256)
        j1, i1 = min(np.int32(j + 1), j_last), min(np.int32(i + 1), i_last)
        left, right = np.int32(((j >> 2) << 4) + (j & 3)), np.int32(((j1 >> 2) << 4) + (j1 & 3))
        above = np.int32((i >> 2) * row_pitch + ((i & 3) << 2))
        below = np.int32((i1 >> 2) * row_pitch + ((i1 & 3) << 2))
        at_00[k] = np.uint32(above + left)
        at_01[k] = np.uint32(above + right)
        at_10[k] = np.uint32(below + left)
        at_11[k] = np.uint32(below + right)
    for k in range(n):
        at_00[k] = texels[at_00[k]]
        at_01[k] = texels[at_01[k]]
        at_10[k] = texels[at_10[k]]
        at_11[k] = texels[at_11[k]]
    for k in range(n):
        fx, fy = part_x[k], part_y[k]
        w_11 = np.uint32(np.uint32(fx * fy) >> EIGHT)
        w_01, w_10 = np.uint32(fx - w_11), np.uint32(fy - w_11)
        w_00 = np.uint32(np.uint32(np.uint32(256) - fx) - w_10)
        a, b, c, d = at_00[k], at_01[k], at_10[k], at_11[k]
        red_blue = np.uint32(np.uint32(a & RED_BLUE) * w_00) + np.uint32(np.uint32(b & RED_BLUE) * w_01)
        red_blue += np.uint32(np.uint32(c & RED_BLUE) * w_10) + np.uint32(np.uint32(d & RED_BLUE) * w_11)
        green = np.uint32(np.uint32(a & GREEN) * w_00) + np.uint32(np.uint32(b & GREEN) * w_01)
        green += np.uint32(np.uint32(c & GREEN) * w_10) + np.uint32(np.uint32(d & GREEN) * w_11)
        red_blue = np.uint32(np.uint32(np.uint32(red_blue) + HALVES) >> EIGHT) & RED_BLUE
        green = np.uint32(np.uint32(np.uint32(green) + np.uint32(0x8000)) >> EIGHT) & GREEN
        colour[k] = np.uint32(red_blue | green)


@njit(cache=True, fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def sample_nearest(
    texels: NDArray[np.uint32],
    size: tuple[int, int],
    u_plane: tuple[np.float32, np.float32],
    v_plane: tuple[np.float32, np.float32],
    first_column: int,
    depth_m: NDArray[np.float32],
    colour: NDArray[np.uint32],
) -> None:
    """Write the colours of the texels that a run of pixels falls into. Arguments as for ``sample_smooth``."""
    width, height = size
    u_step, u_base = u_plane[0] * np.float32(width), u_plane[1] * np.float32(width)
    v_step, v_base = v_plane[0] * np.float32(height), v_plane[1] * np.float32(height)
    row_pitch = 16 * ((width + 3) // 4)
    for k in range(depth_m.shape[0]):
        column = np.float32(first_column + k)
        j = min(max(int((u_base + u_step * column) * depth_m[k]), 0), width - 1)
        i = min(max(int((v_base + v_step * column) * depth_m[k]), 0), height - 1)
        at = (i >> 2) * row_pitch + ((i & 3) << 2) + ((j >> 2) << 4) + (j & 3)
        colour[k] = texels[np.uint64(at)]


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
