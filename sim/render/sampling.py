"""Looking up the colours of one row of pixels in textures.

Texels lie in tiles of 4x4, one cache line each: texel (i, j) of a mip level is number
``(i // 4) * row_pitch + (i % 4) * 4 + (j // 4) * 16 + j % 4``, the sum of a part of its row and one of its column. Each
level has its last row and column twice, so that a texel's right and lower neighbours always exist.

Loops over pixels that compute, fetch and mix stand apart, so that the first and the last become vector code.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

RED_BLUE, GREEN = np.uint32(0x00FF00FF), np.uint32(0x0000FF00)
HALVES, HALF = np.uint32(0x00800080), np.uint32(0x8000)
EIGHT = np.uint32(8)
LEVEL_0_UP_TO = 2.0
"""Texels that a pixel may cover before the next mip level is taken."""


@njit(cache=True)
def sample_row(
    texels: NDArray[np.uint32],
    position: NDArray[np.float32],
    level: NDArray[np.int32],
    room: NDArray[np.uint32],
    colour: NDArray[np.uint32],
) -> None:
    """Write the interpolated colours (W,) of a row of pixels.

    The weights of the four texels around a position are in 1/256, and their sum is exactly 256.

    Args:
        texels: all packed texels.
        position: (2, W) x and y in texels, from the centre of the level's first texel: >= 0, and not beyond
            the centre of its last. A position at a centre shows that texel alone.
        level: (2, W), where each pixel's mip level begins in ``texels``, and its row pitch.
        room: (6, W) to work in.
        colour: written, packed like texels.
    """
    texel_00, texel_01, texel_10, texel_11 = room[0], room[1], room[2], room[3]
    weight_x, weight_y = room[4], room[5]
    _split(position[0], weight_x, texel_00, texel_01)
    _split(position[1], weight_y, texel_10, texel_11)
    _number_texels(level[0], level[1], texel_00, texel_01, texel_10, texel_11)
    for k in range(colour.shape[0]):
        texel_00[k] = texels[texel_00[k]]
        texel_01[k] = texels[texel_01[k]]
        texel_10[k] = texels[texel_10[k]]
        texel_11[k] = texels[texel_11[k]]
    _mix(texel_00, texel_01, texel_10, texel_11, weight_x, weight_y, colour)


@njit(cache=True)
def _split(
    position: NDArray[np.float32],
    weight: NDArray[np.uint32],
    texel: NDArray[np.uint32],
    next_texel: NDArray[np.uint32],
) -> None:
    """Write the texel before each position, the one after, and the second's weight in 1/256."""
    for k in range(position.shape[0]):
        x = position[k]
        j = np.int32(x)
        weight[k] = np.uint32(np.int32((x - np.float32(j)) * np.float32(256.0)))
        texel[k] = np.uint32(j)
        next_texel[k] = np.uint32(np.int32(j + 1))


@njit(cache=True)
def _number_texels(
    begin: NDArray[np.int32],
    row_pitch: NDArray[np.int32],
    first: NDArray[np.uint32],
    second: NDArray[np.uint32],
    third: NDArray[np.uint32],
    fourth: NDArray[np.uint32],
) -> None:
    """Turn columns (j, j + 1) and rows (i, i + 1) into the numbers of the four texels where they cross."""
    for k in range(begin.shape[0]):
        j, j1 = np.int32(first[k]), np.int32(second[k])
        i, i1 = np.int32(third[k]), np.int32(fourth[k])
        pitch, start = row_pitch[k], begin[k]
        left = np.int32(((j >> 2) << 4) + (j & 3))
        right = np.int32(((j1 >> 2) << 4) + (j1 & 3))
        above = np.int32(np.int32(start + np.int32((i >> 2) * pitch)) + ((i & 3) << 2))
        below = np.int32(np.int32(start + np.int32((i1 >> 2) * pitch)) + ((i1 & 3) << 2))
        first[k], second[k] = np.uint32(above + left), np.uint32(above + right)
        third[k], fourth[k] = np.uint32(below + left), np.uint32(below + right)


@njit(cache=True)
def _mix(
    texel_00: NDArray[np.uint32],
    texel_01: NDArray[np.uint32],
    texel_10: NDArray[np.uint32],
    texel_11: NDArray[np.uint32],
    weight_x: NDArray[np.uint32],
    weight_y: NDArray[np.uint32],
    colour: NDArray[np.uint32],
) -> None:
    """Write ``sum_ab weight_ab texel_ab``: two channels at once, and one; every step kept to 32 bits."""
    for k in range(colour.shape[0]):
        fx, fy = weight_x[k], weight_y[k]
        w_11 = np.uint32(np.uint32(fx * fy) >> EIGHT)
        w_01, w_10 = np.uint32(fx - w_11), np.uint32(fy - w_11)
        w_00 = np.uint32(np.uint32(np.uint32(256) - fx) - w_10)
        a, b, c, d = texel_00[k], texel_01[k], texel_10[k], texel_11[k]
        red_blue = np.uint32(np.uint32(a & RED_BLUE) * w_00) + np.uint32(np.uint32(b & RED_BLUE) * w_01)
        red_blue += np.uint32(np.uint32(c & RED_BLUE) * w_10) + np.uint32(np.uint32(d & RED_BLUE) * w_11)
        green = np.uint32(np.uint32(a & GREEN) * w_00) + np.uint32(np.uint32(b & GREEN) * w_01)
        green += np.uint32(np.uint32(c & GREEN) * w_10) + np.uint32(np.uint32(d & GREEN) * w_11)
        red_blue = np.uint32(np.uint32(np.uint32(red_blue) + HALVES) >> EIGHT) & RED_BLUE
        green = np.uint32(np.uint32(np.uint32(green) + HALF) >> EIGHT) & GREEN
        colour[k] = np.uint32(red_blue | green)


@njit(cache=True)
def mip_level(texels_per_pixel: float, level_count: int) -> int:
    """Return the level at which a pixel covers between 1/2 and 2 texels; its area in level 0 is given.

    A level has a quarter of the texels of the one before.
    """
    level = 0
    while texels_per_pixel > LEVEL_0_UP_TO and level + 1 < level_count:
        texels_per_pixel *= 0.25
        level += 1
    return level
