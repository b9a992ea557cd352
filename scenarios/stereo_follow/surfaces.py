"""Textures of walls, floors and furniture, drawn anew for every episode.

A texture's rows run from the panel's top to its bottom. Resolutions suit a distance of 2 m.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from scenarios.stereo_follow.indoors import RGB
from sim.mesh import Texture

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
