"""The sea in a thermal picture: what its facets emit and reflect, waves by waves; see ``thermal_sea_tables``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.render.compilation import row_kernel
from sim.shaders.thermal.glitter import NO_GLITTER, GlitterArrays, glitter, may_glitter
from sim.shaders.thermal.mirror import CELL, NO_MIRROR, MirrorArrays, may_show, mirrored
from sim.shaders.thermal.sea_tables import FIRST, LEAST_SINE, SINES, SLOPES, STEEPEST, levels_of
from sim.thermal.radiance import band_radiance
from sim.thermal.waves import CELLS, LEVELS, TILE_M, SeaWaves
from sim.world import Body

_HALF, _ONE, _ZERO = np.float32(0.5), np.float32(1.0), np.float32(0.0)
_PER_CELL = np.float32(CELLS / TILE_M)
_STEEP, _PER_SLOPE = np.float32(STEEPEST), np.float32((SLOPES - 1) / (2 * STEEPEST))
_PER_SINE = np.float32(SINES - 1)
_REALS, _WHOLES = 8, 2
_BLOCK = np.uint64(2 * CELL)
"""Pixels of a row that are looked up in one cell of the mirror."""


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
        slopes: (cells of all levels, 2), from the finest level on; a cell is the mean of four of the level before.
        radiance: (SINES * SLOPES, 2): what facets emit, and what they reflect of the sky.
        black: radiance of a black body as warm as the water. fine_slope: see ``SeaState``.
        mirror, sun: what else they reflect.
    """

    body: int
    slopes: NDArray[np.float32]
    radiance: NDArray[np.float32]
    black: np.float32
    fine_slope: np.float32
    mirror: MirrorArrays
    sun: GlitterArrays


class SeaScratch(NamedTuple):
    """Scratch of ``sea_run``, for rows of W pixels.

    Attributes:
        real: (_REALS, W) float32. whole: (_WHOLES, W) uint32.
    """

    real: NDArray[np.float32]
    whole: NDArray[np.uint32]


def new_sea_scratch(width: int) -> SeaScratch:
    """Return scratch for rows of ``width`` pixels."""
    return SeaScratch(np.empty((_REALS, width), np.float32), np.empty((_WHOLES, width), np.uint32))


NO_SEA = SeaArrays(
    -2,
    np.zeros((FIRST[-1], 2), np.float32),
    np.zeros((SINES * SLOPES, 2), np.float32),
    _ONE,
    _ONE,
    NO_MIRROR,
    NO_GLITTER,
)


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
    scratch: SeaScratch,
    radiance: NDArray[np.float32],
) -> None:
    """Write the radiance of the pixels first … last - 1 of a row, which all show the sea, without the air before it.

    Args:
        ray: (3, 3), takes (x, y, 1) of a pixel to the world direction of unit depth.
        camera_m: (3,).
        pixel_rad: width of a pixel.
    """
    y, count = np.float32(row) + _HALF, last - first
    middle = (first + last) >> np.uint64(1)
    level = _level(ray, np.float32(np.int32(middle)), y, depth_m[middle], pixel_rad)
    _place_run(ray, camera_m, np.float32(np.int32(first)), y, level, depth_m[first:last], scratch, count)
    side = np.uint32(CELLS >> level)
    _slope_run(sea.slopes[FIRST[level] :], side, scratch, count)
    _look_up_run(sea.radiance, scratch, radiance[first:last])
    real, emitted, half = scratch.real, scratch.real[7], count >> np.uint64(1)
    _reflect_run(sea, np.float32(np.int32(first)), y, depth_m[first:last], scratch, radiance[first:last])
    for k in range(count):
        radiance[first + k] += emitted[k]
    if may_glitter(sea.sun, real[2, half], real[3, half], real[4, half] / _PER_SINE, sea.fine_slope):
        for k in range(count):
            slope = real[5, k] / _PER_SLOPE - _STEEP
            sine = real[4, k] / _PER_SINE
            radiance[first + k] += glitter(sea.sun, real[2, k], real[3, k], sine, slope, real[6, k], sea.fine_slope)


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def _place_run(
    ray: NDArray[np.float32],
    camera_m: NDArray[np.float32],
    start: np.float32,
    y: np.float32,
    level: int,
    depth_m: NDArray[np.float32],
    scratch: SeaScratch,
    count: np.uint64,
) -> None:
    """Write the cells (numbers and shares of the next ones), the level direction of sight and the row in the table."""
    x0, y0 = ray[0, 1] * y + ray[0, 2], ray[1, 1] * y + ray[1, 2]
    z0 = ray[2, 1] * y + ray[2, 2]
    per_cell = _PER_CELL / np.float32(1 << level)
    # The middle of a coarse cell is that of its fine ones, whose values are at whole numbers.
    shift = _HALF / np.float32(1 << level) - _HALF
    u0, v0 = camera_m[0] * per_cell + shift, camera_m[1] * per_cell + shift
    real, whole = scratch.real, scratch.whole
    fu, fv, along_x, along_y, place = real[0], real[1], real[2], real[3], real[4]
    j, i = whole[0], whole[1]
    for k in range(count):
        x = start + np.float32(np.int32(k)) + _HALF
        dx, dy, dz = ray[0, 0] * x + x0, ray[1, 0] * x + y0, ray[2, 0] * x + z0
        level_square = dx * dx + dy * dy
        per_length = _ONE / np.sqrt(level_square)
        sine = -dz / np.sqrt(level_square + dz * dz)
        far = depth_m[k] * per_cell
        u, v = u0 + far * dx, v0 + far * dy
        below_u, below_v = np.floor(u), np.floor(v)
        fu[k], fv[k] = u - below_u, v - below_v
        j[k], i[k] = np.uint32(np.int32(below_u)), np.uint32(np.int32(below_v))
        along_x[k], along_y[k] = dx * per_length, dy * per_length
        place[k] = min(max(sine, _ZERO), _ONE) * _PER_SINE


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def _slope_run(slopes: NDArray[np.float32], side: np.uint32, scratch: SeaScratch, count: np.uint64) -> None:
    """Write the slope along the line of sight, as a column of the table, and the one across."""
    real, whole, mask, one = scratch.real, scratch.whole, side - np.uint32(1), np.uint32(1)
    fu, fv, along_x, along_y, column, across = real[0], real[1], real[2], real[3], real[5], real[6]
    for k in range(count):
        j0, i0 = whole[0, k] & mask, (whole[1, k] & mask) * side
        j1, i1 = (whole[0, k] + one) & mask, ((whole[1, k] + one) & mask) * side
        a, b, c, d = i0 + j0, i0 + j1, i1 + j0, i1 + j1
        sx = _mix(slopes[a, 0], slopes[b, 0], slopes[c, 0], slopes[d, 0], fu[k], fv[k])
        sy = _mix(slopes[a, 1], slopes[b, 1], slopes[c, 1], slopes[d, 1], fu[k], fv[k])
        slope = sx * along_x[k] + sy * along_y[k]
        across[k] = sy * along_x[k] - sx * along_y[k]
        column[k] = (min(max(slope, -_STEEP), _STEEP) + _STEEP) * _PER_SLOPE


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def _look_up_run(table: NDArray[np.float32], scratch: SeaScratch, radiance: NDArray[np.float32]) -> None:
    """Write what is reflected of the sky at the places in the table, and what is emitted to the scratch."""
    emitted, place, column = scratch.real[7], scratch.real[4], scratch.real[5]
    one, pitch = np.uint32(1), np.uint32(SLOPES)
    for k in range(radiance.shape[0]):
        m = min(np.int32(place[k]), np.int32(SINES - 2))
        n = min(np.int32(column[k]), np.int32(SLOPES - 2))
        down, across = place[k] - np.float32(m), column[k] - np.float32(n)
        at = np.uint32(m) * pitch + np.uint32(n)
        under = at + pitch
        emitted[k] = _mix(table[at, 0], table[at + one, 0], table[under, 0], table[under + one, 0], across, down)
        radiance[k] = _mix(table[at, 1], table[at + one, 1], table[under, 1], table[under + one, 1], across, down)


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def _reflect_run(
    sea: SeaArrays,
    start: np.float32,
    y: np.float32,
    depth_m: NDArray[np.float32],
    scratch: SeaScratch,
    radiance: NDArray[np.float32],
) -> None:
    """Replace the sky's reflection (K,) by that of what stands before it."""
    emitted, column = scratch.real[7], scratch.real[5]
    count = np.uint64(radiance.shape[0])
    for block in range(np.uint64(0), count, _BLOCK):
        last = min(block + _BLOCK, count)
        if not (
            may_show(sea.mirror, start + np.float32(np.int32(block)), y)
            or may_show(sea.mirror, start + np.float32(np.int32(last)), y)
        ):
            continue
        # The mirrored picture has fewer pixels: neighbours share a look-up.
        for k in range(block, last, np.uint64(2)):
            slope = column[k] / _PER_SLOPE - _STEEP
            share = _ONE - emitted[k] / sea.black
            x, sky = start + np.float32(np.int32(k)) + _ONE, radiance[k]
            beside = min(k + np.uint64(1), last - np.uint64(1))
            seen = mirrored(sea.mirror, x, y, depth_m[k], slope, sea.fine_slope, share, sky)
            radiance[beside] += seen - sky
            radiance[k] = seen


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
    cells = depth_m * length * pixel_rad / max(-dz / length, LEAST_SINE) * _PER_CELL
    level = 0
    while level < LEVELS - 1 and cells > 1.5:
        cells *= 0.5
        level += 1
    return level


def sea_arrays(sea: Sea, table: NDArray[np.float32], mirror: MirrorArrays, sun: GlitterArrays) -> SeaArrays:
    """Return a sea as it is now; ``table`` is that of its temperature and sky."""
    return SeaArrays(
        sea.body.index,
        levels_of(sea.waves.slopes()),
        table,
        np.float32(band_radiance(sea.temperature_k)),
        np.float32(sea.waves.state.fine_slope),
        mirror,
        sun,
    )
