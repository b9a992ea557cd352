"""The sea in a thermal picture: what its facets emit and reflect, waves by waves, and the sun's glitter.

A facet mirrors the sun to the camera if its normal lies halfway between the two. Of water whose fine slopes are
normally distributed about those of the waves that are seen, with the deviation sigma,

    L = rho E p(s) / (4 sin(grazing) cos(tilt)^4),   p = exp(-|s - s_seen|² / (2 sigma²)) / (2 pi sigma²)

E is the irradiance by the sun of a surface that faces it, rho the reflectance at half the angle between sun and camera.

A facet with slope s along the line of sight, seen at the grazing angle g, is seen at ``g + s`` and mirrors the sky at
the elevation ``g + 2 s``. Both are averaged over the slopes of waves that are too fine to be seen, weighted by what of
each facet faces the camera, ``1 + s / tan g``, and tabulated over ``sin g`` and s.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.constants import Boltzmann, Planck, speed_of_light

from sim.render.compilation import row_kernel
from sim.shaders.thermal.mirror import CELL, NO_MIRROR, MirrorArrays, may_show, mirrored
from sim.thermal.radiance import BAND_M, Air, air_mass, band_radiance, reflectance, sky_radiance
from sim.thermal.waves import CELLS, LEVELS, TILE_M, SeaWaves
from sim.world import Body

_SUN_K, _SUN_SR = 5772.0, 6.8e-5
_ONE, _ZERO, _HALF, _TWO = np.float32(1.0), np.float32(0.0), np.float32(0.5), np.float32(2.0)
_CELLS = 257
_MIRRORED = reflectance(np.linspace(0.0, 1.0, _CELLS)).astype(np.float32)
_LAST_CELL = np.float32(_CELLS - 1)
_FARTHEST = np.float32(4.0)
"""Deviations beyond which there is no glitter."""
_STEEPEST = np.float32(0.6)


class GlitterArrays(NamedTuple):
    """The sun, for kernels, float32.

    Attributes:
        towards: (3,) unit vector.
        irradiance: in the band, W/m², 0 for no sun.
        reflected: reflectance of water by the cosine of the angle of incidence, from 0 to 1.
    """

    towards: NDArray[np.float32]
    irradiance: np.float32
    reflected: NDArray[np.float32]


NO_GLITTER = GlitterArrays(np.zeros(3, np.float32), _ZERO, _MIRRORED)


def _outside_air_wm2() -> float:
    """Return the sun's irradiance in the band above the air: Planck's law, summed."""
    wavelength_m = np.linspace(*BAND_M, 601)
    photon = Planck * speed_of_light / (wavelength_m * Boltzmann * _SUN_K)
    spectral = 2.0 * Planck * speed_of_light**2 / wavelength_m**5 / np.expm1(photon)
    return float(_SUN_SR * np.trapezoid(spectral, wavelength_m))


_OUTSIDE_AIR_WM2 = _outside_air_wm2()


def glitter_arrays(towards_sun: NDArray[np.float32], air: Air) -> GlitterArrays:
    """Return the sun (3,) through gaps between clouds and through the clear air, which absorbs as much as it emits."""
    if towards_sun[2] <= 0.0:
        return NO_GLITTER
    passed = (1.0 - air.cloud) * (1.0 - air.zenith_emissivity) ** float(air_mass(towards_sun[2]))
    return GlitterArrays(towards_sun, np.float32(passed * _OUTSIDE_AIR_WM2), _MIRRORED)


@row_kernel(error_model="numpy")
def may_glitter(
    sun: GlitterArrays, along_x: np.float32, along_y: np.float32, sine: np.float32, fine_slope: np.float32
) -> bool:
    """Return whether water seen at a grazing angle along the level direction (x, y) may mirror the sun."""
    if sun.irradiance == _ZERO:
        return False
    cosine = np.sqrt(_ONE - sine * sine)
    nx, ny, nz = sun.towards[0] - cosine * along_x, sun.towards[1] - cosine * along_y, sun.towards[2] + sine
    return abs(nx * along_y - ny * along_x) < (_FARTHEST * fine_slope + _STEEPEST * _HALF) * nz


@row_kernel(error_model="numpy", fastmath={"contract", "arcp", "nsz"})
def glitter(
    sun: GlitterArrays,
    along_x: np.float32,
    along_y: np.float32,
    sine: np.float32,
    slope_along: np.float32,
    slope_across: np.float32,
    fine_slope: np.float32,
) -> np.float32:
    """Return the radiance that glitter adds.

    Args:
        along_x, along_y: level direction of sight, a unit vector.
        sine: of the grazing angle.
        slope_along, slope_across: of the waves that are seen; across is to the left of the sight.
        fine_slope: sigma.
    """
    cosine = np.sqrt(max(_ONE - sine * sine, _ZERO))
    nx, ny, nz = sun.towards[0] - cosine * along_x, sun.towards[1] - cosine * along_y, sun.towards[2] + sine
    away_along = -(nx * along_x + ny * along_y) / nz - slope_along
    away_across = -(ny * along_x - nx * along_y) / nz - slope_across
    spread = _TWO * fine_slope * fine_slope
    square = (away_along * away_along + away_across * away_across) / spread
    if square > _HALF * _FARTHEST * _FARTHEST:
        return _ZERO
    length = np.sqrt(nx * nx + ny * ny + nz * nz)
    share = sun.reflected[np.uint32(_HALF * length * _LAST_CELL)]
    tilt = nz / length
    density = np.exp(-square) / (np.float32(np.pi) * spread)
    return share * sun.irradiance * density / (np.float32(4.0) * max(sine, np.float32(0.02)) * tilt**4)


SINES, SLOPES, STEEPEST = 96, 64, 0.6
"""Cells of the table, and the greatest slope in it."""
FIRST = np.cumsum([0] + [(CELLS >> level) ** 2 for level in range(LEVELS)]).astype(np.uint32)
"""First cell of each level."""
LEAST_SINE = np.float32(0.01)
_QUADRATURE = 9
_COSINES = np.linspace(0.0, 1.0, 1025)
_REFLECTED = reflectance(_COSINES)


def radiance_table(air: Air, temperature_k: float, fine_slope: float) -> NDArray[np.float32]:
    """Return ``SeaArrays.radiance``."""
    sine = np.linspace(0.0, 1.0, SINES)[:, None, None]
    slope = np.linspace(-STEEPEST, STEEPEST, SLOPES)[:, None]
    nodes, weights = np.polynomial.hermite_e.hermegauss(_QUADRATURE)
    grazing = np.arcsin(np.maximum(sine, LEAST_SINE))
    tilt = np.arctan(slope + fine_slope * nodes)
    facing = weights * np.maximum(np.sin(grazing + tilt), 1e-4) / np.cos(tilt)
    share = np.interp(np.sin(grazing + tilt), _COSINES, _REFLECTED)
    # A facet that mirrors something below the horizon mirrors more of the sea, which looks like the sky's edge.
    mirrored = sky_radiance(air, np.maximum(np.sin(grazing + 2 * tilt), 0.0))
    emitted = (1.0 - share) * band_radiance(temperature_k)
    total = facing.sum(-1)
    both = [(facing * each).sum(-1) / total for each in (emitted, share * mirrored)]
    return np.stack(both, axis=-1).reshape(-1, 2).astype(np.float32)


@njit(cache=True)
def levels_of(slopes: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return ``SeaArrays.slopes`` of the finest ones (CELLS, CELLS, 2)."""
    levels = np.empty((FIRST[-1], 2), np.float32)
    levels[: CELLS * CELLS] = slopes.reshape(-1, 2)
    for level in range(1, LEVELS):
        side, fine, own = CELLS >> level, FIRST[level - 1], FIRST[level]
        for i in range(side):
            for j in range(side):
                at = fine + 4 * i * side + 2 * j
                for c in range(2):
                    four = levels[at, c] + levels[at + 1, c] + levels[at + 2 * side, c] + levels[at + 2 * side + 1, c]
                    levels[own + i * side + j, c] = np.float32(0.25) * four
    return levels


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


@row_kernel()
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
