"""Houses: walls with windows and doors under a flat, gable or hip roof, each with its own small texture."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.mesh import TexturedMesh
from sim.meshes.facade import HousePart, house_texture, part_uv, plain_uv
from sim.meshes.facets import Facets
from sim.meshes.roof_details import Slopes, add_deck_details, add_slope_details

ROOFS = ("flat", "gable", "hip")
OVERHANG_M = 0.4
SLAB_M = 0.18
"""Thickness of a sloping roof."""
PARAPET_M = 0.45
HIGHEST_ROOF_M = 4.5
"""From the eaves to the ridge, whatever the pitch."""


def house(
    size_m: tuple[float, float, float],
    roof: str,
    wall_rgb: tuple[int, int, int],
    roof_rgb: tuple[int, int, int],
    rng: np.random.Generator,
) -> TexturedMesh:
    """Return a house that stands on the ground around the origin, of at most 120 triangles.

    Args:
        size_m: length (x), width (y) and height of the eaves, > 0. Sloping roofs hang over by ``OVERHANG_M``, their
            ridge lies along the longer side; flat ones have a parapet.
        roof: one of ``ROOFS``.
        wall_rgb, roof_rgb: sRGB 0-255.
        rng: of pitch, windows, chimneys, dormers and other things on the roof.

    Raises:
        ValueError: if a size or the roof is impossible.
    """
    if len(size_m) != 3 or not all(side > 0 for side in size_m):
        raise ValueError(f"size_m: expected three lengths > 0 m, got {size_m}")
    if roof not in ROOFS:
        raise ValueError(f"roof: expected one of {', '.join(ROOFS)}, got {roof!r}")
    length, width, eaves = max(size_m[:2]), min(size_m[:2]), size_m[2]
    facets = Facets()
    gable_m = 0.0
    if roof == "gable":
        fall = _fall((28.0, 42.0), width, rng)
        gable_m = 0.5 * width * fall
        _add_gable(facets, length, width, eaves, fall, rng)
    else:
        _add_walls(facets, length, width, eaves)
        if roof == "hip":
            _add_hip(facets, length, width, eaves, _fall((22.0, 33.0), width, rng), rng)
        else:
            _add_flat_roof(facets, length, width, eaves, rng)
    mesh = facets.mesh(house_texture((length, eaves, gable_m), roof == "flat", wall_rgb, roof_rgb, rng))
    return _quarter_turned(mesh) if size_m[1] > size_m[0] else mesh


def _fall(pitch_deg: tuple[float, float], width: float, rng: np.random.Generator) -> float:
    """Draw a roof's fall in metres per metre."""
    return min(float(np.tan(np.radians(rng.uniform(*pitch_deg)))), 2.0 * HIGHEST_ROOF_M / width)


def _rectangle(half_x: float, half_y: float) -> list[tuple[float, float]]:
    return [(-half_x, -half_y), (half_x, -half_y), (half_x, half_y), (-half_x, half_y)]


def _add_walls(facets: Facets, length: float, width: float, eaves: float) -> None:
    outline = _rectangle(0.5 * length, 0.5 * width)
    front, back, dark = part_uv(HousePart.FRONT), part_uv(HousePart.BACK), plain_uv(HousePart.DARK)
    rings = [[(*p, z) for p in outline] for z in (0.0, eaves)]
    facets.loft(rings, lambda segment, side: front if side == 0 else back, dark, dark)


def _add_flat_roof(facets: Facets, length: float, width: float, eaves: float, rng: np.random.Generator) -> None:
    """Add a deck with a parapet, and the things on it."""
    x, y = 0.5 * length, 0.5 * width
    # Inset and height: foot and outer edge of the parapet, its inner edge, the deck.
    steps = ((-0.03, eaves - 0.1), (-0.03, eaves + PARAPET_M), (0.3, eaves + PARAPET_M), (0.3, eaves + 0.05))
    rings = [[(*p, z) for p in _rectangle(x - inset, y - inset)] for inset, z in steps]
    colours = [plain_uv(part) for part in (HousePart.LIGHT, HousePart.LIGHT, HousePart.DARK)]
    facets.loft(rings, lambda segment, side: colours[segment], plain_uv(HousePart.DARK), part_uv(HousePart.ROOF))
    add_deck_details(facets, (x - 0.3, y - 0.3), eaves + 0.05, rng)


def _add_gable(
    facets: Facets, length: float, width: float, eaves: float, fall: float, rng: np.random.Generator
) -> None:
    """Add five-sided walls and a roof of two slabs that meet in the ridge."""
    x, y = 0.5 * length, 0.5 * width
    ridge = eaves + fall * y
    profile = np.array([(-y, 0.0), (y, 0.0), (y, eaves), (0.0, ridge), (-y, eaves)])
    walls = [np.column_stack([np.full(5, at), profile]) for at in (-x, x)]
    front, back, dark = part_uv(HousePart.FRONT), part_uv(HousePart.BACK), plain_uv(HousePart.DARK)
    # Round the profile: floor, wall at +y, two sides under the roof, wall at -y.
    long_sides = (dark, back[[1, 2, 3, 0]], dark, dark, front[[3, 0, 1, 2]])
    facets.loft(walls, lambda segment, side: long_sides[side], None, None)
    gable = part_uv(HousePart.GABLE, np.column_stack([profile[:, 0] / width + 0.5, profile[:, 1] / ridge]))
    facets.polygon(walls[1], gable)
    facets.polygon(walls[0][::-1], gable[::-1])
    top = _add_gable_roof(facets, x + OVERHANG_M, y + OVERHANG_M, ridge, fall)
    add_slope_details(facets, Slopes(x, y, top, fall), rng)


def _add_gable_roof(facets: Facets, x: float, y: float, ridge: float, fall: float) -> float:
    """Add two slabs as far as (x, y) from the middle, on a ridge; return the height of their top."""
    low, rise = ridge - fall * y, SLAB_M * float(np.hypot(1.0, fall))
    chevron = np.array([(-y, low), (0.0, ridge), (y, low), (y, low + rise), (0.0, ridge + rise), (-y, low + rise)])
    ends = [np.column_stack([np.full(6, at), chevron]) for at in (-x, x)]
    dark, tiles = plain_uv(HousePart.DARK), part_uv(HousePart.ROOF)
    colours = (dark, dark, dark, tiles[[1, 2, 3, 0]], tiles[[3, 0, 1, 2]], dark)
    facets.loft(ends, lambda segment, side: colours[side], None, None)
    for slab in ([0, 1, 4, 5], [1, 2, 3, 4]):
        facets.polygon(ends[1][slab], dark)
        facets.polygon(ends[0][slab[::-1]], dark)
    return ridge + rise


def _add_hip(facets: Facets, length: float, width: float, eaves: float, fall: float, rng: np.random.Generator) -> None:
    x, y = 0.5 * length + OVERHANG_M, 0.5 * width + OVERHANG_M
    low, edge = eaves - 0.02, eaves + SLAB_M
    ridge = edge + fall * y
    dark = plain_uv(HousePart.DARK)
    outline = _rectangle(x, y)
    facets.loft([[(*p, z) for p in outline] for z in (low, edge)], lambda segment, side: dark, dark, None)
    corners = np.array([(*p, edge) for p in outline])
    west, east = np.array([y - x, 0.0, ridge]), np.array([x - y, 0.0, ridge])
    inset = y / (2.0 * x)
    long_uv = part_uv(HousePart.ROOF, np.array([(0, 0), (1, 0), (1 - inset, 1), (inset, 1)]))
    short_uv = part_uv(HousePart.ROOF, np.array([(0.5 - inset, 0), (0.5 + inset, 0), (0.5, 1)]))
    facets.polygon([corners[0], corners[1], east, west], long_uv)
    facets.polygon([corners[2], corners[3], west, east], long_uv)
    facets.polygon([corners[1], corners[2], east], short_uv)
    facets.polygon([corners[3], corners[0], west], short_uv)
    add_slope_details(facets, Slopes(x - y, y, ridge, fall), rng)


def _quarter_turned(mesh: TexturedMesh) -> TexturedMesh:
    def turned(vectors: NDArray[np.float32]) -> NDArray[np.float32]:
        return np.ascontiguousarray(vectors[:, [1, 0, 2]] * np.array([-1.0, 1.0, 1.0], dtype=np.float32))

    return TexturedMesh(turned(mesh.vertices_m), turned(mesh.normals), mesh.uv, mesh.faces, mesh.texture)
