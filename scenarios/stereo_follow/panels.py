"""Rectangles that rooms are made of: walls and what hangs on them, lamps, windows, and their textures."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from sim.mesh import Texture, TexturedMesh
from sim.meshes.facets import Facets
from sim.shaders.lamps import BrightArea
from sim.world import Body, World

RGB = tuple[int, int, int]
_CELL_M = 2.0
"""Side of the cells into which panels are cut: TinyRenderer draws no triangle that reaches behind the camera."""
_GRAIN_TEXELS = 256


Window = tuple[float, float, float, float]
"""Part of a texture: left, lower, right and upper edge as shares of its width and height, from the lower left."""
WHOLE: Window = (0.0, 0.0, 1.0, 1.0)


def panel(
    corner_m: ArrayLike, side_a_m: ArrayLike, side_b_m: ArrayLike, texture: Texture, window: Window = WHOLE
) -> TexturedMesh:
    """Return a rectangle that faces ``side_a x side_b``; the window's lower left corner lies at ``corner_m``.

    Args:
        corner_m, side_a_m, side_b_m: (3,) one corner and the two sides that begin there.
        window: part of the texture that covers the rectangle.
    """
    left, low, right, high = window
    corner, a, b = (np.asarray(each, dtype=float) for each in (corner_m, side_a_m, side_b_m))
    steps_a, steps_b = (
        np.linspace(0.0, 1.0, int(np.ceil(np.linalg.norm(side) / _CELL_M - 1e-9)) + 1) for side in (a, b)
    )
    facets = Facets()
    for u0, u1 in pairwise(steps_a):
        for v0, v1 in pairwise(steps_b):
            at = np.array([(u0, v0), (u1, v0), (u1, v1), (u0, v1)])
            u, v = left + (right - left) * at[:, 0], low + (high - low) * at[:, 1]
            facets.polygon(corner + at @ np.stack([a, b]), np.column_stack([u, 1.0 - v]))
    return facets.mesh(texture)


def plain(rgb: RGB) -> Texture:
    """Return a texture of one colour."""
    return Texture(np.full((4, 4, 3), rgb, np.uint8))


def grained(rgb: RGB, rng: np.random.Generator) -> Texture:
    """Return a texture of one colour with slight fine and coarse grain: paper, plaster, linoleum."""
    fine, coarse = rng.normal(size=(2, _GRAIN_TEXELS, _GRAIN_TEXELS)).astype(np.float32)
    clouds: NDArray[np.float32] = cv2.GaussianBlur(coarse, (0, 0), _GRAIN_TEXELS / 16).astype(np.float32)
    grain = 1.0 + 0.012 * fine + 0.015 * clouds / clouds.std()
    return Texture(np.clip(np.array(rgb) * grain[..., None] + 0.5, 0, 255).astype(np.uint8), smooth=True)


SHINING = plain((255, 255, 255))
"""Texture of panels that emit light."""

Opening = tuple[float, float, float]
"""Start and end along a wall, and height above the ground."""


@dataclass(frozen=True, eq=False)
class Panel:
    """A rectangle that faces ``side_a x side_b``.

    Attributes:
        name: of its body.
        corner_m, side_a_m, side_b_m: (3,) one corner and the two sides that begin there, world frame.
        texture: with the lower left corner of its ``window`` at ``corner_m``.
        luminance_nit: of its own light; 0 for none.
        temperature_k: colour temperature of that light.
        group: of lights that are switched together.
        window: part of the texture that covers the panel.
    """

    name: str
    corner_m: NDArray[np.float64]
    side_a_m: NDArray[np.float64]
    side_b_m: NDArray[np.float64]
    texture: Texture
    luminance_nit: float = 0.0
    temperature_k: float = 6500.0
    group: str = ""
    window: Window = WHOLE


def new_panel(
    name: str, corner_m: ArrayLike, side_a_m: ArrayLike, side_b_m: ArrayLike, texture: Texture, **light: float | str
) -> Panel:
    """Return a panel from plain numbers; ``light`` are the last three of its attributes."""
    corner, a, b = (np.asarray(each, dtype=float) for each in (corner_m, side_a_m, side_b_m))
    return Panel(name, corner, a, b, texture, **light)  # type: ignore[arg-type]


def add_panel(world: World, piece: Panel) -> Body:
    """Add a panel to a world as a static body."""
    mesh = panel(piece.corner_m, piece.side_a_m, piece.side_b_m, piece.texture, piece.window)
    return world.add(mesh, np.eye(4), name=piece.name, category="building")


def bright_area(instance_id: int, piece: Panel) -> BrightArea:
    """Return the light of a panel that stands in a world as the body ``instance_id``."""
    light = (piece.luminance_nit, piece.temperature_k)
    return BrightArea(instance_id, piece.corner_m, piece.side_a_m, piece.side_b_m, *light)


def wall(
    name: str,
    start_m: tuple[float, float],
    end_m: tuple[float, float],
    height_m: float,
    texture: Texture,
    opening: Opening | None = None,
    offset_m: float = 0.0,
) -> Iterator[Panel]:
    """Yield the panels of an upright wall that faces the right of the line from ``start_m`` to ``end_m``.

    The texture covers the whole wall once; each panel shows its part.

    Args:
        offset_m: distance of the wall before that line.
    """
    start, along = np.array([*start_m, 0.0]), np.array([end_m[0] - start_m[0], end_m[1] - start_m[1], 0.0])
    length_m = float(np.linalg.norm(along))
    along /= length_m
    up = np.array([0.0, 0.0, 1.0])
    start = start + offset_m * np.cross(along, up)
    pieces = [(0.0, length_m, 0.0, height_m)]
    if opening is not None:
        first_m, last_m, top_m = opening
        pieces = [(0.0, first_m, 0.0, height_m), (last_m, length_m, 0.0, height_m), (first_m, last_m, top_m, height_m)]
    for left_m, right_m, low_m, high_m in pieces:
        if right_m - left_m > 1e-6 and high_m - low_m > 1e-6:
            corner = start + left_m * along + low_m * up
            window = (left_m / length_m, low_m / height_m, right_m / length_m, high_m / height_m)
            yield Panel(name, corner, (right_m - left_m) * along, (high_m - low_m) * up, texture, window=window)


def box(
    name: str, middle_m: tuple[float, float], size_m: tuple[float, float, float], texture: Texture, low_m: float = 0.0
) -> Iterator[Panel]:
    """Yield the five visible panels of a box whose bottom is ``low_m`` above the ground: bench, machine, planter."""
    x, y = middle_m[0] - 0.5 * size_m[0], middle_m[1] - 0.5 * size_m[1]
    dx, dy, dz = size_m
    corners = ((x, y), (x + dx, y), (x + dx, y + dy), (x, y + dy))
    for here, there in zip(corners, (*corners[1:], corners[0]), strict=True):
        along = (there[0] - here[0], there[1] - here[1], 0.0)
        yield new_panel(name, (*here, low_m), along, (0.0, 0.0, dz), texture)
    yield new_panel(name, (x, y, low_m + dz), (dx, 0.0, 0.0), (0.0, dy, 0.0), texture)


_LARGEST_TEXELS = 1024


def tiled(
    rgb: RGB,
    size_m: tuple[float, float],
    tile_m: tuple[float, float],
    rng: np.random.Generator,
    *,
    unlike: float = 0.03,
) -> Texture:
    """Return tiles, slabs or bricks with joints, every second row shifted by half a tile.

    Args:
        size_m: width and height of the panel. tile_m: of a tile. unlike: relative standard deviation from tile to tile.
    """
    columns, rows = _texels(size_m, 45.0)
    x_m, y_m = np.meshgrid((np.arange(columns) + 0.5) * size_m[0] / columns, (np.arange(rows) + 0.5) * size_m[1] / rows)
    row = np.floor(y_m / tile_m[1])
    shifted = x_m / tile_m[0] + 0.5 * (row % 2)
    column = np.floor(shifted)
    shade = rng.normal(0.0, unlike, (int(row.max()) + 1, int(column.max()) + 1))[row.astype(int), column.astype(int)]
    edge_m = np.minimum(_to_edge(shifted) * tile_m[0], _to_edge(y_m / tile_m[1]) * tile_m[1])
    joint = edge_m < max(0.006, 0.6 * size_m[0] / columns)
    return _texture(np.array(rgb) * ((1.0 + shade) * np.where(joint, 0.72, 1.0))[..., None], rng, 0.025)


def stained(rgb: RGB, size_m: tuple[float, float], rng: np.random.Generator, *, strength: float = 0.05) -> Texture:
    """Return plaster or concrete with stains, darker towards the ground."""
    columns, rows = _texels(size_m, 30.0)
    coarse = cv2.resize(
        rng.normal(size=(max(rows // 24, 2), max(columns // 24, 2))), (columns, rows), interpolation=cv2.INTER_CUBIC
    )
    foot = np.exp(-(size_m[1] * (1.0 - (np.arange(rows) + 0.5) / rows)) / 0.25)
    shade = 1.0 + strength * coarse - 0.12 * foot[:, None]
    return _texture(np.array(rgb) * shade[..., None], rng, 0.02)


def leafy(rgb: RGB, size_m: tuple[float, float], rng: np.random.Generator) -> Texture:
    """Return a hedge."""
    columns, rows = _texels(size_m, 40.0)
    leaves = sum(
        cv2.resize(rng.normal(size=(rows // step + 2, columns // step + 2)), (columns, rows)) / weight
        for step, weight in ((3, 4.5), (8, 5.0), (30, 8.0))
    )
    return _texture(np.array(rgb) * np.exp(np.asarray(leaves))[..., None], rng, 0.05)


def poster(size_m: tuple[float, float], rng: np.random.Generator) -> Texture:
    """Return a poster or a notice board: blocks of colour, lines of text."""
    columns, rows = _texels(size_m, 160.0)
    sheet = np.full((rows, columns, 3), rng.uniform(170, 250, 3))
    for _ in range(int(rng.integers(2, 5))):
        x, y = int(rng.uniform(0, 0.7) * columns), int(rng.uniform(0, 0.7) * rows)
        width, height = int(rng.uniform(0.2, 0.6) * columns), int(rng.uniform(0.15, 0.4) * rows)
        sheet[y : y + height, x : x + width] = rng.uniform(20, 230, 3)
    for y in range(int(0.08 * rows), rows - 4, max(rows // 22, 4)):
        if rng.random() < 0.6:
            sheet[y : y + 2, int(0.1 * columns) : int(rng.uniform(0.4, 0.9) * columns)] *= 0.35
    sheet[[0, 1, -2, -1]] = sheet[:, [0, 1, -2, -1]] = 60.0
    return _texture(sheet, rng, 0.01)


def door_leaf(rgb: RGB, rng: np.random.Generator) -> Texture:
    """Return a closed door of 0.9 by 2.05 m: frame, leaf, handle, and a pane in some."""
    rows, columns = 205, 90
    leaf = np.full((rows, columns, 3), np.array(rgb, dtype=float))
    leaf *= 1.0 + 0.03 * cv2.resize(rng.normal(size=(8, columns // 2)), (columns, rows))[..., None]
    if rng.random() < 0.4:
        leaf[25:95, 25:65] = (96, 104, 110)
    leaf[100:104, 74:84] = (188, 188, 184)
    leaf[:, [0, 1, 2, 3, -4, -3, -2, -1]] = leaf[:4] = (92, 88, 82)
    return _texture(leaf, rng, 0.01)


def pane(rng: np.random.Generator) -> Texture:
    """Return a window seen from outside by day: dark glass in a light frame."""
    glass = np.full((120, 120, 3), rng.uniform(40, 70) * np.array([0.9, 1.0, 1.1]))
    glass *= np.linspace(1.5, 0.8, 120)[:, None, None]
    for line in (slice(0, 6), slice(57, 63), slice(114, 120)):
        glass[line] = glass[:, line] = 205.0
    return _texture(glass, rng, 0.01)


def _texels(size_m: tuple[float, float], per_metre: float) -> tuple[int, int]:
    return tuple(int(np.clip(np.ceil(side * per_metre), 8, _LARGEST_TEXELS)) for side in size_m)  # type: ignore[return-value]


def _to_edge(position: NDArray[np.float64]) -> NDArray[np.float64]:
    inside = position % 1.0
    return np.minimum(inside, 1.0 - inside)


def _texture(rgb: NDArray[np.float64], rng: np.random.Generator, grain: float) -> Texture:
    grained = rgb * (1.0 + rng.normal(0.0, grain, rgb.shape[:2]))[..., None]
    return Texture(np.clip(grained + 0.5, 0, 255).astype(np.uint8), smooth=True)
