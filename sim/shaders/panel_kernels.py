"""Looking up maps of light on panels, for runs of pixels of one row that show the same panel.

Pixels are those from ``first`` up to, not including, ``last`` of the row's arrays (W,).
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

ONE, ZERO = np.float32(1.0), np.float32(0.0)


@njit(cache=True, fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def place_run(
    place: NDArray[np.float32],
    panel: int,
    row: int,
    first: np.uint64,
    last: np.uint64,
    depth_m: NDArray[np.float32],
    u: NDArray[np.float32],
    v: NDArray[np.float32],
) -> None:
    """Write where on a panel pixels lie, see ``BakedArrays.place``."""
    down = np.float32(row)
    u_base, u_step, u_start = place[panel, 0] + place[panel, 2] * down, place[panel, 1], place[panel, 3]
    v_base, v_step, v_start = place[panel, 4] + place[panel, 6] * down, place[panel, 5], place[panel, 7]
    for k in range(first, last):
        column, depth = np.float32(np.int32(k)), depth_m[k]
        u[k] = (u_base + u_step * column) * depth + u_start
        v[k] = (v_base + v_step * column) * depth + v_start


@njit(cache=True, fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def split_run(
    first_sample: int,
    columns: int,
    rows: int,
    first: np.uint64,
    last: np.uint64,
    u: NDArray[np.float32],
    v: NDArray[np.float32],
    index: NDArray[np.uint32],
    x: NDArray[np.float32],
    y: NDArray[np.float32],
) -> None:
    """Write the number of the sample before each position (u, v) in [0, 1], and how far it is on to the next ones."""
    across, down = np.float32(columns - 1), np.float32(rows - 1)
    start, pitch = np.int32(first_sample), np.int32(columns)
    last_column, last_row = np.int32(columns - 2), np.int32(rows - 2)
    for k in range(first, last):
        s, t = min(max(u[k], ZERO), ONE) * across, min(max(v[k], ZERO), ONE) * down
        j, i = min(np.int32(s), last_column), min(np.int32(t), last_row)
        index[k] = np.uint32(np.int32(start + np.int32(i * pitch)) + j)
        x[k], y[k] = s - np.float32(j), t - np.float32(i)


@njit(cache=True, error_model="numpy")
def mix_light(
    light: NDArray[np.float32],
    columns: int,
    first: np.uint64,
    last: np.uint64,
    index: NDArray[np.uint32],
    x: NDArray[np.float32],
    y: NDArray[np.float32],
    red: NDArray[np.float32],
    green: NDArray[np.float32],
    blue: NDArray[np.float32],
) -> None:
    """Write the bilinear light between four samples each.

    Near panels many neighbouring pixels lie between the same four, which are looked up once.
    """
    start = first
    while start < last:
        here = index[start]
        end = start + np.uint64(1)
        while end < last and index[end] == here:
            end += np.uint64(1)
        a = np.uint64(here)
        b = a + np.uint64(columns)
        _between(light, a, b, 0, start, end, x, y, red)
        _between(light, a, b, 1, start, end, x, y, green)
        _between(light, a, b, 2, start, end, x, y, blue)
        start = end


@njit(cache=True, fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def _between(
    light: NDArray[np.float32],
    above: np.uint64,
    below: np.uint64,
    channel: int,
    first: np.uint64,
    last: np.uint64,
    x: NDArray[np.float32],
    y: NDArray[np.float32],
    result: NDArray[np.float32],
) -> None:
    """Write one channel between a sample, its right neighbour and the two below; by itself, to be vector code."""
    level, across = light[above, channel], light[above + np.uint64(1), channel] - light[above, channel]
    down = light[below, channel] - level
    twist = light[below + np.uint64(1), channel] - light[below, channel] - across
    for k in range(first, last):
        result[k] = level + x[k] * across + y[k] * (down + x[k] * twist)


@njit(cache=True, fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
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
