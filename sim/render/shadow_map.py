"""Shadow maps: height towards the sun of the highest surface, drawn by the rasteriser's own kernels.

A map covers a square *region* of the plane perpendicular to the sun. Regions come from a fixed lattice (sides in powers
of sqrt 2, centres a sixth of a side apart). So the region of a view does not depend on earlier views, and neighbouring
views mostly share one: its fixed bodies are drawn once and kept. A view needs a part of its region only, so tiles are
drawn when they are first needed.
"""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sim.render.scene import SceneArrays, pack_shapes
from sim.render.shadow_kernels import draw_tiles
from sim.render.shadow_tiles import BLOCK, MapArrays, forget, new_map
from sim.world import World

_CENTRES_PER_SIDE = 6
_REGIONS_KEPT = 3
"""Regions kept, of eight megabytes each. A flight over a town draws a tenth of its regions twice; with six, few."""


@dataclass(frozen=True, slots=True)
class ShadowMap:
    """Heights of shadow casters.

    Attributes:
        height_m: (N, N) float32 along the direction towards the sun; ``NOTHING`` where there is no caster, and in
            the outermost texels. Valid until the next map is made, as is the next array.
        highest_m: (N / BLOCK, N / BLOCK) float32, the greatest height in each block of texels and the first row and
            column of the next ones: surfaces at least as high are lit.
        light_view: (4, 4) from the world to ``(column, row, 1, height)``.
        texel_m: side of a texel.
    """

    height_m: NDArray[np.float32]
    highest_m: NDArray[np.float32]
    light_view: NDArray[np.float64]
    texel_m: float


def light_axes(sun_direction: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return rows (3, 3): right, down and towards the sun; seen from the sun, x is right and y down."""
    towards = sun_direction / np.linalg.norm(sun_direction)
    aside = np.array([0.0, 1.0, 0.0]) if abs(towards[1]) < 0.9 else np.array([1.0, 0.0, 0.0])
    right = np.cross(aside, towards)
    right /= np.linalg.norm(right)
    # Forward, away from the sun, is right x down.
    return np.stack([right, np.cross(-towards, right), towards])


@dataclass(frozen=True, eq=False)
class Region:
    """A region that is kept.

    Attributes:
        light_view, texel_m: see ``ShadowMap``.
        in_map: (3, 4), the rows of ``light_view`` for column, row and height.
        arrays: its map.
    """

    light_view: NDArray[np.float64]
    in_map: NDArray[np.float64]
    texel_m: float
    arrays: MapArrays


class ShadowCaster:
    """Draws shadow maps of a world. Bodies of category ``ground`` receive shadows and cast none.

    Attributes:
        axes: see ``light_axes``.
    """

    def __init__(
        self,
        world: World,
        sun_direction: NDArray[np.float64],
        size: int = 1024,
        *,
        casting: Literal["all", "movers", "fixed"] = "all",
    ) -> None:
        """Set the bodies to draw.

        Args:
            size: side of a map in texels, a multiple of ``BLOCK``.
            casting: the bodies that cast a shadow: those that may move, those that never do, or all.
        """
        if size < BLOCK or size % BLOCK:
            raise ValueError(f"size: expected a positive multiple of {BLOCK}, got {size}")
        self._world = world
        self.axes = light_axes(np.asarray(sun_direction, dtype=float))
        self._size = size
        self._casting = casting
        self._body_count = -1
        self._kept: OrderedDict[tuple[int, int, int], Region] = OrderedDict()

    def turn(self, sun_direction: NDArray[np.float64]) -> None:
        """Let the sun stand elsewhere; regions and maps so far are invalid."""
        self.axes = light_axes(np.asarray(sun_direction, dtype=float))
        self._kept.clear()

    def region(self, low_m: NDArray[np.float64], high_m: NDArray[np.float64]) -> Region:
        """Return the region around two corners, with the tiles drawn so far.

        Args:
            low_m, high_m: (2,) along the first two of ``axes``.
        """
        self._pack()
        key = self._key(low_m, high_m)
        if key not in self._kept:
            self._kept[key] = self._new_region(key)
        self._kept.move_to_end(key)
        return self._kept[key]

    def draw(self, region: Region, wanted: NDArray[np.bool_]) -> ShadowMap:
        """Return the map of the latest region, with all bodies at their present poses.

        Args:
            wanted: (n, n) tiles to look up, see ``find_tiles``; the map is valid in these only.
        """
        arrays, view, movers = region.arrays, region.light_view, self._movers
        draw_tiles(self._scene, self._world.poses, view, self._fixed, movers, self._projected, wanted, arrays)
        return ShadowMap(arrays.height_m, arrays.highest_m, view, region.texel_m)

    def _key(self, low_m: NDArray[np.float64], high_m: NDArray[np.float64]) -> tuple[int, int, int]:
        # The lattice may miss the middle by half a step on either side; the outermost texels are empty.
        usable = 1.0 - 1.0 / _CENTRES_PER_SIDE - 4.0 / self._size
        # In plain floats: arrays of so few numbers take five times as long, for every picture.
        (low_x, low_y), (high_x, high_y) = low_m.tolist(), high_m.tolist()
        needed_m = max(high_x - low_x, high_y - low_y, 1.0) / usable
        level = int(np.ceil(2.0 * np.log2(needed_m)))
        step_m = _side_m(level) / _CENTRES_PER_SIDE
        return level, round(0.5 * (low_x + high_x) / step_m), round(0.5 * (low_y + high_y) / step_m)

    def _light_view(self, key: tuple[int, int, int], texel_m: float) -> NDArray[np.float64]:
        step_m = _side_m(key[0]) / _CENTRES_PER_SIDE
        view = np.zeros((4, 4))
        view[:2, :3] = self.axes[:2] / texel_m
        view[:2, 3] = 0.5 * self._size - np.array(key[1:]) * step_m / texel_m
        view[2, 3] = 1.0
        view[3, :3] = self.axes[2]
        return view

    def _new_region(self, key: tuple[int, int, int]) -> Region:
        texel_m = _side_m(key[0]) / self._size
        if len(self._kept) >= _REGIONS_KEPT:
            arrays = self._kept.popitem(last=False)[1].arrays
            forget(arrays)
        else:
            arrays = new_map(self._size, len(self._movers))
        light_view = self._light_view(key, texel_m)
        return Region(light_view, light_view[[0, 1, 3]], texel_m, arrays)

    def _pack(self) -> None:
        if self._body_count == len(self._world.bodies):
            return
        bodies = self._world.bodies
        casts = [body for body in bodies if body.category != "ground"]
        self._scene: SceneArrays = pack_shapes(self._world)
        self._movers, self._fixed = (
            np.array([body.index for body in casts if body.movable is moves and self._casting in kinds], dtype=np.int64)
            for moves, kinds in ((True, ("all", "movers")), (False, ("all", "fixed")))
        )
        self._projected = np.empty((int(np.diff(self._scene.first_vertex).max(initial=0)), 4))
        self._kept.clear()
        self._body_count = len(bodies)


def _side_m(level: int) -> float:
    return float(2.0 ** (0.5 * level))
