"""Shadow maps: how high, towards the sun, the nearest surface lies, drawn by the rasteriser's own kernels.

A map covers a square *region* of the plane square to the sun. Regions come from a fixed lattice (sides in
powers of sqrt 2, centres a sixth of a side apart), so which region a view gets depends on the view alone and
never on the views before it, while neighbouring views mostly share one: bodies that never move are drawn once
for a region and kept.
"""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.render.scene import SceneArrays, pack_geometry
from sim.render.shadow_kernels import BLOCK, draw_fixed, find_highest, redraw_movers
from sim.world import World

NOTHING = np.float32(-1e30)
"""Height in a texel that no caster covers."""

_CENTRES_PER_SIDE = 6
_REGIONS_KEPT = 3
"""Eight megabytes each. A flight over a town draws a tenth of its regions twice; with six kept, none to speak of."""


@dataclass(frozen=True, slots=True)
class ShadowMap:
    """Heights of shadow casters.

    Attributes:
        height_m: (N, N) float32 along the direction towards the sun; ``NOTHING`` where there is no caster, and in
            the outermost texels. Valid until the next map is made, as is the next array.
        highest_m: (N / BLOCK, N / BLOCK) float32, the greatest height in each block of texels and the first row and
            column of the next ones: what is not lower there is lit without looking further.
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


class _Region:
    """What is kept of a region: heights without and with movers, the movers' boxes in it, and their poses by then."""

    def __init__(self, size: int, mover_count: int) -> None:
        self.fixed_m = np.empty((size, size), np.float32)
        self.height_m = np.empty((size, size), np.float32)
        self.highest_m = np.empty((size // BLOCK, size // BLOCK), np.float32)
        self.changed = np.zeros((mover_count, 4), np.int64)
        self.poses_drawn = np.empty((0, 4, 4))


class ShadowCaster:
    """Draws shadow maps of a world. Bodies of category ``ground`` receive shadows and cast none.

    Attributes:
        axes: see ``light_axes``.
    """

    def __init__(
        self, world: World, sun_direction: NDArray[np.float64], size: int = 1024, *, movers_only: bool = False
    ) -> None:
        """Set what is drawn.

        Args:
            size: side of a map in texels, a multiple of ``BLOCK``.
            movers_only: what never moves casts no shadow either.
        """
        if size < BLOCK or size % BLOCK:
            raise ValueError(f"size: expected a positive multiple of {BLOCK}, got {size}")
        self._world = world
        self.axes = light_axes(np.asarray(sun_direction, dtype=float))
        self._size = size
        self._movers_only = movers_only
        self._body_count = -1
        self._kept: OrderedDict[tuple[int, int, int], _Region] = OrderedDict()

    def covering(self, low_m: NDArray[np.float64], high_m: NDArray[np.float64]) -> ShadowMap:
        """Return the map of the region between two corners, with all bodies where they are now.

        Args:
            low_m, high_m: (2,) along the first two of ``axes``.
        """
        self._pack()
        key = self._region(low_m, high_m)
        texel_m = _side_m(key[0]) / self._size
        light_view = self._light_view(key, texel_m)
        if key not in self._kept:
            self._keep(key, light_view)
        self._kept.move_to_end(key)
        region = self._kept[key]
        poses = self._world.poses[self._movers]
        if not np.array_equal(poses, region.poses_drawn):
            region.poses_drawn = poses
            redraw_movers(
                self._scene,
                self._world.poses,
                light_view,
                self._movers,
                self._projected,
                region.fixed_m,
                region.height_m,
                region.highest_m,
                region.changed,
            )
        return ShadowMap(region.height_m, region.highest_m, light_view, texel_m)

    def _region(self, low_m: NDArray[np.float64], high_m: NDArray[np.float64]) -> tuple[int, int, int]:
        # The lattice may miss the middle by half a step on either side; the outermost texels are empty.
        usable = 1.0 - 1.0 / _CENTRES_PER_SIDE - 4.0 / self._size
        needed_m = max(float((high_m - low_m).max()), 1.0) / usable
        level = int(np.ceil(2.0 * np.log2(needed_m)))
        step_m = _side_m(level) / _CENTRES_PER_SIDE
        column, row = np.round(0.5 * (low_m + high_m) / step_m).astype(int)
        return level, int(column), int(row)

    def _light_view(self, key: tuple[int, int, int], texel_m: float) -> NDArray[np.float64]:
        step_m = _side_m(key[0]) / _CENTRES_PER_SIDE
        view = np.zeros((4, 4))
        view[:2, :3] = self.axes[:2] / texel_m
        view[:2, 3] = 0.5 * self._size - np.array(key[1:]) * step_m / texel_m
        view[2, 3] = 1.0
        view[3, :3] = self.axes[2]
        return view

    def _keep(self, key: tuple[int, int, int], light_view: NDArray[np.float64]) -> None:
        if len(self._kept) >= _REGIONS_KEPT:
            region = self._kept.popitem(last=False)[1]
        else:
            region = _Region(self._size, len(self._movers))
        region.fixed_m[:] = NOTHING
        draw_fixed(self._scene, self._world.poses, light_view, self._fixed, self._projected, region.fixed_m)
        region.height_m[:] = region.fixed_m
        find_highest(region.height_m, np.array([0, self._size, 0, self._size]), region.highest_m)
        region.changed[:] = 0
        region.poses_drawn = np.empty((0, 4, 4))
        self._kept[key] = region

    def _pack(self) -> None:
        if self._body_count == len(self._world.bodies):
            return
        bodies = self._world.bodies
        casts = [body for body in bodies if body.category != "ground"]
        self._scene: SceneArrays = pack_geometry([body.mesh for body in bodies])
        self._movers = np.array([body.index for body in casts if body.movable], dtype=np.int64)
        self._fixed = np.array(
            [body.index for body in casts if not body.movable and not self._movers_only], dtype=np.int64
        )
        self._projected = np.empty((int(np.diff(self._scene.first_vertex).max(initial=0)), 4))
        self._kept.clear()
        self._body_count = len(bodies)


def _side_m(level: int) -> float:
    return float(2.0 ** (0.5 * level))
