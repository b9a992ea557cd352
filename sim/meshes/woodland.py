"""Woods and hedges seen from afar: closed canopies of few triangles with a foliage texture."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from sim.checks import check
from sim.mesh import Texture, TexturedMesh
from sim.meshes.facets import Facets
from sim.meshes.ground import Height

_SIDES, _RINGS = 14, ((1.0, 0.0), (1.04, 0.55), (0.9, 0.9), (0.55, 1.0))
"""Outline of a wood, and its rings: share of its radius, share of its height."""
_TEXELS, _TEXEL_M = 128, 0.5
_SUNK_M = 1.0
"""Depth of feet in the ground, so that none floats on a slope."""


def wood(
    centre_m: NDArray[np.float64],
    radius_m: float,
    height_m: float,
    foliage_rgb: tuple[int, int, int],
    land_m: Height,
    rng: np.random.Generator,
) -> TexturedMesh:
    """Return a wood of about 110 triangles around a place (2,), in the world frame."""
    check("radius_m", radius_m > 0, "a length > 0 m", radius_m)
    check("height_m", height_m > 0, "a length > 0 m", height_m)
    angles = np.arange(_SIDES) * (2.0 * np.pi / _SIDES)
    reach_m = radius_m * rng.uniform(0.7, 1.25, _SIDES) * (1.0 + 0.3 * np.cos(2.0 * angles + rng.uniform(0.0, 6.3)))
    points = []
    for share, up in _RINGS:
        wobble = 1.0 + rng.normal(0.0, 0.04, _SIDES)
        x = centre_m[0] + share * wobble * reach_m * np.cos(angles)
        y = centre_m[1] + share * wobble * reach_m * np.sin(angles)
        rise = height_m * up * (1.0 + rng.normal(0.0, 0.08, _SIDES)) if up else -_SUNK_M
        points.append(np.column_stack([x, y, land_m(x, y) + rise]))
    top = np.array([*centre_m, float(land_m(*centre_m)) + height_m * rng.uniform(0.95, 1.1)])
    facets = Facets()
    for low, high in pairwise(points):
        for k in range(_SIDES):
            after = (k + 1) % _SIDES
            _add_triangle(facets, low[k], low[after], high[after])
            _add_triangle(facets, low[k], high[after], high[k])
    for k in range(_SIDES):
        _add_triangle(facets, points[-1][k], points[-1][(k + 1) % _SIDES], top)
    return _rounded(facets.mesh(_canopy(foliage_rgb)), top, radius_m, height_m)


def _rounded(flat: TexturedMesh, top: NDArray[np.float64], radius_m: float, height_m: float) -> TexturedMesh:
    """Return a wood with the normals of a dome, so that its faces do not show."""
    outward = (flat.vertices_m - top + (0.0, 0.0, height_m)) / (radius_m, radius_m, height_m)
    outward[:, 2] = np.maximum(outward[:, 2], 0.0) + 0.15
    normals = outward / np.linalg.norm(outward, axis=1, keepdims=True)
    return replace(flat, normals=normals.astype(np.float32))


def hedge(
    line_m: NDArray[np.float64], foliage_rgb: tuple[int, int, int], land_m: Height, rng: np.random.Generator
) -> TexturedMesh:
    """Return a hedge along a polyline (n, 2), 2 to 4 m high, in the world frame."""
    along = np.gradient(line_m, axis=0)
    left = np.column_stack([-along[:, 1], along[:, 0]]) / np.linalg.norm(along, axis=1, keepdims=True)
    half_m = rng.uniform(0.8, 1.6, (len(line_m), 1))
    height_m = rng.uniform(1.8, 4.0, len(line_m))
    profile = ((1.0, -_SUNK_M, 0.0), (0.8, 0.0, 0.8), (0.0, 0.0, 1.0), (-0.8, 0.0, 0.8), (-1.0, -_SUNK_M, 0.0))
    rows = []
    for aside, below_m, up in profile:
        place = line_m + aside * half_m * left
        rows.append(np.column_stack([place, land_m(place[:, 0], place[:, 1]) + below_m + up * height_m]))
    facets = Facets()
    for outer, inner in pairwise(rows):
        for k in range(len(line_m) - 1):
            _add_triangle(facets, outer[k], inner[k], inner[k + 1])
            _add_triangle(facets, outer[k], inner[k + 1], outer[k + 1])
    for end, turn in ((0, 1), (-1, -1)):
        corners = [row[end] for row in rows][::turn]
        for a, b in pairwise(corners[1:]):
            _add_triangle(facets, corners[0], b, a)
    return facets.mesh(_canopy(foliage_rgb))


def _add_triangle(facets: Facets, a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64]) -> None:
    """Add a triangle with a piece of foliage in true size, or the whole of it where the triangle is larger."""
    corners = np.stack([a, b, c])
    flat = np.column_stack([corners[:, 0] + 0.37 * corners[:, 2], corners[:, 1] + 0.71 * corners[:, 2]])
    flat = (flat - flat.min(axis=0)) / (_TEXELS * _TEXEL_M)
    facets.polygon(corners, flat / max(1.0, float(flat.max())))


@cache
def _canopy(foliage_rgb: tuple[int, int, int]) -> Texture:
    """Return crowns from above: light tops, dark gaps; the same one every time."""
    rng = np.random.Generator(np.random.PCG64(sum(foliage_rgb)))
    crowns = cv2.resize(rng.normal(size=(22, 22)), (_TEXELS, _TEXELS), interpolation=cv2.INTER_CUBIC)
    leaves = rng.normal(size=(_TEXELS, _TEXELS))
    light = np.clip(0.92 + 0.2 * crowns + 0.1 * leaves, 0.35, 1.5)
    return Texture(np.clip(np.array(foliage_rgb) * light[..., None], 0, 255).astype(np.uint8), smooth=True)
