"""Look-up of maps of light on panels, for runs of pixels of one row on one panel.

Pixels are those from ``first`` up to, not including, ``last`` of the row's arrays (W,).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.render.compilation import row_kernel
from sim.render.runs import LANES, PITCH

LIGHT_LINES = 5
ONE, ZERO = np.float32(1.0), np.float32(0.0)


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def place_run(
    place: NDArray[np.float32],
    panel: int,
    row: int,
    first_sample: int,
    columns: int,
    rows: int,
    first: np.uint64,
    last: np.uint64,
    depth_m: NDArray[np.float32],
    index: NDArray[np.uint32],
    x: NDArray[np.float32],
    y: NDArray[np.float32],
) -> None:
    """Write the places of pixels on a panel: number of the sample before, and fractions towards the next ones.

    Args:
        place: see ``BakedArrays``.
        first_sample, columns, rows: of the panel's map.
    """
    down = np.float32(row)
    u_base, u_step, u_start = place[panel, 0] + place[panel, 2] * down, place[panel, 1], place[panel, 3]
    v_base, v_step, v_start = place[panel, 4] + place[panel, 6] * down, place[panel, 5], place[panel, 7]
    wide, high = np.float32(columns - 1), np.float32(rows - 1)
    start, pitch = np.int32(first_sample), np.int32(columns)
    last_column, last_row = np.int32(columns - 2), np.int32(rows - 2)
    for k in range(first, last):
        column, depth = np.float32(np.int32(k)), depth_m[k]
        u = (u_base + u_step * column) * depth + u_start
        v = (v_base + v_step * column) * depth + v_start
        s, t = min(max(u, ZERO), ONE) * wide, min(max(v, ZERO), ONE) * high
        j, i = min(np.int32(s), last_column), min(np.int32(t), last_row)
        index[k] = np.uint32(np.int32(start + np.int32(i * pitch)) + j)
        x[k], y[k] = s - np.float32(j), t - np.float32(i)


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def mix_light(
    light: NDArray[np.float32],
    columns: int,
    first: np.uint64,
    last: np.uint64,
    index: NDArray[np.uint32],
    lines: NDArray[np.float32],
) -> None:
    """Write the bilinear light ``level + x across + y (down + x twist)`` between four samples each.

    On near panels many neighbouring pixels share these four, which are read once.

    Args:
        lines: line buffer of x, y, red, green and blue, see ``sim.render.runs``.
    """
    one = np.uint64(1)
    to_y, to_red, to_green, to_blue = np.uint64(PITCH), np.uint64(2 * PITCH), np.uint64(3 * PITCH), np.uint64(4 * PITCH)
    k = first
    while k < last:
        here = index[k]
        a = np.uint64(here)
        b = a + np.uint64(columns)
        r, g, b_ = light[a, 0], light[a, 1], light[a, 2]
        r_across, g_across, b_across = light[a + one, 0] - r, light[a + one, 1] - g, light[a + one, 2] - b_
        r_down, g_down, b_down = light[b, 0] - r, light[b, 1] - g, light[b, 2] - b_
        r_twist = light[b + one, 0] - light[b, 0] - r_across
        g_twist = light[b + one, 1] - light[b, 1] - g_across
        b_twist = light[b + one, 2] - light[b, 2] - b_across
        end = k + one
        while end < last and index[end] == here:
            end += one
        for block in range(k, end, np.uint64(LANES)):
            for n in range(block, block + np.uint64(LANES)):
                s, t = lines[n], lines[to_y + n]
                lines[to_red + n] = r + s * r_across + t * (r_down + s * r_twist)
                lines[to_green + n] = g + s * g_across + t * (g_down + s * g_twist)
                lines[to_blue + n] = b_ + s * b_across + t * (b_down + s * b_twist)
        k = end


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def mix_run(
    values: NDArray[np.float32],
    columns: int,
    first: np.uint64,
    last: np.uint64,
    index: NDArray[np.uint32],
    x: NDArray[np.float32],
    y: NDArray[np.float32],
    factor: np.float32,
    result: NDArray[np.float32],
) -> None:
    """Write ``factor`` times the bilinear value between four samples each."""
    for k in range(first, last):
        a = np.uint64(index[k])
        b = a + np.uint64(columns)
        upper = values[a] + x[k] * (values[a + np.uint64(1)] - values[a])
        lower = values[b] + x[k] * (values[b + np.uint64(1)] - values[b])
        result[k] = factor * (upper + y[k] * (lower - upper))
