"""Seasons of a town: colours of leaves, lawns and fields, fallen leaves and bare trees."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scenarios.road_town.canvas import Canvas, Rgb
from scenarios.road_town.layout import Layout
from sim.meshes.tree import FOLIAGE_RGB

Season = Literal["summer", "autumn", "winter", "spring"]


@dataclass(frozen=True)
class Look:
    """How plants look in a season.

    Attributes:
        foliage: colour of each kind of tree, in the order of ``FOLIAGE_RGB``.
        bare_share: of trees without leaves.
        grass: colour to which green ground turns, at the same lightness. turned: share of the way.
    """

    foliage: tuple[Rgb, ...] = FOLIAGE_RGB
    bare_share: float = 0.0
    grass: Rgb = (94, 108, 62)
    turned: float = 0.0


LOOKS: dict[Season, Look] = {
    "summer": Look(),
    "autumn": Look(
        ((148, 96, 36), (176, 134, 46), (122, 66, 36), (112, 108, 48), (158, 112, 58), (138, 82, 34)),
        grass=(122, 112, 62),
        turned=0.65,
    ),
    "winter": Look(
        ((104, 92, 78), (98, 88, 78), (48, 62, 42), (112, 100, 84), (52, 66, 46), (92, 84, 74)),
        bare_share=0.8,
        grass=(112, 106, 78),
        turned=0.7,
    ),
    "spring": Look(
        ((104, 136, 56), (124, 148, 66), (88, 124, 56), (206, 178, 184), (112, 138, 74), (126, 142, 58)),
        grass=(92, 124, 52),
        turned=0.6,
    ),
}
"""Spring's fourth kind is in blossom; winter's third and fifth are evergreen."""
_GREEN_FROM, _GREEN_AT = 4, 30
"""Excess of green, ``2 G - R - B``, from which ground is taken for plants, and at which it is nothing else."""
_LEAVES_A_TREE = 70


def turn_ground(picture: NDArray[np.uint8], season: Season) -> None:
    """Give the green parts of a picture of the ground (H, W, 3) the colours of a season."""
    look = LOOKS[season]
    if look.turned:
        _turn(picture, np.array(look.grass, np.float32), np.float32(look.turned))


@njit(cache=True)
def _turn(picture: NDArray[np.uint8], grass: NDArray[np.float32], turned: np.float32) -> None:
    light = grass.sum() / np.float32(3.0)
    for row in range(picture.shape[0]):
        for column in range(picture.shape[1]):
            r, g, b = picture[row, column]
            excess = 2 * int(g) - int(r) - int(b)
            if excess <= _GREEN_FROM:
                continue
            share = turned * np.float32(min(excess - _GREEN_FROM, _GREEN_AT)) / np.float32(_GREEN_AT)
            level = (np.float32(r) + np.float32(g) + np.float32(b)) / np.float32(3.0) / light
            for channel in range(3):
                held = np.float32(picture[row, column, channel])
                mixed = held + share * (level * grass[channel] - held)
                picture[row, column, channel] = np.uint8(min(max(mixed, np.float32(0.0)), np.float32(255.0)))


def strew_leaves(canvas: Canvas, layout: Layout, rng: np.random.Generator) -> None:
    """Paint the leaves that autumn has blown from the trees onto the ground around them."""
    trees = np.array([(*tree.centre_m, tree.radius_m) for tree in layout.trees]).reshape(-1, 3)
    around = np.repeat(trees, _LEAVES_A_TREE, axis=0)
    places = around[:, :2] + 1.15 * around[:, 2:] * rng.normal(0.0, 1.0, (len(around), 2))
    foliage = np.array(LOOKS["autumn"].foliage)
    tones = foliage[rng.integers(len(foliage), size=len(around))] + rng.normal(0.0, 14.0, (len(around), 1))
    colours: list[Rgb] = [(r, g, b) for r, g, b in np.clip(tones, 20, 240).astype(int).tolist()]
    canvas.discs(places, rng.uniform(0.07, 0.2, len(around)), colours)
