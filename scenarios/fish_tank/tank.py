"""The tank without its fish: floor, walls, rim, the table that it stands on, and the lamps above."""

from __future__ import annotations

from itertools import pairwise
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from sim.mesh import Texture, TexturedMesh
from sim.meshes.facets import Facets, palette, swatch_uv
from sim.shaders.water import Panel
from sim.world import World

VOLUME_M = (0.60, 0.42, 0.12)
"""Usual length, width and depth of the water. Its floor is at z = 0, the middle of the floor at (0, 0)."""
_RIM_M, _WALL_M = 0.03, 0.008
"""Height of the walls above the water, and their thickness."""
_TABLE_M = (1.8, 1.5)
_WALL_RGB, _RIM_RGB = (206, 212, 212), (150, 160, 164)
_FLOOR_RGB, _TABLE_RGB = (212, 212, 203), (112, 96, 80)
_TEXELS = 512


Volume = tuple[float, float, float]


def build_tank(
    world: World,
    rng: np.random.Generator,
    volume_m: Volume = VOLUME_M,
    *,
    is_round: bool = False,
    floor: Literal["plain", "gravel", "sand"] = "plain",
) -> None:
    """Add the bodies of a tank, none of them movable.

    Args:
        volume_m: length, width and depth of the water.
        is_round: whether the tank is round, a basin in a square rim; the volume is as long as wide then.
    """
    x_m, y_m, depth_m = volume_m
    texture = {"plain": lambda: _grained(_FLOOR_RGB, 5.0, rng), "gravel": lambda: _gravel(volume_m, rng)}
    texture["sand"] = lambda: _sand(rng)
    base = _plate((x_m + 2 * _WALL_M, y_m + 2 * _WALL_M), 0.0, texture[floor]())
    world.add(base, np.eye(4), name="floor", category="ground")
    table = _plate((max(_TABLE_M[0], 3 * x_m), max(_TABLE_M[1], 3 * y_m)), -0.01, _grained(_TABLE_RGB, 9.0, rng))
    world.add(table, np.eye(4), name="table", category="ground")
    facets = Facets()
    high_m = depth_m + _RIM_M
    for sign in (-1.0, 1.0):
        for low_m, size_m in (
            ((sign * (x_m + _WALL_M) / 2, 0.0), (_WALL_M, y_m + 2 * _WALL_M)),
            ((0.0, sign * (y_m + _WALL_M) / 2), (x_m, _WALL_M)),
        ):
            low = np.array(low_m) - 0.5 * np.array(size_m)
            facets.box((*low, -0.01), (*(low + size_m), high_m), swatch_uv(0, 2))
            facets.box((*low, high_m), (*(low + size_m), high_m + 0.004), swatch_uv(1, 2))
    if is_round:
        _add_basin(facets, 0.5 * x_m, high_m)
    world.add(facets.mesh(palette([_WALL_RGB, _RIM_RGB])), np.eye(4), name="walls", category="wall")


_BASIN_SIDES = 64


def _add_basin(facets: Facets, radius_m: float, high_m: float) -> None:
    """Add a round wall that faces inwards, and the rim from it to the square around it."""
    angle = 2.0 * np.pi * np.arange(_BASIN_SIDES + 1) / _BASIN_SIDES
    circle = radius_m * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    square = circle / np.abs(circle).max(axis=1, keepdims=True) * radius_m
    for k in range(_BASIN_SIDES):
        (ax, ay), (bx, by) = circle[k].tolist(), circle[k + 1].tolist()
        (cx, cy), (dx, dy) = square[k + 1].tolist(), square[k].tolist()
        wall = [(bx, by, 0.0), (ax, ay, 0.0), (ax, ay, high_m), (bx, by, high_m)]
        facets.polygon(wall, swatch_uv(0, 2))
        facets.polygon([(ax, ay, high_m), (dx, dy, high_m), (cx, cy, high_m), (bx, by, high_m)], swatch_uv(0, 2))


_LEAVES_RGB = ((74, 112, 48), (96, 130, 58), (58, 92, 44), (120, 138, 70))
_AFLOAT_M = 0.0015
"""Height of floating leaves above the water."""


def add_leaves(
    world: World, count: int, volume_m: Volume, rng: np.random.Generator, *, is_round: bool = False
) -> NDArray[np.int64]:
    """Add round leaves that float on the water in groups, as those of frogbit do; return their ids."""
    ids = []
    half_m = 0.5 * np.array(volume_m[:2]) - 0.03
    middle_m = np.zeros(2)
    for k in range(count):
        if k % 5 == 0:
            middle_m = rng.uniform(-1.0, 1.0, 2) * half_m
        place_m = np.clip(middle_m + rng.normal(0.0, 0.022, 2), -half_m, half_m)
        if is_round:
            place_m *= min(1.0, half_m[0] / max(float(np.linalg.norm(place_m)), 1e-9))
        size_m, turn = rng.uniform(0.008, 0.016), rng.uniform(0.0, 2.0 * np.pi)
        angle = turn + np.linspace(0.12, 2.0 * np.pi - 0.12, 15)
        # Fan-shaped: the notch of the stalk lies in the middle.
        edge = size_m * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        facets = Facets()
        for (ax, ay), (bx, by) in pairwise(edge.tolist()):
            facets.polygon([(0.0, 0.0, 0.0), (ax, ay, 0.0), (bx, by, 0.0)], swatch_uv(0, 1))
        rgb = _LEAVES_RGB[int(rng.integers(len(_LEAVES_RGB)))]
        T = np.eye(4)
        T[:3, 3] = *place_m, volume_m[2] + _AFLOAT_M + 1e-4 * k
        ids.append(world.add(facets.mesh(palette([rgb])), T, name="leaf", category="plant").index)
    return np.array(ids, np.int64)


def _plate(size_m: tuple[float, float], z_m: float, texture: Texture) -> TexturedMesh:
    """Return a level rectangle about the origin that faces up, covered by the texture once."""
    facets = Facets()
    x_m, y_m = 0.5 * size_m[0], 0.5 * size_m[1]
    corners_m = [(-x_m, -y_m, z_m), (x_m, -y_m, z_m), (x_m, y_m, z_m), (-x_m, y_m, z_m)]
    facets.polygon(corners_m, [(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0)])
    return facets.mesh(texture)


def _grained(rgb: tuple[int, int, int], grain: float, rng: np.random.Generator) -> Texture:
    """Return a surface with fine grain and broad stains of standard deviation ``grain`` (8-bit levels)."""
    fine = _stains(_TEXELS // 3, rng)
    broad = _stains(24, rng)
    picture = np.asarray(rgb, float) + grain * (0.5 * fine + 0.8 * broad)[..., None]
    return Texture(np.clip(picture, 0, 255).astype(np.uint8), smooth=True)


def _sand(rng: np.random.Generator) -> Texture:
    """Return pale sand: grains of all shades, and ripples."""
    grains = rng.standard_normal((_TEXELS, _TEXELS))
    rows = np.linspace(0.0, 14.0 * np.pi, _TEXELS)[:, None] + 1.2 * _stains(6, rng)
    picture = (
        np.array([196.0, 174.0, 138.0])
        * (1.0 + 0.07 * grains + 0.03 * np.sin(rows) + 0.05 * _stains(20, rng))[..., None]
    )
    return Texture(np.clip(picture, 0, 255).astype(np.uint8), smooth=True)


_PEBBLE_M = 0.006
_PEBBLES_RGB = np.array(
    [(200, 194, 182), (206, 198, 184), (190, 184, 174), (208, 198, 178), (194, 182, 166), (184, 182, 178)]
)
"""Pale, as keepers choose gravel before which fish show."""


def _gravel(volume_m: Volume, rng: np.random.Generator) -> Texture:
    """Return pebbles of several colours: the cells nearest to random points, darker towards their edges."""
    side = 2 * _TEXELS
    count = int(volume_m[0] * volume_m[1] / _PEBBLE_M**2)
    seeds = np.ones((side, side), np.uint8)
    seeds[tuple(rng.integers(0, side, (2, count)))] = 0
    off, cell = cv2.distanceTransformWithLabels(seeds, cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL)
    cells = int(cell.max()) + 1
    colour = _PEBBLES_RGB[rng.integers(0, len(_PEBBLES_RGB), cells)] * rng.uniform(0.96, 1.04, (cells, 1))
    typical = side * _PEBBLE_M / volume_m[0] / 2
    shade = np.clip(1.02 - 0.07 * (off / typical) ** 2, 0.86, 1.02)
    picture = colour[cell] * (shade * (1.0 + 0.03 * rng.standard_normal((side, side))))[..., None]
    return Texture(np.clip(picture, 0, 255).astype(np.uint8), smooth=True)


def _stains(cells: int, rng: np.random.Generator) -> NDArray[np.float64]:
    noise = rng.standard_normal((cells, cells)).astype(np.float32)
    return cv2.resize(noise, (_TEXELS, _TEXELS), interpolation=cv2.INTER_CUBIC).astype(float)


_CEILING_M = 2.6
"""Height of the ceiling above the tank's floor."""


def room_lights(rng: np.random.Generator, glare: float, lamp: float) -> tuple[Panel, ...]:
    """Return the bright panels of one day.

    Args:
        glare: 0 for tubes and skylight so far aside that only steep ripples mirror them, 1 for a surface that mirrors
            them along the tank's short sides.
        lamp: brightness of the small lamp, which throws sharp shadows and caustics; 0 for none, 1 for the usual one.
    """
    side = 1.0 if rng.random() < 0.5 else -1.0
    aside_m = 0.4 * (1.0 - glare)
    tube_x_m, tube_y_m = aside_m + rng.uniform(0.6, 0.85, 2), rng.uniform(-0.2, 0.2, 2)
    tubes_nit, tubes_k = rng.uniform(5000.0, 9000.0), float(rng.choice((3000.0, 4000.0, 5000.0)))
    tubes = tuple(
        Panel(
            (float(sign * x_m), float(y_m), _CEILING_M),
            (0.0, 1.2, 0.0),
            (0.05, 0.0, 0.0),
            luminance_nit=float(tubes_nit),
            temperature_k=tubes_k,
        )
        for sign, x_m, y_m in zip((side, -side), tube_x_m, tube_y_m, strict=True)
    )
    skylight = Panel(
        (float(side * (aside_m + rng.uniform(0.9, 1.4))), float(rng.uniform(-1.2, 1.2)), _CEILING_M),
        (0.7, 0.0, 0.0),
        (0.0, 0.9, 0.0),
        luminance_nit=float(rng.uniform(600.0, 2500.0)),
        temperature_k=6500.0,
        panes=(2, 3),
        bar_share=0.12,
    )
    spot = Panel(
        (float(-side * rng.uniform(0.9, 1.3)), float(rng.uniform(-0.9, 0.9)), 1.9),
        (0.07, 0.0, 0.0),
        (0.0, 0.07, 0.0),
        luminance_nit=lamp * float(rng.uniform(2e5, 5e5)),
        temperature_k=tubes_k,
    )
    return (*tubes, skylight, spot)


_MIRROR = 0.374
"""Horizontal place of a lamp's mirror image over that of the lamp, for a camera 1.48 m above the water and lamps at the
ceiling.
"""


def varied_lights(rng: np.random.Generator, glare: float, lamp: float, volume_m: Volume) -> tuple[Panel, ...]:
    """Return the bright panels of a room of any kind: one to four tubes or panels, none to three small lamps.

    Args:
        glare, lamp: see ``room_lights``.
    """
    panels = []
    for _ in range(int(rng.integers(1, 5))):
        around, turn = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(0.0, np.pi)
        c, s = np.cos(around), np.sin(around)
        edge_m = min(0.5 * volume_m[0] / max(abs(c), 1e-9), 0.5 * volume_m[1] / max(abs(s), 1e-9))
        away_m = edge_m * rng.uniform(0.8, 1.15) / _MIRROR + 0.4 * (1.0 - glare) + 0.1
        long_m, wide_m = (1.2, 0.05) if rng.random() < 0.7 else (0.6, 0.6)
        panels.append(
            Panel(
                (float(away_m * c), float(away_m * s), _CEILING_M),
                (float(long_m * np.cos(turn)), float(long_m * np.sin(turn)), 0.0),
                (float(-wide_m * np.sin(turn)), float(wide_m * np.cos(turn)), 0.0),
                luminance_nit=float(rng.uniform(4000.0, 9000.0)) * (1.0 if wide_m < 0.1 else 0.25),
                temperature_k=float(rng.choice((2700.0, 3000.0, 4000.0, 5000.0, 6500.0))),
            )
        )
    count = int(rng.integers(0, 4))
    for _ in range(count):
        around, away_m = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(0.9, 1.4)
        panels.append(
            Panel(
                (float(away_m * np.cos(around)), float(away_m * np.sin(around)), float(rng.uniform(1.6, 2.2))),
                (0.07, 0.0, 0.0),
                (0.0, 0.07, 0.0),
                luminance_nit=lamp * float(rng.uniform(1.5e5, 4e5)) / count,
                temperature_k=float(rng.choice((2700.0, 3500.0, 5000.0, 8000.0))),
            )
        )
    return tuple(panels)
