"""The sea in a thermal picture: what its facets emit and reflect of the sky, waves by waves.

A facet with slope s along the line of sight, seen at the grazing angle g, is seen at ``g + s`` and mirrors the sky at
the elevation ``g + 2 s``. Both are averaged over the slopes of waves that are too fine to be seen, weighted by what of
each facet faces the camera, ``1 + s / tan g``, and tabulated over ``sin g`` and s.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.render.compilation import row_kernel
from sim.thermal.radiance import band_radiance
from sim.thermal.sky import Air, sky_radiance
from sim.thermal.water import reflectance
from sim.thermal.waves import CELLS, LEVELS, TILE_M, SeaWaves
from sim.world import Body

SINES, SLOPES, STEEPEST = 96, 64, 0.6
"""Cells of the table, and the greatest slope in it."""
_QUADRATURE = 9
_LEAST_SINE = np.float32(0.01)
_HALF, _ONE, _ZERO = np.float32(0.5), np.float32(1.0), np.float32(0.0)
_PER_CELL = np.float32(CELLS / TILE_M)
_LAST_CELL = np.uint32(CELLS - 1)


@dataclass(frozen=True, eq=False)
class Sea:
    """The sea of a world.

    Attributes:
        body: a level surface; its z is the tide.
        waves: on it.
        temperature_k: of the water's skin.
    """

    body: Body
    waves: SeaWaves
    temperature_k: float


class SeaArrays(NamedTuple):
    """A sea for kernels, all float32.

    Attributes:
        body: index; -2 for none.
        slopes: (LEVELS, CELLS, CELLS, 2), each level a mean over twice as many cells as the one before.
        radiance: (SINES * SLOPES, 2): what facets emit, and what they reflect of the sky.
    """

    body: int
    slopes: NDArray[np.float32]
    radiance: NDArray[np.float32]


NO_SEA = SeaArrays(-2, np.zeros((LEVELS, CELLS, CELLS, 2), np.float32), np.zeros((SINES * SLOPES, 2), np.float32))


def radiance_table(air: Air, temperature_k: float, fine_slope: float) -> NDArray[np.float32]:
    """Return ``SeaArrays.radiance``."""
    sine = np.linspace(0.0, 1.0, SINES)[:, None, None]
    slope = np.linspace(-STEEPEST, STEEPEST, SLOPES)[:, None]
    nodes, weights = np.polynomial.hermite_e.hermegauss(_QUADRATURE)
    grazing = np.arcsin(np.maximum(sine, _LEAST_SINE))
    tilt = np.arctan(slope + fine_slope * nodes)
    facing = weights * np.maximum(np.sin(grazing + tilt), 1e-4) / np.cos(tilt)
    share = reflectance(np.clip(np.sin(grazing + tilt), 0.0, 1.0))
    # A facet that mirrors something below the horizon mirrors more of the sea, which looks like the sky's edge.
    mirrored = sky_radiance(air, np.maximum(np.sin(grazing + 2 * tilt), 0.0))
    emitted = (1.0 - share) * band_radiance(temperature_k)
    total = facing.sum(-1)
    both = [(facing * each).sum(-1) / total for each in (emitted, share * mirrored)]
    return np.stack(both, axis=-1).reshape(-1, 2).astype(np.float32)


def levels_of(slopes: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return ``SeaArrays.slopes`` of the finest ones (CELLS, CELLS, 2)."""
    levels = [slopes]
    for k in range(LEVELS - 1):
        fine, step = levels[-1], 1 << k
        along = fine + np.roll(fine, -step, axis=1)
        levels.append(np.float32(0.25) * (along + np.roll(along, -step, axis=0)))
    return np.stack(levels)


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def sea_run(
    sea: SeaArrays,
    ray: NDArray[np.float32],
    camera_m: NDArray[np.float32],
    pixel_rad: np.float32,
    row: int,
    first: np.uint64,
    last: np.uint64,
    depth_m: NDArray[np.float32],
    radiance: NDArray[np.float32],
) -> None:
    """Write the radiance of the pixels first … last - 1 of a row, which all show the sea, without the air before it.

    Args:
        ray: (3, 3), takes (x, y, 1) of a pixel to the world direction of unit depth.
        camera_m: (3,).
        pixel_rad: width of a pixel.
    """
    y = np.float32(row) + _HALF
    middle = (first + last) >> np.uint64(1)
    level = _level(ray, np.float32(np.int32(middle)), y, depth_m[middle], pixel_rad)
    slopes = sea.slopes[level]
    shift = _HALF * np.float32((1 << level) - 1)
    for column in range(first, last):
        x, z = np.float32(np.int32(column)) + _HALF, depth_m[column]
        dx = ray[0, 0] * x + ray[0, 1] * y + ray[0, 2]
        dy = ray[1, 0] * x + ray[1, 1] * y + ray[1, 2]
        dz = ray[2, 0] * x + ray[2, 1] * y + ray[2, 2]
        level_length = np.sqrt(dx * dx + dy * dy)
        sine = -dz / np.sqrt(dx * dx + dy * dy + dz * dz)
        u, v = (camera_m[0] + z * dx) * _PER_CELL - shift, (camera_m[1] + z * dy) * _PER_CELL - shift
        j, i = np.floor(u), np.floor(v)
        fu, fv = u - j, v - i
        j0, i0 = np.uint32(np.int32(j)) & _LAST_CELL, np.uint32(np.int32(i)) & _LAST_CELL
        j1, i1 = (j0 + np.uint32(1)) & _LAST_CELL, (i0 + np.uint32(1)) & _LAST_CELL
        sx = _mix(slopes[i0, j0, 0], slopes[i0, j1, 0], slopes[i1, j0, 0], slopes[i1, j1, 0], fu, fv)
        sy = _mix(slopes[i0, j0, 1], slopes[i0, j1, 1], slopes[i1, j0, 1], slopes[i1, j1, 1], fu, fv)
        slope = (sx * dx + sy * dy) / level_length
        a = min(max(sine, _ZERO), _ONE) * np.float32(SINES - 1)
        b = (min(max(slope, np.float32(-STEEPEST)), np.float32(STEEPEST)) + np.float32(STEEPEST)) * np.float32(
            (SLOPES - 1) / (2 * STEEPEST)
        )
        m, n = min(np.int32(a), np.int32(SINES - 2)), min(np.int32(b), np.int32(SLOPES - 2))
        fa, fb = a - np.float32(m), b - np.float32(n)
        at = np.uint32(m * np.int32(SLOPES) + n)
        under = at + np.uint32(SLOPES)
        one = np.uint32(1)
        t = sea.radiance
        emitted = _mix(t[at, 0], t[at + one, 0], t[under, 0], t[under + one, 0], fb, fa)
        mirrored = _mix(t[at, 1], t[at + one, 1], t[under, 1], t[under + one, 1], fb, fa)
        radiance[column] = emitted + mirrored


@row_kernel(forceinline=True)
def _mix(
    a00: np.float32, a01: np.float32, a10: np.float32, a11: np.float32, across: np.float32, down: np.float32
) -> np.float32:
    upper = a00 + (a01 - a00) * across
    return upper + (a10 + (a11 - a10) * across - upper) * down


@row_kernel(error_model="numpy")
def _level(ray: NDArray[np.float32], x: np.float32, y: np.float32, depth_m: np.float32, pixel_rad: np.float32) -> int:
    """Return the level whose cells are about as long as the pixel's patch of the sea."""
    dx = ray[0, 0] * x + ray[0, 1] * y + ray[0, 2]
    dy = ray[1, 0] * x + ray[1, 1] * y + ray[1, 2]
    dz = ray[2, 0] * x + ray[2, 1] * y + ray[2, 2]
    length = np.sqrt(dx * dx + dy * dy + dz * dz)
    cells = depth_m * length * pixel_rad / max(-dz / length, _LEAST_SINE) * _PER_CELL
    level = 0
    while level < LEVELS - 1 and cells > 1.5:
        cells *= 0.5
        level += 1
    return level


def sea_arrays(sea: Sea, table: NDArray[np.float32]) -> SeaArrays:
    """Return a sea as it is now; ``table`` is that of its temperature and sky."""
    return SeaArrays(sea.body.index, levels_of(sea.waves.slopes()), table)
