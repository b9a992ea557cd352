"""The kernels of ``sim.shaders.thermal.shader``, a row of pixels at a time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.gbuffer import SKY
from sim.render.attributes import SurfaceRow
from sim.render.compilation import row_kernel
from sim.render.runs import find_runs
from sim.shaders.thermal.sea import SeaArrays, SeaScratch, new_sea_scratch, sea_run
from sim.shaders.thermal.sun import MOST_SUNS, SunArrays, add_up, find_light
from sim.thermal.radiance import COLDEST_K, TABLE, TABLE_STEP_K

PARTS = 16
SKY_CELLS = 128
VARIATION_K = 4.0 / 127.0

_BYTE = np.uint32(255)
_ONE, _HALF, _ZERO = np.float32(1.0), np.float32(0.5), np.float32(0.0)
_LAST_PART = np.uint32(PARTS - 1)
_COLDEST_K, _PER_K = np.float32(COLDEST_K), np.float32(1.0 / TABLE_STEP_K)
_LAST_ENTRY = np.float32(len(TABLE) - 1.001)


class KeptPicture(NamedTuple):
    """The latest picture of a view. A pixel that shows the same place of the same body again is in the same sun, and
    has the same radiance until temperatures change.

    Attributes:
        depth_m, instance_id: (H, W) what was seen.
        light: (H, S, W) float32 by ``find_light``.
        exposure: (H, W) float32, ``sum_s weight * light``; weights change more often than the light.
        radiance: (H, W) float32. version: (H,) int64, of the temperatures in each row.
    """

    depth_m: NDArray[np.float32]
    instance_id: NDArray[np.int32]
    light: NDArray[np.float32]
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
        moves: (B,) bool, the bodies whose rows are never kept. version: of the temperatures of the others.
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
        light: (MOST_SUNS,) float32.
        sea: see there.
    """

    firsts: NDArray[np.uint32]
    light: NDArray[np.float32]
    sea: SeaScratch


def new_thermal_scratch(width: int) -> ThermalScratch:
    """Return scratch for rows of ``width`` pixels."""
    return ThermalScratch(np.empty(width + 1, np.uint32), np.empty(MOST_SUNS, np.float32), new_sea_scratch(width))


@row_kernel(error_model="numpy")
def thermal_row(
    light: ThermalArrays, row: int, surfaces: SurfaceRow, scratch: ThermalScratch, radiance: NDArray[np.float32]
) -> None:
    """Write the radiance (1, W) of one row.

    Loops are over whole rows, or spans between runs of the sea: other runs are short, and their calls would cost more
    than needless pixels.
    """
    kept, out, ids, depth_m = light.kept, radiance[0], surfaces.instance_id, surfaces.depth_m
    runs, varies = find_runs(ids, scratch.firsts), False
    for run in range(runs):
        body = ids[scratch.firsts[run]]
        varies |= body == SKY or light.moves[body]
    is_same = _is_same(kept.depth_m[row], kept.instance_id[row], depth_m, ids)
    is_current = kept.version[row] == light.version
    if is_same and is_current and not varies:
        _copy_row(kept.radiance[row], out)
        return
    if not is_same:
        _expose_row(light, row, surfaces, scratch.light)
    if not is_same or not is_current:
        add_up(kept.light[row], light.sun.weight, kept.exposure[row])
    start, width = np.uint64(0), np.uint64(out.shape[0])
    for run in range(runs + np.uint64(1)):
        first = np.uint64(scratch.firsts[run])
        if first < width and ids[first] != light.sea.body:
            continue
        _body_span(
            light.shaded_k,
            light.warmth_k,
            light.emissivity,
            light.planck,
            light.around,
            kept.exposure[row, start:first],
            surfaces.colour[start:first],
            ids[start:first],
            surfaces.normal[2, start:first],
            out[start:first],
        )
        if first < width:
            start = np.uint64(scratch.firsts[run + np.uint64(1)])
            sea_run(light.sea, light.ray, light.camera_m, light.pixel_rad, row, first, start, depth_m, scratch.sea, out)
    _air_row(light.ray, light.air, row, depth_m, out)
    for run in range(runs):
        first, last = np.uint64(scratch.firsts[run]), np.uint64(scratch.firsts[run + np.uint64(1)])
        if ids[first] == SKY:
            _sky_run(light.sky, light.ray, row, first, last, out)
    _copy_row(out, kept.radiance[row])
    kept.version[row] = light.version


@row_kernel()
def _copy_row(source: NDArray[np.float32], target: NDArray[np.float32]) -> None:
    for column in range(target.shape[0]):
        target[column] = source[column]


@row_kernel()
def _is_same(
    depth_m: NDArray[np.float32],
    instance_id: NDArray[np.int32],
    now_m: NDArray[np.float32],
    now_id: NDArray[np.int32],
) -> bool:
    """Return whether a row shows what it showed before."""
    changes = np.int32(0)
    for column in range(depth_m.shape[0]):
        changes |= np.int32(now_m[column] != depth_m[column]) | (now_id[column] ^ instance_id[column])
    return changes == 0


@row_kernel(error_model="numpy", fastmath={"contract", "arcp", "nsz"})
def _body_span(
    shaded_k: NDArray[np.float32],
    warmth_k: NDArray[np.float32],
    emissivity: NDArray[np.float32],
    planck: NDArray[np.float32],
    around: NDArray[np.float32],
    exposures: NDArray[np.float32],
    colour: NDArray[np.uint32],
    instance_id: NDArray[np.int32],
    normal_z: NDArray[np.float32],
    radiance: NDArray[np.float32],
) -> None:
    """``L = e B(T) + (1 - e) (sky (1 + n_z) / 2 + ground (1 - n_z) / 2)``."""
    level, tilt = _HALF * (around[0] + around[1]), _HALF * (around[0] - around[1])
    for column in range(radiance.shape[0]):
        body = np.uint32(max(instance_id[column], np.int32(0)))
        part = body * np.uint32(PARTS) + min(colour[column] & _BYTE, _LAST_PART)
        varied = np.float32(np.int32((colour[column] >> np.uint32(8)) & _BYTE) - np.int32(128))
        kelvin = shaded_k[part] + warmth_k[part] * exposures[column] + varied * np.float32(VARIATION_K)
        place = min(max((kelvin - _COLDEST_K) * _PER_K, _ZERO), _LAST_ENTRY)
        entry = np.uint32(np.int32(place))
        black = planck[entry] + (planck[entry + np.uint32(1)] - planck[entry]) * (place - np.float32(np.int32(entry)))
        radiance[column] = emissivity[part] * black + (_ONE - emissivity[part]) * (level + tilt * normal_z[column])


@row_kernel(error_model="numpy", fastmath={"contract", "arcp", "nsz"})
def _sky_run(
    sky: NDArray[np.float32],
    ray: NDArray[np.float32],
    row: int,
    first: np.uint64,
    last: np.uint64,
    radiance: NDArray[np.float32],
) -> None:
    """Write the sky's radiance, interpolated."""
    y = np.float32(row) + _HALF
    for column in range(first, last):
        x = np.float32(np.int32(column)) + _HALF
        dx = ray[0, 0] * x + ray[0, 1] * y + ray[0, 2]
        dy = ray[1, 0] * x + ray[1, 1] * y + ray[1, 2]
        dz = ray[2, 0] * x + ray[2, 1] * y + ray[2, 2]
        place = max(dz, _ZERO) / np.sqrt(dx * dx + dy * dy + dz * dz) * np.float32(SKY_CELLS - 1.001)
        cell = np.uint32(place)
        radiance[column] = sky[cell] + (sky[cell + np.uint32(1)] - sky[cell]) * (place - np.float32(cell))


@row_kernel(error_model="numpy", fastmath={"contract", "arcp", "nsz"})
def _air_row(
    ray: NDArray[np.float32],
    air: NDArray[np.float32],
    row: int,
    depth_m: NDArray[np.float32],
    radiance: NDArray[np.float32],
) -> None:
    """``L exp(-a d) + L_air (1 - exp(-a d))`` with ``exp(-x) = 1 / (1 + x + x²/2 + x³/6 + x⁴/24)``, to 1e-4 for x < 1
    (and vector code). Where nothing is, the sky is written afterwards.
    """
    y, attenuation, own = np.float32(row) + _HALF, air[0], air[1]
    for column in range(radiance.shape[0]):
        x = np.float32(np.int32(column)) + _HALF
        dx = ray[0, 0] * x + ray[0, 1] * y + ray[0, 2]
        dy = ray[1, 0] * x + ray[1, 1] * y + ray[1, 2]
        dz = ray[2, 0] * x + ray[2, 1] * y + ray[2, 2]
        t = attenuation * depth_m[column] * np.sqrt(dx * dx + dy * dy + dz * dz)
        grown = _ONE + t * (_ONE + t * (_HALF + t * (np.float32(1 / 6) + t * np.float32(1 / 24))))
        radiance[column] = own + (radiance[column] - own) / grown


@row_kernel(error_model="numpy")
def _expose_row(light: ThermalArrays, row: int, surfaces: SurfaceRow, found: NDArray[np.float32]) -> None:
    """Find the sun on the pixels that show something else than before; ``found`` is scratch."""
    kept, ray, camera_m, normal = light.kept, light.ray, light.camera_m, surfaces.normal
    depth_m, instance_id = kept.depth_m[row], kept.instance_id[row]
    y = np.float32(row) + _HALF
    for column in range(depth_m.shape[0]):
        z, body = surfaces.depth_m[column], surfaces.instance_id[column]
        if z == depth_m[column] and body == instance_id[column]:
            continue
        depth_m[column], instance_id[column] = z, body
        if body == SKY or body == light.sea.body:
            continue
        x = np.float32(np.int32(column)) + _HALF
        px = camera_m[0] + z * (ray[0, 0] * x + ray[0, 1] * y + ray[0, 2])
        py = camera_m[1] + z * (ray[1, 0] * x + ray[1, 1] * y + ray[1, 2])
        pz = camera_m[2] + z * (ray[2, 0] * x + ray[2, 1] * y + ray[2, 2])
        suns = found[: light.sun.weight.shape[0]]
        nx, ny, nz = normal[0, column], normal[1, column], normal[2, column]
        find_light(light.sun, px, py, pz, nx, ny, nz, light.moves[body], suns)
        for s in range(suns.shape[0]):
            kept.light[row, s, column] = suns[s]
