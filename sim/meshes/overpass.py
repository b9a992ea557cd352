"""Ways over a street: decks with their pavement, piers, stairs, embankments, and covers with grass on them.

Frames: x along the deck, y across it, z up from the street.
"""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from typing import Literal

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from sim.checks import check, check_choice
from sim.mesh import Texture, TexturedMesh
from sim.meshes.facets import Facets

Surface = Literal["path", "rail", "road", "grass"]
SURFACES: tuple[Surface, ...] = ("path", "rail", "road", "grass")
TILE_M = 12.0
"""Length of deck that the picture of a surface covers."""
PARAPET_M, _PARAPET_WIDTH_M = 1.0, 0.25
_WALL_M = 0.4
_TEXELS, _SWATCH = 128, 16
_CONCRETE, _SHADED, _STEEL, _EARTH = range(4)


def deck(
    surface: Surface, length_m: float, width_m: float, under_m: float, top_m: float, *, ends: bool = True
) -> TexturedMesh:
    """Return a deck from ``-length / 2`` to ``length / 2`` with parapets, of at most 40 triangles for 12 m.

    Args:
        under_m, top_m: heights of its lower and upper side.
        ends: whether its end faces are there.
    """
    check("length_m", length_m > 0, "a length > 0 m", length_m)
    check("top_m", top_m > under_m, f"more than under_m = {under_m}", top_m)
    facets, half = Facets(), 0.5 * width_m
    _add_surface(facets, -0.5 * length_m, 0.5 * length_m, half, top_m, top_m)
    side, below = _swatch(_CONCRETE), _swatch(_SHADED)
    rail_m, inner = top_m + PARAPET_M, half - _PARAPET_WIDTH_M
    # Round from the lower left edge; the upper side between the parapets is the surface.
    profile = [(-half, under_m), (half, under_m), (half, rail_m), (inner, rail_m), (inner, top_m)]
    profile += [(-inner, top_m), (-inner, rail_m), (-half, rail_m)]
    rings = [[(x, *p) for p in profile] for x in (-0.5 * length_m, 0.5 * length_m)]
    colours = (below, side, side, side, None, side, side, side)
    facets.loft(rings, lambda segment, edge: colours[edge], None, None)
    if ends:
        for x in (-0.5 * length_m, 0.5 * length_m):
            face = [(x, -half, under_m), (x, half, under_m), (x, half, top_m), (x, -half, top_m)]
            _face(facets, face, side, (x, 0.0, 0.0))
            for y0, y1 in ((-half, -inner), (inner, half)):
                end = [(x, y0, top_m), (x, y1, top_m), (x, y1, rail_m), (x, y0, rail_m)]
                _face(facets, end, side, (x, 0.0, 0.0))
    return facets.mesh(surface_texture(surface))


def embankment(
    surface: Surface, length_m: float, width_m: float, start_m: float, end_m: float, *, slope: float = 1.4
) -> TexturedMesh:
    """Return an embankment that begins at x = 0 with height ``start_m`` and ends at ``length_m`` with ``end_m``.

    Args:
        slope: metres aside for each metre down; 0: upright walls.
    """
    facets, half = Facets(), 0.5 * width_m
    _add_surface(facets, 0.0, length_m, half, start_m, end_m)
    earth = _swatch(_EARTH if slope else _CONCRETE)
    for side in (-1.0, 1.0):
        top = [(0.0, side * half, start_m), (length_m, side * half, end_m)]
        foot = [(0.0, side * (half + slope * start_m), 0.0), (length_m, side * (half + slope * end_m), 0.0)]
        _face(facets, [foot[0], foot[1], top[1], top[0]], earth, (0.0, side, 0.0))
    for x, z, ahead in ((0.0, start_m, -1.0), (length_m, end_m, 1.0)):
        wide = half + slope * z
        _face(facets, [(x, -wide, 0.0), (x, wide, 0.0), (x, half, z), (x, -half, z)], earth, (ahead, 0.0, 0.0))
    return facets.mesh(surface_texture(surface))


def pier(width_m: float, height_m: float) -> TexturedMesh:
    """Return two columns under a beam across a deck of ``width_m``, up to ``height_m``."""
    facets, concrete = Facets(), _swatch(_CONCRETE)
    half = 0.5 * width_m
    for y in (-0.55 * half, 0.55 * half):
        facets.box((-0.5, y - 0.5, 0.0), (0.5, y + 0.5, height_m - 0.7), concrete)
    facets.box((-0.6, -0.9 * half, height_m - 0.7), (0.6, 0.9 * half, height_m), concrete)
    return facets.mesh(surface_texture("road"))


def stairs(height_m: float, run_m: float, width_m: float) -> TexturedMesh:
    """Return stairs that fall from ``height_m`` at x = 0 to the ground at ``run_m``, with a landing before them."""
    facets, half = Facets(), 0.5 * width_m
    concrete, steel = _swatch(_CONCRETE), _swatch(_STEEL)
    facets.box((-width_m, -half, height_m - 0.35), (0.0, half, height_m), concrete)
    for x in (-width_m + 0.2, -0.2):
        facets.box((x - 0.15, -0.15, 0.0), (x + 0.15, 0.15, height_m - 0.35), steel)
    profile = [(0.0, height_m - 0.35), (run_m - 0.5, 0.0), (run_m, 0.0), (0.0, height_m)]
    rings = [[(x, y, z) for x, z in profile] for y in (half, -half)]
    steps = _steps_uv()
    colours = (_swatch(_SHADED), concrete, steps, concrete)
    facets.loft(rings, lambda segment, edge: colours[edge], concrete, concrete)
    for y in (-half, half):
        low, high = [(0.0, y, height_m), (run_m, y, 0.0)], [(run_m, y, 1.0), (0.0, y, height_m + 1.0)]
        facets.polygon([*low, *high], steel)
        facets.polygon([*low, *high][::-1], steel)
    return facets.mesh(surface_texture("path"))


def cover(length_m: float, span_m: float, under_m: float, top_m: float, berm_m: float) -> TexturedMesh:
    """Return a cover over a street that runs along **y**: a deck of ``span_m``, walls, and banks of ``berm_m`` aside.

    Args:
        length_m: along the street. under_m, top_m: heights of the deck.
    """
    facets, half, long = Facets(), 0.5 * span_m, 0.5 * length_m
    concrete, shaded = _swatch(_CONCRETE), _swatch(_SHADED)
    for y0, y1 in pairwise(np.linspace(-long, long, 1 + max(1, round(length_m / TILE_M)))):
        for x0, x1 in pairwise(np.linspace(-half, half, 1 + max(1, round(span_m / TILE_M)))):
            facets.polygon([(x0, y0, top_m), (x1, y0, top_m), (x1, y1, top_m), (x0, y1, top_m)], _whole_uv())
        for side in (-1.0, 1.0):
            foot, edge, inner = side * (half + berm_m), side * half, side * (half - _WALL_M)
            bank = [(foot, y0, 0.0), (foot, y1, 0.0), (edge, y1, top_m), (edge, y0, top_m)]
            _face(facets, bank, _whole_uv(), (side, 0.0, 0.0))
            wall = [(inner, y0, 0.0), (inner, y1, 0.0), (inner, y1, under_m), (inner, y0, under_m)]
            _face(facets, wall, shaded, (-side, 0.0, 0.0))
    ceiling = [(-half, -long, under_m), (half, -long, under_m), (half, long, under_m), (-half, long, under_m)]
    _face(facets, ceiling, shaded, (0.0, 0.0, -1.0))
    for y in (-long, long):
        out = (0.0, y, 0.0)
        front = [(-half, y, under_m), (half, y, under_m), (half, y, top_m), (-half, y, top_m)]
        _face(facets, front, concrete, out)
        for side in (-1.0, 1.0):
            inner, edge, foot = side * (half - _WALL_M), side * half, side * (half + berm_m)
            _face(facets, [(inner, y, 0.0), (edge, y, 0.0), (edge, y, under_m), (inner, y, under_m)], concrete, out)
            _face(facets, [(edge, y, 0.0), (foot, y, 0.0), (edge, y, top_m)], concrete, out)
        # A low wall on the portal, so that nobody falls.
        inward = y - np.sign(y) * 0.3
        facets.box((-half, min(y, inward), top_m), (half, max(y, inward), top_m + 0.9), concrete)
    return facets.mesh(surface_texture("grass"))


def _face(facets: Facets, corners: list[tuple[float, float, float]], uv: ArrayLike, towards: ArrayLike) -> None:
    """Add a plane polygon, its corners in the order in which it faces a direction (3,)."""
    a, b, c = np.array(corners[:3])
    if np.cross(b - a, c - a) @ np.asarray(towards) < 0.0:
        corners = corners[::-1]
        uv = uv[::-1] if isinstance(uv, np.ndarray) else uv
    facets.polygon(corners, uv)


def _add_surface(facets: Facets, x0: float, x1: float, half: float, z0: float, z1: float) -> None:
    """Add the upper side of a deck, in pieces of ``TILE_M``."""
    count = max(1, round((x1 - x0) / TILE_M))
    x, z = np.linspace(x0, x1, count + 1), np.linspace(z0, z1, count + 1)
    for k in range(count):
        corners = [(x[k], -half, z[k]), (x[k + 1], -half, z[k + 1]), (x[k + 1], half, z[k + 1]), (x[k], half, z[k])]
        facets.polygon(corners, _whole_uv())


def _whole_uv() -> NDArray[np.float64]:
    """Return the corners of a surface's picture: the upper half of the texture."""
    return np.array([(0.001, 0.499), (0.999, 0.499), (0.999, 0.001), (0.001, 0.001)])


def _steps_uv() -> NDArray[np.float64]:
    low, high = (_TEXELS - 2 * _SWATCH) / _TEXELS + 0.002, (_TEXELS - _SWATCH) / _TEXELS - 0.002
    return np.array([(0.998, low), (0.998, high), (0.002, high), (0.002, low)])


def _swatch(index: int) -> tuple[float, float]:
    return ((index + 0.5) * _SWATCH / _TEXELS, (0.5 * _TEXELS + 0.5 * _SWATCH) / _TEXELS)


@cache
def surface_texture(surface: Surface) -> Texture:
    """Return the texture of a deck with a surface; the same one every time."""
    check_choice("surface", surface, SURFACES)
    rng = np.random.Generator(np.random.PCG64(SURFACES.index(surface)))
    picture = np.zeros((_TEXELS, _TEXELS, 3))
    half = _TEXELS // 2
    picture[:half] = _SURFACES[surface](half, _TEXELS, rng)
    for k, rgb in enumerate(((158, 154, 146), (92, 90, 86), (110, 116, 118), (96, 108, 66))):
        noise = 1.0 + 0.04 * rng.normal(size=(_SWATCH, _SWATCH, 1))
        picture[half : half + _SWATCH, k * _SWATCH : (k + 1) * _SWATCH] = np.array(rgb) * noise
    steps = np.where(np.arange(_TEXELS) // 4 % 2 == 0, 168.0, 118.0)
    picture[_TEXELS - 2 * _SWATCH : _TEXELS - _SWATCH] = steps[None, :, None]
    return Texture(np.clip(picture, 0, 255).astype(np.uint8))


def _worn(rgb: tuple[int, int, int], rows: int, columns: int, rng: np.random.Generator) -> NDArray[np.float64]:
    coarse = cv2.resize(rng.normal(size=(6, 10)), (columns, rows), interpolation=cv2.INTER_CUBIC)
    light = 1.0 + 0.05 * coarse + 0.04 * rng.normal(size=(rows, columns))
    return np.array(rgb, dtype=np.float64) * light[..., None]


def _road(rows: int, columns: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return asphalt with edge lines and a dashed centre line."""
    picture = _worn((88, 89, 91), rows, columns, rng)
    picture[:9] = picture[-9:] = _worn((152, 148, 140), 9, columns, rng)
    for row in (12, rows - 14):
        picture[row : row + 2] = (206, 206, 200)
    picture[rows // 2 - 1 : rows // 2 + 1, : columns // 2] = (206, 206, 200)
    return picture


def _rail(rows: int, columns: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return two tracks on ballast: sleepers every 0.6 m under two rails."""
    picture = _worn((118, 108, 98), rows, columns, rng) * (1.0 + 0.1 * rng.normal(size=(rows, columns, 1)))
    for middle in (round(0.29 * rows), round(0.71 * rows)):
        for sleeper in range(0, columns, 6):
            picture[middle - 9 : middle + 9, sleeper : sleeper + 3] *= 0.72
        for rail in (middle - 5, middle + 5):
            picture[rail : rail + 1] = (150, 132, 116)
            picture[rail + 1 : rail + 2] *= 0.6
    return picture


def _path(rows: int, columns: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return planks."""
    picture = _worn((150, 138, 120), rows, columns, rng)
    picture[:, ::4] *= 0.82
    return picture


def _grass(rows: int, columns: int, rng: np.random.Generator) -> NDArray[np.float64]:
    patches = cv2.resize(rng.normal(size=(8, 14)), (columns, rows), interpolation=cv2.INTER_CUBIC)[..., None]
    noise = 1.0 + 0.11 * rng.normal(size=(rows, columns, 1))
    return (np.array((96.0, 108.0, 64.0)) + patches * np.array((8.0, 4.0, 2.0))) * noise


_SURFACES = {"road": _road, "rail": _rail, "path": _path, "grass": _grass}
