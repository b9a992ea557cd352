"""Textured triangle meshes, the one kind of shape that bodies are made of."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Texture:
    """A picture that colours surfaces.

    Attributes:
        rgb: (h, w, 3) uint8, sRGB encoded.
        smooth: True for pictures (mip-mapped and interpolated by ``raster``), False for palettes whose texels
            are separate colours.
    """

    rgb: NDArray[np.uint8]
    smooth: bool = False


@dataclass(frozen=True, eq=False)
class TexturedMesh:
    """Triangles with one texture, in the body frame.

    Vertices are not shared between faces that differ in normal or colour (flat shading, crisp palettes).

    Attributes:
        vertices_m: (V, 3) float32.
        normals: (V, 3) float32 unit vectors, outward.
        uv: (V, 2) float32 in [0, 1]; (0, 0) is the *top left* corner of the texture picture, v grows downwards.
        faces: (F, 3) int32, counter-clockwise seen from outside.
        texture: shared between meshes where it can be.
    """

    vertices_m: NDArray[np.float32]
    normals: NDArray[np.float32]
    uv: NDArray[np.float32]
    faces: NDArray[np.int32]
    texture: Texture = field(repr=False)

    def with_texture(self, texture: Texture) -> TexturedMesh:
        """Return the same geometry in other colours."""
        return TexturedMesh(self.vertices_m, self.normals, self.uv, self.faces, texture)

    @property
    def size_m(self) -> NDArray[np.float32]:
        """Extent (3,) of the axis-aligned bounds in the body frame."""
        return np.ptp(self.vertices_m, axis=0)

    @property
    def bounds_m(self) -> NDArray[np.float64]:
        """Least and greatest x, y, z (2, 3) of the vertices in the body frame."""
        return np.stack([self.vertices_m.min(axis=0), self.vertices_m.max(axis=0)]).astype(float)
