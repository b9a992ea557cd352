"""Where bent rays end in the inner picture: the kernels of ``sim.render.refraction`` that search its depth map."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.render.compilation import row_kernel
from sim.render.water.edges import EDGE, EDGE_TILE, TILE, find_edges, find_near_edges
from sim.render.water.ends import Endings
from sim.render.water.rays import ONE, STEP_PX, SURFACE_DEPTH, ZERO, WaterRays, interpolate_row
from sim.render.water.ways import ALONG_X, ALONG_Y, ENTRY_DEPTH, ENTRY_X, ENTRY_Y, FLOOR_SHARE, PLANES, SCALE

_SURFACE, _MET, _FRONT, _STEP, _LEFT, _DEEPEST, _LINES = range(PLANES, PLANES + 7)
"""Lines of the scratch, after those of the ways."""
_DRY, _WET, _BLOCKED = range(3)
"""Kinds of nodes: beside the water; in it; in it, but the inner picture shows something above it."""
_SAME = np.float32(0.04)
"""Greatest difference of places on one surface, relative to the floor's share."""
_FILLED = np.float32(0.01)
"""The same for places that fill others: bodies low above the floor are not to be copied."""
_ITERATIONS, _CLOSE_PX = 5, np.float32(0.02)
_STEP_PX = np.float32(1.0)
"""Step along a ray that is followed."""
_BEYOND = np.float32(1.02)
"""The last step leads below the floor."""
_MOST_STEPS = np.float32(400.0)


def trace(
    rays: WaterRays,
    ways: NDArray[np.float32],
    straight: NDArray[np.float32],
    nearness: NDArray[np.float32],
    ends: Endings,
) -> None:
    """Write where the rays end.

    Where no edge is near, the rays of the nodes are traced and those between interpolated; all others are followed.

    Args:
        ways: of the rays in the inner picture.
        straight: (H, W) 1 / depth of the picture without water. nearness: (h, w) that of the inner picture.
    """
    height, width = ends.depth_m.shape
    edges = np.zeros((-(-nearness.shape[0] // EDGE_TILE), -(-nearness.shape[1] // EDGE_TILE)), np.bool_)
    find_edges(nearness, np.float32(EDGE * rays.water.depth_m), edges)
    places, kinds = np.empty((3, *ways.shape[1:]), np.float32), np.empty(ways.shape[1:], np.int8)
    _trace_nodes(rays, ways, straight, nearness, places, kinds)
    near_edge = np.empty((-(-height // TILE), -(-width // TILE)), np.bool_)
    find_near_edges(ways, edges, kinds, near_edge)
    _trace_rows(rays, ways, straight, nearness, places, near_edge, ends)


@row_kernel(error_model="numpy", fastmath={"contract", "arcp", "nsz"})
def _trace_nodes(
    rays: WaterRays,
    ways: NDArray[np.float32],
    straight: NDArray[np.float32],
    nearness: NDArray[np.float32],
    places: NDArray[np.float32],
    kinds: NDArray[np.int8],
) -> None:
    """Write the column and row in the inner picture where the rays of the nodes end, the camera's 1 / depth there, and
    their kinds: the fixed points of ``share = 1 - z nearness(a + share e)``.

    A few steps from the floor find them, as shares change slowly across a surface.
    """
    for i in range(kinds.shape[0]):
        row = min(i * STEP_PX, straight.shape[0] - 1)
        for j in range(kinds.shape[1]):
            column = min(j * STEP_PX, straight.shape[1] - 1)
            z_s, z = rays.nodes[SURFACE_DEPTH, i, j], ways[ENTRY_DEPTH, i, j]
            x, y, ex, ey = ways[ENTRY_X, i, j], ways[ENTRY_Y, i, j], ways[ALONG_X, i, j], ways[ALONG_Y, i, j]
            share = ways[FLOOR_SHARE, i, j]
            near = _between(nearness, x + share * ex, y + share * ey)
            for _ in range(_ITERATIONS):
                before, share = share, max(ONE - z * near, ZERO)
                if abs(share - before) * (abs(ex) + abs(ey)) < _CLOSE_PX:
                    break
                near = _between(nearness, x + share * ex, y + share * ey)
            places[0, i, j], places[1, i, j] = x + share * ex, y + share * ey
            places[2, i, j] = ONE / (z_s + (ONE / near - z) * ways[SCALE, i, j])
            kinds[i, j] = _DRY
            if _is_over(rays, j * STEP_PX, i * STEP_PX, z_s) and z_s * straight[row, column] < ONE:
                kinds[i, j] = _WET if z * near < ONE else _BLOCKED


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
def _is_over(rays: WaterRays, column: int, row: int, z_s: np.float32) -> bool:
    """Return whether the ray of a pixel is over the water at depth z_s."""
    m, at, water = rays.matrix, rays.position_m, rays.water
    x, y = column + rays.pixel_offset, row + rays.pixel_offset
    place_x = at[0] + z_s * (m[0, 0] * x + m[0, 1] * y + m[0, 2])
    place_y = at[1] + z_s * (m[1, 0] * x + m[1, 1] * y + m[1, 2])
    return water.low_m[0] < place_x < water.high_m[0] and water.low_m[1] < place_y < water.high_m[1]


@row_kernel(error_model="numpy", fastmath={"contract", "arcp", "nsz"})
def _interpolate_ends(places: NDArray[np.float32], inner: tuple[int, int], row: int, ends: Endings) -> None:
    """Write the ends of one row's rays from those of the nodes."""
    column, line, source, depth_m = ends.column[row], ends.row[row], ends.source[row], ends.depth_m[row]
    width, half, pitch = column.shape[0], np.float32(0.5), np.int32(inner[1])
    most_x, most_y = np.float32(inner[1] - 1), np.float32(inner[0] - 1)
    interpolate_row(places[0], row, width, column)
    interpolate_row(places[1], row, width, line)
    interpolate_row(places[2], row, width, depth_m)
    for k in range(width):
        x, y = min(max(column[k], ZERO), most_x), min(max(line[k], ZERO), most_y)
        column[k], line[k] = x, y
        source[k] = np.int32(np.int32(y + half) * pitch) + np.int32(x + half)
        depth_m[k] = ONE / depth_m[k]


@njit(cache=True)
def _trace_rows(
    rays: WaterRays,
    ways: NDArray[np.float32],
    straight: NDArray[np.float32],
    nearness: NDArray[np.float32],
    places: NDArray[np.float32],
    near_edge: NDArray[np.bool_],
    ends: Endings,
) -> None:
    """Write the ends of all rays from those of the nodes, but for those near edges and those that are not bent."""
    height, width = ends.depth_m.shape
    lines, followed = np.empty((_LINES, width), np.float32), np.empty(width, np.int32)
    for row in range(height):
        _interpolate_ends(places, nearness.shape, row, ends)
        _find_wet(rays, row, straight[row], lines)
        count = _sort_rays(row, straight, near_edge[row // TILE], lines, followed, ends)
        if count > 0:
            for plane in range(PLANES):
                interpolate_row(ways[plane], row, width, lines[plane])
            _follow(nearness, row, lines, followed, count, ends)


@row_kernel(error_model="numpy", fastmath={"contract", "arcp", "nsz"})
def _find_wet(rays: WaterRays, row: int, straight: NDArray[np.float32], lines: NDArray[np.float32]) -> None:
    """Write z_s and ``z_s / depth`` of what the straight rays of a row meet: 1 where this is not in the water."""
    m, water, offset = rays.matrix, rays.water, np.float32(rays.pixel_offset)
    low_x, high_x = np.float32(water.low_m[0] - rays.position_m[0]), np.float32(water.high_m[0] - rays.position_m[0])
    low_y, high_y = np.float32(water.low_m[1] - rays.position_m[1]), np.float32(water.high_m[1] - rays.position_m[1])
    y = np.float32(row) + offset
    a_step, a = np.float32(m[0, 0]), np.float32(m[0, 1]) * y + np.float32(m[0, 2])
    b_step, b = np.float32(m[1, 0]), np.float32(m[1, 1]) * y + np.float32(m[1, 2])
    z_s, met = lines[_SURFACE], lines[_MET]
    interpolate_row(rays.nodes[SURFACE_DEPTH], row, met.shape[0], z_s)
    for k in range(met.shape[0]):
        x = np.float32(np.int32(k)) + offset
        place_x, place_y = z_s[k] * (a_step * x + a), z_s[k] * (b_step * x + b)
        inside = (place_x > low_x) & (place_x < high_x) & (place_y > low_y) & (place_y < high_y)
        met[k] = min(z_s[k] * straight[k], ONE) if inside else ONE


@row_kernel(error_model="numpy")
def _sort_rays(
    row: int,
    straight: NDArray[np.float32],
    near_edge: NDArray[np.bool_],
    lines: NDArray[np.float32],
    followed: NDArray[np.int32],
    ends: Endings,
) -> int:
    """Write the ends of a row's rays that are not bent, and the columns of those to follow; return how many."""
    met, width, count = lines[_MET], np.int32(straight.shape[1]), 0
    for tile in range(near_edge.shape[0]):
        for k in range(np.int32(tile * TILE), min(np.int32(tile * TILE + TILE), width)):
            if met[k] >= ONE:
                ends.column[row, k], ends.row[row, k] = np.float32(k), np.float32(row)
                ends.source[row, k] = np.int32(-1) - np.int32(row * width + k)
                ends.depth_m[row, k] = ONE / straight[row, k]
            elif near_edge[tile]:
                followed[count] = k
                count += 1
    return count


@row_kernel(error_model="numpy", fastmath={"contract", "arcp", "nsz"})
def _follow(
    nearness: NDArray[np.float32],
    row: int,
    lines: NDArray[np.float32],
    followed: NDArray[np.int32],
    count: int,
    ends: Endings,
) -> None:
    """Write the ends of ``count`` rays of a row, in columns ``followed``: each the first place that is not before the
    inner picture's surface. All take a step together, so that the processor fetches many at a time.
    """
    entry_x, entry_y, along_x, along_y = lines[ENTRY_X], lines[ENTRY_Y], lines[ALONG_X], lines[ALONG_Y]
    entry_depth, floor = lines[ENTRY_DEPTH], lines[FLOOR_SHARE]
    front, step, left, deepest = lines[_FRONT], lines[_STEP], lines[_LEFT], lines[_DEEPEST]
    for n in range(count):
        k = followed[n]
        length = np.sqrt(along_x[k] * along_x[k] + along_y[k] * along_y[k]) * floor[k]
        steps = min(np.floor(length / _STEP_PX) + ONE, _MOST_STEPS)
        front[k], step[k], left[k], deepest[k] = ZERO, _BEYOND * floor[k] / steps, steps + np.float32(1.5), ZERO
    taken = ZERO
    while count > 0:
        kept = 0
        for n in range(count):
            k = followed[n]
            x, y, z, ex, ey = entry_x[k], entry_y[k], entry_depth[k], along_x[k], along_y[k]
            share = taken * step[k]
            shown = ONE - z * nearness[_pixel(nearness, x + share * ex, y + share * ey)]
            if shown > share:
                if shown >= deepest[k]:
                    front[k], deepest[k] = share, shown - _FILLED * floor[k]
            elif shown >= ZERO:
                # The ray meets what is shown there, unless it shows something else where the ray is at that depth.
                there = _pixel(nearness, x + shown * ex, y + shown * ey)
                met = ONE - z * nearness[there]
                if abs(met - shown) <= max(np.float32(2.0) * step[k], _SAME * floor[k]):
                    _end(nearness, row, k, max(met, ZERO), there, lines, ends)
                    continue
            if taken + ONE < left[k]:
                followed[kept] = k
                kept += 1
            else:
                _fill(nearness, row, k, lines, ends)
        count = kept
        taken += ONE


@row_kernel(error_model="numpy", fastmath={"contract", "arcp", "nsz"})
def _fill(nearness: NDArray[np.float32], row: int, k: int, lines: NDArray[np.float32], ends: Endings) -> None:
    """Write the end of a ray that passed behind a body and had not come out when it met the floor.

    The inner picture lacks what is seen. It is filled by the lowest surface before the body, mirrored at its edge.
    """
    x, y, ex, ey = lines[ENTRY_X, k], lines[ENTRY_Y, k], lines[ALONG_X, k], lines[ALONG_Y, k]
    z, front, near = lines[ENTRY_DEPTH, k], lines[_FRONT, k], _FILLED * lines[FLOOR_SHARE, k]
    floor = _pixel(nearness, x + front * ex, y + front * ey)
    shown = ONE - z * nearness[floor]
    mirrored = max(np.float32(2.0) * front - shown, ZERO)
    there = _pixel(nearness, x + mirrored * ex, y + mirrored * ey)
    beyond = ONE - z * nearness[there] - shown
    if -near <= beyond <= near + front - mirrored:
        _end(nearness, row, k, mirrored, there, lines, ends)
    else:
        _end(nearness, row, k, front, floor, lines, ends)


@row_kernel(forceinline=True)
def _pixel(nearness: NDArray[np.float32], x: np.float32, y: np.float32) -> tuple[np.int32, np.int32]:
    half = np.float32(0.5)
    j = min(max(np.int32(x + half), np.int32(0)), np.int32(nearness.shape[1] - 1))
    i = min(max(np.int32(y + half), np.int32(0)), np.int32(nearness.shape[0] - 1))
    return i, j


@row_kernel(forceinline=True, error_model="numpy")
def _end(
    nearness: NDArray[np.float32],
    row: int,
    k: int,
    share: np.float32,
    there: tuple[np.int32, np.int32],
    lines: NDArray[np.float32],
    ends: Endings,
) -> None:
    """Write the end of a ray at a pixel, and where in it; at most half a pixel away from its middle."""
    i, j = there
    half = np.float32(0.5)
    x, y = lines[ENTRY_X, k] + share * lines[ALONG_X, k], lines[ENTRY_Y, k] + share * lines[ALONG_Y, k]
    ends.column[row, k] = min(max(x, np.float32(j) - half), np.float32(j) + half)
    ends.row[row, k] = min(max(y, np.float32(i) - half), np.float32(i) + half)
    ends.source[row, k] = i * nearness.shape[1] + j
    ends.depth_m[row, k] = lines[_SURFACE, k] + (ONE / nearness[i, j] - lines[ENTRY_DEPTH, k]) * lines[SCALE, k]
