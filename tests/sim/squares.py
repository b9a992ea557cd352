"""Squares and boxes to put into worlds."""

from __future__ import annotations

from typing import Any

import numpy as np
import trimesh

from sim.mesh import Texture, TexturedMesh


def square(side_m: float, rgb: Any) -> TexturedMesh:
    """Return a level square of one colour."""
    corners = 0.5 * side_m * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], dtype=np.float32)
    return TexturedMesh(
        corners,
        np.tile(np.array([0, 0, 1], dtype=np.float32), (4, 1)),
        np.array([[0, 1], [1, 1], [1, 0], [0, 0]], dtype=np.float32),
        np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32),
        Texture(np.full((4, 4, 3), rgb, dtype=np.uint8)),
    )


def block(size_m: tuple[float, float, float], rgb: Any = (200, 30, 30)) -> TexturedMesh:
    """Return a box of one colour that stands on its origin."""
    shape = trimesh.creation.box(size_m)
    corners = shape.triangles.reshape(-1, 3) + np.array([0, 0, 0.5 * size_m[2]])
    return TexturedMesh(
        corners.astype(np.float32),
        np.repeat(shape.face_normals, 3, axis=0).astype(np.float32),
        np.full((len(corners), 2), 0.5, np.float32),
        np.arange(len(corners), dtype=np.int32).reshape(-1, 3),
        Texture(np.full((4, 4, 3), rgb, dtype=np.uint8)),
    )
