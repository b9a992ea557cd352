"""What stands about on a quay as a thermal camera sees it: containers, cranes, masts; and a far skyline."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sim.mesh import TexturedMesh
from sim.meshes.facets import Facets, swatch_uv
from sim.meshes.shed import add_plate
from sim.meshes.thermal_paint import blotches, parts_palette, varied

CONTAINER_M = (6.06, 2.44, 2.59)
"""Length, width and height of a container of 20 feet (ISO 668, 1CC)."""
CRANE_PARTS = ("painted steel", "dark paint", "car glass")
"""Materials of the parts of ``portal_crane``."""


def container(rng: np.random.Generator) -> TexturedMesh:
    """Return a container of one part, x along its length, its floor's middle at the origin: ribbed walls, stains."""
    (length, width, height), texels = CONTAINER_M, (40, 160)
    k = blotches(texels, ((6.0, 0.35), (30.0, 0.6)), rng) + rng.normal(0.0, 1.0)
    # The sides of ribs look to either end and see other parts of sky and sun.
    k += 0.5 * np.where(np.arange(texels[1]) % 5 < 2, 1.0, -1.0)
    k[[0, 1, -2, -1]] -= 0.7
    k[:, [0, 1, 2, -3, -2, -1]] -= 0.7
    x, y, facets = 0.5 * length, 0.5 * width, Facets()
    corners = [(-x, -y), (x, -y), (x, y), (-x, y)]
    for (x0, y0), (x1, y1) in zip(corners, [*corners[1:], corners[0]], strict=True):
        add_plate(facets, [(x0, y0, 0.0), (x1, y1, 0.0), (x1, y1, height), (x0, y0, height)])
    add_plate(facets, [(*corner, height) for corner in corners])
    return facets.mesh(varied(0, k))


def portal_crane(height_m: float, reach_m: float, turn_rad: float) -> TexturedMesh:
    """Return a slewing crane on four legs, 8 m apart, about the origin; ``CRANE_PARTS`` are its parts.

    Args:
        height_m: of its platform. reach_m: of the jib, which rises at 45 degrees.
        turn_rad: direction of the jib from +x towards +y.
    """
    facets, (steel, dark, glass) = Facets(), (swatch_uv(k, len(CRANE_PARTS)) for k in range(len(CRANE_PARTS)))
    for x in (-4.0, 4.0):
        for y in (-4.0, 4.0):
            facets.box((x - 0.35, y - 0.35, 0.0), (x + 0.35, y + 0.35, height_m), steel)
            facets.box((x - 0.9, y - 0.4, 0.0), (x + 0.9, y + 0.4, 0.9), dark)
        facets.box((x - 0.3, -4.0, 0.55 * height_m), (x + 0.3, 4.0, 0.55 * height_m + 0.5), steel)
        _beam(facets, (x, -4.0, 0.9), (x, 4.0, 0.55 * height_m), 0.25, steel)
    facets.box((-4.6, -4.6, height_m), (4.6, 4.6, height_m + 0.8), steel)
    ahead = np.array([np.cos(turn_rad), np.sin(turn_rad), 0.0])
    left, up = np.array([-ahead[1], ahead[0], 0.0]), np.array([0.0, 0.0, 1.0])
    cabin = height_m + 1.0
    for (x0, x1), half, (z0, z1), uv in (
        ((-4.5, 2.0), 1.9, (0.0, 3.2), steel),
        ((2.0, 3.4), 1.0, (0.4, 2.6), glass),
        ((-6.2, -4.5), 1.7, (-0.2, 2.0), dark),
    ):
        ring = [x * ahead + y * left for x, y in ((x0, -half), (x1, -half), (x1, half), (x0, half))]
        _box(facets, [[p + (cabin + z) * up for p in ring] for z in (z0, z1)], uv)
    foot, tip = 1.6 * ahead + (cabin + 1.0) * up, reach_m * ahead + (cabin + reach_m) * up
    mast = -2.0 * ahead + (cabin + 8.5) * up
    for side in (-0.8, 0.8):
        _beam(facets, foot + side * left, tip + 0.3 * side * left, 0.22, steel)
        _beam(facets, -3.5 * ahead + side * left + (cabin + 3.0) * up, mast, 0.2, steel)
    for share in np.linspace(0.1, 0.9, 9):
        at = foot + share * (tip - foot)
        _beam(facets, at - (0.8 - 0.5 * share) * left, at + (0.8 - 0.5 * share) * left, 0.1, steel)
    _beam(facets, mast, tip, 0.08, dark)
    _beam(facets, tip, [*tip[:2], 0.45 * height_m], 0.07, dark)
    return facets.mesh(parts_palette(len(CRANE_PARTS)))


def _beam(facets: Facets, start_m: ArrayLike, end_m: ArrayLike, half_m: float, uv: ArrayLike) -> None:
    """Add a square beam between two points."""
    start, end = np.asarray(start_m, dtype=float), np.asarray(end_m, dtype=float)
    ahead = (end - start) / np.linalg.norm(end - start)
    across = np.cross(ahead, (0.0, 0.0, 1.0) if abs(ahead[2]) < 0.9 else (1.0, 0.0, 0.0))
    across /= np.linalg.norm(across)
    over = np.cross(ahead, across)
    ring = half_m * np.array([-across - over, across - over, across + over, over - across])
    _box(facets, [ring + start, ring + end], uv)


def _box(facets: Facets, rings_m: ArrayLike, uv: ArrayLike) -> None:
    """Add what lies between two rings, in one colour."""
    facets.loft(rings_m, lambda segment, side: uv, uv, uv)


def skyline(radius_m: float, heights_m: NDArray[np.float64], foot_m: float) -> TexturedMesh:
    """Return hills all round the origin, as an upright band of ``heights_m`` (n,) that faces inwards, of one part."""
    count, facets = len(heights_m), Facets()
    angles = np.arange(count + 1) * (2.0 * np.pi / count)
    round_m = radius_m * np.column_stack([np.cos(angles), np.sin(angles)])
    tops = [*heights_m.tolist(), float(heights_m[0])]
    for k in range(count):
        (a, b), uv = (round_m[k + 1], round_m[k]), swatch_uv(0, 1)
        facets.polygon([(*a, foot_m), (*b, foot_m), (*b, tops[k]), (*a, tops[k + 1])], uv)
    return facets.mesh(parts_palette(1))
