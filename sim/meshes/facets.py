"""Building flat-shaded meshes out of coloured polygons, boxes and lofts."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sim.mesh import Texture, TexturedMesh


class Facets:
    """A mesh in the making: flat faces, each with its own vertices.

    Wherever a method takes ``uv`` it may be (2,), one colour for the whole face (the centre of a palette's swatch),
    or one row (n, 2) for each corner.
    """

    def __init__(self) -> None:
        self._vertices_m: list[NDArray[np.float64]] = []
        self._normals: list[NDArray[np.float64]] = []
        self._uv: list[NDArray[np.float64]] = []
        self._faces: list[NDArray[np.int32]] = []
        self._vertex_count = 0

    def polygon(self, corners_m: ArrayLike, uv: ArrayLike) -> None:
        """Add one plane convex polygon (n, 3), its corners counter-clockwise seen from outside.

        Corners that coincide with the one before them are left out; what has no area is not added.
        """
        corners = np.asarray(corners_m, dtype=float)
        colours = np.broadcast_to(np.asarray(uv, dtype=float), (len(corners), 2))
        distinct = np.linalg.norm(corners - corners[np.arange(-1, len(corners) - 1)], axis=1) > 1e-6
        corners, colours = corners[distinct], colours[distinct]
        if len(corners) < 3:
            return
        area = _twice_area(corners)
        length = np.linalg.norm(area)
        if length < 1e-9:
            return
        if len(corners) > 4:
            start = _best_fan_start(corners)
            corners, colours = np.roll(corners, -start, axis=0), np.roll(colours, -start, axis=0)
        fan = np.arange(1, len(corners) - 1)
        self._faces.append((self._vertex_count + np.column_stack([np.zeros_like(fan), fan, fan + 1])).astype(np.int32))
        self._vertices_m.append(corners)
        self._normals.append(np.broadcast_to(area / length, corners.shape))
        self._uv.append(colours)
        self._vertex_count += len(corners)

    def quad(self, corners_m: ArrayLike, uv: ArrayLike) -> None:
        """Add four corners (4, 3) that need not lie in one plane: one face, or two triangles."""
        corners = np.asarray(corners_m, dtype=float)
        colours = np.broadcast_to(np.asarray(uv, dtype=float), (4, 2))
        normal = _twice_area(corners)
        warp_m = abs(normal @ (corners[1] - corners[0])) / max(float(np.linalg.norm(normal)), 1e-12)
        if warp_m < 1e-3:
            self.polygon(corners, colours)
        else:
            for triangle in ([0, 1, 2], [0, 2, 3]):
                self.polygon(corners[triangle], colours[triangle])

    def box(self, low_m: ArrayLike, high_m: ArrayLike, uv: ArrayLike) -> None:
        """Add an axis-aligned box between two opposite corners (3,), in one colour."""
        (x0, y0, z0), (x1, y1, z1) = np.asarray(low_m, dtype=float), np.asarray(high_m, dtype=float)
        outline = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
        self.loft([[(*p, z) for p in outline] for z in (z0, z1)], lambda segment, side: uv, uv, uv)

    def loft(
        self,
        rings_m: ArrayLike,
        side_uv: Callable[[int, int], ArrayLike | None],
        first_uv: ArrayLike | None,
        last_uv: ArrayLike | None,
    ) -> None:
        """Add a skin over rings (S, P, 3), closed by the first and last ring where these have a colour.

        Rings run counter-clockwise for somebody whom the following rings come towards.

        Args:
            side_uv: colour of the face between rings ``segment`` and ``segment + 1`` and between their points
                ``side`` and ``side + 1``, None to leave it out; (4, 2) corners go round counter-clockwise from
                the first of these.
            first_uv, last_uv: colours of the end faces, which must be convex; None leaves an end open.
        """
        rings = np.asarray(rings_m, dtype=float)
        count = rings.shape[1]
        for segment in range(len(rings) - 1):
            for side in range(count):
                after = (side + 1) % count
                near, far = rings[segment], rings[segment + 1]
                uv = side_uv(segment, side)
                if uv is not None:
                    self.quad([near[side], near[after], far[after], far[side]], uv)
        if first_uv is not None:
            self.polygon(rings[0, ::-1], first_uv)
        if last_uv is not None:
            self.polygon(rings[-1], last_uv)

    def mesh(self, texture: Texture) -> TexturedMesh:
        """Return what was added so far."""
        return TexturedMesh(
            np.concatenate(self._vertices_m).astype(np.float32),
            np.concatenate(self._normals).astype(np.float32),
            np.concatenate(self._uv).astype(np.float32),
            np.concatenate(self._faces),
            texture,
        )


def _best_fan_start(corners_m: NDArray[np.float64]) -> int:
    """Return the corner from which a fan's smallest triangle is largest (corners may lie on straight sides)."""
    smallest = []
    for start in range(len(corners_m)):
        spokes = np.roll(corners_m, -start, axis=0)[1:] - corners_m[start]
        smallest.append(np.linalg.norm(np.cross(spokes[:-1], spokes[1:]), axis=1).min())
    return int(np.argmax(smallest))


def _twice_area(corners_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return twice the area of a polygon (n, 3) as a vector (3,) along its normal (Newell's method)."""
    x, y, z = corners_m.T
    after = np.arange(1 - len(corners_m), 1)
    return np.array([y @ z[after] - z @ y[after], z @ x[after] - x @ z[after], x @ y[after] - y @ x[after]])


def palette(colours_rgb: Sequence[tuple[int, int, int]]) -> Texture:
    """Return a texture of one square swatch a colour, side by side; ``swatch_uv`` says where their centres are."""
    row = np.asarray(colours_rgb, dtype=np.uint8)[None]
    return Texture(np.ascontiguousarray(np.repeat(np.repeat(row, SWATCH_TEXELS, axis=0), SWATCH_TEXELS, axis=1)))


def swatch_uv(index: int, count: int) -> tuple[float, float]:
    """Return the centre of swatch ``index`` of a palette of ``count`` colours."""
    return ((index + 0.5) / count, 0.5)


SWATCH_TEXELS = 4
"""Side of a swatch: nearest sampling at its centre is then two texels away from the next colour."""
