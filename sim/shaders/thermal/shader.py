"""Thermal radiance of a world: each part of each body has a temperature, in the shade and in the sun.

A mesh in a thermal world carries no visible colour but its thermal looks. Red is the index of the part of its body, 0
to 15; green the fine variation of that part's temperature, 128 for none, ``VARIATION_K`` for each step; blue is 0. So a
G-buffer of either renderer carries them. (A smooth texture must have the same red everywhere.)

For a surface with emissivity e and normal n at distance d

    T = T_shade + (T_sun - T_shade) * exposure + variation
    L_0 = e B(T) + (1 - e) (sky (1 + n_z) / 2 + ground (1 - n_z) / 2)
    L = L_0 exp(-a d) + B(T_air) (1 - exp(-a d))

B is the radiance of a black body in the band. The exposure is the weighted sum of ``lit * max(0, n . l)`` over several
positions l of the sun in the past hour: stone remembers. What never moves casts shadows. The sea is that of
``sim.shaders.thermal.sea``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.checks import check
from sim.gbuffer import SKY, GBuffer
from sim.optics import PinholeCamera, ray_of_pixel
from sim.render.attributes import SurfaceRow
from sim.render.compilation import row_kernel
from sim.render.raster import Raster
from sim.render.row_stages import RowStage, finish_rows, light_picture
from sim.render.rows import find_runs
from sim.shaders.thermal.mirror import NO_MIRROR, MirrorArrays, image_of, mirror_arrays, rows_mirrored
from sim.shaders.thermal.sea import (
    NO_GLITTER,
    NO_SEA,
    Sea,
    SeaArrays,
    SeaScratch,
    glitter_arrays,
    new_sea_scratch,
    radiance_table,
    sea_arrays,
    sea_run,
)
from sim.shaders.thermal.sun import MOST_SUNS, SunArrays, Suns, add_up, find_light
from sim.thermal.radiance import COLDEST_K, TABLE, TABLE_STEP_K, Air, band_radiance, sky_radiance
from sim.world import Body, World

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
    """Temperatures of a world in one picture, all float32 where no other type is given.

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
    depth_m: NDArray[np.float32], instance_id: NDArray[np.int32], now_m: NDArray[np.float32], now_id: NDArray[np.int32]
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


_VIEWS_KEPT = 4
"""A picture's and its mirror's, of two cameras."""
_LEVEL_STEP_M = 0.05
"""The mirror's level follows the tide in steps: what does not move is then drawn on it once."""
_NEVER = np.float32(-1.0)


class ThermalShader:
    """Gives G-buffers of one world their thermal radiance, whichever renderer drew them.

    Attributes:
        sea: None for a world without.
    """

    lighting = RowStage(thermal_row, new_thermal_scratch, channels=1)

    def __init__(self, world: World, shadow_reach_m: float, air: Air | None = None) -> None:
        """Start with everything as warm as the air, no sun and no sea.

        Args:
            shadow_reach_m: shadows are cast by and on what is nearer than this to the world's origin.
        """
        self._world, self._suns = world, Suns(world, shadow_reach_m)
        self._raster = Raster(world)
        self.sea: Sea | None = None
        self._kept: dict[tuple[PinholeCamera, bytes], KeptPicture] = {}
        self._table_of: tuple[Air, float, float] | None = None
        self._table = NO_SEA.radiance
        self._parts = np.empty((3, 0, PARTS), np.float32)
        self._moves = np.empty(0, np.bool_)
        self._version = 0
        self.set_air(air or Air())

    def set_parts(
        self,
        bodies: Body | Sequence[Body],
        shaded_k: NDArray[np.float64],
        sunlit_k: NDArray[np.float64],
        emissivity: NDArray[np.float64],
    ) -> None:
        """Set the temperatures of the first P <= 16 parts of a body, or of several alike, and their emissivity.

        Args:
            shaded_k, sunlit_k: (P,), out of the sun and facing it.
            emissivity: (P,) in [0, 1].
        """
        count = len(shaded_k)
        check("shaded_k", 0 < count <= PARTS, f"1 to {PARTS} parts", count)
        self._make_room()
        alike = [bodies] if isinstance(bodies, Body) else bodies
        parts = np.stack([shaded_k, np.asarray(sunlit_k, dtype=float) - shaded_k, emissivity]).astype(np.float32)
        index = [body.index for body in alike]
        if not (self._parts[:, index, :count] == parts[:, None]).all():
            self._parts[:, index, :count] = parts[:, None]
            self._version += not all(body.movable for body in alike)

    def set_air(self, air: Air) -> None:
        """Set the air and the sky; what reflects little reflects these and a ground as warm as the air."""
        self._air = air
        self._version += 1
        sky = sky_radiance(air, np.linspace(0.0, 1.0, SKY_CELLS))
        sine = np.linspace(0.0, 1.0, 65)[1:] - 1.0 / 128
        mean = float((2.0 * sine * sky_radiance(air, sine)).mean())
        black = float(band_radiance(air.temperature_k))
        self._sky = sky.astype(np.float32)
        self._around = np.array([mean, black], np.float32)
        self._air_arrays = np.array([air.attenuation_per_m, black], np.float32)

    def set_sun(self, towards_sun: Sequence[NDArray[np.float64]], weights: Sequence[float]) -> None:
        """Set the positions of the sun that surfaces remember.

        Args:
            towards_sun: S unit vectors (3,), the latest one first: it glitters on the sea. None at night.
            weights: S numbers; all of them together should be 1.
        """
        if self._suns.set(towards_sun, weights):
            self._kept.clear()
        self._version += 1

    def shade(
        self, gbuffer: GBuffer, camera: PinholeCamera, T_world_camera: NDArray[np.float64]
    ) -> NDArray[np.float32]:
        """Return the radiance (H, 1, W) float32 in W/(m² sr) of a G-buffer sampled at pixel centres."""
        return light_picture(self.lighting, self.row_light(gbuffer.depth_m, camera, T_world_camera), gbuffer)

    def row_light(
        self, depth_m: NDArray[np.float32], camera: PinholeCamera, T_world_camera: NDArray[np.float64]
    ) -> ThermalArrays:
        """Return the present temperatures in one camera's picture, for the row kernel."""
        light = self._dry_light(camera, T_world_camera)
        if self.sea is None:
            return light
        mirror = self._mirror(self.sea, depth_m, camera, T_world_camera)
        suns = self._suns.arrays.towards
        sun = glitter_arrays(suns[0], self._air) if len(suns) else NO_GLITTER
        return light._replace(sea=sea_arrays(self.sea, self._sea_table(self.sea), mirror, sun))

    def _mirror(
        self, sea: Sea, depth_m: NDArray[np.float32], camera: PinholeCamera, T_world_camera: NDArray[np.float64]
    ) -> MirrorArrays:
        """Return what the sea mirrors."""
        tide_m = float(self._world.poses[sea.body.index, 2, 3])
        image, T_world_image = image_of(camera, T_world_camera, _LEVEL_STEP_M * round(tide_m / _LEVEL_STEP_M))
        rows = rows_mirrored(depth_m, camera, T_world_camera, tide_m)
        if rows == 0:
            return NO_MIRROR
        seen = self._raster.visible(image, T_world_image)
        light = self._dry_light(image, T_world_image)
        # The way there is nearly that to the water, for which the picture itself accounts.
        light = light._replace(air=light.air * np.array([0.0, 1.0], np.float32))
        radiance = np.empty((rows, 1, image.width_px), np.float32)
        finish_rows(self._raster.resolving, seen, np.arange(rows), self.lighting, light, radiance)
        return mirror_arrays(image, camera, seen.depth_m[:rows], radiance[:, 0])

    def _dry_light(self, camera: PinholeCamera, T_world_camera: NDArray[np.float64]) -> ThermalArrays:
        """Return ``row_light`` of a world without a sea."""
        self._make_room()
        shaded_k, warmth_k, emissivity = self._parts.reshape(3, -1)
        return ThermalArrays(
            shaded_k,
            warmth_k,
            emissivity,
            _PLANCK,
            self._sky,
            self._around,
            self._air_arrays,
            (T_world_camera[:3, :3] @ ray_of_pixel(camera)).astype(np.float32),
            T_world_camera[:3, 3].astype(np.float32),
            np.float32(1.0 / camera.focal_px),
            self._moves,
            self._version,
            self._suns.arrays,
            self._kept_picture(camera, T_world_camera),
            NO_SEA,
        )

    def _make_room(self) -> None:
        """Give bodies that are new the temperature of the air."""
        new = len(self._world.bodies) - self._parts.shape[1]
        if new > 0:
            fresh = np.zeros((3, new, PARTS), np.float32)
            fresh[0], fresh[2] = self._air.temperature_k, 0.95
            self._parts = np.concatenate([self._parts, fresh], axis=1)
            self._moves = np.array([body.movable for body in self._world.bodies])
            self._kept.clear()

    def _kept_picture(self, camera: PinholeCamera, T_world_camera: NDArray[np.float64]) -> KeptPicture:
        key = camera, T_world_camera.tobytes()
        if key not in self._kept:
            if len(self._kept) >= _VIEWS_KEPT:
                del self._kept[next(iter(self._kept))]
            shape = camera.height_px, camera.width_px
            self._kept[key] = KeptPicture(
                np.full(shape, _NEVER),
                np.full(shape, -2, np.int32),
                np.zeros((shape[0], len(self._suns.arrays.weight), shape[1]), np.float32),
                np.zeros(shape, np.float32),
                np.zeros(shape, np.float32),
                np.full(shape[0], -1),
            )
        return self._kept[key]

    def _sea_table(self, sea: Sea) -> NDArray[np.float32]:
        wanted = self._air, sea.temperature_k, sea.waves.state.fine_slope
        if wanted != self._table_of:
            self._table_of, self._table = wanted, radiance_table(*wanted)
        return self._table


_PLANCK = TABLE.astype(np.float32)
