"""Where the sun has shone in the past hour, by shadow maps of what never moves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.checks import check
from sim.render.compilation import row_kernel
from sim.render.shadow_map import ShadowCaster
from sim.world import World

_TEXELS = 1024
MOST_SUNS = 8
_BIAS = np.float32(1.5)
_ONE, _HALF, _ZERO = np.float32(1.0), np.float32(0.5), np.float32(0.0)


class SunArrays(NamedTuple):
    """Positions of the sun, for kernels.

    Attributes:
        towards: (S, 3) float32 unit vectors. weight: (S,) float32, of each position.
        in_map: (S, 3, 4) float32, from the world to column, row and height of a shadow map.
        height_m: (S, N, N) float32. texel_m: (S,) float32, sides of texels.
        strongest: index of the greatest weight.
    """

    towards: NDArray[np.float32]
    weight: NDArray[np.float32]
    in_map: NDArray[np.float32]
    height_m: NDArray[np.float32]
    texel_m: NDArray[np.float32]
    strongest: int


class Suns:
    """The positions of the sun that surfaces remember.

    Attributes:
        arrays: for kernels.
    """

    def __init__(self, world: World, reach_m: float) -> None:
        """Start at night.

        Args:
            reach_m: shadows are cast by and on what is nearer than this to the world's origin.
        """
        check("reach_m", reach_m > 0, "a number > 0", reach_m)
        self._caster = ShadowCaster(world, np.array([0.0, 0.0, 1.0]), _TEXELS, casting="fixed")
        self._reach_m = reach_m
        self._maps: dict[tuple[float, ...], tuple[NDArray[np.float32], NDArray[np.float32], float]] = {}
        self.arrays = _arrays({})

    def set(self, towards_sun: Sequence[NDArray[np.float64]], weights: Sequence[float]) -> bool:
        """Set S positions (3,) and their weights; return whether ``find_light`` now finds another light anywhere.

        It does when positions change, and when another one becomes the strongest: what moves takes its light. A
        position that stays keeps its shadow map.
        """
        check("towards_sun", len(towards_sun) <= MOST_SUNS, f"at most {MOST_SUNS} positions", len(towards_sun))
        check("weights", len(weights) == len(towards_sun), f"{len(towards_sun)} numbers", len(weights))
        directions = [tuple(float(x) for x in each) for each in towards_sun]
        is_new = directions != list(self._maps)
        if is_new:
            self._maps = {each: self._maps.get(each) or self._shadows(each) for each in directions}
            self.arrays = _arrays(self._maps)
        strongest = max(range(len(weights)), key=lambda s: weights[s], default=-1)
        is_new |= strongest != self.arrays.strongest
        self.arrays = self.arrays._replace(weight=np.array(weights, np.float32), strongest=strongest)
        return is_new

    def _shadows(self, towards_sun: tuple[float, ...]) -> tuple[NDArray[np.float32], NDArray[np.float32], float]:
        """Return ``in_map``, heights and texel."""
        # One caster for all positions: packing the world takes longer than drawing a map.
        self._caster.turn(np.array(towards_sun))
        reach_m = np.full(2, self._reach_m)
        region = self._caster.region(-reach_m, reach_m)
        drawn = self._caster.draw(region, np.ones_like(region.arrays.drawn))
        return region.in_map.astype(np.float32), drawn.height_m.copy(), region.texel_m


def _arrays(maps: dict[tuple[float, ...], tuple[NDArray[np.float32], NDArray[np.float32], float]]) -> SunArrays:
    return SunArrays(
        np.array(list(maps), np.float32).reshape(-1, 3),
        np.empty(len(maps), np.float32),
        np.array([each[0] for each in maps.values()], np.float32).reshape(-1, 3, 4),
        np.array([each[1] for each in maps.values()], np.float32).reshape(-1, _TEXELS, _TEXELS),
        np.array([each[2] for each in maps.values()], np.float32),
        -1,
    )


@row_kernel(error_model="numpy")
def find_light(
    sun: SunArrays,
    x: np.float32,
    y: np.float32,
    z: np.float32,
    nx: np.float32,
    ny: np.float32,
    nz: np.float32,
    moves: bool,
    light: NDArray[np.float32],
) -> None:
    """Write ``lit * max(0, n . l)`` (S,) of a place (x, y, z) on a surface with this normal.

    What moves does not remember: the position of greatest weight counts for all.
    """
    for s in range(light.shape[0]):
        if moves and s != sun.strongest:
            continue
        cosine = nx * sun.towards[s, 0] + ny * sun.towards[s, 1] + nz * sun.towards[s, 2]
        light[s] = _ZERO
        if cosine > _ZERO:
            # Places are lifted off their surface by more than a texel: no surface shades itself.
            lift = _BIAS * sun.texel_m[s]
            light[s] = cosine * _lit(sun, s, x + lift * nx, y + lift * ny, z + lift * nz)
    if moves:
        for s in range(light.shape[0]):
            light[s] = light[sun.strongest]


@row_kernel()
def add_up(light: NDArray[np.float32], weight: NDArray[np.float32], exposure: NDArray[np.float32]) -> None:
    """Write the weighted sum (W,) of the light (S, W) of all positions."""
    for k in range(exposure.shape[0]):
        exposure[k] = _ZERO
    for s in range(weight.shape[0]):
        share, line = weight[s], light[s]
        for k in range(exposure.shape[0]):
            exposure[k] += share * line[k]


@row_kernel(error_model="numpy")
def _lit(sun: SunArrays, s: int, x: np.float32, y: np.float32, z: np.float32) -> np.float32:
    """Return the bilinear share of the four texels around a place that are not higher; 1 outside the map."""
    rows = sun.in_map[s]
    u = rows[0, 0] * x + rows[0, 1] * y + rows[0, 2] * z + rows[0, 3] - _HALF
    v = rows[1, 0] * x + rows[1, 1] * y + rows[1, 2] * z + rows[1, 3] - _HALF
    height = rows[2, 0] * x + rows[2, 1] * y + rows[2, 2] * z + rows[2, 3]
    size = np.float32(sun.height_m.shape[1] - 2)
    if not (u >= _ZERO and v >= _ZERO and u < size and v < size):
        return _ONE
    j, i = np.int32(u), np.int32(v)
    fu, fv, lit = u - np.float32(j), v - np.float32(i), _ZERO
    heights = sun.height_m[s]
    lit += (_ONE - fu) * (_ONE - fv) if heights[i, j] <= height else _ZERO
    lit += fu * (_ONE - fv) if heights[i, j + 1] <= height else _ZERO
    lit += (_ONE - fu) * fv if heights[i + 1, j] <= height else _ZERO
    lit += fu * fv if heights[i + 1, j + 1] <= height else _ZERO
    return lit
