"""Nearest triangle of each pixel: the first half of the rasteriser. See ``sim.render.triangles``."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.gbuffer import SKY
from sim.render.scene import CHUNK, SceneArrays
from sim.render.textures import TexturePool
from sim.render.triangles import (
    body_may_show,
    chunk_may_show,
    project_vertices,
    row_span,
    set_up_triangle,
    sides_of,
    view_of_body,
)

NEAR_M = 0.2
"""Least depth that is drawn."""

NOTHING = 0
"""Row of the ``TriangleTable`` of pixels that show no body."""

SHORT = 24
"""Spans below this number of pixels are too short for vector code."""


BODY, TEXTURE, IS_SMOOTH, IS_FLAT = range(4)
"""Columns of ``TriangleTable.whole``."""
U, V, NX, NY, NZ, TEXEL_DENSITY = 0, 3, 6, 9, 12, 15
"""First columns of things in ``TriangleTable.real``."""


class TriangleTable(NamedTuple):
    """Triangles that may be visible, with their linear attributes as planes (per column, per row, constant).

    Row ``NOTHING`` is that of pixels without a body. Values that are read together are stored together.

    Attributes:
        whole: (N, 4) int32: body; texture; whether it is smooth; whether the face is flat, all its corners having the
            same normal.
        real: (N, 16) float32: planes (6) of ``x / q_w`` and ``y / q_w``, the position (u width, v height) in the
            texture; planes (9) of ``n / q_w``, the normal in the world frame, or on flat faces ``n`` itself as the
            constants; texels that a pixel covers times nearness³, the Jacobian of a projective map.
        sides: (N, 9) float32: planes of the three edge functions, >= 0 inside, in pixels along the axis to which an
            edge is steeper.
    """

    whole: NDArray[np.int32]
    real: NDArray[np.float32]
    sides: NDArray[np.float32]


def new_triangle_table(face_count: int) -> TriangleTable:
    """Return a table for ``face_count`` triangles; ``NOTHING`` is set."""
    rows = face_count + 1
    table = TriangleTable(
        np.empty((rows, 4), np.int32), np.empty((rows, 16), np.float32), np.empty((rows, 9), np.float32)
    )
    table.whole[NOTHING] = (SKY, 0, False, True)
    table.real[NOTHING] = table.sides[NOTHING] = 0.0
    return table


@njit(cache=True)
def draw_bodies(
    scene: SceneArrays,
    textures: TexturePool,
    poses: NDArray[np.float64],
    view: NDArray[np.float64],
    projected: NDArray[np.float64],
    bodies: NDArray[np.int64],
    kept: int,
    table: TriangleTable,
    nearness: NDArray[np.float32],
    triangle: NDArray[np.int32],
) -> int:
    """Find the nearest triangle of every pixel, of some bodies and of what is drawn already.

    Where two are equally near, that of the body with the lower index is drawn: so a picture drawn in two parts equals
    one drawn at once.

    Args:
        poses: T_world_body (B, 4, 4).
        view: the view matrix of a camera.
        projected: scratch for the vertices of the largest body.
        bodies: indices in ascending order.
        kept: number of rows in use of ``table``, 1 for a blank picture.
        table: written: the triangles that may be visible.
        nearness: (H, W), written: 1 / depth, 0 where there is nothing.
        triangle: (H, W), written: row of ``table``.

    Returns:
        Number of rows in use of ``table``.
    """
    height, width = nearness.shape
    edges, weights, matrix = np.empty((4, 3)), np.empty((3, 3)), np.empty((4, 4))
    sides = sides_of(view, width, height, NEAR_M)
    count = kept
    for body in bodies:
        if not body_may_show(sides, poses, scene.centre_m, scene.radius_m, body):
            continue
        pose, start = poses[body], scene.first_vertex[body]
        view_of_body(view, pose, matrix)
        first_face, last_face = scene.first_face[body], scene.first_face[body + 1]
        for chunk in range(scene.first_chunk[body], scene.first_chunk[body + 1]):
            chunk_face, first_face = first_face, min(first_face + CHUNK, last_face)
            if not chunk_may_show(matrix, scene.chunk_middle_m, scene.chunk_half_m, chunk, width, height, NEAR_M):
                continue
            vertices = scene.chunk_vertices[chunk]
            project_vertices(matrix, scene.vertices_m[vertices[0] : vertices[1]], projected[vertices[0] - start :])
            for face in range(chunk_face, first_face):
                i, j, k = scene.faces[face, 0] - start, scene.faces[face, 1] - start, scene.faces[face, 2] - start
                first, last, edge_count = set_up_triangle(projected, i, j, k, NEAR_M, height, edges, weights)
                if first >= last:
                    continue
                if _draw_triangle(
                    edges, weights, edge_count, first, last, body, count, kept, table.whole, nearness, triangle
                ):
                    _write_attributes(scene, textures, pose, body, face, weights, table, count)
                    count += 1
    return count


@njit(cache=True, forceinline=True, fastmath={"contract"})
def _draw_triangle(
    edges: NDArray[np.float64],
    weights: NDArray[np.float64],
    edge_count: int,
    first_row: int,
    last_row: int,
    body: int,
    index: int,
    kept: int,
    whole: NDArray[np.int32],
    nearness: NDArray[np.float32],
    triangle: NDArray[np.int32],
) -> bool:
    """Write a triangle's nearness ``sum_i e_i`` (g = 1) and its ``index`` where it exceeds ``nearness``. Return whether
    it may be nearest in any pixel.

    Args:
        kept: triangles below this index were drawn out of turn, before bodies of lower index.
        whole: of the triangle table.
    """
    width = nearness.shape[1]
    new = np.int32(index)
    per_column = np.float32(weights[0, 0] + weights[1, 0] + weights[2, 0])
    per_row = weights[0, 1] + weights[1, 1] + weights[2, 1]
    constant = weights[0, 2] + weights[1, 2] + weights[2, 2]
    drawn = False
    for row in range(first_row, last_row):
        left, right = row_span(edges, edge_count, row, width)
        if left >= right:
            continue
        base = np.float32(constant + per_row * row)
        if kept > NOTHING + 1:
            drawn |= _break_ties(base, per_column, left, right, body, new, kept, whole, nearness[row], triangle[row])
        if right - left >= SHORT:
            drawn = True
            _fill_span(base, per_column, np.uint64(left), np.uint64(right), new, nearness[row], triangle[row])
            continue
        for column in range(np.uint64(left), np.uint64(right)):
            value = base + per_column * np.float32(np.int32(column))
            old = nearness[row, column]
            nearer = value > old
            nearness[row, column] = value if nearer else old
            triangle[row, column] = new if nearer else triangle[row, column]
            drawn |= nearer
    return drawn


@njit(cache=True, fastmath={"contract"})
def _break_ties(
    base: np.float32,
    per_column: np.float32,
    first: int,
    last: int,
    body: int,
    new: np.int32,
    kept: int,
    whole: NDArray[np.int32],
    nearness: NDArray[np.float32],
    triangle: NDArray[np.int32],
) -> bool:
    """Give pixels of a row to a triangle that is as near as the kept one of a body with a higher index; return whether
    there are any.
    """
    ties = np.int32(0)
    for column in range(np.uint64(first), np.uint64(last)):
        ties += np.int32(base + per_column * np.float32(np.int32(column)) == nearness[column])
    if ties == np.int32(0):
        return False
    drawn = False
    for column in range(np.uint64(first), np.uint64(last)):
        if base + per_column * np.float32(np.int32(column)) == nearness[column]:
            old = triangle[column]
            if old < kept and whole[old, BODY] > body:
                triangle[column] = new
                drawn = True
    return drawn


@njit(cache=True, forceinline=True, fastmath={"contract"})
def _fill_span(
    base: np.float32,
    per_column: np.float32,
    first: np.uint64,
    last: np.uint64,
    new: np.int32,
    nearness: NDArray[np.float32],
    triangle: NDArray[np.int32],
) -> None:
    """``_draw_triangle`` for one row, in a form that becomes vector code."""
    for column in range(first, last):
        value = base + per_column * np.float32(np.int32(column))
        old = nearness[column]
        nearer = value > old
        nearness[column] = value if nearer else old
        triangle[column] = new if nearer else triangle[column]


@njit(cache=True)
def _determinant(m: NDArray[np.float64]) -> float:
    return (
        m[0, 0] * (m[1, 1] * m[2, 2] - m[1, 2] * m[2, 1])
        - m[0, 1] * (m[1, 0] * m[2, 2] - m[1, 2] * m[2, 0])
        + m[0, 2] * (m[1, 0] * m[2, 1] - m[1, 1] * m[2, 0])
    )


@njit(cache=True, inline="always")
def _write_attributes(
    scene: SceneArrays,
    textures: TexturePool,
    pose: NDArray[np.float64],
    body: int,
    face: int,
    weights: NDArray[np.float64],
    table: TriangleTable,
    index: int,
) -> None:
    """Write a row of the table, with the planes ``sum_i a_i e_i`` of texture position and normal."""
    whole, real, sides = table.whole[index], table.real[index], table.sides[index]
    for i in range(3):
        scale = 1.0 / max(abs(weights[i, 0]), abs(weights[i, 1]), 1e-300)
        for k in range(3):
            sides[3 * i + k] = scale * weights[i, k]
    t = scene.texture[body]
    width, height = textures.last[t, 0, 0] + 1.0, textures.last[t, 0, 1] + 1.0
    flat = scene.face_is_flat[face]
    whole[BODY], whole[TEXTURE] = body, t
    whole[IS_SMOOTH], whole[IS_FLAT] = textures.smooth[t], flat
    for c in range(2):
        size = width if c == 0 else height
        for k in range(3):
            total = 0.0
            for i in range(3):
                total += scene.uv[scene.faces[face, i], c] * weights[i, k]
            real[U + 3 * c + k] = size * total
    i, j, k = scene.faces[face, 0], scene.faces[face, 1], scene.faces[face, 2]
    uv_area = (scene.uv[j, 0] - scene.uv[i, 0]) * (scene.uv[k, 1] - scene.uv[i, 1])
    uv_area -= (scene.uv[k, 0] - scene.uv[i, 0]) * (scene.uv[j, 1] - scene.uv[i, 1])
    real[TEXEL_DENSITY] = abs(uv_area * _determinant(weights)) * width * height
    for c in range(3):
        for k in range(3):
            real[NX + 3 * c + k] = 0.0
        for i in range(1 if flat else 3):
            vertex = scene.faces[face, i]
            component = 0.0
            for m in range(3):
                component += pose[c, m] * scene.normals[vertex, m]
            if flat:
                real[NX + 3 * c + 2] = component
            else:
                for k in range(3):
                    real[NX + 3 * c + k] += component * weights[i, k]
