"""The kernels of ``sim.render.shadow_map``: the part of a map that a view looks up, and its drawing."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.render.scene import SceneArrays
from sim.render.shadow_tiles import (
    TILE,
    MapArrays,
    copy_tiles,
    fill_tiles,
    find_highest,
    mark_blocks,
    new_tiles,
    span_tiles,
)
from sim.render.triangles import project_body, row_span, set_up_triangle

_SQUARE_PX = 8
"""Side of the squares of pixels whose texels are found together."""
_MARGIN = 2.0
"""Texels; the shader also reads the next one, and computes with single precision."""


@njit(cache=True)
def bounds_across(
    depth_m: NDArray[np.float32],
    step_px: int,
    reach_m: float,
    from_pixel: NDArray[np.float64],
    low_m: NDArray[np.float64],
    high_m: NDArray[np.float64],
) -> None:
    """Write the bounds (2,), perpendicular to the light, of the surfaces nearer than ``reach_m``.

    Args:
        depth_m: (H, W) of every ``step_px``-th pixel of every ``step_px``-th row.
        from_pixel: (2, 4): ``depth * from_pixel[:, :3] @ (x, y, 1) + from_pixel[:, 3]`` is the place, perpendicular to
            the light, of the surface at pixel (x, y).
        low_m, high_m: written; not finite if nothing is near enough.
    """
    low_m[:], high_m[:] = np.inf, -np.inf
    for row in range(depth_m.shape[0]):
        for column in range(depth_m.shape[1]):
            depth = depth_m[row, column]
            if depth >= reach_m:
                continue
            for axis in range(2):
                line = from_pixel[axis]
                across_m = depth * (line[0] * (column * step_px) + line[1] * (row * step_px) + line[2]) + line[3]
                low_m[axis], high_m[axis] = min(low_m[axis], across_m), max(high_m[axis], across_m)


@njit(cache=True)
def find_tiles(depth_m: NDArray[np.float32], from_pixel: NDArray[np.float64], wanted: NDArray[np.bool_]) -> None:
    """Set the tiles (n, n) of a map that the shading of a picture looks up, and some around them.

    A square of pixels that lie between two depths looks up no texel beyond the four products of the least and greatest
    depth with the least and greatest ray.

    Args:
        depth_m: (H, W).
        from_pixel: (2, 4): ``depth * from_pixel[:, :3] @ (x, y, 1) + from_pixel[:, 3]`` is the map's column and row of
            the surface at pixel coordinates (x, y).
    """
    wanted[:] = False
    bounds = np.empty((2, 2), np.int64)
    for first_row in range(0, depth_m.shape[0], _SQUARE_PX):
        last_row = min(first_row + _SQUARE_PX, depth_m.shape[0]) - 1
        for first_column in range(0, depth_m.shape[1], _SQUARE_PX):
            last_column = min(first_column + _SQUARE_PX, depth_m.shape[1]) - 1
            nearest, farthest = np.inf, 0.0
            for row in range(first_row, last_row + 1):
                for column in range(first_column, last_column + 1):
                    depth = depth_m[row, column]
                    # Where nothing is there is no shadow.
                    if depth < np.inf:
                        nearest, farthest = min(nearest, depth), max(farthest, depth)
            if nearest > farthest:
                continue
            for axis in range(2):
                line = from_pixel[axis]
                ray = line[0] * (first_column + 0.5) + line[1] * (first_row + 0.5) + line[2]
                along, down = line[0] * (last_column - first_column), line[1] * (last_row - first_row)
                least, greatest = ray + min(along, 0.0) + min(down, 0.0), ray + max(along, 0.0) + max(down, 0.0)
                low = min(least * nearest, least * farthest) + line[3] - _MARGIN
                high = max(greatest * nearest, greatest * farthest) + line[3] + _MARGIN
                end = wanted.shape[0] * TILE - 1.0
                bounds[axis, 0] = int(min(max(low, 0.0), end)) // TILE
                bounds[axis, 1] = int(min(max(high, 0.0), end)) // TILE
            wanted[bounds[1, 0] : bounds[1, 1] + 1, bounds[0, 0] : bounds[0, 1] + 1] = True


@njit(cache=True)
def draw_tiles(
    scene: SceneArrays,
    poses: NDArray[np.float64],
    light_view: NDArray[np.float64],
    fixed: NDArray[np.int64],
    movers: NDArray[np.int64],
    projected: NDArray[np.float64],
    wanted: NDArray[np.bool_],
    map_so_far: MapArrays,
) -> None:
    """Draw the missing tiles of a map among the wanted ones, and update the movers' shadows.

    Args:
        poses: (B, 4, 4) of all bodies.
        fixed, movers: indices of the bodies that cast shadows.
        projected: scratch for the vertices of the largest body.
        wanted: (n, n) tiles.
    """
    drawn, fixed_m, height_m = map_so_far.drawn, map_so_far.fixed_m, map_so_far.height_m
    new, stale = np.zeros_like(drawn), np.zeros(map_so_far.highest_m.shape, np.bool_)
    has_new = new_tiles(wanted, drawn, new)
    have_moved = has_new or not map_so_far.is_current[0]
    for n in range(movers.shape[0]):
        have_moved |= _differ(poses[movers[n]], map_so_far.poses_drawn[n])
    if not have_moved:
        return
    spans = np.empty((drawn.shape[0], 2), np.int64)
    box = np.empty(4, np.int64)
    if has_new:
        span_tiles(new, height_m.shape[0], spans)
        fill_tiles(new, fixed_m)
        for n in range(fixed.shape[0]):
            _draw_body(scene, poses[fixed[n]], light_view, fixed[n], projected, spans, fixed_m, box)
        copy_tiles(new, fixed_m, height_m, stale)
        drawn |= new
    changed = map_so_far.changed
    for n in range(movers.shape[0]):
        mark_blocks(changed[n], stale)
        for row in range(changed[n, 0], changed[n, 1]):
            for column in range(changed[n, 2], changed[n, 3]):
                height_m[row, column] = fixed_m[row, column]
    span_tiles(drawn, height_m.shape[0], spans)
    for n in range(movers.shape[0]):
        pose = poses[movers[n]]
        _draw_body(scene, pose, light_view, movers[n], projected, spans, height_m, changed[n])
        mark_blocks(changed[n], stale)
        map_so_far.poses_drawn[n] = pose
    find_highest(height_m, stale, map_so_far.highest_m)
    map_so_far.is_current[0] = True


@njit(cache=True)
def _differ(a: NDArray[np.float64], b: NDArray[np.float64]) -> bool:
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            if a[i, j] != b[i, j]:
                return True
    return False


@njit(cache=True)
def _may_reach(
    light_view: NDArray[np.float64],
    pose: NDArray[np.float64],
    centre_m: NDArray[np.float64],
    radius_m: float,
    spans: NDArray[np.int64],
) -> bool:
    """Return False if a body's bounding sphere surely lies outside the spans."""
    column, row, scale = light_view[0, 3], light_view[1, 3], 0.0
    for k in range(3):
        place_m = pose[k, 3]
        for j in range(3):
            place_m += pose[k, j] * centre_m[j]
        column += light_view[0, k] * place_m
        row += light_view[1, k] * place_m
        scale += light_view[0, k] * light_view[0, k]
    reach = radius_m * np.sqrt(scale) + 1.0
    end = spans.shape[0] * TILE - 1.0
    if row + reach < 0.0 or row - reach > end:
        return False
    for i in range(int(max(row - reach, 0.0)) // TILE, int(min(row + reach, end)) // TILE + 1):
        if spans[i, 0] < column + reach and column - reach < spans[i, 1]:
            return True
    return False


@njit(cache=True)
def _draw_body(
    scene: SceneArrays,
    pose: NDArray[np.float64],
    light_view: NDArray[np.float64],
    body: int,
    projected: NDArray[np.float64],
    spans: NDArray[np.int64],
    height_m: NDArray[np.float32],
    changed: NDArray[np.int64],
) -> None:
    """Raise ``height_m`` within the spans to the body's faces that look to the sun; ``changed`` is set to the rows and
    columns (first, after the last, first, after the last) that may have changed. The outermost texels are left out.
    """
    size = height_m.shape[0]
    changed[0], changed[1], changed[2], changed[3] = size, 0, size, 0
    if not _may_reach(light_view, pose, scene.centre_m[body], scene.radius_m[body], spans):
        return
    start = scene.first_vertex[body]
    project_body(light_view, pose, scene.vertices_m[start : scene.first_vertex[body + 1]], projected)
    edges, weights = np.empty((4, 3)), np.empty((3, 3))
    plane = np.empty(3)
    for face in range(scene.first_face[body], scene.first_face[body + 1]):
        a, b, c = scene.faces[face, 0] - start, scene.faces[face, 1] - start, scene.faces[face, 2] - start
        first, last, edge_count = set_up_triangle(projected, a, b, c, 0.0, size, edges, weights)
        if first >= last:
            continue
        for k in range(3):
            plane[k] = (
                projected[a, 3] * weights[0, k] + projected[b, 3] * weights[1, k] + projected[c, 3] * weights[2, k]
            )
        for row in range(max(first, 1), min(last, size - 1)):
            span_left, span_right = spans[row // TILE, 0], spans[row // TILE, 1]
            if span_left >= span_right:
                continue
            left, right = row_span(edges, edge_count, row, size)
            left, right = max(left, span_left, 1), min(right, span_right, size - 1)
            if left >= right:
                continue
            changed[0], changed[1] = min(changed[0], row), max(changed[1], row + 1)
            changed[2], changed[3] = min(changed[2], left), max(changed[3], right)
            base = plane[1] * row + plane[2]
            for column in range(left, right):
                value = np.float32(base + plane[0] * column)
                if value > height_m[row, column]:
                    height_m[row, column] = value
