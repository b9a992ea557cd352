"""The land beyond a town: fields, woods and hedges as far as a ring of hills that closes the horizon.

The town lies in a valley. The hills are higher than a helicopter flies, so that no view ends in an empty edge.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenarios.road_town.land_paint import paint_countryside
from sim.mesh import Texture
from sim.meshes.ground import surroundings
from sim.meshes.tree import FOLIAGE_RGB
from sim.meshes.woodland import hedge, wood
from sim.world import World

LEAST_VALLEY_RADIUS_M, _BEYOND_CORNERS_M = 720.0, 20.0
"""Least radius of the valley, and its least way beyond the corners of the town's square."""
TO_CREST_M = 510.0
"""Distance from the valley's edge to the crest."""
_TO_END_M = 630.0
"""Distance from the valley's edge to the land's, where it is nearest."""
HILLS_M = (125.0, 175.0)
"""Lowest and highest crest above the town: a helicopter flies at most 100 m high."""
_WAVES = 5
FIELDS_PX = 1024
"""Side of the picture of a tile of land as large as the town."""
_FIELDS_A_TILE = 30
_WOODS, _HEDGES = 34, 44
_WOODS_FROM_M, _HEDGES_FROM_M = 40.0, 12.0
"""Free ground between the town's square and the nearest wood or hedge."""


class Hills:
    """Height of the land around a town.

    Attributes:
        valley_radius_m: of the level land in the middle, which holds the town's square.
    """

    def __init__(self, extent_m: float, rng: np.random.Generator) -> None:
        """``extent_m``: side of the town's square."""
        self.valley_radius_m = max(LEAST_VALLEY_RADIUS_M, extent_m / math.sqrt(2.0) + _BEYOND_CORNERS_M)
        self._counts = rng.integers(2, 9, _WAVES)
        self._phases = rng.uniform(0.0, 2.0 * np.pi, _WAVES)

    def height_m(self, x_m: ArrayLike, y_m: ArrayLike) -> NDArray[np.float64]:
        """Return heights above the town at places; 0 in the valley."""
        x, y = np.asarray(x_m, dtype=float), np.asarray(y_m, dtype=float)
        share = np.clip((np.hypot(x, y) - self.valley_radius_m) / TO_CREST_M, 0.0, 1.0)
        angle = np.arctan2(y, x)[..., None]
        wave = 0.5 + 0.5 * np.sin(self._counts * angle + self._phases).mean(axis=-1)
        crest = HILLS_M[0] + (HILLS_M[1] - HILLS_M[0]) * wave
        return np.asarray(crest * share**2 * (3.0 - 2.0 * share))


def add_countryside(world: World, extent_m: float, rng: np.random.Generator) -> None:
    """Add the land around a town's square of side ``extent_m``."""
    hills = Hills(extent_m, rng)
    fields = Texture(paint_countryside(extent_m, rng, FIELDS_PX, _FIELDS_A_TILE), smooth=True)
    land = surroundings(extent_m, 2.0 * (hills.valley_radius_m + _TO_END_M), fields, hills.height_m)
    world.add(land, np.eye(4), name="fields", category="ground")
    edge_m = 0.5 * extent_m
    for k in range(_WOODS):
        radius_m = float(rng.uniform(14.0, 46.0))
        centre_m = _place(edge_m + _WOODS_FROM_M + radius_m, 30.0 + 900.0 * (k / _WOODS) ** 1.5, rng)
        foliage = FOLIAGE_RGB[int(rng.integers(len(FOLIAGE_RGB)))]
        world.add(
            wood(centre_m, radius_m, float(rng.uniform(9.0, 16.0)), foliage, hills.height_m, rng),
            np.eye(4),
            name=f"wood-{k}",
            category="wood",
        )
    for k in range(_HEDGES):
        length_m = float(rng.uniform(40.0, 130.0))
        centre_m = _place(edge_m + _HEDGES_FROM_M + 0.5 * length_m, 400.0 * (k / _HEDGES), rng)
        # Along or across the fields.
        yaw_rad = 0.5 * np.pi * int(rng.integers(2)) + float(rng.normal(0.0, 0.15))
        half = 0.5 * length_m * np.array([np.cos(yaw_rad), np.sin(yaw_rad)])
        line_m = np.linspace(centre_m - half, centre_m + half, 2 + int(length_m / 30.0))
        line_m[1:-1] += rng.normal(0.0, 1.5, line_m[1:-1].shape)
        foliage = FOLIAGE_RGB[int(rng.integers(len(FOLIAGE_RGB)))]
        world.add(hedge(line_m, foliage, hills.height_m, rng), np.eye(4), name=f"hedge-{k}", category="hedge")


def _place(clear_m: float, beyond_m: float, rng: np.random.Generator) -> NDArray[np.float64]:
    """Draw a place (2,) on a square ring: ``clear_m`` from the middle on one axis, and up to ``beyond_m`` farther."""
    away_m = clear_m + float(rng.uniform(0.0, beyond_m))
    place = np.array([away_m, float(rng.uniform(-away_m, away_m))]) * rng.choice([-1.0, 1.0], 2)
    return place if rng.random() < 0.5 else place[::-1]
