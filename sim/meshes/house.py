"""Houses: walls with windows and doors under a flat, gable or hip roof, each with its own small texture."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.mesh import TexturedMesh
from sim.meshes.facade import HousePart, house_texture, part_uv, plain_uv
from sim.meshes.facets import Facets

ROOFS = ("flat", "gable", "hip")
OVERHANG_M = 0.4
SLAB_M = 0.18
"""Thickness of a sloping roof."""
PARAPET_M = 0.45


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
        rng: decides pitch, windows, chimneys, dormers and what else stands on the roof.

    Raises:
        ValueError: if a size or the roof is impossible.
    """
    if len(size_m) != 3 or not all(side > 0 for side in size_m):
        raise ValueError(f"size_m: expected three lengths > 0 m, got {size_m}")
    if roof not in ROOFS:
        raise ValueError(f"roof: expected one of {', '.join(ROOFS)}, got {roof!r}")
    length, width = max(size_m[:2]), min(size_m[:2])
    facets = Facets()
    if roof == "flat":
        _add_walls(facets, length, width, size_m[2])
        _add_flat_roof(facets, length, width, size_m[2], rng)
    elif roof == "gable":
        _add_gable(facets, length, width, size_m[2], rng)
    else:
        _add_walls(facets, length, width, size_m[2])
        _add_hip(facets, length, width, size_m[2], rng)
    mesh = facets.mesh(house_texture(length, size_m[2], roof, wall_rgb, roof_rgb, rng))
    return _quarter_turned(mesh) if size_m[1] > size_m[0] else mesh


def _add_walls(facets: Facets, length: float, width: float, eaves: float) -> None:
    x, y = 0.5 * length, 0.5 * width
    outline = [(-x, -y), (x, -y), (x, y), (-x, y)]
    dark = plain_uv(HousePart.DARK)
    facets.loft(
        [[(*p, z) for p in outline] for z in (0.0, eaves)],
        lambda segment, side: part_uv(HousePart.FRONT if side == 0 else HousePart.BACK),
        dark,
        dark,
    )


def _add_flat_roof(facets: Facets, length: float, width: float, eaves: float, rng: np.random.Generator) -> None:
    """Add a parapet around a deck, and boxes on it: lift house, air conditioning, roof lights."""
    x, y = 0.5 * length, 0.5 * width
    rings = []
    for inset, z in ((0.0, eaves), (-0.05, eaves + PARAPET_M), (0.3, eaves + PARAPET_M), (0.3, eaves + 0.05)):
        a, b = x - inset, y - inset
        rings.append([(-a, -b, z), (a, -b, z), (a, b, z), (-a, b, z)])
    colours = (HousePart.LIGHT, HousePart.LIGHT, HousePart.DARK)
    facets.loft(
        rings,
        lambda segment, side: plain_uv(colours[segment]),
        plain_uv(HousePart.DARK),
        part_uv(HousePart.ROOF),
    )
    room = np.array([x - 1.6, y - 1.6])
    if (room < 0.3).any():
        return
    kinds = (HousePart.METAL, HousePart.METAL, HousePart.LIGHT, HousePart.GLASS, HousePart.BRICK)
    for _ in range(int(rng.integers(3, 6))):
        kind = kinds[int(rng.integers(len(kinds)))]
        half = rng.uniform((0.4, 0.4), (1.1, 0.9))
        height = 0.25 if kind == HousePart.GLASS else rng.uniform(0.5, 1.3)
        cx, cy = rng.uniform(-room, room)
        facets.box(
            (cx - half[0], cy - half[1], eaves + 0.03),
            (cx + half[0], cy + half[1], eaves + 0.05 + height),
            plain_uv(kind),
        )


def _add_gable(facets: Facets, length: float, width: float, eaves: float, rng: np.random.Generator) -> None:
    """Add five-sided walls and a roof of two slabs that meet in the ridge."""
    x, y = 0.5 * length, 0.5 * width
    slope = min(np.tan(np.radians(rng.uniform(28.0, 42.0))), 4.5 / y)
    ridge = eaves + slope * y
    profile = np.array([(-y, 0.0), (y, 0.0), (y, eaves), (0.0, ridge), (-y, eaves)])
    walls = [np.column_stack([np.full(5, at), profile]) for at in (-x, x)]
    dark = plain_uv(HousePart.DARK)
    front, back = part_uv(HousePart.FRONT), part_uv(HousePart.BACK)
    # Sides, from the ground up: floor, left wall, two slopes under the roof, right wall.
    facets.loft(
        walls, lambda segment, side: (dark, back[[1, 2, 3, 0]], dark, dark, front[[2, 3, 0, 1]])[side], None, None
    )
    gable_uv = np.stack([profile[:, 0] / width + 0.5, profile[:, 1] / ridge], axis=1)
    for wall, order in ((walls[0], slice(None, None, -1)), (walls[1], slice(None))):
        facets.polygon(wall[order], part_uv(HousePart.GABLE, gable_uv)[order])

    out, rise = y + OVERHANG_M, SLAB_M / np.cos(np.arctan(slope))
    low = eaves - slope * OVERHANG_M
    chevron = np.array(
        [(-out, low), (0.0, ridge), (out, low), (out, low + rise), (0.0, ridge + rise), (-out, low + rise)]
    )
    ends = [np.column_stack([np.full(6, at), chevron]) for at in (-x - OVERHANG_M, x + OVERHANG_M)]
    roof = part_uv(HousePart.ROOF)
    light = plain_uv(HousePart.LIGHT)
    facets.loft(
        ends, lambda segment, side: (dark, dark, light, roof[[1, 2, 3, 0]], roof[[3, 0, 1, 2]], light)[side], None, None
    )
    for half in ([0, 1, 4, 5], [1, 2, 3, 4]):
        facets.polygon(ends[1][half], light)
        facets.polygon(ends[0][half[::-1]], light)
    _add_things_on_slopes(facets, (x, y, ridge + rise), slope, rng)


def _add_hip(facets: Facets, length: float, width: float, eaves: float, rng: np.random.Generator) -> None:
    x, y = 0.5 * length + OVERHANG_M, 0.5 * width + OVERHANG_M
    slope = min(np.tan(np.radians(rng.uniform(22.0, 33.0))), 4.5 / y)
    low, edge = eaves - 0.02, eaves + SLAB_M
    ridge = edge + slope * y
    outline = [(-x, -y), (x, -y), (x, y), (-x, y)]
    light, dark = plain_uv(HousePart.LIGHT), plain_uv(HousePart.DARK)
    facets.loft([[(*p, z) for p in outline] for z in (low, edge)], lambda segment, side: light, dark, None)
    corners = np.array([(*p, edge) for p in outline])
    west, east = np.array([y - x, 0.0, ridge]), np.array([x - y, 0.0, ridge])
    inset = y / (2.0 * x)
    long_uv = part_uv(HousePart.ROOF, np.array([(0, 0), (1, 0), (1 - inset, 1), (inset, 1)]))
    short_uv = part_uv(HousePart.ROOF, np.array([(0.5 - inset, 0), (0.5 + inset, 0), (0.5, 1)]))
    facets.polygon([corners[0], corners[1], east, west], long_uv)
    facets.polygon([corners[2], corners[3], west, east], long_uv)
    facets.polygon([corners[1], corners[2], east], short_uv)
    facets.polygon([corners[3], corners[0], west], short_uv)
    _add_things_on_slopes(facets, (x - y, y, ridge), slope, rng)


def _add_things_on_slopes(
    facets: Facets, top: tuple[float, float, float], slope: float, rng: np.random.Generator
) -> None:
    """Add a chimney beside the ridge and roof lights or solar panels on the slopes.

    Args:
        top: half the ridge's length, half the roof's width and the ridge's height.
    """
    half_ridge, half_width, ridge = top
    x, y = rng.uniform(-0.7, 0.7) * half_ridge, rng.uniform(0.3, 0.6) * rng.choice([-1.0, 1.0])
    facets.box(
        (x - 0.4, y - 0.35, ridge - 1.5 * slope - 0.3), (x + 0.4, y + 0.35, ridge + 0.7), plain_uv(HousePart.BRICK)
    )
    side = float(rng.choice([-1.0, 1.0]))
    kind = HousePart.SOLAR if rng.random() < 0.3 and half_ridge > 2.0 else HousePart.GLASS
    for k in range(1 if kind == HousePart.SOLAR else int(rng.integers(1, 4))):
        middle = 0.5 * half_width * (1.0 if kind == HousePart.SOLAR else rng.uniform(0.7, 1.2))
        half_x, half_y = (0.7 * half_ridge, 0.25 * half_width) if kind == HousePart.SOLAR else (0.4, 0.5)
        centre = 0.0 if kind == HousePart.SOLAR else half_ridge * (0.7 * k - 0.7)
        _add_panel(facets, (centre, side * middle), (half_x, half_y), ridge, slope, kind)


def _add_panel(
    facets: Facets,
    centre: tuple[float, float],
    half: tuple[float, float],
    ridge: float,
    slope: float,
    kind: HousePart,
) -> None:
    """Add a thin closed slab that lies on a slope."""
    (x, y), (a, b) = centre, half
    outline = np.array([(x - a, y - b), (x + a, y - b), (x + a, y + b), (x - a, y + b)])
    height = ridge - slope * np.abs(outline[:, 1])
    rings = [np.column_stack([outline, height + lift]) for lift in (-0.05, 0.08)]
    uv = plain_uv(kind)
    facets.loft(rings, lambda segment, side: uv, uv, uv)


def _quarter_turned(mesh: TexturedMesh) -> TexturedMesh:
    def turned(vectors: NDArray[np.float32]) -> NDArray[np.float32]:
        return np.ascontiguousarray(vectors[:, [1, 0, 2]] * np.array([-1.0, 1.0, 1.0], dtype=np.float32))

    return TexturedMesh(turned(mesh.vertices_m), turned(mesh.normals), mesh.uv, mesh.faces, mesh.texture)
