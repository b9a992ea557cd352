"""Where bent rays end in the inner picture: the kernels of ``sim.render.refraction`` that search its depth map."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.render.compilation import row_kernel
from sim.render.water_edges import EDGE, TILE, find_edges, find_near_edges
from sim.render.water_rays import (
    ALONG_X,
    ALONG_Y,
    ONE,
    STEP_PX,
    SURFACE_DEPTH,
    ZERO,
    WaterRays,
    floor_depth,
    interpolate_row,
)

_SAME = np.float32(0.04)
"""Greatest difference of places on one surface, relative to the floor's share."""
_FILLED = np.float32(0.01)
"""The same for places that fill others: bodies low above the floor are not to be copied."""
_ITERATIONS = 4
_STEP_PX = np.float32(1.5)
"""Step along a ray that is followed."""
_MOST_STEPS = np.float32(400.0)


class Endings(NamedTuple):
    """The ends of a picture's rays; all are (H, W).

    Attributes:
        column, row: float32, where in the inner picture, in pixels from the middle of the first.
        source: int32, number of the inner pixel that shows the same surface, counted along rows.
        depth_m: float32, along the optical axis; inf where there is no body.
    """

    column: NDArray[np.float32]
    row: NDArray[np.float32]
    source: NDArray[np.int32]
    depth_m: NDArray[np.float32]


def new_endings(height: int, width: int, depth_m: NDArray[np.float32]) -> Endings:
    """Return ends for pictures of this size, with a depth map of the caller's."""
    real = np.empty((2, height, width), np.float32)
    return Endings(real[0], real[1], np.empty((height, width), np.int32), depth_m)


def trace(rays: WaterRays, nearness: NDArray[np.float32], margin_x: int, margin_y: int, ends: Endings) -> None:
    """Write where the rays end.

    Where no edge is near, the rays of the nodes are traced and those between interpolated; all others are followed.

    Args:
        nearness: (h, w) 1 / depth of the inner picture, wider and higher by the margins on each side.
    """
    height, width = ends.depth_m.shape
    edges = np.zeros((-(-nearness.shape[0] // TILE), -(-nearness.shape[1] // TILE)), np.bool_)
    find_edges(nearness, np.float32(EDGE * rays.water.depth_m), edges)
    shifts = np.empty((3, *rays.nodes.shape[1:]), np.float32)
    wet = np.empty(rays.nodes.shape[1:], np.bool_)
    _trace_nodes(rays, nearness, margin_x, margin_y, shifts, wet)
    near_edge = np.zeros((-(-height // TILE), -(-width // TILE)), np.bool_)
    find_near_edges(rays, edges, wet, margin_x, margin_y, near_edge)
    # As one kernel they would take half as long again: the compiler then makes no vector code of some loops.
    _interpolate_ends(shifts, margin_x, margin_y, nearness.shape, ends)
    _follow_near_edges(rays, nearness, margin_x, margin_y, near_edge, ends)


@njit(cache=True)
def _follow_near_edges(
    rays: WaterRays,
    nearness: NDArray[np.float32],
    margin_x: int,
    margin_y: int,
    near_edge: NDArray[np.bool_],
    ends: Endings,
) -> None:
    """Write the ends of the rays in the tiles near an edge."""
    width = ends.depth_m.shape[1]
    lines, followed = np.empty((8, width), np.float32), np.empty(width, np.int32)
    for row in range(ends.depth_m.shape[0]):
        _trace_row(rays, nearness, row, margin_x, margin_y, near_edge[row // TILE], lines, followed, ends)


@row_kernel(error_model="numpy", fastmath={"contract", "arcp", "nsz"})
def _trace_nodes(
    rays: WaterRays,
    nearness: NDArray[np.float32],
    margin_x: int,
    margin_y: int,
    shifts: NDArray[np.float32],
    wet: NDArray[np.bool_],
) -> None:
    """Write how far the rays of the nodes end from where they are, along x and y, the nearness there, and which are in
    the water: the fixed points of ``share = 1 - z_s nearness(p + share e)``.

    A few steps find them, as shares change slowly across a surface.
    """
    for i in range(wet.shape[0]):
        y = np.float32(i * STEP_PX)
        for j in range(wet.shape[1]):
            x = np.float32(j * STEP_PX)
            z, ex, ey = rays.nodes[SURFACE_DEPTH, i, j], rays.nodes[ALONG_X, i, j], rays.nodes[ALONG_Y, i, j]
            x, y_in = x + np.float32(margin_x), y + np.float32(margin_y)
            near = _between(nearness, x, y_in)
            wet[i, j] = _is_over(rays, x - np.float32(margin_x), y, z) and z * near < ONE
            share = ZERO
            if wet[i, j]:
                for _ in range(_ITERATIONS):
                    share = max(ONE - z * near, ZERO)
                    near = _between(nearness, x + share * ex, y_in + share * ey)
                share = max(ONE - z * near, ZERO)
            shifts[0, i, j], shifts[1, i, j], shifts[2, i, j] = share * ex, share * ey, near


@row_kernel(forceinline=True)
def _between(nearness: NDArray[np.float32], x: np.float32, y: np.float32) -> np.float32:
    """Return the nearness at a place in the inner picture, as if it were linear around it."""
    x = min(max(x, ZERO), np.float32(nearness.shape[1]) - np.float32(1.01))
    y = min(max(y, ZERO), np.float32(nearness.shape[0]) - np.float32(1.01))
    j, i = np.int32(x), np.int32(y)
    here = nearness[i, j]
    across, down = nearness[i, j + 1] - here, nearness[i + 1, j] - here
    return here + (x - np.float32(j)) * across + (y - np.float32(i)) * down


@row_kernel(forceinline=True)
def _is_over(rays: WaterRays, column: np.float32, row: np.float32, z: np.float32) -> bool:
    """Return whether the ray of a pixel is over the water at depth z."""
    m, at, water, offset = rays.matrix, rays.position_m, rays.water, np.float32(rays.pixel_offset)
    x, y = column + offset, row + offset
    place_x = at[0] + z * (m[0, 0] * x + m[0, 1] * y + m[0, 2])
    place_y = at[1] + z * (m[1, 0] * x + m[1, 1] * y + m[1, 2])
    return water.low_m[0] < place_x < water.high_m[0] and water.low_m[1] < place_y < water.high_m[1]


@row_kernel(error_model="numpy", fastmath={"contract", "arcp", "nsz"})
def _interpolate_ends(
    shifts: NDArray[np.float32], margin_x: int, margin_y: int, inner: tuple[int, int], ends: Endings
) -> None:
    """Write the ends of all rays from those of the nodes."""
    height, width = ends.depth_m.shape
    half, pitch = np.float32(0.5), np.int32(inner[1])
    most_x, most_y = np.float32(inner[1] - 1), np.float32(inner[0] - 1)
    first_x = np.int32(margin_x)
    for row in range(height):
        column, line, source, depth_m = ends.column[row], ends.row[row], ends.source[row], ends.depth_m[row]
        interpolate_row(shifts[0], row, width, column)
        interpolate_row(shifts[1], row, width, line)
        interpolate_row(shifts[2], row, width, depth_m)
        y = np.float32(row + margin_y)
        for k in range(width):
            x = min(max(np.float32(np.int32(k) + first_x) + column[k], ZERO), most_x)
            v = min(max(y + line[k], ZERO), most_y)
            column[k], line[k] = x, v
            source[k] = np.int32(np.int32(v + half) * pitch) + np.int32(x + half)
            depth_m[k] = ONE / depth_m[k]


@row_kernel(error_model="numpy", fastmath={"contract", "arcp", "nsz"})
def _trace_row(
    rays: WaterRays,
    nearness: NDArray[np.float32],
    row: int,
    margin_x: int,
    margin_y: int,
    near_edge: NDArray[np.bool_],
    lines: NDArray[np.float32],
    followed: NDArray[np.int32],
    ends: Endings,
) -> None:
    """Write the ends of one row's rays in the tiles that are near an edge."""
    width = ends.depth_m.shape[1]
    interpolate_row(rays.nodes[SURFACE_DEPTH], row, width, lines[0])
    interpolate_row(rays.nodes[ALONG_X], row, width, lines[1])
    interpolate_row(rays.nodes[ALONG_Y], row, width, lines[2])
    count, i = 0, row + margin_y
    for tile in range(near_edge.shape[0]):
        if not near_edge[tile]:
            continue
        for column in range(tile * TILE, min(tile * TILE + TILE, width)):
            z, j = lines[0, column], column + margin_x
            if z * nearness[i, j] < ONE and _is_over(rays, np.float32(column), np.float32(row), z):
                followed[count] = column
                count += 1
            else:
                _end(nearness, row, column, np.float32(j), np.float32(i), (i, j), ends)
    _follow(rays, nearness, row, margin_x, margin_y, lines, followed, count, ends)


@row_kernel(error_model="numpy", fastmath={"contract", "arcp", "nsz"})
def _follow(
    rays: WaterRays,
    nearness: NDArray[np.float32],
    row: int,
    margin_x: int,
    margin_y: int,
    lines: NDArray[np.float32],
    followed: NDArray[np.int32],
    count: int,
    ends: Endings,
) -> None:
    """Write the ends of ``count`` rays of a row, in columns ``followed``: each the first place that is not before the
    inner picture's surface. All take a step together, so that the processor fetches many at a time.
    """
    offset = rays.pixel_offset
    front, step, left, deepest = lines[4], lines[5], lines[6], lines[7]
    for n in range(count):
        k = followed[n]
        z, ex, ey = lines[0, k], lines[1, k], lines[2, k]
        last = np.float32(1.0 - z / floor_depth(rays, k + offset, row + offset, z, ex, ey))
        steps = min(np.floor(np.sqrt(ex * ex + ey * ey) * last / _STEP_PX) + np.float32(2.0), _MOST_STEPS)
        deepest[k] = ONE - z * nearness[row + margin_y, k + margin_x] - _FILLED * last
        front[k], step[k], left[k] = ZERO, last / steps, steps + np.float32(1.5)
    y = np.float32(row + margin_y)
    taken = ZERO
    while count > 0:
        taken += ONE
        kept = 0
        for n in range(count):
            k = followed[n]
            z, ex, ey, share = lines[0, k], lines[1, k], lines[2, k], taken * step[k]
            x = np.float32(k + margin_x)
            shown = ONE - z * nearness[_pixel(nearness, x + share * ex, y + share * ey)]
            if shown > share:
                if shown >= deepest[k]:
                    front[k], deepest[k] = share, shown - _FILLED * left[k] * step[k]
            elif shown >= ZERO:
                # The ray meets what is shown there, unless it shows something else where the ray is at that depth.
                there = _pixel(nearness, x + shown * ex, y + shown * ey)
                same = max(np.float32(2.0) * step[k], _SAME * (left[k] - np.float32(1.5)) * step[k])
                met = ONE - z * nearness[there]
                if abs(met - shown) <= same:
                    shown = max(met, ZERO)
                    _end(nearness, row, k, x + shown * ex, y + shown * ey, there, ends)
                    continue
            if taken < left[k]:
                followed[kept] = k
                kept += 1
            else:
                _fill(nearness, row, k, margin_x, margin_y, lines, ends)
        count = kept


@row_kernel(error_model="numpy", fastmath={"contract", "arcp", "nsz"})
def _fill(
    nearness: NDArray[np.float32],
    row: int,
    column: int,
    margin_x: int,
    margin_y: int,
    lines: NDArray[np.float32],
    ends: Endings,
) -> None:
    """Write the end of a ray that passed behind a body and had not come out when it met the floor.

    The inner picture lacks what is seen. It is filled by the lowest surface before the body, mirrored at its edge.
    """
    z, ex, ey, front = lines[0, column], lines[1, column], lines[2, column], lines[4, column]
    last = (lines[6, column] - np.float32(1.5)) * lines[5, column]
    x, y = np.float32(column + margin_x), np.float32(row + margin_y)
    floor = _pixel(nearness, x + front * ex, y + front * ey)
    shown = ONE - z * nearness[floor]
    mirrored = max(np.float32(2.0) * front - shown, ZERO)
    there = _pixel(nearness, x + mirrored * ex, y + mirrored * ey)
    beyond = ONE - z * nearness[there] - shown
    if -_FILLED * last <= beyond <= _FILLED * last + front - mirrored:
        _end(nearness, row, column, x + mirrored * ex, y + mirrored * ey, there, ends)
    else:
        _end(nearness, row, column, x + front * ex, y + front * ey, floor, ends)


@row_kernel(forceinline=True)
def _pixel(nearness: NDArray[np.float32], x: np.float32, y: np.float32) -> tuple[int, int]:
    half = np.float32(0.5)
    j = min(max(int(np.floor(x + half)), 0), nearness.shape[1] - 1)
    i = min(max(int(np.floor(y + half)), 0), nearness.shape[0] - 1)
    return i, j


@row_kernel(forceinline=True, error_model="numpy")
def _end(
    nearness: NDArray[np.float32],
    row: int,
    column: int,
    x: np.float32,
    y: np.float32,
    there: tuple[int, int],
    ends: Endings,
) -> None:
    """Write the end of a ray at a pixel, and where in it; at most half a pixel away from its middle."""
    i, j = there
    half = np.float32(0.5)
    ends.column[row, column] = min(max(x, np.float32(j) - half), np.float32(j) + half)
    ends.row[row, column] = min(max(y, np.float32(i) - half), np.float32(i) + half)
    ends.source[row, column] = i * nearness.shape[1] + j
    ends.depth_m[row, column] = ONE / nearness[i, j]
