"""Construction of flat-shaded meshes from coloured polygons, boxes and lofts."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sim.mesh import Texture, TexturedMesh

_Row = list[float]


class Facets:
    """Builder of a mesh of flat faces, each with its own vertices.

    Wherever a method takes ``uv`` it may be (2,), one colour for the whole face (the centre of a palette's swatch),
    or one row (n, 2) for each corner.
    """

    def __init__(self) -> None:
        self._vertices_m: list[_Row] = []
        self._normals: list[_Row] = []
        self._uv: list[_Row] = []
        self._faces: list[tuple[int, int, int]] = []

    def polygon(self, corners_m: ArrayLike, uv: ArrayLike) -> None:
        """Add one plane convex polygon (n, 3), its corners counter-clockwise seen from outside.

        Corners that coincide with the one before and polygons without area are left out.
        """
        corners: list[_Row] = np.asarray(corners_m, dtype=float).tolist()
        self._add_polygon(corners, _rows(uv, len(corners)))

    def _add_quad(self, corners: list[_Row], uv: ArrayLike) -> None:
        """Add four corners that need not lie in one plane: one face, or two triangles."""
        colours = _rows(uv, 4)
        normal, (a, b) = _twice_area(corners), corners[:2]
        rise = abs(sum(n * (q - p) for n, p, q in zip(normal, a, b, strict=True)))
        if rise / max(math.hypot(*normal), 1e-12) < 1e-3:
            self._add_polygon(corners, colours)
        else:
            for triangle in ((0, 1, 2), (0, 2, 3)):
                self._add_polygon([corners[k] for k in triangle], [colours[k] for k in triangle])

    def _add_polygon(self, corners: list[_Row], colours: list[_Row]) -> None:
        # In plain floats: a town has thirty thousand faces, and arrays of four rows take five times as long.
        distinct = [math.dist(corner, corners[k - 1]) > 1e-6 for k, corner in enumerate(corners)]
        if not all(distinct):
            corners = [corner for corner, kept in zip(corners, distinct, strict=True) if kept]
            colours = [colour for colour, kept in zip(colours, distinct, strict=True) if kept]
        if len(corners) < 3:
            return
        area = np.array(_twice_area(corners))
        length = math.sqrt(area @ area)
        if length < 1e-9:
            return
        if len(corners) > 4:
            start = _best_fan_start(np.array(corners))
            corners, colours = corners[start:] + corners[:start], colours[start:] + colours[:start]
        first, count = len(self._vertices_m), len(corners)
        self._faces += [(first, first + k, first + k + 1) for k in range(1, count - 1)]
        self._vertices_m += corners
        self._normals += [(area / length).tolist()] * count
        self._uv += colours

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

        Rings run counter-clockwise as seen from ahead, where the following rings lie.

        Args:
            side_uv: colour of the face between rings ``segment`` and ``segment + 1`` and between their points
                ``side`` and ``side + 1``, None to leave it out; (4, 2) corners go round counter-clockwise from
                the first of these.
            first_uv, last_uv: colours of the end faces, which must be convex; None leaves an end open.
        """
        rings: list[list[_Row]] = np.asarray(rings_m, dtype=float).tolist()
        count = len(rings[0])
        for segment in range(len(rings) - 1):
            for side in range(count):
                after = (side + 1) % count
                near, far = rings[segment], rings[segment + 1]
                uv = side_uv(segment, side)
                if uv is not None:
                    self._add_quad([near[side], near[after], far[after], far[side]], uv)
        if first_uv is not None:
            self.polygon(rings[0][::-1], first_uv)
        if last_uv is not None:
            self.polygon(rings[-1], last_uv)

    def mesh(self, texture: Texture) -> TexturedMesh:
        """Return the mesh of all faces so far."""
        return TexturedMesh(
            np.array(self._vertices_m, dtype=float).astype(np.float32),
            np.array(self._normals, dtype=float).astype(np.float32),
            np.array(self._uv, dtype=float).astype(np.float32),
            np.array(self._faces, dtype=np.int32),
            texture,
        )


def _best_fan_start(corners_m: NDArray[np.float64]) -> int:
    """Return the corner from which a fan's smallest triangle is largest (corners may lie on straight sides)."""
    smallest = []
    for start in range(len(corners_m)):
        spokes = np.roll(corners_m, -start, axis=0)[1:] - corners_m[start]
        smallest.append(np.linalg.norm(np.cross(spokes[:-1], spokes[1:]), axis=1).min())
    return int(np.argmax(smallest))


def _twice_area(corners_m: list[_Row]) -> list[float]:
    """Return twice the area of a polygon as a vector along its normal (Newell's method)."""
    if len(corners_m) != 4:
        x, y, z = np.array(corners_m).T
        after = np.arange(1 - len(corners_m), 1)
        return [y @ z[after] - z @ y[after], z @ x[after] - x @ z[after], x @ y[after] - y @ x[after]]
    # Nearly all have four corners. The order of the sum is that of the products above, so that the bits are equal.
    (x0, y0, z0), (x1, y1, z1), (x2, y2, z2), (x3, y3, z3) = corners_m
    return [
        ((y0 * z1 + y2 * z3) + (y1 * z2 + y3 * z0)) - ((z0 * y1 + z2 * y3) + (z1 * y2 + z3 * y0)),
        ((z0 * x1 + z2 * x3) + (z1 * x2 + z3 * x0)) - ((x0 * z1 + x2 * z3) + (x1 * z2 + x3 * z0)),
        ((x0 * y1 + x2 * y3) + (x1 * y2 + x3 * y0)) - ((y0 * x1 + y2 * x3) + (y1 * x2 + y3 * x0)),
    ]


def _rows(uv: ArrayLike, count: int) -> list[_Row]:
    """Return a colour for each of ``count`` corners."""
    if isinstance(uv, tuple) and isinstance(uv[0], float):
        return [list(uv)] * count
    rows: list[_Row] = np.broadcast_to(np.asarray(uv, dtype=float), (count, 2)).tolist()
    return rows


def palette(colours_rgb: Sequence[tuple[int, int, int]]) -> Texture:
    """Return a texture of one square swatch a colour, side by side; ``swatch_uv`` says where their centres are."""
    row = np.asarray(colours_rgb, dtype=np.uint8)[None]
    return Texture(np.ascontiguousarray(np.repeat(np.repeat(row, SWATCH_TEXELS, axis=0), SWATCH_TEXELS, axis=1)))


def swatch_uv(index: int, count: int) -> tuple[float, float]:
    """Return the centre of swatch ``index`` of a palette of ``count`` colours."""
    return ((index + 0.5) / count, 0.5)


SWATCH_TEXELS = 4
"""Side of a swatch: nearest sampling at its centre is then two texels away from the next colour."""


def painted_box(size_m: tuple[float, float, float], rgb: tuple[int, int, int]) -> TexturedMesh:
    """Return a box of one colour (sRGB, 0-255) whose lower side is centred on the origin."""
    facets = Facets()
    x_m, y_m, z_m = size_m
    facets.box((-x_m / 2, -y_m / 2, 0.0), (x_m / 2, y_m / 2, z_m), swatch_uv(0, 1))
    return facets.mesh(palette([rgb]))
