"""The tank without its fish: floor, walls, rim, the table that it stands on, and the lamps above."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from sim.mesh import Texture, TexturedMesh
from sim.meshes.facets import Facets, palette, swatch_uv
from sim.shaders.water import Panel
from sim.world import World

VOLUME_M = (0.60, 0.42, 0.12)
"""Length, width and depth of the water. Its floor is at z = 0, the middle of the floor at (0, 0)."""
_RIM_M, _WALL_M = 0.03, 0.008
"""Height of the walls above the water, and their thickness."""
_TABLE_M = (1.8, 1.5)
_WALL_RGB, _RIM_RGB = (206, 212, 212), (150, 160, 164)
_FLOOR_RGB, _TABLE_RGB = (212, 212, 203), (112, 96, 80)
_TEXELS = 512


def build_tank(world: World, rng: np.random.Generator) -> None:
    """Add the bodies of a tank, none of them movable."""
    x_m, y_m, depth_m = VOLUME_M
    floor = _plate((x_m + 2 * _WALL_M, y_m + 2 * _WALL_M), 0.0, _grained(_FLOOR_RGB, 5.0, rng))
    world.add(floor, np.eye(4), name="floor", category="ground")
    table = _plate(_TABLE_M, -0.01, _grained(_TABLE_RGB, 9.0, rng))
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
    world.add(facets.mesh(palette([_WALL_RGB, _RIM_RGB])), np.eye(4), name="walls", category="wall")


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
