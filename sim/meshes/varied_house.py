"""Houses of many forms, roofings and windows: bodies and wings put together from the parts of ``house``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sim.checks import check_choice
from sim.mesh import Texture, TexturedMesh
from sim.meshes.facets import Facets
from sim.meshes.house import (
    TEXELS,
    HousePart,
    Rgb,
    add_flat_roof,
    add_gable,
    add_hip,
    add_walls,
    cut_door,
    fill_part,
    opening,
    pane,
    part_uv,
    plain_uv,
    plaster,
    quarter_turned,
    roof_fall,
    stains,
    tiles,
)

Form = Literal["gable", "cross", "wing", "hip", "flat", "stepped"]
Roofing = Literal["tiles", "slate", "metal", "gravel", "green", "membrane"]
Windows = Literal["single", "shutters", "bands", "tall"]

FORMS: tuple[Form, ...] = ("gable", "cross", "wing", "hip", "flat", "stepped")
SLOPING: tuple[Roofing, ...] = ("tiles", "slate", "metal")
LEVEL: tuple[Roofing, ...] = ("gravel", "green", "membrane", "metal")
WINDOWS: tuple[Windows, ...] = ("single", "shutters", "bands", "tall")
ROOFING_RGB: dict[Roofing, tuple[Rgb, ...]] = {
    "tiles": ((152, 84, 62), (168, 98, 70), (132, 76, 60), (112, 78, 66), (140, 96, 76), (96, 66, 58)),
    "slate": ((72, 76, 84), (86, 88, 92), (60, 62, 68), (98, 94, 90)),
    "metal": ((150, 154, 156), (112, 120, 124), (120, 146, 134), (92, 98, 108)),
    "gravel": ((142, 138, 130), (120, 118, 114), (98, 98, 98)),
    "green": ((104, 112, 70), (122, 116, 78), (94, 100, 66)),
    "membrane": ((196, 198, 198), (172, 174, 174)),
}
"""Colours of roofings (sRGB 0-255): of each, one is drawn for a house and varied a little."""
_SHUTTERS: tuple[Rgb, ...] = ((60, 84, 66), (98, 52, 46), (66, 84, 112), (214, 210, 200))
_WING = (0.58, 0.42)
"""Width of a house's body and of its wing, as shares of the whole."""


@dataclass(frozen=True)
class HouseStyle:
    """How a house looks.

    Attributes:
        form: ``cross`` has its ridge along the shorter side, ``wing`` a second ridge at a right angle to the first,
            ``stepped`` a flat roof with a smaller storey on it.
        roofing: one of ``ROOFING_RGB``. windows: one of ``WINDOWS``.
        seed: of everything else about it.
    """

    form: Form
    roofing: Roofing
    windows: Windows
    seed: int

    def __post_init__(self) -> None:
        check_choice("form", self.form, FORMS)
        check_choice("roofing", self.roofing, ROOFING_RGB)
        check_choice("windows", self.windows, WINDOWS)


def varied_house(size_m: tuple[float, float, float], style: HouseStyle, wall_rgb: Rgb) -> TexturedMesh:
    """Return a house that stands on the ground around the origin, of at most 260 triangles.

    Args:
        size_m: length (x), width (y) and height of the eaves, > 0, see ``house``; its front is at +y.
        wall_rgb: sRGB 0-255.

    Raises:
        ValueError: if a size is impossible.
    """
    if len(size_m) != 3 or not all(side > 0 for side in size_m):
        raise ValueError(f"size_m: expected three lengths > 0 m, got {size_m}")
    rng = np.random.Generator(np.random.PCG64(style.seed))
    texture = _texture(size_m, style, wall_rgb, rng)
    length, width, eaves = max(size_m[:2]), min(size_m[:2]), size_m[2]
    made = _FORMS[style.form](length, width, eaves, texture, rng)
    return quarter_turned(made) if size_m[1] > size_m[0] else made


def _gabled(length: float, width: float, eaves: float, texture: Texture, rng: np.random.Generator) -> TexturedMesh:
    facets = Facets()
    add_gable(facets, length, width, eaves, roof_fall((25.0, 48.0), width, rng), rng)
    return facets.mesh(texture)


def _crossed(length: float, width: float, eaves: float, texture: Texture, rng: np.random.Generator) -> TexturedMesh:
    return quarter_turned(_gabled(width, length, eaves, texture, rng))


def _winged(length: float, width: float, eaves: float, texture: Texture, rng: np.random.Generator) -> TexturedMesh:
    """Return a body along the back, and a wing that runs out of it to the front."""
    body_m, wing_m = _WING[0] * width, _WING[1] * length
    body = _gabled(length, body_m, eaves, texture, rng)
    reach_m = width - 0.5 * body_m
    wing = quarter_turned(_gabled(reach_m, min(wing_m, reach_m), eaves, texture, rng))
    side = float(rng.choice([-1.0, 1.0]))
    aside_m = side * (0.5 * length - 0.5 * min(wing_m, reach_m)) * float(rng.choice([1.0, 0.55]))
    return _merged(
        _moved(body, 0.0, -0.5 * (width - body_m), 0.0), _moved(wing, aside_m, 0.5 * width - 0.5 * reach_m, 0.0)
    )


def _hipped(length: float, width: float, eaves: float, texture: Texture, rng: np.random.Generator) -> TexturedMesh:
    facets = Facets()
    add_walls(facets, length, width, eaves)
    add_hip(facets, length, width, eaves, roof_fall((22.0, 38.0), width, rng), rng)
    return facets.mesh(texture)


def _flat(length: float, width: float, eaves: float, texture: Texture, rng: np.random.Generator) -> TexturedMesh:
    facets = Facets()
    add_walls(facets, length, width, eaves)
    add_flat_roof(facets, length, width, eaves, rng)
    if rng.random() < 0.35:
        _add_solar_rows(facets, 0.5 * length - 1.4, 0.5 * width - 1.4, eaves + 0.05)
    if eaves > 6.0:
        _add_balconies(facets, length, width, eaves)
    return facets.mesh(texture)


def _stepped(length: float, width: float, eaves: float, texture: Texture, rng: np.random.Generator) -> TexturedMesh:
    """Return a flat house with a storey of two thirds of its length on it."""
    base = Facets()
    add_walls(base, length, width, eaves)
    add_flat_roof(base, length, width, eaves, rng)
    if eaves > 6.0:
        _add_balconies(base, length, width, eaves)
    top = Facets()
    upper = (length * float(rng.uniform(0.45, 0.7)), width * float(rng.uniform(0.6, 0.8)))
    add_walls(top, *upper, 2.9)
    add_flat_roof(top, *upper, 2.9, rng)
    side = float(rng.choice([-1.0, 1.0]))
    aside_m = side * (0.5 * (length - upper[0]) - 0.6) * float(rng.uniform(0.3, 1.0))
    return _merged(base.mesh(texture), _moved(top.mesh(texture), aside_m, 0.0, eaves))


_FORMS = {"gable": _gabled, "cross": _crossed, "wing": _winged, "hip": _hipped, "flat": _flat, "stepped": _stepped}


def _add_solar_rows(facets: Facets, half_x: float, half_y: float, deck_m: float) -> None:
    """Add rows of tilted panels on a flat roof."""
    if half_x < 1.0 or half_y < 1.0:
        return
    panel, dark = part_uv(HousePart.SOLAR), plain_uv(HousePart.DARK)
    for y in np.arange(-half_y + 0.5, half_y - 0.4, 1.6):
        profile = [(y - 0.45, deck_m), (y + 0.45, deck_m), (y + 0.45, deck_m + 0.5), (y - 0.45, deck_m + 0.1)]
        rings = [[(x, *point) for point in profile] for x in (-half_x, half_x)]
        facets.loft(rings, lambda segment, side: panel if side == 2 else dark, dark, dark)


def _add_balconies(facets: Facets, length: float, width: float, eaves: float) -> None:
    """Add a balcony a storey on the back, from the second on."""
    light, storeys = plain_uv(HousePart.LIGHT), max(2, round(eaves / 2.9))
    for storey in range(1, storeys):
        z = storey * eaves / storeys
        for x in np.arange(-0.5 * length + 2.2, 0.5 * length - 1.6, 5.2):
            facets.box((x - 1.3, -0.5 * width - 1.25, z - 0.1), (x + 1.3, -0.5 * width + 0.1, z + 0.95), light)


def _moved(mesh: TexturedMesh, x: float, y: float, z: float) -> TexturedMesh:
    vertices_m = mesh.vertices_m + np.array([x, y, z], np.float32)
    return TexturedMesh(vertices_m, mesh.normals, mesh.uv, mesh.faces, mesh.texture)


def _merged(first: TexturedMesh, second: TexturedMesh) -> TexturedMesh:
    """Return two meshes of one texture as one."""
    return TexturedMesh(
        np.concatenate([first.vertices_m, second.vertices_m]),
        np.concatenate([first.normals, second.normals]),
        np.concatenate([first.uv, second.uv]),
        np.concatenate([first.faces, second.faces + np.int32(len(first.vertices_m))]),
        first.texture,
    )


def _texture(size_m: tuple[float, float, float], style: HouseStyle, wall_rgb: Rgb, rng: np.random.Generator) -> Texture:
    length_m, eaves_m = max(size_m[:2]), size_m[2]
    floors = max(1, round(eaves_m / 2.9))
    choices = ROOFING_RGB[style.roofing]
    shade = np.array(choices[int(rng.integers(len(choices)))]) * float(rng.normal(1.0, 0.07)) + rng.normal(0.0, 3.0, 3)
    roof_rgb: Rgb = (int(shade[0]), int(shade[1]), int(shade[2]))
    accent = _SHUTTERS[int(rng.integers(len(_SHUTTERS)))]
    picture = np.zeros((TEXELS, TEXELS, 3))
    fill_part(picture, HousePart.ROOF, _ROOFINGS[style.roofing](roof_rgb, rng))
    bays = {"single": 2.6, "shutters": 3.4, "bands": 4.5, "tall": 2.9}[style.windows]
    for part in (HousePart.FRONT, HousePart.BACK):
        count = max(2, round(length_m / bays * (1.0 if part is HousePart.FRONT else 0.8)))
        wall = _wall(part, count, floors, wall_rgb, style.windows, accent, rng)
        if part is HousePart.FRONT:
            cut_door(wall, count, floors, rng)
        fill_part(picture, part, wall)
    fill_part(picture, HousePart.GABLE, _wall(HousePart.GABLE, 2, floors + 1, wall_rgb, style.windows, accent, rng))
    plain = {
        HousePart.DARK: tuple(0.45 * c for c in roof_rgb),
        HousePart.LIGHT: tuple(0.5 * c + 0.5 * 205 for c in wall_rgb),
        HousePart.METAL: (158, 162, 164),
        HousePart.GLASS: (58, 68, 78),
        HousePart.BRICK: (126, 82, 68),
    }
    for part, rgb in plain.items():
        fill_part(picture, part, np.broadcast_to(np.array(rgb, dtype=float), (*part.value[2:], 3)))
    cells = np.full((*HousePart.SOLAR.value[2:], 3), (28.0, 34.0, 58.0))
    cells[::4] = cells[:, ::3] = (70.0, 76.0, 96.0)
    fill_part(picture, HousePart.SOLAR, cells)
    return Texture(np.clip(picture, 0, 255).astype(np.uint8))


def _wall(
    part: HousePart, bays: int, floors: int, rgb: Rgb, windows: Windows, accent: Rgb, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Return a wall (rows, columns, 3) with the windows of a style on every floor."""
    rows, columns = part.value[2:]
    wall = plaster(rows, columns, rgb, rng)
    for floor in range(floors):
        for bay in range(bays):
            down, across = opening(rows / floors, columns / bays, rows, floor, bay)
            if windows == "bands":
                left, right = round((bay + 0.06) * columns / bays), round((bay + 0.94) * columns / bays)
                across = slice(left, max(right, left + 1))
            elif windows == "tall":
                down = slice(down.start, max(down.stop, round(rows - (floor + 0.1) * rows / floors)))
            elif windows == "shutters":
                wall[down, max(across.start - 1, 0) : across.stop + 1] = accent
            wall[down, across] = pane(rng)
    return wall


def _size() -> tuple[int, int]:
    rows, columns = HousePart.ROOF.value[2:]
    return rows, columns


def _slates(rgb: Rgb, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return dark slabs with lichen."""
    rows, columns = _size()
    light = 1.0 + 0.07 * rng.normal(size=(rows, columns)) + stains(rows, columns, 0.07, rng)
    return np.array(rgb, dtype=np.float64) * light[..., None]


def _sheets(rgb: Rgb, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return metal sheets with standing seams down the slope."""
    rows, columns = _size()
    light = 1.0 + 0.012 * rng.normal(size=(rows, columns)) + stains(rows, columns, 0.04, rng)
    light[:, ::3] *= 0.86
    light[:, 1::3] *= 1.04
    return np.array(rgb, dtype=np.float64) * light[..., None]


def _gravel(rgb: Rgb, rng: np.random.Generator) -> NDArray[np.float64]:
    rows, columns = _size()
    light = 1.0 + 0.08 * rng.normal(size=(rows, columns)) + stains(rows, columns, 0.08, rng)
    return np.array(rgb, dtype=np.float64) * light[..., None]


def _sedum(rgb: Rgb, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return a planted roof: patches of green, red and dry ground."""
    rows, columns = _size()
    patches = np.tanh(stains(rows, columns, 1.0, rng))[..., None]
    tint = np.array((26.0, -8.0, 6.0)) * patches
    light = 1.0 + 0.1 * rng.normal(size=(rows, columns, 1))
    return (np.array(rgb, dtype=np.float64) + tint) * light


def _membrane(rgb: Rgb, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return welded lanes of plastic, with puddle marks."""
    rows, columns = _size()
    light = 1.0 + 0.01 * rng.normal(size=(rows, columns)) + stains(rows, columns, 0.06, rng)
    light[:: int(rng.integers(6, 10))] *= 0.94
    return np.array(rgb, dtype=np.float64) * light[..., None]


_ROOFINGS = {
    "tiles": tiles,
    "slate": _slates,
    "metal": _sheets,
    "gravel": _gravel,
    "green": _sedum,
    "membrane": _membrane,
}
