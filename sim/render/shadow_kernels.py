"""The kernels of ``sim.render.shadow_map``: drawing heights, and keeping account of the highest."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.render.scene import SceneArrays
from sim.render.triangles import body_may_show, project_body, row_span, set_up_triangle

BLOCK = 16
"""Side of the blocks of texels whose greatest height is known; a power of two, which the shader makes use of."""


@njit(cache=True)
def bounds_across(
    depth_m: NDArray[np.float32],
    step_px: int,
    reach_m: float,
    from_pixel: NDArray[np.float64],
    low_m: NDArray[np.float64],
    high_m: NDArray[np.float64],
) -> None:
    """Write the bounds (2,) across the light of the surfaces that are seen nearer than ``reach_m``.

    Args:
        depth_m: (H, W) of every ``step_px``-th pixel of every ``step_px``-th row.
        from_pixel: (2, 4): ``depth * from_pixel[:, :3] @ (x, y, 1) + from_pixel[:, 3]`` is where across the light the
            surface at pixel (x, y) lies.
        low_m, high_m: not finite where nothing is near enough.
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
def draw_fixed(
    scene: SceneArrays,
    poses: NDArray[np.float64],
    light_view: NDArray[np.float64],
    bodies: NDArray[np.int64],
    projected: NDArray[np.float64],
    height_m: NDArray[np.float32],
) -> None:
    changed = np.empty(4, np.int64)
    for n in range(bodies.shape[0]):
        _draw_body(scene, poses[bodies[n]], light_view, bodies[n], projected, height_m, changed)


@njit(cache=True)
def redraw_movers(
    scene: SceneArrays,
    poses: NDArray[np.float64],
    light_view: NDArray[np.float64],
    bodies: NDArray[np.int64],
    projected: NDArray[np.float64],
    fixed_m: NDArray[np.float32],
    height_m: NDArray[np.float32],
    highest_m: NDArray[np.float32],
    changed: NDArray[np.int64],
) -> None:
    """Take the movers' last shadows off ``height_m`` (their ``changed`` boxes, from ``fixed_m``); draw new
    ones.
    """
    before = changed.copy()
    for n in range(bodies.shape[0]):
        for row in range(changed[n, 0], changed[n, 1]):
            for column in range(changed[n, 2], changed[n, 3]):
                height_m[row, column] = fixed_m[row, column]
    for n in range(bodies.shape[0]):
        _draw_body(scene, poses[bodies[n]], light_view, bodies[n], projected, height_m, changed[n])
    for n in range(bodies.shape[0]):
        find_highest(height_m, before[n], highest_m)
        find_highest(height_m, changed[n], highest_m)


@njit(cache=True)
def find_highest(height_m: NDArray[np.float32], changed: NDArray[np.int64], highest_m: NDArray[np.float32]) -> None:
    """Write the greatest height (N / BLOCK, N / BLOCK) of each block with texels in a box of rows and columns.

    A block ends with the first row and column of the next, so that it holds all of the 2x2 texels that begin in it.
    """
    size = height_m.shape[0]
    if changed[0] >= changed[1] or changed[2] >= changed[3]:
        return
    for block_row in range(max(changed[0] - 1, 0) // BLOCK, (changed[1] - 1) // BLOCK + 1):
        for block_column in range(max(changed[2] - 1, 0) // BLOCK, (changed[3] - 1) // BLOCK + 1):
            highest = height_m[block_row * BLOCK, block_column * BLOCK]
            for row in range(block_row * BLOCK, min(block_row * BLOCK + BLOCK + 1, size)):
                for column in range(block_column * BLOCK, min(block_column * BLOCK + BLOCK + 1, size)):
                    highest = max(highest, height_m[row, column])
            highest_m[block_row, block_column] = highest


@njit(cache=True)
def _draw_body(
    scene: SceneArrays,
    pose: NDArray[np.float64],
    light_view: NDArray[np.float64],
    body: int,
    projected: NDArray[np.float64],
    height_m: NDArray[np.float32],
    changed: NDArray[np.int64],
) -> None:
    """Raise ``height_m`` to the body's faces that look to the sun; ``changed`` is set to the rows and columns
    (first, after the last, first, after the last) that may have changed. The outermost texels are left out.
    """
    size = height_m.shape[0]
    changed[0], changed[1], changed[2], changed[3] = size, 0, size, 0
    if not body_may_show(light_view, pose, scene.centre_m[body], scene.radius_m[body], size, size, 0.0):
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
            left, right = row_span(edges, edge_count, row, size)
            left, right = max(left, 1), min(right, size - 1)
            if left >= right:
                continue
            changed[0], changed[1] = min(changed[0], row), max(changed[1], row + 1)
            changed[2], changed[3] = min(changed[2], left), max(changed[3], right)
            base = plane[1] * row + plane[2]
            for column in range(left, right):
                value = np.float32(base + plane[0] * column)
                if value > height_m[row, column]:
                    height_m[row, column] = value
