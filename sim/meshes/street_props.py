"""Small things beside streets and in gardens: hedges, shrubs, fences, signs and bins, all of one texture.

They are added to one ``Facets`` in the world's frame, so that a renderer has one body for all things of a block.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import cv2
import numpy as np
import trimesh
from numpy.typing import NDArray

from sim.checks import check_choice
from sim.mesh import Texture
from sim.meshes.facets import Facets

_TEXELS, _TILE, _SWATCH = 128, 32, 8
_FOLIAGE = ((58, 78, 42), (70, 88, 46), (48, 70, 40), (86, 96, 52))
_SWATCHES = {
    "wood": (122, 100, 78),
    "pale": (196, 190, 178),
    "stone": (146, 140, 130),
    "steel": (140, 144, 146),
    "back": (150, 152, 150),
    "black": (44, 46, 46),
    "green": (48, 84, 58),
    "blue": (46, 72, 120),
    "brown": (88, 66, 50),
}
_FACES = ("limit", "parking", "priority", "yield", "no_entry", "crossing")
"""Signs in the texture, in its third row of tiles of 16 texels."""


class Place:
    """Where a thing stands: points of its own frame (x along, y across, z up) in the world's."""

    def __init__(self, centre_m: tuple[float, float], yaw_rad: float) -> None:
        c, s = np.cos(yaw_rad), np.sin(yaw_rad)
        self._origin, self._turn = np.array([*centre_m, 0.0]), np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])

    def __call__(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return points (..., 3) in the world's frame."""
        moved: NDArray[np.float64] = points @ self._turn + self._origin
        return moved


def add_prop(
    facets: Facets,
    kind: str,
    size_m: tuple[float, float, float],
    centre_m: tuple[float, float],
    yaw_rad: float,
    variant: int,
) -> None:
    """Add a thing on the ground at a place.

    Args:
        kind: one of ``KINDS``.
        size_m: along, across, height.
        variant: decides its colour and all that is random about it.
    """
    check_choice("kind", kind, KINDS)
    rng = np.random.Generator(np.random.PCG64(variant))
    KINDS[kind](facets, size_m, Place(centre_m, yaw_rad), variant, rng)


def _add_hedge(
    facets: Facets, size_m: tuple[float, float, float], place: Place, variant: int, rng: np.random.Generator
) -> None:
    """Add a cut hedge: a row of leaning quads with an uneven top."""
    length, width, height = size_m
    kind = variant % len(_FOLIAGE)
    count = 1 + max(1, round(length / 1.6))
    along = np.linspace(-0.5 * length, 0.5 * length, count)
    top = height * (1.0 + 0.06 * rng.normal(size=count))
    wide = 0.5 * width * (1.0 + 0.08 * rng.normal(size=count))
    rings = np.zeros((count, 4, 3))
    rings[:, :, 0] = along[:, None]
    rings[:, 0, 1], rings[:, 1, 1], rings[:, 2, 1], rings[:, 3, 1] = -wide, wide, 0.8 * wide, -0.8 * wide
    rings[:, 2, 2] = rings[:, 3, 2] = top
    facets.loft(
        place(rings),
        lambda segment, side: None if side == 0 else _leaves(kind, rng),
        _leaves(kind, rng),
        _leaves(kind, rng),
    )


def _add_shrub(
    facets: Facets, size_m: tuple[float, float, float], place: Place, variant: int, rng: np.random.Generator
) -> None:
    """Add one to three lumps of leaves."""
    kind, count = variant % len(_FOLIAGE), int(rng.integers(1, 4))
    ball = trimesh.creation.icosphere(subdivisions=0)
    for k in range(count):
        share = 1.0 if k == 0 else float(rng.uniform(0.5, 0.8))
        spin = trimesh.transformations.random_rotation_matrix(rng.random(3))[:3, :3]
        lump = ball.vertices @ spin.T * rng.uniform(0.8, 1.1, (len(ball.vertices), 1))
        aside = np.array([0.0, 0.0]) if k == 0 else rng.uniform(-0.25, 0.25, 2) * size_m[:2]
        centre = np.array([*aside, 0.42 * share * size_m[2]])
        lump = lump * (0.5 * share * np.array(size_m) * (0.8, 0.8, 1.1)) + centre
        lump[:, 2] = np.maximum(lump[:, 2], 0.0)
        for face in lump[ball.faces]:
            facets.polygon(place(face), _leaves(kind, rng)[:3])


def _add_fence(
    facets: Facets, size_m: tuple[float, float, float], place: Place, variant: int, rng: np.random.Generator
) -> None:
    half = 0.5 * np.array(size_m[:2])
    colour = _swatch(("wood", "pale", "stone")[variant % 3])
    _add_box(facets, place, (-half[0], -half[1], 0.0), (half[0], half[1], size_m[2]), colour)


def _add_bin(
    facets: Facets, size_m: tuple[float, float, float], place: Place, variant: int, rng: np.random.Generator
) -> None:
    """Add a row of wheeled bins, as many as its length holds."""
    count = max(1, int(size_m[0] / 0.7))
    for k in range(count):
        x = 0.7 * (k - 0.5 * (count - 1))
        colour = _swatch(("black", "green", "blue", "brown")[(variant + k) % 4])
        _add_box(facets, place, (x - 0.29, -0.35, 0.0), (x + 0.29, 0.35, size_m[2]), colour)


def _add_sign(
    facets: Facets, size_m: tuple[float, float, float], place: Place, variant: int, rng: np.random.Generator
) -> None:
    """Add a post with a plate that faces -x."""
    steel, back = _swatch("steel"), _swatch("back")
    height, half = size_m[2], 0.36
    _add_box(facets, place, (-0.045, -0.045, 0.0), (0.045, 0.045, height), steel)
    name = _FACES[variant % len(_FACES)]
    shape = {"limit": _ROUND, "no_entry": _ROUND, "yield": _DOWN, "priority": _ON_EDGE}.get(name, _SQUARE)
    middle = height - half
    plate = np.column_stack([np.full(len(shape), -0.06), -half * shape[:, 0], middle + half * shape[:, 1]])
    index = _FACES.index(name)
    corner = np.array([16.0 * index, 64.0])
    inside = np.column_stack([0.5 + 0.5 * shape[:, 0], 0.5 - 0.5 * shape[:, 1]])
    facets.polygon(place(plate), (corner + 0.1 + inside * 15.8) / _TEXELS)
    rear = plate[::-1] + np.array((0.03, 0.0, 0.0))
    facets.polygon(place(rear), back)


_ANGLES = (np.arange(10) + 0.5) * (0.2 * np.pi)
_ROUND = np.column_stack([np.cos(_ANGLES), np.sin(_ANGLES)])
_SQUARE = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
_ON_EDGE = np.array([(0.0, -1.0), (1.0, 0.0), (0.0, 1.0), (-1.0, 0.0)])
_DOWN = np.array([(0.0, -1.0), (1.0, 0.75), (-1.0, 0.75)])

KINDS: dict[str, Callable[[Facets, tuple[float, float, float], Place, int, np.random.Generator], None]] = {
    "hedge": _add_hedge,
    "shrub": _add_shrub,
    "fence": _add_fence,
    "bin": _add_bin,
    "sign": _add_sign,
}


def _add_box(
    facets: Facets, place: Place, low: tuple[float, ...], high: tuple[float, ...], uv: tuple[float, float]
) -> None:
    """Add a box without a floor."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    outline = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
    facets.loft(place(np.array([[(*p, z) for p in outline] for z in (z0, z1)])), lambda segment, side: uv, None, uv)


def _leaves(kind: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return the corners (4, 2) of a piece of foliage."""
    side = 12.0
    corner = np.array([_TILE * kind, 0.0]) + 0.5 + rng.random(2) * (_TILE - 1.0 - side)
    return np.asarray((corner + side * np.array([(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0)])) / _TEXELS)


def _swatch(name: str) -> tuple[float, float]:
    return ((list(_SWATCHES).index(name) + 0.5) * _SWATCH / _TEXELS, (_TILE + 0.5 * _SWATCH) / _TEXELS)


@cache
def props_texture() -> Texture:
    """Return the texture of all things of this module: foliage, plain colours, signs; the same one every time."""
    rng = np.random.Generator(np.random.PCG64(58))
    picture = np.full((_TEXELS, _TEXELS, 3), 120.0)
    for k, rgb in enumerate(_FOLIAGE):
        clumps = cv2.resize(rng.normal(size=(12, 12)), (_TILE, _TILE), interpolation=cv2.INTER_CUBIC)
        light = np.clip(1.0 + 0.16 * clumps + 0.13 * rng.normal(size=(_TILE, _TILE)), 0.4, 1.6)
        picture[:_TILE, _TILE * k : _TILE * (k + 1)] = np.array(rgb) * light[..., None]
    for k, rgb in enumerate(_SWATCHES.values()):
        picture[_TILE : _TILE + _SWATCH, _SWATCH * k : _SWATCH * (k + 1)] = rgb
    pixels = np.clip(picture, 0, 255).astype(np.uint8)
    for k, name in enumerate(_FACES):
        pixels[64:80, 16 * k : 16 * (k + 1)] = _face(name)
    return Texture(pixels)


def _face(name: str) -> NDArray[np.uint8]:
    """Return the picture (16, 16, 3) of a sign's face."""
    face = np.full((16, 16, 3), (226, 226, 222), np.uint8)
    if name == "limit":
        cv2.circle(face, (8, 8), 7, (186, 30, 34), 2)
        cv2.rectangle(face, (5, 6), (6, 10), (30, 30, 30), 1)
        cv2.rectangle(face, (9, 6), (11, 10), (30, 30, 30), 1)
    elif name == "parking":
        face[:] = (34, 74, 156)
        cv2.line(face, (6, 3), (6, 12), (230, 230, 230), 1)
        cv2.rectangle(face, (6, 3), (10, 7), (230, 230, 230), 1)
    elif name == "priority":
        cv2.fillPoly(face, [np.array([(8, 3), (13, 8), (8, 13), (3, 8)])], (232, 186, 40))
    elif name == "yield":
        face[:] = (190, 34, 36)
        cv2.fillPoly(face, [np.array([(8, 12), (4, 5), (12, 5)])], (230, 230, 226))
    elif name == "no_entry":
        face[:] = (184, 28, 32)
        face[7:10, 3:13] = (232, 232, 230)
    else:
        face[:] = (34, 74, 156)
        cv2.fillPoly(face, [np.array([(8, 3), (13, 12), (3, 12)])], (230, 230, 230))
    return face
