"""Light on the floor of a rippled water: caustics and the shadows of bodies that move in it.

Rays that fall straight on the surface are bent and counted where they reach the floor: the count, relative to that of a
level surface, is the caustic of a lamp straight above and far away, and its mean is 1. A lamp aside shifts it, and the
lamp's size blurs it, as Gaussian as the lamp is wide. So does it with shadows of bodies, sums of ellipses of optical
thickness ``t`` that leave ``exp(-t)``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.render.compilation import announce_compilation
from sim.shaders.caustics_kernels import light_floor
from sim.water_surface import RippledSurface
from sim.world import World


@dataclass(frozen=True, slots=True)
class LightThroughSurface:
    """Light of one lamp in water at rest.

    Attributes:
        illuminance_lx: that enters.
        run: (2,) mean way of its rays along x and y per metre of descent.
        spread: (2,) standard deviation of it.
    """

    illuminance_lx: float
    run: NDArray[np.float64]
    spread: NDArray[np.float64]


class MapExtent(NamedTuple):
    """Where maps of the floor lie; all are world coordinates.

    Attributes:
        first_m: (2,) x and y of the first cell's middle; rows go along y. step_m: between cells.
        low_m, high_m: (2,) of the water.
        level_m, depth_m: of the surface at rest, and from there to the floor.
        refractive_index: of the water.
    """

    first_m: NDArray[np.float32]
    step_m: np.float32
    low_m: NDArray[np.float32]
    high_m: NDArray[np.float32]
    level_m: np.float32
    depth_m: np.float32
    refractive_index: np.float32


class FloorLight:
    """Maps of the light on the floor of one water."""

    def __init__(self, world: World, surface: RippledSurface, lights: Sequence[LightThroughSurface]) -> None:
        """Take the bodies of ``world`` that can move, now or later, as those that cast shadows."""
        self._world, self._surface = world, surface
        # Two rays to a cell along x and y: of a level surface, the same share of rays then reaches every cell.
        self._step_m = 2.0 * surface.grid().step_m
        columns, rows = (np.ceil((surface.high_m - surface.low_m) / self._step_m).astype(int) + 4).tolist()
        self._maps = np.ones((2, rows, columns), np.float32)
        self._scratch = np.empty((3, rows, columns), np.float32)
        total_lx = sum(light.illuminance_lx for light in lights) or 1.0
        self._lights = np.array([[light.illuminance_lx / total_lx, *light.run, *light.spread] for light in lights])
        self._bodies = -1
        self._owner, self._ellipsoids = np.empty(0, np.int64), np.empty((0, 2, 3))
        announce_compilation(light_floor)

    def maps(self) -> NDArray[np.float32]:
        """Return the light on the floor (2, rows, columns) float32, with and without shadows of bodies.

        It is relative to the mean without ripples and bodies, and valid until the next call.
        """
        if self._bodies != len(self._world.bodies):
            self._find_bodies()
        light_floor(
            self._surface.grid(),
            self._surface.refractive_index,
            self._floor(),
            self._step_m,
            self._lights,
            self._world.poses,
            self._owner,
            self._ellipsoids,
            self._scratch,
            self._maps,
        )
        return self._maps

    def extent(self) -> MapExtent:
        """Return where the maps lie."""
        surface = self._surface
        return MapExtent(
            self._floor()[:2].astype(np.float32),
            np.float32(self._step_m),
            surface.low_m.astype(np.float32),
            surface.high_m.astype(np.float32),
            np.float32(surface.level_m),
            np.float32(surface.depth_m),
            np.float32(surface.refractive_index),
        )

    def mean_direction(self) -> NDArray[np.float32]:
        """Return the unit vector (3,) in the water against the mean of the light."""
        share, run = self._lights[:, 0], self._lights[:, 1:3]
        against = np.array([*(-share @ run), 1.0])
        return (against / np.linalg.norm(against)).astype(np.float32)

    def _floor(self) -> NDArray[np.float64]:
        surface = self._surface
        return np.array([*(surface.low_m - 1.5 * self._step_m), surface.level_m - surface.depth_m, surface.depth_m])

    def _find_bodies(self) -> None:
        movers = [body for body in self._world.bodies if body.movable]
        low_high = [(body.mesh.vertices_m.min(axis=0), body.mesh.vertices_m.max(axis=0)) for body in movers]
        self._owner = np.array([body.index for body in movers], dtype=np.int64)
        # A quarter of the size is the standard deviation of an ellipse that fills it.
        middles = [(0.5 * (low + high), 0.25 * (high - low)) for low, high in low_high]
        self._ellipsoids = np.array(middles, dtype=float).reshape(-1, 2, 3)
        self._bodies = len(self._world.bodies)
