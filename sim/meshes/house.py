"""Houses: walls with windows and doors under a flat, gable or hip roof, each with its own small texture."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import cv2
import numpy as np
from numpy.typing import NDArray

from sim.mesh import Texture, TexturedMesh
from sim.meshes.facets import Facets

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
    size_m: tuple[float, float, float], is_flat: bool, wall_rgb: Rgb, roof_rgb: Rgb, rng: np.random.Generator
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
    fill_part(picture, HousePart.ROOF, felt(roof_rgb, rng) if is_flat else tiles(roof_rgb, rng))
    front = wall(HousePart.FRONT, max(2, round(length_m / 2.6)), floors, wall_rgb, rng)
    cut_door(front, max(2, round(length_m / 2.6)), floors, rng)
    fill_part(picture, HousePart.FRONT, front)
    fill_part(picture, HousePart.BACK, wall(HousePart.BACK, max(2, round(length_m / 3.2)), floors, wall_rgb, rng))
    fill_part(picture, HousePart.GABLE, gable_wall(floors, eaves_m / (eaves_m + gable_m), wall_rgb, rng))
    plain = {
        HousePart.DARK: tuple(0.45 * c for c in roof_rgb),
        HousePart.LIGHT: tuple(0.5 * c + 0.5 * 205 for c in wall_rgb),
        HousePart.METAL: (158, 162, 164),
        HousePart.GLASS: (58, 68, 78),
        HousePart.BRICK: (126, 82, 68),
        HousePart.SOLAR: (30, 36, 58),
    }
    for part, rgb in plain.items():
        fill_part(picture, part, np.broadcast_to(np.array(rgb, dtype=float), (*part.value[2:], 3)))
    return Texture(np.clip(picture, 0, 255).astype(np.uint8))


def fill_part(picture: NDArray[np.float64], part: HousePart, content: NDArray[np.float64]) -> None:
    top, left, rows, columns = part.value
    picture[top : top + rows, left : left + columns] = content


def tiles(rgb: Rgb, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return rows of tiles: shaded joints, single tiles off the mean colour, and weather stains."""
    rows, columns = HousePart.ROOF.value[2:]
    light = 1.0 + 0.05 * rng.normal(size=(rows, columns)) + stains(rows, columns, 0.06, rng)
    light[1::2] *= 0.9
    return np.array(rgb, dtype=np.float64) * light[..., None]


def felt(rgb: Rgb, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return roofing felt: seams between lanes, puddle marks."""
    rows, columns = HousePart.ROOF.value[2:]
    light = 1.0 + 0.02 * rng.normal(size=(rows, columns)) + stains(rows, columns, 0.09, rng)
    light[:, int(rng.integers(4, 9)) :: 9] *= 0.88
    return np.array(rgb, dtype=np.float64) * light[..., None]


def stains(rows: int, columns: int, strength: float, rng: np.random.Generator) -> NDArray[np.float64]:
    coarse = strength * rng.normal(size=(4, 8))
    return np.asarray(cv2.resize(coarse, (columns, rows), interpolation=cv2.INTER_CUBIC), dtype=np.float64)


def plaster(rows: int, columns: int, rgb: Rgb, rng: np.random.Generator) -> NDArray[np.float64]:
    light = 1.0 + 0.015 * rng.normal(size=(rows, columns)) + stains(rows, columns, 0.03, rng)
    light[-1] *= 0.75
    return np.array(rgb, dtype=np.float64) * light[..., None]


def wall(part: HousePart, bays: int, floors: int, rgb: Rgb, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return a wall (rows, columns, 3) with a window in every bay of every floor."""
    rows, columns = part.value[2:]
    wall = plaster(rows, columns, rgb, rng)
    for floor in range(floors):
        for bay in range(bays):
            wall[opening(rows / floors, columns / bays, rows, floor, bay)] = pane(rng)
    return wall


def gable_wall(floors: int, eaves_share: float, rgb: Rgb, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return a gable wall: two windows a floor up to the eaves, one below the ridge where there is room."""
    rows, columns = HousePart.GABLE.value[2:]
    wall = plaster(rows, columns, rgb, rng)
    floor_rows = rows * eaves_share / floors
    for floor in range(floors):
        for bay in range(2):
            wall[opening(floor_rows, columns / 2, rows, floor, bay)] = pane(rng)
    if (1.0 - eaves_share) * rows > 0.7 * floor_rows:
        wall[opening(0.7 * floor_rows, columns / 3, round(rows * (1.0 - eaves_share)), 0, 1)] = pane(rng)
    return wall


def cut_door(wall: NDArray[np.float64], bays: int, floors: int, rng: np.random.Generator) -> None:
    """Put a door, which reaches down to the ground, in the place of one window."""
    rows, columns = wall.shape[:2]
    down, across = opening(rows / floors, columns / bays, rows, 0, int(rng.integers(bays)))
    wall[down.start :, across] = (88, 62, 46)


def opening(floor_rows: float, bay_columns: float, ground_row: int, floor: int, bay: int) -> tuple[slice, slice]:
    """Return the rows and columns of a window, at least one texel of each."""
    top = round(ground_row - (floor + 0.8) * floor_rows)
    bottom = round(ground_row - (floor + 0.28) * floor_rows)
    left, right = round((bay + 0.3) * bay_columns), round((bay + 0.7) * bay_columns)
    return slice(max(top, 0), max(bottom, top + 1)), slice(left, max(right, left + 1))


def pane(rng: np.random.Generator) -> NDArray[np.float64]:
    return np.asarray(rng.uniform(0.8, 1.5) * np.array((52.0, 60.0, 70.0)), dtype=np.float64)


@dataclass(frozen=True)
class Slopes:
    """Two roof slopes that fall from a ridge along x to both sides.

    Attributes:
        half_ridge_m: half the length of the ridge.
        half_width_m: from the ridge to the eaves, in plan.
        ridge_m: height of the ridge.
        fall: metres down for each metre away from the ridge.
    """

    half_ridge_m: float
    half_width_m: float
    ridge_m: float
    fall: float

    def height_m(self, y_m: float) -> float:
        """Return the height of the slopes at a distance from the ridge."""
        return self.ridge_m - self.fall * abs(y_m)


def add_slope_details(facets: Facets, slopes: Slopes, rng: np.random.Generator) -> None:
    """Add a chimney, and on either slope dormers, roof lights, solar panels or nothing."""
    _add_chimney(facets, slopes, rng)
    room_for_dormers = slopes.half_ridge_m > 2.5 and slopes.fall > 0.5 and slopes.half_width_m > 3.0
    for side in (-1.0, 1.0):
        kind = rng.random()
        if kind < 0.3 and room_for_dormers:
            _add_dormers(facets, slopes, side, int(rng.integers(1, 3)))
        elif kind < 0.45 and slopes.half_ridge_m > 2.0:
            half = (rng.uniform(0.4, 0.8) * slopes.half_ridge_m, 0.25 * slopes.half_width_m)
            _add_slab(facets, slopes, (0.0, 0.5 * side * slopes.half_width_m), half, HousePart.SOLAR)
        elif kind < 0.8:
            away = side * rng.uniform(0.35, 0.6) * slopes.half_width_m
            count = int(rng.integers(1, 4)) if slopes.half_ridge_m > 1.5 else 1
            for k in range(count):
                along = 0.7 * slopes.half_ridge_m * (k - 0.5 * (count - 1))
                _add_slab(facets, slopes, (along, away), (0.4, 0.5), HousePart.GLASS)


def _add_chimney(facets: Facets, slopes: Slopes, rng: np.random.Generator) -> None:
    x = rng.uniform(-0.7, 0.7) * slopes.half_ridge_m
    y = rng.uniform(0.3, 0.6) * float(rng.choice([-1.0, 1.0]))
    foot = slopes.height_m(abs(y) + 0.35) - 0.1
    facets.box((x - 0.4, y - 0.35, foot), (x + 0.4, y + 0.35, slopes.ridge_m + 0.7), plain_uv(HousePart.BRICK))


def _add_slab(
    facets: Facets, slopes: Slopes, centre_m: tuple[float, float], half_m: tuple[float, float], kind: HousePart
) -> None:
    """Add a thin closed slab that lies on a slope."""
    (x, y), (a, b) = centre_m, half_m
    outline = [(x - a, y - b), (x + a, y - b), (x + a, y + b), (x - a, y + b)]
    uv = plain_uv(kind)
    rings = [[(*p, slopes.height_m(p[1]) + lift) for p in outline] for lift in (-0.05, 0.08)]
    facets.loft(rings, lambda segment, side: uv, uv, uv)


def _add_dormers(facets: Facets, slopes: Slopes, side: float, count: int) -> None:
    """Add dormers: wedges with a glazed front and a flat roof that runs back into the slope."""
    half = 0.8
    front, top = 0.72 * slopes.half_width_m, slopes.height_m(0.72 * slopes.half_width_m) + 1.3
    back = (slopes.ridge_m - top) / slopes.fall - 0.1
    # In the plane across the ridge: foot and head of the front, and where the roof meets the slope.
    profile = [(front, slopes.height_m(front) - 0.1), (front, top), (back, top)]
    colours = (HousePart.GLASS, HousePart.DARK, HousePart.DARK)
    light = plain_uv(HousePart.LIGHT)
    for k in range(count):
        x = (k - 0.5 * (count - 1)) * 1.1 * slopes.half_ridge_m
        # The two sides are mirror images: the order of the ends keeps the faces turned out.
        ends = [[(x + side * along, side * y, z) for y, z in profile] for along in (-half, half)]
        facets.loft(ends, lambda segment, edge: plain_uv(colours[edge]), light, light)


def add_deck_details(facets: Facets, half_deck_m: tuple[float, float], deck_m: float, rng: np.random.Generator) -> None:
    """Add boxes on a flat roof: lift house, air conditioning, roof lights. Small decks stay empty.

    Args:
        half_deck_m: (x, y) from the middle to the parapet.
        deck_m: height of the deck.
    """
    room = np.array(half_deck_m) - 1.3
    if (room < 0.3).any():
        return
    kinds = (HousePart.METAL, HousePart.METAL, HousePart.LIGHT, HousePart.GLASS, HousePart.BRICK)
    for _ in range(int(rng.integers(3, 6))):
        kind = kinds[int(rng.integers(len(kinds)))]
        half = rng.uniform((0.4, 0.4), (1.1, 0.9))
        height = 0.25 if kind == HousePart.GLASS else rng.uniform(0.5, 1.3)
        x, y = rng.uniform(-room, room)
        low, high = (x - half[0], y - half[1], deck_m - 0.02), (x + half[0], y + half[1], deck_m + height)
        facets.box(low, high, plain_uv(kind))


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
        fall = roof_fall((28.0, 42.0), width, rng)
        gable_m = 0.5 * width * fall
        add_gable(facets, length, width, eaves, fall, rng)
    else:
        add_walls(facets, length, width, eaves)
        if roof == "hip":
            add_hip(facets, length, width, eaves, roof_fall((22.0, 33.0), width, rng), rng)
        else:
            add_flat_roof(facets, length, width, eaves, rng)
    mesh = facets.mesh(house_texture((length, eaves, gable_m), roof == "flat", wall_rgb, roof_rgb, rng))
    return quarter_turned(mesh) if size_m[1] > size_m[0] else mesh


def roof_fall(pitch_deg: tuple[float, float], width: float, rng: np.random.Generator) -> float:
    """Draw a roof's fall in metres per metre."""
    return min(float(np.tan(np.radians(rng.uniform(*pitch_deg)))), 2.0 * HIGHEST_ROOF_M / width)


def footprint(half_x: float, half_y: float) -> list[tuple[float, float]]:
    return [(-half_x, -half_y), (half_x, -half_y), (half_x, half_y), (-half_x, half_y)]


def add_walls(facets: Facets, length: float, width: float, eaves: float) -> None:
    outline = footprint(0.5 * length, 0.5 * width)
    front, back, dark = part_uv(HousePart.FRONT), part_uv(HousePart.BACK), plain_uv(HousePart.DARK)
    rings = [[(*p, z) for p in outline] for z in (0.0, eaves)]
    facets.loft(rings, lambda segment, side: front if side == 0 else back, dark, dark)


def add_flat_roof(facets: Facets, length: float, width: float, eaves: float, rng: np.random.Generator) -> None:
    """Add a deck with a parapet, and the things on it."""
    x, y = 0.5 * length, 0.5 * width
    # Inset and height: foot and outer edge of the parapet, its inner edge, the deck.
    steps = ((-0.03, eaves - 0.1), (-0.03, eaves + PARAPET_M), (0.3, eaves + PARAPET_M), (0.3, eaves + 0.05))
    rings = [[(*p, z) for p in footprint(x - inset, y - inset)] for inset, z in steps]
    colours = [plain_uv(part) for part in (HousePart.LIGHT, HousePart.LIGHT, HousePart.DARK)]
    facets.loft(rings, lambda segment, side: colours[segment], plain_uv(HousePart.DARK), part_uv(HousePart.ROOF))
    add_deck_details(facets, (x - 0.3, y - 0.3), eaves + 0.05, rng)


def add_gable(facets: Facets, length: float, width: float, eaves: float, fall: float, rng: np.random.Generator) -> None:
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


def add_hip(facets: Facets, length: float, width: float, eaves: float, fall: float, rng: np.random.Generator) -> None:
    x, y = 0.5 * length + OVERHANG_M, 0.5 * width + OVERHANG_M
    low, edge = eaves - 0.02, eaves + SLAB_M
    ridge = edge + fall * y
    dark = plain_uv(HousePart.DARK)
    outline = footprint(x, y)
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


def quarter_turned(mesh: TexturedMesh) -> TexturedMesh:
    def turned(vectors: NDArray[np.float32]) -> NDArray[np.float32]:
        return np.ascontiguousarray(vectors[:, [1, 0, 2]] * np.array([-1.0, 1.0, 1.0], dtype=np.float32))

    return TexturedMesh(turned(mesh.vertices_m), turned(mesh.normals), mesh.uv, mesh.faces, mesh.texture)
