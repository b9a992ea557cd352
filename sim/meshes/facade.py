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
    size_m: tuple[float, float, float],
    is_flat: bool,
    wall_rgb: Rgb,
    roof_rgb: Rgb,
    rng: np.random.Generator,
) -> Texture:
    """Return the texture of one house.

    Args:
        size_m: length, height of the eaves, and height of the gable above them (0 = none); they decide how many
            windows its walls have.
        is_flat: roofing felt, not rows of tiles.
    """
    length_m, eaves_m, gable_m = size_m
    floors = max(1, round(eaves_m / 2.9))
    picture = np.zeros((TEXELS, TEXELS, 3))
    _fill(picture, HousePart.ROOF, _felt(roof_rgb, rng) if is_flat else _tiles(roof_rgb, rng))
    front = _wall(HousePart.FRONT, max(2, round(length_m / 2.6)), floors, wall_rgb, rng)
    _cut_door(front, max(2, round(length_m / 2.6)), floors, rng)
    _fill(picture, HousePart.FRONT, front)
    _fill(picture, HousePart.BACK, _wall(HousePart.BACK, max(2, round(length_m / 3.2)), floors, wall_rgb, rng))
    _fill(picture, HousePart.GABLE, _gable(floors, eaves_m / (eaves_m + gable_m), wall_rgb, rng))
    plain = {
        HousePart.DARK: tuple(0.45 * c for c in roof_rgb),
        HousePart.LIGHT: tuple(0.5 * c + 0.5 * 205 for c in wall_rgb),
        HousePart.METAL: (158, 162, 164),
        HousePart.GLASS: (58, 68, 78),
        HousePart.BRICK: (126, 82, 68),
        HousePart.SOLAR: (30, 36, 58),
    }
    for part, rgb in plain.items():
        _fill(picture, part, np.broadcast_to(np.array(rgb, dtype=float), (*part.value[2:], 3)))
    return Texture(np.clip(picture, 0, 255).astype(np.uint8))


def _fill(picture: NDArray[np.float64], part: HousePart, content: NDArray[np.float64]) -> None:
    top, left, rows, columns = part.value
    picture[top : top + rows, left : left + columns] = content


def _tiles(rgb: Rgb, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return rows of tiles: shaded joints, single tiles off the mean colour, and weather stains."""
    rows, columns = HousePart.ROOF.value[2:]
    light = 1.0 + 0.05 * rng.normal(size=(rows, columns)) + _stains(rows, columns, 0.06, rng)
    light[1::2] *= 0.9
    return np.array(rgb, dtype=np.float64) * light[..., None]


def _felt(rgb: Rgb, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return roofing felt: seams between lanes, puddle marks."""
    rows, columns = HousePart.ROOF.value[2:]
    light = 1.0 + 0.02 * rng.normal(size=(rows, columns)) + _stains(rows, columns, 0.09, rng)
    light[:, int(rng.integers(4, 9)) :: 9] *= 0.88
    return np.array(rgb, dtype=np.float64) * light[..., None]


def _stains(rows: int, columns: int, strength: float, rng: np.random.Generator) -> NDArray[np.float64]:
    coarse = strength * rng.normal(size=(4, 8))
    return np.asarray(cv2.resize(coarse, (columns, rows), interpolation=cv2.INTER_CUBIC), dtype=np.float64)


def _plaster(rows: int, columns: int, rgb: Rgb, rng: np.random.Generator) -> NDArray[np.float64]:
    light = 1.0 + 0.015 * rng.normal(size=(rows, columns)) + _stains(rows, columns, 0.03, rng)
    light[-1] *= 0.75
    return np.array(rgb, dtype=np.float64) * light[..., None]


def _wall(part: HousePart, bays: int, floors: int, rgb: Rgb, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return a wall (rows, columns, 3) with a window in every bay of every floor."""
    rows, columns = part.value[2:]
    wall = _plaster(rows, columns, rgb, rng)
    for floor in range(floors):
        for bay in range(bays):
            wall[_opening(rows / floors, columns / bays, rows, floor, bay)] = _pane(rng)
    return wall


def _gable(floors: int, eaves_share: float, rgb: Rgb, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return a gable wall: two windows a floor up to the eaves, one below the ridge where there is room."""
    rows, columns = HousePart.GABLE.value[2:]
    wall = _plaster(rows, columns, rgb, rng)
    floor_rows = rows * eaves_share / floors
    for floor in range(floors):
        for bay in range(2):
            wall[_opening(floor_rows, columns / 2, rows, floor, bay)] = _pane(rng)
    if (1.0 - eaves_share) * rows > 0.7 * floor_rows:
        wall[_opening(0.7 * floor_rows, columns / 3, round(rows * (1.0 - eaves_share)), 0, 1)] = _pane(rng)
    return wall


def _cut_door(wall: NDArray[np.float64], bays: int, floors: int, rng: np.random.Generator) -> None:
    """Put a door, which reaches down to the ground, in the place of one window."""
    rows, columns = wall.shape[:2]
    down, across = _opening(rows / floors, columns / bays, rows, 0, int(rng.integers(bays)))
    wall[down.start :, across] = (88, 62, 46)


def _opening(floor_rows: float, bay_columns: float, ground_row: int, floor: int, bay: int) -> tuple[slice, slice]:
    """Return the rows and columns of a window, at least one texel of each."""
    top = round(ground_row - (floor + 0.8) * floor_rows)
    bottom = round(ground_row - (floor + 0.28) * floor_rows)
    left, right = round((bay + 0.3) * bay_columns), round((bay + 0.7) * bay_columns)
    return slice(max(top, 0), max(bottom, top + 1)), slice(left, max(right, left + 1))


def _pane(rng: np.random.Generator) -> NDArray[np.float64]:
    return np.asarray(rng.uniform(0.8, 1.5) * np.array((52.0, 60.0, 70.0)), dtype=np.float64)
