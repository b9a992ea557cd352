"""Meshes and textures of plane panels: plaster, floor, paper."""

from __future__ import annotations

from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from sim.mesh import Texture, TexturedMesh
from sim.meshes.facets import Facets

RGB = tuple[int, int, int]
_CELL_M = 2.0
"""Side of the cells into which panels are cut: TinyRenderer draws no triangle that reaches behind the camera."""
_GRAIN_TEXELS = 256


Window = tuple[float, float, float, float]
"""Part of a texture: left, lower, right and upper edge as shares of its width and height, from the lower left."""
WHOLE: Window = (0.0, 0.0, 1.0, 1.0)


def panel(
    corner_m: ArrayLike, side_a_m: ArrayLike, side_b_m: ArrayLike, texture: Texture, window: Window = WHOLE
) -> TexturedMesh:
    """Return a rectangle that faces ``side_a x side_b``; the window's lower left corner lies at ``corner_m``.

    Args:
        corner_m, side_a_m, side_b_m: (3,) one corner and the two sides that begin there.
        window: part of the texture that covers the rectangle.
    """
    left, low, right, high = window
    corner, a, b = (np.asarray(each, dtype=float) for each in (corner_m, side_a_m, side_b_m))
    steps_a, steps_b = (
        np.linspace(0.0, 1.0, int(np.ceil(np.linalg.norm(side) / _CELL_M - 1e-9)) + 1) for side in (a, b)
    )
    facets = Facets()
    for u0, u1 in pairwise(steps_a):
        for v0, v1 in pairwise(steps_b):
            at = np.array([(u0, v0), (u1, v0), (u1, v1), (u0, v1)])
            u, v = left + (right - left) * at[:, 0], low + (high - low) * at[:, 1]
            facets.polygon(corner + at @ np.stack([a, b]), np.column_stack([u, 1.0 - v]))
    return facets.mesh(texture)


def plain(rgb: RGB) -> Texture:
    """Return a texture of one colour."""
    return Texture(np.full((4, 4, 3), rgb, np.uint8))


def grained(rgb: RGB, rng: np.random.Generator) -> Texture:
    """Return a texture of one colour with slight fine and coarse grain: paper, plaster, linoleum."""
    fine, coarse = rng.normal(size=(2, _GRAIN_TEXELS, _GRAIN_TEXELS)).astype(np.float32)
    clouds: NDArray[np.float32] = cv2.GaussianBlur(coarse, (0, 0), _GRAIN_TEXELS / 16).astype(np.float32)
    grain = 1.0 + 0.012 * fine + 0.015 * clouds / clouds.std()
    return Texture(np.clip(np.array(rgb) * grain[..., None] + 0.5, 0, 255).astype(np.uint8), smooth=True)
