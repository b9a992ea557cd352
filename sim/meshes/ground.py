"""Meshes of a town's square ground, the fields around it, and kerbs."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from sim.checks import check
from sim.mesh import Texture, TexturedMesh
from sim.meshes.facets import Facets, palette, swatch_uv

CELLS = 8
"""Quads along a square's side: small enough triangles for clipping at the near plane."""

KERB_TOLERANCE_M = 0.03
"""Greatest deviation of a kerb from its polyline, to save triangles."""


def ground(extent_m: float, texture: Texture) -> TexturedMesh:
    """Return a flat square at z = 0, centred on the origin, facing up.

    Args:
        extent_m: its side, > 0.
        texture: covers it once; its top left corner lies at (-extent / 2, +extent / 2), its top edge along +x.
    """
    _require_positive("extent_m", extent_m)
    facets = Facets()
    _add_square(facets, (0.0, 0.0), extent_m, CELLS, mirrored=(False, False))
    return facets.mesh(texture)


Height = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]
"""Height of the land in metres at places x and y."""


def surroundings(extent_m: float, outer_m: float, texture: Texture, height_m: Height) -> TexturedMesh:
    """Return land around a square ground: tiles of its size on all sides, without the ground itself.

    Neighbouring tiles are mirror images, so that the texture runs on over their edges.

    Args:
        extent_m: side of the ground, and of a tile, > 0.
        outer_m: the land reaches at least to a square of this side, > extent_m.
        texture: covers one tile.
        height_m: of the land, 0 on the ground's edge.
    """
    _require_positive("extent_m", extent_m)
    if not outer_m > extent_m:
        raise ValueError(f"outer_m: expected more than extent_m = {extent_m}, got {outer_m}")
    reach = int(np.ceil((outer_m - extent_m) / (2.0 * extent_m)))
    facets = Facets()
    for i in range(-reach, reach + 1):
        for j in range(-reach, reach + 1):
            if (i, j) != (0, 0):
                centre = (i * extent_m, j * extent_m)
                _add_square(facets, centre, extent_m, CELLS // 2, mirrored=(i % 2 == 1, j % 2 == 1))
    return _raised(facets.mesh(texture), height_m)


def _raised(flat: TexturedMesh, height_m: Height) -> TexturedMesh:
    """Return flat land with heights, and with the normals of the slopes."""
    x, y = flat.vertices_m[:, 0].astype(float), flat.vertices_m[:, 1].astype(float)
    east, north = (height_m(x + dx, y + dy) - height_m(x - dx, y - dy) for dx, dy in ((0.5, 0.0), (0.0, 0.5)))
    normals = np.column_stack([-east, -north, np.ones_like(x)])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    vertices_m = np.column_stack([x, y, height_m(x, y)])
    return replace(flat, vertices_m=vertices_m.astype(np.float32), normals=normals.astype(np.float32))


def kerb(
    polyline_m: NDArray[np.float64], width_m: float, height_m: float, rgb: tuple[int, int, int], *, bevel_m: float
) -> TexturedMesh:
    """Return a low strip of stone along a polyline (n, 2), open below and at its ends; n >= 2 distinct points.

    Args:
        bevel_m: width of each sloping side, seen from above.

    Raises:
        ValueError: if there are fewer than two points, a size is not positive, or the bevels leave no top.
    """
    _require_positive("width_m", width_m)
    _require_positive("height_m", height_m)
    check("bevel_m", 0.0 < bevel_m < 0.5 * width_m, f"a length in (0, {0.5 * width_m:g}) m", bevel_m)
    points = np.asarray(polyline_m, dtype=float)
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < 2:
        raise ValueError(f"polyline_m: expected at least two points (n, 2), got shape {points.shape}")
    points = _simplified(points)
    normals, foot_m, top_m = _mitred_normals(points), 0.5 * width_m, 0.5 * width_m - bevel_m
    rings = np.zeros((len(points), 4, 3))
    # Up the left side, over to the right one and down; the face back along the ground is left out.
    for k, (aside_m, height) in enumerate([(foot_m, 0.0), (top_m, height_m), (-top_m, height_m), (-foot_m, 0.0)]):
        rings[:, k, :2] = points + normals * aside_m
        rings[:, k, 2] = height
    stone = swatch_uv(0, 1)
    facets = Facets()
    facets.loft(rings, lambda segment, k: None if k == 3 else stone, None, None)
    return facets.mesh(palette([rgb]))


def _add_square(
    facets: Facets, centre_m: tuple[float, float], side_m: float, cells: int, mirrored: tuple[bool, bool]
) -> None:
    steps = np.linspace(0.0, 1.0, cells + 1)
    for u0, u1 in itertools.pairwise(steps):
        for v0, v1 in itertools.pairwise(steps):
            corners = np.array([(u0, v1), (u1, v1), (u1, v0), (u0, v0)])
            places = np.zeros((4, 3))
            places[:, 0] = centre_m[0] + (corners[:, 0] - 0.5) * side_m
            places[:, 1] = centre_m[1] + (0.5 - corners[:, 1]) * side_m
            facets.polygon(places, np.where(mirrored, 1.0 - corners, corners))


def _simplified(points_m: NDArray[np.float64]) -> NDArray[np.float64]:
    kept = cv2.approxPolyDP(points_m.astype(np.float32)[:, None], KERB_TOLERANCE_M, closed=False)
    return np.asarray(kept[:, 0], dtype=float)


def _mitred_normals(points_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (n, 2) vectors to the left, long enough that offset edges stay parallel to the line (at most 2)."""
    ahead = np.diff(points_m, axis=0)
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    normals = np.column_stack([-ahead[:, 1], ahead[:, 0]])
    before = np.concatenate([normals[:1], normals])
    after = np.concatenate([normals, normals[-1:]])
    # |before + after| = 2 cos(half the turn), and the mitre is 1 / cos(half the turn) long.
    total = before + after
    return 2.0 * total / np.maximum((total**2).sum(axis=1, keepdims=True), 1.0)


def _require_positive(name: str, value: float) -> None:
    if not value > 0:
        raise ValueError(f"{name}: expected a length > 0 m, got {value}")
