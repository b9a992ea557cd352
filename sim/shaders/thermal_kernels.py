"""The kernels of ``sim.shaders.thermal``, a row of pixels at a time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.gbuffer import SKY
from sim.render.attributes import SurfaceRow
from sim.render.compilation import row_kernel
from sim.render.runs import find_runs
from sim.shaders.thermal_sea import SeaArrays, SeaScratch, new_sea_scratch, sea_run
from sim.thermal.radiance import COLDEST_K, TABLE, TABLE_STEP_K

PARTS = 16
SKY_CELLS = 128
VARIATION_K = 4.0 / 127.0

_BYTE = np.uint32(255)
_ONE, _HALF, _ZERO = np.float32(1.0), np.float32(0.5), np.float32(0.0)
_LAST_PART = np.uint32(PARTS - 1)
_COLDEST_K, _PER_K = np.float32(COLDEST_K), np.float32(1.0 / TABLE_STEP_K)
_LAST_ENTRY = np.float32(len(TABLE) - 1.001)
_BIAS = np.float32(1.5)


class SunArrays(NamedTuple):
    """Where the sun has shone, for kernels.

    Attributes:
        towards: (S, 3) float32 unit vectors. weight: (S,) float32, of each position of the sun.
        in_map: (S, 3, 4) float32, from the world to column, row and height of a shadow map.
        height_m: (S, N, N) float32. texel_m: (S,) float32, sides of texels.
    """

    towards: NDArray[np.float32]
    weight: NDArray[np.float32]
    in_map: NDArray[np.float32]
    height_m: NDArray[np.float32]
    texel_m: NDArray[np.float32]


class KeptPicture(NamedTuple):
    """The latest picture of a view. A pixel that shows the same place of the same body again is in the same sun, and
    has the same radiance until temperatures change.

    Attributes:
        depth_m, instance_id: (H, W) what was seen.
        exposure: (H, W) float32, ``sum_s weight * lit * max(0, n . l)``.
        radiance: (H, W) float32, of what never moves.
        version: (H,) int64, of the temperatures in each row.
    """

    depth_m: NDArray[np.float32]
    instance_id: NDArray[np.int32]
    exposure: NDArray[np.float32]
    radiance: NDArray[np.float32]
    version: NDArray[np.int64]


class ThermalArrays(NamedTuple):
    """Temperatures of a world in one picture, all float32 where nothing else is said.

    Attributes:
        shaded_k, warmth_k, emissivity: (B * PARTS,), of each part of each body: in the shade, what full sun adds, and
            emissivity.
        planck: radiance at ``COLDEST_K`` + n ``TABLE_STEP_K``.
        sky: (SKY_CELLS,) radiance by the sine of the elevation, from 0 to 1.
        around: (2,) mean radiance of the sky, and that of the ground.
        air: (2,) attenuation a metre, radiance of the air.
        ray: (3, 3), takes (x, y, 1) of a pixel to the world direction of unit depth. camera_m: (3,).
        pixel_rad: width of a pixel.
        moves: (B,) bool, the bodies whose radiance is not kept. version: of the temperatures of the others.
        sun, kept, sea: see there.
    """

    shaded_k: NDArray[np.float32]
    warmth_k: NDArray[np.float32]
    emissivity: NDArray[np.float32]
    planck: NDArray[np.float32]
    sky: NDArray[np.float32]
    around: NDArray[np.float32]
    air: NDArray[np.float32]
    ray: NDArray[np.float32]
    camera_m: NDArray[np.float32]
    pixel_rad: np.float32
    moves: NDArray[np.bool_]
    version: int
    sun: SunArrays
    kept: KeptPicture
    sea: SeaArrays


class ThermalScratch(NamedTuple):
    """Scratch of ``thermal_row``, for rows of W pixels.

    Attributes:
        firsts: of runs (> W,).
        sea: see there.
    """

    firsts: NDArray[np.uint32]
    sea: SeaScratch


def new_thermal_scratch(width: int) -> ThermalScratch:
    """Return scratch for rows of ``width`` pixels."""
    return ThermalScratch(np.empty(width + 1, np.uint32), new_sea_scratch(width))


@row_kernel(error_model="numpy")
def thermal_row(
    light: ThermalArrays, row: int, surfaces: SurfaceRow, scratch: ThermalScratch, radiance: NDArray[np.float32]
) -> None:
    """Write the radiance (1, W) of one row."""
    out, kept = radiance[0], light.kept
    is_current = kept.version[row] == light.version
    runs = find_runs(surfaces.instance_id, scratch.firsts)
    for run in range(runs):
        first, last = np.uint64(scratch.firsts[run]), np.uint64(scratch.firsts[run + np.uint64(1)])
        body = surfaces.instance_id[first]
        if body == SKY:
            _sky_run(light, row, first, last, out)
            continue
        if body == light.sea.body:
            sea_run(
                light.sea,
                light.ray,
                light.camera_m,
                light.pixel_rad,
                row,
                first,
                last,
                surfaces.depth_m,
                scratch.sea,
                out,
            )
            _air_run(light, row, first, last, surfaces.depth_m, out)
            continue
        is_same = _is_same(kept.depth_m[row], kept.instance_id[row], surfaces, first, last)
        if is_same and is_current and not light.moves[body]:
            _copy_run(kept.radiance[row], out, first, last)
            continue
        if not is_same:
            _expose_run(light, row, surfaces, first, last)
        _body_run(light, row, body, first, last, surfaces, out)
        _air_run(light, row, first, last, surfaces.depth_m, out)
        _copy_run(out, kept.radiance[row], first, last)
    kept.version[row] = light.version


@row_kernel(forceinline=True)
def _copy_run(source: NDArray[np.float32], target: NDArray[np.float32], first: np.uint64, last: np.uint64) -> None:
    for column in range(first, last):
        target[column] = source[column]


@row_kernel()
def _is_same(
    depth_m: NDArray[np.float32],
    instance_id: NDArray[np.int32],
    surfaces: SurfaceRow,
    first: np.uint64,
    last: np.uint64,
) -> bool:
    """Return whether the pixels first … last - 1 show what they showed before."""
    changes, now_m, now_id = np.int32(0), surfaces.depth_m, surfaces.instance_id
    for column in range(first, last):
        changes |= np.int32(now_m[column] != depth_m[column]) | (now_id[column] ^ instance_id[column])
    return changes == 0


@row_kernel(error_model="numpy", fastmath={"contract", "arcp", "nsz"})
def _body_run(
    light: ThermalArrays,
    row: int,
    body: np.int32,
    first: np.uint64,
    last: np.uint64,
    surfaces: SurfaceRow,
    radiance: NDArray[np.float32],
) -> None:
    """``L = e B(T) + (1 - e) (sky (1 + n_z) / 2 + ground (1 - n_z) / 2)``."""
    exposure, normal_z, planck = light.kept.exposure[row], surfaces.normal[2], light.planck
    level, tilt = _HALF * (light.around[0] + light.around[1]), _HALF * (light.around[0] - light.around[1])
    base = np.uint32(body) * np.uint32(PARTS)
    for column in range(first, last):
        colour = surfaces.colour[column]
        part = base + min(colour & _BYTE, _LAST_PART)
        varied = np.float32(np.int32((colour >> np.uint32(8)) & _BYTE) - np.int32(128)) * np.float32(VARIATION_K)
        kelvin = light.shaded_k[part] + light.warmth_k[part] * exposure[column] + varied
        place = min(max((kelvin - _COLDEST_K) * _PER_K, _ZERO), _LAST_ENTRY)
        entry = np.uint32(place)
        black = planck[entry] + (planck[entry + np.uint32(1)] - planck[entry]) * (place - np.float32(entry))
        emissivity = light.emissivity[part]
        radiance[column] = emissivity * black + (_ONE - emissivity) * (level + tilt * normal_z[column])


@row_kernel(error_model="numpy", fastmath={"contract", "arcp", "nsz"})
def _sky_run(light: ThermalArrays, row: int, first: np.uint64, last: np.uint64, radiance: NDArray[np.float32]) -> None:
    """Write the sky's radiance, interpolated."""
    ray, y = light.ray, np.float32(row) + _HALF
    for column in range(first, last):
        x = np.float32(np.int32(column)) + _HALF
        dx = ray[0, 0] * x + ray[0, 1] * y + ray[0, 2]
        dy = ray[1, 0] * x + ray[1, 1] * y + ray[1, 2]
        dz = ray[2, 0] * x + ray[2, 1] * y + ray[2, 2]
        sine = max(dz, _ZERO) / np.sqrt(dx * dx + dy * dy + dz * dz)
        place = sine * np.float32(SKY_CELLS - 1.001)
        cell = np.uint32(place)
        radiance[column] = light.sky[cell] + (light.sky[cell + np.uint32(1)] - light.sky[cell]) * (
            place - np.float32(cell)
        )


@row_kernel(error_model="numpy", fastmath={"contract", "arcp", "nsz"})
def _air_run(
    light: ThermalArrays,
    row: int,
    first: np.uint64,
    last: np.uint64,
    depth_m: NDArray[np.float32],
    radiance: NDArray[np.float32],
) -> None:
    """``L exp(-a d) + L_air (1 - exp(-a d))`` with ``exp(-x) = 1 / (1 + x + x²/2 + x³/6 + x⁴/24)``, to 1e-4 for x < 1
    (and vector code).
    """
    ray, y, attenuation, air = light.ray, np.float32(row) + _HALF, light.air[0], light.air[1]
    for column in range(first, last):
        x = np.float32(np.int32(column)) + _HALF
        dx = ray[0, 0] * x + ray[0, 1] * y + ray[0, 2]
        dy = ray[1, 0] * x + ray[1, 1] * y + ray[1, 2]
        dz = ray[2, 0] * x + ray[2, 1] * y + ray[2, 2]
        t = attenuation * depth_m[column] * np.sqrt(dx * dx + dy * dy + dz * dz)
        grown = _ONE + t * (_ONE + t * (_HALF + t * (np.float32(1 / 6) + t * np.float32(1 / 24))))
        radiance[column] = air + (radiance[column] - air) / grown


@row_kernel(error_model="numpy")
def _expose_run(light: ThermalArrays, row: int, surfaces: SurfaceRow, first: np.uint64, last: np.uint64) -> None:
    """Find the sun on the pixels first … last - 1 that show something else than before."""
    depth_m, instance_id = light.kept.depth_m[row], light.kept.instance_id[row]
    for column in range(first, last):
        if surfaces.depth_m[column] != depth_m[column] or surfaces.instance_id[column] != instance_id[column]:
            depth_m[column], instance_id[column] = surfaces.depth_m[column], surfaces.instance_id[column]
            light.kept.exposure[row, column] = _exposure(light, row, column, surfaces)


@row_kernel(error_model="numpy")
def _exposure(light: ThermalArrays, row: int, column: np.uint64, surfaces: SurfaceRow) -> np.float32:
    z = surfaces.depth_m[column]
    x, y, sun = np.float32(np.int32(column)) + _HALF, np.float32(row) + _HALF, light.sun
    px = light.camera_m[0] + z * (light.ray[0, 0] * x + light.ray[0, 1] * y + light.ray[0, 2])
    py = light.camera_m[1] + z * (light.ray[1, 0] * x + light.ray[1, 1] * y + light.ray[1, 2])
    pz = light.camera_m[2] + z * (light.ray[2, 0] * x + light.ray[2, 1] * y + light.ray[2, 2])
    nx, ny, nz = surfaces.normal[0, column], surfaces.normal[1, column], surfaces.normal[2, column]
    total = _ZERO
    for s in range(sun.weight.shape[0]):
        cosine = nx * sun.towards[s, 0] + ny * sun.towards[s, 1] + nz * sun.towards[s, 2]
        if cosine > _ZERO:
            # Places are lifted off their surface by more than a texel: no surface shades itself.
            lift = _BIAS * sun.texel_m[s]
            total += sun.weight[s] * cosine * _lit(sun, s, px + lift * nx, py + lift * ny, pz + lift * nz)
    return total


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
