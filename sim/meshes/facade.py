"""The small texture of a house: its roof, three kinds of wall, and plain colours."""

from __future__ import annotations

from enum import Enum

import cv2
import numpy as np
from numpy.typing import NDArray

from sim.mesh import Texture

TEXELS = 64
Rgb = tuple[int, int, int]


class HousePart(Enum):
    """Parts of the texture: (top row, left column, rows, columns)."""

    ROOF = (0, 0, 28, 64)
    FRONT = (28, 0, 14, 64)
    BACK = (42, 0, 14, 38)
    GABLE = (42, 38, 22, 26)
    DARK = (56, 0, 8, 6)
    LIGHT = (56, 6, 8, 6)
    METAL = (56, 12, 8, 6)
    GLASS = (56, 18, 8, 6)
    BRICK = (56, 24, 8, 6)
    SOLAR = (56, 30, 8, 6)


_SQUARE = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])


def part_uv(part: HousePart, places: NDArray[np.float64] = _SQUARE) -> NDArray[np.float64]:
    """Return texture coordinates (n, 2) of places (n, 2) in a part; (0, 0) is its *lower* left corner."""
    top, left, rows, columns = part.value
    inside = np.clip(places, 0.0, 1.0)
    # A hundredth of a texel inside, so that nothing is read from the part beside it.
    u = left + 0.01 + inside[:, 0] * (columns - 0.02)
    v = top + 0.01 + (1.0 - inside[:, 1]) * (rows - 0.02)
    return np.column_stack([u, v]) / TEXELS


def plain_uv(part: HousePart) -> tuple[float, float]:
    """Return the middle of a part."""
    top, left, rows, columns = part.value
    return ((left + 0.5 * columns) / TEXELS, (top + 0.5 * rows) / TEXELS)


def house_texture(
    length_m: float, eaves_m: float, roof: str, wall_rgb: Rgb, roof_rgb: Rgb, rng: np.random.Generator
) -> Texture:
    """Return the texture of one house.

    Args:
        length_m, eaves_m: decide how many windows and floors its walls have.
        roof: ``flat`` is felt with patches, others are rows of tiles.
    """
    picture = np.zeros((TEXELS, TEXELS, 3))
    floors = max(1, round(eaves_m / 2.9))
    _fill(picture, HousePart.ROOF, _felt(roof_rgb, rng) if roof == "flat" else _tiles(roof_rgb, rng))
    for part, bays in (
        (HousePart.FRONT, max(2, round(length_m / 2.6))),
        (HousePart.BACK, max(2, round(length_m / 3.2))),
        (HousePart.GABLE, 2),
    ):
        has_door = part == HousePart.FRONT
        gable_floors = floors + (roof == "gable") if part == HousePart.GABLE else floors
        _fill(picture, part, _wall(part.value[2:], bays, gable_floors, has_door, wall_rgb, rng))
    plain = {
        HousePart.DARK: tuple(0.45 * c for c in roof_rgb),
        HousePart.LIGHT: tuple(0.5 * c + 0.5 * 205 for c in wall_rgb),
        HousePart.METAL: (158, 162, 164),
        HousePart.GLASS: (58, 68, 78),
        HousePart.BRICK: (126, 82, 68),
        HousePart.SOLAR: (30, 36, 58),
    }
    for part, rgb in plain.items():
        _fill(picture, part, np.broadcast_to(np.array(rgb), (*part.value[2:], 3)))
    return Texture(np.clip(picture, 0, 255).astype(np.uint8))


def _fill(picture: NDArray[np.float64], part: HousePart, content: NDArray[np.float64]) -> None:
    top, left, rows, columns = part.value
    picture[top : top + rows, left : left + columns] = content


def _tiles(rgb: Rgb, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return rows of tiles: shaded joints, single tiles off the mean colour, and weather stains."""
    rows, columns = HousePart.ROOF.value[2:]
    light = 1.0 + 0.05 * rng.normal(size=(rows, columns)) + _stains(rows, columns, 0.06, rng)
    light[1::2] *= 0.9
    return np.array(rgb) * light[..., None]


def _felt(rgb: Rgb, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return roofing felt: seams between lanes, puddle marks."""
    rows, columns = HousePart.ROOF.value[2:]
    light = 1.0 + 0.02 * rng.normal(size=(rows, columns)) + _stains(rows, columns, 0.09, rng)
    light[:, int(rng.integers(4, 9)) :: 9] *= 0.88
    return np.array(rgb) * light[..., None]


def _stains(rows: int, columns: int, strength: float, rng: np.random.Generator) -> NDArray[np.float64]:
    coarse = rng.normal(size=(4, 8))
    return strength * np.asarray(cv2.resize(coarse, (columns, rows), interpolation=cv2.INTER_CUBIC))


def _wall(
    shape: tuple[int, int],
    bays: int,
    floors: int,
    has_door: bool,
    rgb: Rgb,
    rng: np.random.Generator,
) -> NDArray[np.float64]:
    """Return a wall (rows, columns, 3) with a grid of windows and perhaps a door in one bay."""
    rows, columns = shape
    light = 1.0 + 0.025 * rng.normal(size=shape) + _stains(rows, columns, 0.03, rng)
    light[-1] *= 0.75
    wall = np.array(rgb) * light[..., None]
    door_bay = int(rng.integers(bays)) if has_door else -1
    for floor in range(floors):
        bottom = rows - (floor + 0.28) * rows / floors
        top = rows - (floor + 0.8) * rows / floors
        for bay in range(bays):
            is_door = floor == 0 and bay == door_bay
            left, right = ((bay + edge) * columns / bays for edge in (0.3, 0.7))
            place = (
                slice(round(top), rows if is_door else max(round(bottom), round(top) + 1)),
                slice(round(left), max(round(right), round(left) + 1)),
            )
            wall[place] = (88, 62, 46) if is_door else np.array((52, 60, 70)) * rng.uniform(0.8, 1.5)
    return wall
