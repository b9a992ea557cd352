"""Where bent rays end: an inner picture as its eye sees it, and the search of its depth map.

Bent rays do not meet in one point, but almost: the point nearest to them all is the eye. So what the inner picture
shows is nearly what is seen through the water, and little is hidden in it that is not hidden in the water. In it, a
bent ray enters the water at pixel a and depth z, and what lies on it at depth w is drawn at

    q(w) = a + (1 - z / w) e,    e = (pixel in which all rays parallel to the bent one meet) - a

on a straight line, at camera depth ``z_s + (w - z) b``.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.optics import Camera, Intrinsics, intrinsic_matrix, project, rays
from sim.render.compilation import row_kernel
from sim.render.water.rays import ALONG_X as TOWARDS_X
from sim.render.water.rays import ALONG_Y as TOWARDS_Y
from sim.render.water.rays import FARTHEST_M, ONE, STEP_PX, SURFACE_DEPTH, ZERO, WaterRays, interpolate_row


class Endings(NamedTuple):
    """The ends of a picture's rays; all are (H, W).

    Attributes:
        column, row: float32, where in the inner picture, in pixels from the middle of the first; of rays that are not
            bent, in the straight picture.
        source: int32, number k of the inner pixel that shows the same surface, counted along rows; ``-1 - k`` for that
            of the straight picture.
        depth_m: float32, along the camera's optical axis; inf where there is no body.
    """

    column: NDArray[np.float32]
    row: NDArray[np.float32]
    source: NDArray[np.int32]
    depth_m: NDArray[np.float32]


def new_endings(height: int, width: int, depth_m: NDArray[np.float32]) -> Endings:
    """Return ends for pictures of this size, with a depth map of the caller's."""
    real = np.empty((2, height, width), np.float32)
    return Endings(real[0], real[1], np.empty((height, width), np.int32), depth_m)


ENTRY_X, ENTRY_Y, ENTRY_DEPTH, ALONG_X, ALONG_Y, SCALE, FLOOR_SHARE = range(7)
"""Planes of ways, at the nodes of ``WaterRays``: a, in pixels from the middle of the first; z; e; b; and the share
``1 - z / w`` at the floor."""
PLANES = 7
_PER_SIDE = 9
_BORDER_PX = 12
_BESIDE = 0.05


class Eye(NamedTuple):
    """The camera of the inner picture, and its pose (4, 4)."""

    camera: Camera
    T_world_camera: NDArray[np.float64]


@lru_cache(maxsize=16)
def eye_of(
    camera: Camera, pose: bytes, rectangle_m: tuple[float, ...], level_m: float, depth_m: float, index: float
) -> Eye:
    """Return the eye of a camera at a pose ``T_world_camera.tobytes()``; the camera itself if it sees no water.

    Args:
        rectangle_m: x and y of the low and of the high corner of the water.
    """
    T_world_camera = np.frombuffer(pose).reshape(4, 4)
    position, low, high = T_world_camera[:3, 3], np.array(rectangle_m[:2]), np.array(rectangle_m[2:])
    entries = _entries(camera, T_world_camera, low, high, level_m)
    if len(entries) < 4:
        return Eye(camera, T_world_camera)
    incoming = entries - position
    incoming /= np.linalg.norm(incoming, axis=1, keepdims=True)
    bent = incoming / index
    bent[:, 2] = -np.sqrt(1.0 - (bent[:, :2] ** 2).sum(axis=1))
    # The point whose squared distances to all rays have the least sum.
    across = np.eye(3) - bent[:, :, None] * bent[:, None, :]
    place = np.linalg.solve(across.sum(axis=0), (across @ entries[:, :, None]).sum(axis=0)[:, 0])
    ends = entries + bent * (depth_m / -bent[:, 2:])
    T_world_eye = np.eye(4)
    ahead = (0.5 * (ends + entries) - place).mean(axis=0)
    ahead /= np.linalg.norm(ahead)
    right = T_world_camera[:3, 0] - (T_world_camera[:3, 0] @ ahead) * ahead
    right /= np.linalg.norm(right)
    T_world_eye[:3, :3], T_world_eye[:3, 3] = np.column_stack([right, np.cross(ahead, right), ahead]), place
    # As many pixels to the floor as the camera has.
    unit = Intrinsics(0, 0, 1.0)
    shown, seen = project(unit, T_world_eye, np.stack([entries, ends]))[0], project(camera, T_world_camera, entries)[0]
    focal_px = float(np.linalg.norm(seen - seen.mean(axis=0)) / np.linalg.norm(shown[1] - shown[1].mean(axis=0)))
    half_px = np.abs(shown).max(axis=(0, 1)) * focal_px + _BORDER_PX
    width_px, height_px = (8 * int(np.ceil(half / 4.0)) for half in half_px)
    return Eye(Intrinsics(width_px, height_px, focal_px), T_world_eye)


def _entries(
    camera: Camera,
    T_world_camera: NDArray[np.float64],
    low: NDArray[np.float64],
    high: NDArray[np.float64],
    level_m: float,
) -> NDArray[np.float64]:
    """Return places (N, 3) all over the level surface that the camera sees, those at its borders among them."""
    steps = np.linspace(0.0, 1.0, _PER_SIDE)
    grid = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    size = np.array([camera.width_px, camera.height_px])
    on_water = np.column_stack([low + grid * (high - low), np.full(len(grid), level_m)])
    pixels = project(camera, T_world_camera, on_water)[0]
    on_water = on_water[((pixels >= 0) & (pixels <= size)).all(axis=1)]
    directions = rays(camera, T_world_camera, grid * size)
    falling = directions[:, 2] < -0.02
    depth = (level_m - T_world_camera[2, 3]) / directions[falling, 2]
    in_picture = T_world_camera[:3, 3] + depth[:, None] * directions[falling]
    beside = _BESIDE * (high - low)
    is_in = ((in_picture[:, :2] >= low - beside) & (in_picture[:, :2] <= high + beside)).all(axis=1)
    return np.concatenate([on_water, in_picture[is_in]])


def ways_of(rays: WaterRays, eye: Eye) -> NDArray[np.float32]:
    """Return the ways (7, R, C) float32 of the nodes' rays in the picture of an eye."""
    ways = np.empty((PLANES, *rays.nodes.shape[1:]), np.float32)
    onto = np.ascontiguousarray(intrinsic_matrix(eye.camera) @ eye.T_world_camera[:3, :3].T)
    _lay_ways(rays, onto, np.ascontiguousarray(rays.position_m - eye.T_world_camera[:3, 3]), ways)
    return ways


@row_kernel(error_model="numpy", fastmath={"contract", "arcp", "nsz"})
def _lay_ways(
    rays: WaterRays, onto: NDArray[np.float64], from_eye: NDArray[np.float64], ways: NDArray[np.float32]
) -> None:
    """Write the ways.

    Args:
        onto: (3, 3) from a place, as the eye has it before it along the world's axes, to its homogeneous pixel.
        from_eye: (3,) from the eye to the camera, world frame.
    """
    m, floor_m = rays.matrix, rays.water.depth_m
    # What is before the eye per unit along the rays of the camera: the pixels of both are related by one matrix.
    a, b, c = _through(onto, m[:, 0]), _through(onto, m[:, 1]), _through(onto, m[:, 2])
    at_x, at_y, at_z = _through(onto, from_eye)
    m_x, m_y, m_z = m[2, 0], m[2, 1], m[2, 2]
    for i in range(ways.shape[1]):
        y = i * STEP_PX + rays.pixel_offset
        base_x, base_y, base_z = b[0] * y + c[0], b[1] * y + c[1], b[2] * y + c[2]
        depths, towards_x, towards_y = (
            rays.nodes[SURFACE_DEPTH, i],
            rays.nodes[TOWARDS_X, i],
            rays.nodes[TOWARDS_Y, i],
        )
        entry_x, entry_y, entry_depth = ways[ENTRY_X, i], ways[ENTRY_Y, i], ways[ENTRY_DEPTH, i]
        along_x, along_y, scale, floor = ways[ALONG_X, i], ways[ALONG_Y, i], ways[SCALE, i], ways[FLOOR_SHARE, i]
        for j in range(depths.shape[0]):
            x, depth, ex, ey = np.int32(j * STEP_PX) + rays.pixel_offset, depths[j], towards_x[j], towards_y[j]
            px, py, pz = a[0] * x + base_x, a[1] * x + base_y, a[2] * x + base_z
            sx, sy, sz = at_x + depth * px, at_y + depth * py, at_z + depth * pz
            # Along the bent ray, per unit of camera depth.
            ux, uy, uz = px + a[0] * ex + b[0] * ey, py + a[1] * ex + b[1] * ey, pz + a[2] * ex + b[2] * ey
            fall = m_x * (x + ex) + m_y * (y + ey) + m_z
            misses = (depth >= FARTHEST_M) | (sz <= 0.0) | (uz <= 0.0)
            a_x, a_y = sx / sz, sy / sz
            entry_x[j], entry_y[j] = 0.0 if misses else a_x - 0.5, 0.0 if misses else a_y - 0.5
            entry_depth[j] = FARTHEST_M if misses else sz
            along_x[j], along_y[j] = 0.0 if misses else ux / uz - a_x, 0.0 if misses else uy / uz - a_y
            scale[j] = 0.0 if misses else 1.0 / uz
            floor[j] = 0.0 if misses else 1.0 - sz / (sz - floor_m / fall * uz)


@row_kernel()
def _through(matrix: NDArray[np.float64], vector: NDArray[np.float64]) -> tuple[float, float, float]:
    return (
        matrix[0, 0] * vector[0] + matrix[0, 1] * vector[1] + matrix[0, 2] * vector[2],
        matrix[1, 0] * vector[0] + matrix[1, 1] * vector[1] + matrix[1, 2] * vector[2],
        matrix[2, 0] * vector[0] + matrix[2, 1] * vector[1] + matrix[2, 2] * vector[2],
    )


TILE, EDGE_TILE = 8, 4
"""Sides of the tiles of the picture whose rays are followed or not, and of those of the inner picture that have an edge
or none."""
NODES = TILE // STEP_PX
EDGE = 0.01
"""Share of the water's depth by which a surface must jump or fold to be an edge."""


@njit(cache=True, error_model="numpy", fastmath={"contract", "arcp", "nsz"})
def find_edges(nearness: NDArray[np.float32], jump_m: np.float32, edges: NDArray[np.bool_]) -> None:
    """Mark the tiles where nearness, which is linear on a plane, is not: ``|n - 2 n' + n''| > jump n'²``."""
    rows, columns = nearness.shape
    worst = np.empty(columns, np.float32)
    for tile_row in range(edges.shape[0]):
        worst[:] = ZERO
        for row in range(tile_row * EDGE_TILE, min(tile_row * EDGE_TILE + EDGE_TILE, rows)):
            above, here, below = nearness[max(row - 1, 0)], nearness[row], nearness[min(row + 1, rows - 1)]
            if 0 < row < rows - 1:
                for k in range(columns):
                    fold = np.abs(above[k] + below[k] - np.float32(2.0) * here[k]) - jump_m * here[k] * here[k]
                    worst[k] = max(worst[k], fold)
            for k in range(1, columns - 1):
                fold = np.abs(here[k - 1] + here[k + 1] - np.float32(2.0) * here[k]) - jump_m * here[k] * here[k]
                worst[k] = max(worst[k], fold)
        for tile in range(edges.shape[1]):
            for k in range(tile * EDGE_TILE, min(tile * EDGE_TILE + EDGE_TILE, columns)):
                edges[tile_row, tile] |= worst[k] > ZERO


@row_kernel(error_model="numpy")
def find_near_edges(
    ways: NDArray[np.float32], edges: NDArray[np.bool_], kinds: NDArray[np.int8], near_edge: NDArray[np.bool_]
) -> None:
    """Mark the tiles of the picture whose rays pass a tile with an edge on their way to the floor, or are of two kinds.

    Args:
        kinds: (R, C) of the nodes.
    """
    rows, columns = kinds.shape
    for tile_row in range(near_edge.shape[0]):
        for tile in range(near_edge.shape[1]):
            left, right, top, bottom = np.inf, -np.inf, np.inf, -np.inf
            first_i, first_j = min(NODES * tile_row, rows - 1), min(NODES * tile, columns - 1)
            last_i, last_j = min(first_i + NODES, rows - 1), min(first_j + NODES, columns - 1)
            is_near = False
            for i in range(first_i, last_i + 1):
                for j in range(first_j, last_j + 1):
                    is_near |= kinds[i, j] != kinds[first_i, first_j]
                    x, y, share = ways[ENTRY_X, i, j], ways[ENTRY_Y, i, j], ways[FLOOR_SHARE, i, j]
                    end_x, end_y = x + share * ways[ALONG_X, i, j], y + share * ways[ALONG_Y, i, j]
                    left, right = min(left, x, end_x), max(right, x, end_x)
                    top, bottom = min(top, y, end_y), max(bottom, y, end_y)
            first_row, last_row = max(int(top + 0.5) // EDGE_TILE, 0), int(bottom + 0.5) // EDGE_TILE
            first_column, last_column = max(int(left + 0.5) // EDGE_TILE, 0), int(right + 0.5) // EDGE_TILE
            for i in range(first_row, min(last_row + 1, edges.shape[0])):
                for j in range(first_column, min(last_column + 1, edges.shape[1])):
                    is_near |= edges[i, j]
            near_edge[tile_row, tile] = is_near


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


@row_kernel()
def _between(nearness: NDArray[np.float32], x: np.float32, y: np.float32) -> np.float32:
    """Return the nearness at a place in the inner picture, as if it were linear around it."""
    x = min(max(x, ZERO), np.float32(nearness.shape[1]) - np.float32(1.01))
    y = min(max(y, ZERO), np.float32(nearness.shape[0]) - np.float32(1.01))
    j, i = np.int32(x), np.int32(y)
    here = nearness[i, j]
    across, down = nearness[i, j + 1] - here, nearness[i + 1, j] - here
    return here + (x - np.float32(j)) * across + (y - np.float32(i)) * down


@row_kernel()
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


@row_kernel()
def _pixel(nearness: NDArray[np.float32], x: np.float32, y: np.float32) -> tuple[np.int32, np.int32]:
    half = np.float32(0.5)
    j = min(max(np.int32(x + half), np.int32(0)), np.int32(nearness.shape[1] - 1))
    i = min(max(np.int32(y + half), np.int32(0)), np.int32(nearness.shape[0] - 1))
    return i, j


@row_kernel(error_model="numpy")
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
