"""Sheds, walls and level ground as a thermal camera sees them: plates with pictures of parts and stains."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sim.mesh import Texture, TexturedMesh
from sim.meshes.facets import Facets
from sim.meshes.thermal_paint import KELVIN_PER_LEVEL, NO_VARIATION, blotches, varied

Picture = NDArray[np.uint8]


class ShedPart(IntEnum):
    """Parts of a shed; the roof is a body of its own, with the one part 0."""

    WALL = 0
    DOOR = 1
    GLASS = 2
    VENT = 3


class Opening(NamedTuple):
    """A door or a window in a shed's front: its middle along the wall, width, sill and head, metres."""

    part: int
    middle_m: float
    width_m: float
    sill_m: float
    head_m: float


def add_plate(facets: Facets, corners_m: ArrayLike, cells: tuple[int, int] = (1, 1)) -> None:
    """Add a plane rectangle, covered by the texture once.

    Args:
        corners_m: (4, 3) bottom left, bottom right, top right and top left corner of the texture, as seen from outside.
        cells: quads along bottom and side: small enough ones for clipping near the camera.
    """
    a, b, c, d = np.asarray(corners_m, dtype=float)
    across, down = np.linspace(0.0, 1.0, cells[0] + 1), np.linspace(0.0, 1.0, cells[1] + 1)
    for u0, u1 in itertools.pairwise(across):
        for v0, v1 in itertools.pairwise(down):
            uv = np.array([(u0, v1), (u1, v1), (u1, v0), (u0, v0)])
            u, v = uv[:, :1], uv[:, 1:]
            facets.polygon((1 - u) * v * a + u * v * b + u * (1 - v) * c + (1 - u) * (1 - v) * d, uv)


def level_plate(
    low_m: tuple[float, float], high_m: tuple[float, float], z_m: float, texture: Texture, cells: tuple[int, int]
) -> TexturedMesh:
    """Return level ground that faces up; the texture's columns run along x, its rows along -y; ``cells`` likewise."""
    (x0, y0), (x1, y1) = low_m, high_m
    facets = Facets()
    add_plate(facets, [(x0, y0, z_m), (x1, y0, z_m), (x1, y1, z_m), (x0, y1, z_m)], cells)
    return facets.mesh(texture)


def parts_picture(part: NDArray[np.integer], variation_k: NDArray[np.float64]) -> Texture:
    """Return a texture of parts (h, w), 0 to 15, with their variation of temperature (h, w)."""
    picture = np.zeros((*part.shape, 3), np.uint8)
    picture[..., 0] = part
    picture[..., 1] = np.clip(np.round(NO_VARIATION + variation_k / KELVIN_PER_LEVEL), 1, 255)
    return Texture(picture)


def planks(shape: tuple[int, int], texels: float, spread_k: float, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return the variation (h, w) of a wall of upright boards ``texels`` wide: each differs, and stains run down."""
    boards = rng.normal(0.0, spread_k, shape[1])[(np.arange(shape[1]) / texels).astype(int)]
    wet = np.linspace(0.6, -0.6, shape[0])[:, None] * spread_k
    return boards + wet + blotches(shape, ((40.0, 0.8 * spread_k), (6.0, 0.3 * spread_k)), rng)


def shed(
    size_m: tuple[float, float, float],
    rise_m: float,
    openings: Sequence[Opening],
    rng: np.random.Generator,
    texels_per_m: float = 8.0,
) -> tuple[TexturedMesh, TexturedMesh]:
    """Return the walls and the roof of a shed whose front, with the openings, lies in x = 0 and faces -x.

    Args:
        size_m: length along y, about 0; depth along +x; height of the eaves.
        rise_m: of the ridge, which lies along y, above the eaves; 0 for a flat roof.
    """
    length, depth, eaves = size_m
    rows, columns = round(eaves * texels_per_m), round(length * texels_per_m)
    part = np.zeros((rows, columns), np.int64)
    for opening in openings:
        left = round((0.5 * length - opening.middle_m - 0.5 * opening.width_m) * texels_per_m)
        right = round((0.5 * length - opening.middle_m + 0.5 * opening.width_m) * texels_per_m)
        top, bottom = (rows - round(z * texels_per_m) for z in (opening.head_m, opening.sill_m))
        part[max(top, 0) : bottom, max(left, 0) : right] = opening.part
    wall = parts_picture(part, planks((rows, columns), 0.9 * texels_per_m, 0.5, rng))
    facets, half, middle = Facets(), 0.5 * length, 0.5 * depth
    corners = [(0.0, half), (0.0, -half), (depth, -half), (depth, half)]
    for (x0, y0), (x1, y1) in zip(corners, [*corners[1:], corners[0]], strict=True):
        add_plate(facets, [(x0, y0, 0.0), (x1, y1, 0.0), (x1, y1, eaves), (x0, y0, eaves)])
    if rise_m > 0:
        for side in (-1.0, 1.0):
            gable = np.array(
                [(0.0, side * half, eaves), (depth, side * half, eaves), (middle, side * half, eaves + rise_m)]
            )
            facets.polygon(gable if side < 0 else gable[::-1], (0.01, 0.02))
    return facets.mesh(wall), _roof(length, depth, eaves, rise_m, rng)


def _roof(length: float, depth: float, eaves: float, rise_m: float, rng: np.random.Generator) -> TexturedMesh:
    """Return two slopes, or one level roof, that hang over by 0.4 m and are 0.15 m thick."""
    half, over, thick = 0.5 * length + 0.4, 0.4, 0.15
    sheets = blotches((48, 160), ((1.2, 0.25), (12.0, 0.6), (30.0, 0.5)), rng)
    facets, middle, z = Facets(), 0.5 * depth, eaves - 0.4 * rise_m / (0.5 * depth)
    for x0, x1 in ((-over, middle), (depth + over, middle)):
        low, high = (x0, z), (x1, eaves + rise_m)
        ends = (half, -half) if x0 < x1 else (-half, half)
        edge = [(*low, ends[0]), (*low, ends[1]), (*high, ends[1]), (*high, ends[0])]
        add_plate(facets, [(x, y, h + thick) for x, h, y in edge])
        add_plate(facets, [(x0, ends[0], z), (x0, ends[1], z), (x0, ends[1], z + thick), (x0, ends[0], z + thick)])
    for side in (-1.0, 1.0):
        outline = [(-over, z), (depth + over, z), (middle, eaves + rise_m)]
        lower = [(x, side * half, h) for x, h in outline]
        upper = [(x, side * half, h + thick) for x, h in outline]
        for a, b in ((0, 2), (2, 1)):
            quad = [lower[a], lower[b], upper[b], upper[a]]
            facets.polygon(quad[:: int(-side)], (0.5, 0.5))
    return facets.mesh(varied(0, sheets))
