"""View matrices, and the rows and columns of a picture that triangles of the world cover.

One description serves a perspective picture and an orthographic map. A (4, 4) *view matrix* takes a
homogeneous world point to ``(q_x, q_y, q_w, g)``. Its pixel is ``(q_x, q_y) / q_w`` and its *nearness* ``g
/ q_w``: for a pinhole camera ``q_w`` is the depth and ``g = 1``, so nearness is 1 / depth; for an
orthographic map ``q_w = 1`` and ``g`` is the height towards the viewer. Of two surfaces the one with the
greater nearness hides the other.

A triangle with corners ``q_0, q_1, q_2`` (x, y, w) covers pixel ``d = (column, row, 1)`` where all three
edge functions ``e_i(d) = (q_j x q_k) . d / det`` are >= 0, with ``det = q_0 . (q_1 x q_2)``; there ``sum_i
a_i e_i(d)`` is ``a / q_w`` for any attribute ``a`` that is linear on the triangle (Olano and Greer,
"Triangle scan conversion using 2D homogeneous coordinates", 1997). So all attributes are linear in column
and row, and triangles that reach behind the camera are not clipped: the near plane is a fourth edge.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.optics import Camera, invert_pose, principal_point


@njit(cache=True)
def sides_of(view: NDArray[np.float64], width: int, height: int, near: float) -> NDArray[np.float64]:
    """Return the sides of a picture and the near plane (5, 4), planes ``n . p + c`` in world metres with ``|n| = 1``;
    values are negative beyond them.
    """
    sides = np.empty((5, 4))
    for k in range(4):
        sides[0, k], sides[1, k] = view[0, k], width * view[2, k] - view[0, k]
        sides[2, k], sides[3, k] = view[1, k], height * view[2, k] - view[1, k]
        sides[4, k] = view[2, k] - (near if k == 3 else 0.0)
    for side in range(5):
        sides[side] /= np.sqrt(sides[side, 0] ** 2 + sides[side, 1] ** 2 + sides[side, 2] ** 2)
    return sides


@njit(cache=True)
def body_may_show(
    sides: NDArray[np.float64],
    poses: NDArray[np.float64],
    centre_m: NDArray[np.float64],
    radius_m: NDArray[np.float64],
    n: int,
) -> bool:
    """Return False if the n-th body's bounding sphere surely lies wholly beyond one of ``sides_of`` a picture.

    Args:
        poses: T_world_body (B, 4, 4).
        centre_m, radius_m: (B, 3) and (B,) of the spheres, in the bodies' frames. (Whole arrays, not views of one
            body's part: making three views costs more than the arithmetic.)
    """
    a, b, c = centre_m[n, 0], centre_m[n, 1], centre_m[n, 2]
    x = poses[n, 0, 0] * a + poses[n, 0, 1] * b + poses[n, 0, 2] * c + poses[n, 0, 3]
    y = poses[n, 1, 0] * a + poses[n, 1, 1] * b + poses[n, 1, 2] * c + poses[n, 1, 3]
    z = poses[n, 2, 0] * a + poses[n, 2, 1] * b + poses[n, 2, 2] * c + poses[n, 2, 3]
    # Rounding must not cull a sphere that touches a side.
    reach_m = (1.0 + 1e-9) * radius_m[n] + 1e-9 * (abs(x) + abs(y) + abs(z))
    for side in range(5):
        if sides[side, 0] * x + sides[side, 1] * y + sides[side, 2] * z + sides[side, 3] < -reach_m:
            return False
    return True


@njit(cache=True)
def project_body(
    view: NDArray[np.float64],
    T_world_body: NDArray[np.float64],
    vertices_m: NDArray[np.float32],
    projected: NDArray[np.float64],
) -> None:
    """Write ``view @ T_world_body @ (vertex, 1)`` of every vertex (n, 3) to ``projected`` (>= n, 4)."""
    matrix = np.empty((4, 4))
    view_of_body(view, T_world_body, matrix)
    project_vertices(matrix, vertices_m, projected)


@njit(cache=True)
def view_of_body(view: NDArray[np.float64], T_world_body: NDArray[np.float64], matrix: NDArray[np.float64]) -> None:
    """Write ``view @ T_world_body`` (4, 4)."""
    for i in range(4):
        for j in range(4):
            total = 0.0
            for k in range(4):
                total += view[i, k] * T_world_body[k, j]
            matrix[i, j] = total


@njit(cache=True)
def chunk_may_show(
    matrix: NDArray[np.float64],
    middle_m: NDArray[np.float64],
    half_m: NDArray[np.float64],
    n: int,
    width: int,
    height: int,
    near: float,
) -> bool:
    """Return False if the n-th box surely lies wholly beyond one side of the picture or before the near plane.

    A side is the plane ``n . p + c = 0``; the box is beyond it if ``n . middle + c < -|n| . half``.

    Args:
        matrix: as ``view_of_body`` writes it.
        middle_m, half_m: (C, 3) of the boxes, in the body's frame.
    """
    for side in range(5):
        axis, size, sign = side // 2, 0.0, 1.0
        if side == 1:
            size, sign = float(width), -1.0
        elif side == 3:
            size, sign = float(height), -1.0
        # Rounding must not cull a box that touches a side.
        value = sign * matrix[axis, 3] + size * matrix[2, 3] - (near if side == 4 else 0.0)
        reach = 1e-6 * (1.0 + abs(value))
        for k in range(3):
            coefficient = sign * matrix[axis, k] + size * matrix[2, k]
            value += coefficient * middle_m[n, k]
            reach += abs(coefficient) * half_m[n, k] + 1e-6 * abs(coefficient * middle_m[n, k])
        if value < -reach:
            return False
    return True


@njit(cache=True)
def project_vertices(
    matrix: NDArray[np.float64], vertices_m: NDArray[np.float32], projected: NDArray[np.float64]
) -> None:
    """Write ``matrix @ (vertex, 1)`` of every vertex (n, 3) to ``projected`` (>= n, 4)."""
    for n in range(vertices_m.shape[0]):
        x, y, z = vertices_m[n, 0], vertices_m[n, 1], vertices_m[n, 2]
        for i in range(4):
            projected[n, i] = matrix[i, 0] * x + matrix[i, 1] * y + matrix[i, 2] * z + matrix[i, 3]


@njit(cache=True, forceinline=True)
def set_up_triangle(
    q: NDArray[np.float64],
    first: int,
    second: int,
    third: int,
    near: float,
    height: int,
    edges: NDArray[np.float64],
    weights: NDArray[np.float64],
) -> tuple[int, int, int]:
    """Write the edge functions of a triangle that faces the viewer.

    ``weights[i] = e_i`` (3, 3), and ``edges[i] = -(q_j x q_k)`` (4, 3), the same but for a factor: of two triangles
    with a common edge, one has exactly the negative of the other's, so that no pixel falls between them. Where the
    triangle reaches before the near plane, ``edges[3] = 1 - near * sum_i e_i``, which is >= 0 where ``q_w >= near``.

    Args:
        q: (n, 4) projected corners; ``first``, ``second``, ``third`` are the triangle's. (Numbers, not views of rows:
            making a view costs more than the arithmetic.)

    Returns:
        first row, row after the last, number of edges (3 or 4). No rows, and undefined results, if the triangle faces
        away, or lies before the near plane or between two rows.
        (``det < 0`` where counter-clockwise corners are seen as such with y down.)
    """
    x0, y0, w0 = q[first, 0], q[first, 1], q[first, 2]
    x1, y1, w1 = q[second, 0], q[second, 1], q[second, 2]
    x2, y2, w2 = q[third, 0], q[third, 1], q[third, 2]
    before = int(w0 < near) + int(w1 < near) + int(w2 < near)
    if before == 3:
        return 0, 0, 0
    edges[0, 0], edges[0, 1], edges[0, 2] = w1 * y2 - y1 * w2, x1 * w2 - w1 * x2, y1 * x2 - x1 * y2
    edges[1, 0], edges[1, 1], edges[1, 2] = w2 * y0 - y2 * w0, x2 * w0 - w2 * x0, y2 * x0 - x2 * y0
    edges[2, 0], edges[2, 1], edges[2, 2] = w0 * y1 - y0 * w1, x0 * w1 - w0 * x1, y0 * x1 - x0 * y1
    minus_det = x0 * edges[0, 0] + y0 * edges[0, 1] + w0 * edges[0, 2]
    if not minus_det > 0.0:
        return 0, 0, 0
    top_row, last_row = 0, height
    if not before:
        # Rows first: most small triangles lie between two of them.
        top = min(y0 / w0, y1 / w1, y2 / w2)
        bottom = max(y0 / w0, y1 / w1, y2 / w2)
        if not (top < height and bottom >= 0.0):
            return 0, 0, 0
        top_row, last_row = max(0, int(np.ceil(top))), min(height, int(np.floor(bottom)) + 1)
        if top_row >= last_row:
            return 0, 0, 0
    for k in range(3):
        for i in range(3):
            weights[i, k] = edges[i, k] / minus_det
    if before:
        for k in range(3):
            nearness = weights[0, k] + weights[1, k] + weights[2, k]
            edges[3, k] = (1.0 if k == 2 else 0.0) - near * nearness
        return top_row, last_row, 4
    return top_row, last_row, 3


@njit(cache=True, forceinline=True)
def row_span(edges: NDArray[np.float64], edge_count: int, row: int, width: int) -> tuple[int, int]:
    """Return the first column and the one after the last where all edge functions are >= 0 in a row.

    An edge ``a column + r >= 0`` bounds the column from the left by ``-r / a`` if ``a > 0``, from the right
    if ``a < 0``. Left bounds are inclusive and right ones exclusive, so that triangles with a common edge
    share no pixel.
    """
    left, right = 0.0, float(width)
    for k in range(edge_count):
        slope = edges[k, 0]
        rest = edges[k, 1] * row + edges[k, 2]
        if slope > 0.0:
            left = max(left, -rest / slope)
        elif slope < 0.0:
            right = min(right, -rest / slope)
        elif rest < 0.0:
            return 0, 0
    if not left < right:
        return 0, 0
    return int(np.ceil(left)), int(np.ceil(right))


def camera_view(camera: Camera, T_world_camera: NDArray[np.float64], pixel_offset: float) -> NDArray[np.float64]:
    """Return the (4, 4) view matrix of a camera that samples pixel (i, j) at ``(j, i) + pixel_offset``.

    ``q_x = f x + (c_x - offset) z``, ``q_y = f y + (c_y - offset) z``, ``q_w = z``, ``g = 1`` for a point
    (x, y, z) of the camera frame.
    """
    return _picture_of_camera(camera, pixel_offset) @ invert_pose(np.asarray(T_world_camera, dtype=float))


@lru_cache(maxsize=16)
def _picture_of_camera(camera: Camera, pixel_offset: float) -> NDArray[np.float64]:
    """Return the view matrix (4, 4) of points of the camera frame, not to be written to."""
    centre_x, centre_y = principal_point(camera) - pixel_offset
    return np.array(
        [
            [camera.focal_px, 0.0, centre_x, 0.0],
            [0.0, camera.focal_px, centre_y, 0.0],
            [0.0, 0.0, 1.0, 0.0],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )
