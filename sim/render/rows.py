"""Rows of pixels: runs of neighbours that show the same body or triangle, and their colours from textures.

Runs are too short for ordinary vector code. So run loops process whole blocks of ``LANES`` pixels and write beyond the
end of the run, where the next run writes later. Their arrays are lines of one *line buffer*: line n begins at
``n * PITCH``. From the fixed distance the compiler knows that lines do not overlap; it leaves space behind the last
column.

Texels lie in tiles of 4x4, one cache line each: texel (i, j) of a mip level is number
``(i // 4) * row_pitch + (i % 4) * 4 + (j // 4) * 16 + j % 4``, the sum of a part of its row and one of its column. Each
level has its last row and column twice, so that a texel's right and lower neighbours always exist.

Loops that compute, fetch and mix are separate, so that the first and the last become vector code. They communicate by
lines of a line buffer (``sim.render.rows``): the four texels, their weights across and down.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.render.compilation import row_kernel

LANES = 16
_SEARCHED = 32
"""Pixels searched at once for the first one of a run."""
WIDEST = 4096
"""Columns of the widest picture."""
PITCH = WIDEST + 5 * LANES
"""No power of two, with which all lines would map to the same part of the processor's cache."""


@njit(cache=True)
def new_lines(lines: int, width: int) -> NDArray[np.float32]:
    """Return ``lines`` lines of zeros for rows of ``width`` pixels.

    Raises:
        ValueError: for pictures that are wider than ``WIDEST``.
    """
    if width > WIDEST:
        raise ValueError("width: expected at most 4096 pixels")
    return np.zeros(lines * PITCH, np.float32)


@row_kernel()
def find_runs(values: NDArray[np.int32], firsts: NDArray[np.uint32]) -> np.uint64:
    """Write the first column of each run of equal values (W,), and W behind the last; return the number of runs.

    Args:
        firsts: (> W,).
    """
    one, block = np.uint64(1), np.uint64(_SEARCHED)
    count, column, width = one, one, np.uint64(values.shape[0])
    firsts[0] = np.uint32(0)
    while column + block <= width:
        change = np.int32(0)
        for k in range(column, column + block):
            change |= values[k] ^ values[k - one]
        if change != 0:
            count = _find_firsts(values, column, column + block, count, firsts)
        column += block
    count = _find_firsts(values, column, width, count, firsts)
    firsts[count] = np.uint32(width)
    return count


@row_kernel()
def _find_firsts(
    values: NDArray[np.int32], start: np.uint64, end: np.uint64, count: np.uint64, firsts: NDArray[np.uint32]
) -> np.uint64:
    """Write the columns from start to end that begin a run behind the ``count`` known ones; return how many are known.

    Without branches: a mispredicted one costs more than a needless write.
    """
    for column in range(start, end):
        firsts[count] = np.uint32(column)
        count += np.uint64(values[column] != values[column - np.uint64(1)])
    return count


RED_BLUE, GREEN = np.uint32(0x00FF00FF), np.uint32(0x0000FF00)
HALVES, HALF = np.uint32(0x00800080), np.uint32(0x8000)
EIGHT = np.uint32(8)
TEXEL_LINES = 6
LEVEL_0_UP_TO = np.float32(2.0)
"""Texels per pixel above which the next mip level is used."""


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def number_texels(
    u_step: np.float32,
    u_base: np.float32,
    v_step: np.float32,
    v_base: np.float32,
    half: np.float32,
    last_column: np.float32,
    last_row: np.float32,
    begin: np.int32,
    row_pitch: np.int32,
    first: np.uint64,
    last: np.uint64,
    depth_m: NDArray[np.float32],
    texel: NDArray[np.uint32],
) -> None:
    """Write the numbers of the four texels around the pixels first … last - 1 of a run, and their weights in 1/256.

    A pixel's position from the centre of the level's first texel is ``(base + step * column) * depth - half``, kept
    between that and the centre of its last; a position at a centre shows that texel alone.

    Args:
        half: 1/2, or 0 for palettes, which show the texel at the position alone.
        begin, row_pitch: where the mip level begins in the pool, and its row pitch.
        depth_m, texel: line buffers, see ``sim.render.rows``.
    """
    to_01, to_10, to_11 = np.uint64(PITCH), np.uint64(2 * PITCH), np.uint64(3 * PITCH)
    to_weight_x, to_weight_y = np.uint64(4 * PITCH), np.uint64(5 * PITCH)
    zero, whole = np.float32(0.0), np.float32(256.0 if half > 0 else 0.0)
    for block in range(first, last, np.uint64(LANES)):
        for column in range(block, block + np.uint64(LANES)):
            x, z = np.float32(np.int32(column)), depth_m[column]
            u = min(max((u_base + u_step * x) * z - half, zero), last_column)
            v = min(max((v_base + v_step * x) * z - half, zero), last_row)
            j, i = np.int32(u), np.int32(v)
            j1, i1 = np.int32(j + 1), np.int32(i + 1)
            left = np.int32(((j >> 2) << 4) + (j & 3))
            right = np.int32(((j1 >> 2) << 4) + (j1 & 3))
            above = np.int32(np.int32(begin + np.int32((i >> 2) * row_pitch)) + ((i & 3) << 2))
            below = np.int32(np.int32(begin + np.int32((i1 >> 2) * row_pitch)) + ((i1 & 3) << 2))
            texel[column], texel[to_01 + column] = np.uint32(above + left), np.uint32(above + right)
            texel[to_10 + column], texel[to_11 + column] = np.uint32(below + left), np.uint32(below + right)
            texel[to_weight_x + column] = np.uint32(np.int32((u - np.float32(j)) * whole))
            texel[to_weight_y + column] = np.uint32(np.int32((v - np.float32(i)) * whole))


@row_kernel()
def fetch_row(texels: NDArray[np.uint32], texel: NDArray[np.uint32], colour: NDArray[np.uint32]) -> None:
    """Write the interpolated colours (W,) of a row of pixels, packed like texels.

    The weights of the four texels around a position are in 1/256, and their sum is exactly 256. Two channels share one
    sum, the third has its own; every step fits into 32 bits.

    Args:
        texels: all packed texels.
        texel: as ``number_texels`` left it; overwritten.
    """
    to_01, to_10, to_11 = np.uint64(PITCH), np.uint64(2 * PITCH), np.uint64(3 * PITCH)
    to_weight_x, to_weight_y = np.uint64(4 * PITCH), np.uint64(5 * PITCH)
    width = np.uint64(colour.shape[0])
    for k in range(width):
        texel[k], texel[to_01 + k] = texels[texel[k]], texels[texel[to_01 + k]]
        texel[to_10 + k], texel[to_11 + k] = texels[texel[to_10 + k]], texels[texel[to_11 + k]]
    for k in range(width):
        fx, fy = texel[to_weight_x + k], texel[to_weight_y + k]
        w_11 = np.uint32(np.uint32(fx * fy) >> EIGHT)
        w_01, w_10 = np.uint32(fx - w_11), np.uint32(fy - w_11)
        w_00 = np.uint32(np.uint32(np.uint32(256) - fx) - w_10)
        a, b, c, d = texel[k], texel[to_01 + k], texel[to_10 + k], texel[to_11 + k]
        red_blue = np.uint32(np.uint32(a & RED_BLUE) * w_00) + np.uint32(np.uint32(b & RED_BLUE) * w_01)
        red_blue += np.uint32(np.uint32(c & RED_BLUE) * w_10) + np.uint32(np.uint32(d & RED_BLUE) * w_11)
        green = np.uint32(np.uint32(a & GREEN) * w_00) + np.uint32(np.uint32(b & GREEN) * w_01)
        green += np.uint32(np.uint32(c & GREEN) * w_10) + np.uint32(np.uint32(d & GREEN) * w_11)
        red_blue = np.uint32(np.uint32(np.uint32(red_blue) + HALVES) >> EIGHT) & RED_BLUE
        green = np.uint32(np.uint32(np.uint32(green) + HALF) >> EIGHT) & GREEN
        colour[k] = np.uint32(red_blue | green)


@row_kernel()
def mip_level(texels_per_pixel: np.float32, level_count: np.int32) -> np.uint32:
    """Return the level at which a pixel covers between 1/2 and 2 texels; its area in level 0 is given.

    A level has a quarter of the texels of the one before.
    """
    level, quarter = np.uint32(0), np.float32(0.25)
    while texels_per_pixel > LEVEL_0_UP_TO and level + np.uint32(1) < np.uint32(level_count):
        texels_per_pixel *= quarter
        level += np.uint32(1)
    return level
