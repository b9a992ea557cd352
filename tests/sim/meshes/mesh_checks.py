"""What every mesh must hold to."""

from __future__ import annotations

import numpy as np
import trimesh
from numpy.typing import NDArray

from sim.mesh import TexturedMesh


def welded(mesh: TexturedMesh) -> trimesh.Trimesh:
    """Return the shape with corners at the same place made one."""
    shape = trimesh.Trimesh(mesh.vertices_m, mesh.faces, process=False)
    shape.merge_vertices(merge_tex=True, merge_norm=True, digits_vertex=4)
    return shape


def parts(mesh: TexturedMesh) -> list[trimesh.Trimesh]:
    return list(welded(mesh).split(only_watertight=False))


def require_sound(mesh: TexturedMesh) -> None:
    """Types, ranges, and normals that are those of the faces."""
    assert (mesh.vertices_m.dtype, mesh.normals.dtype, mesh.uv.dtype) == (np.float32,) * 3
    assert mesh.faces.dtype == np.int32
    assert len(mesh.vertices_m) == len(mesh.normals) == len(mesh.uv)
    assert mesh.uv.min() >= 0.0
    assert mesh.uv.max() <= 1.0
    a, b, c = np.moveaxis(mesh.vertices_m[mesh.faces].astype(float), 1, 0)
    area = np.cross(b - a, c - a)
    doubled = np.linalg.norm(area, axis=1)
    assert doubled.min() > 1e-6
    for corner in range(3):
        cosine = (mesh.normals[mesh.faces[:, corner]] * area).sum(axis=1) / doubled
        assert cosine.min() > 0.999


def require_closed(mesh: TexturedMesh) -> None:
    """Every edge is walked as often one way as the other, and every part holds a volume, not a hollow."""
    faces = np.asarray(welded(mesh).faces)
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    there = {tuple(e): n for e, n in zip(*np.unique(edges, axis=0, return_counts=True), strict=True)}
    assert all(there.get(edge[::-1]) == n for edge, n in there.items())
    assert min(part.volume for part in parts(mesh)) > 0.0


def texels(mesh: TexturedMesh) -> NDArray[np.uint8]:
    """Return the colour (F, 3) that nearest sampling finds in the middle of every face."""
    rows, columns = mesh.texture.rgb.shape[:2]
    u, v = mesh.uv[mesh.faces].mean(axis=1).T
    return mesh.texture.rgb[(v * rows).astype(int), (u * columns).astype(int)]
