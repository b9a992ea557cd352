"""Daylight, twilight and night in any weather, from G-buffer to radiance.

For a surface of reflectance ``rho``, normal ``n``, and the direction ``l`` towards the sun

    E = sun max(0, n . l) lit + share (sky (1 + n_z) + bounce (1 - n_z)) / 2 + lamps + headlights
    L = rho' E / pi + film F(cos) L_sky,   then through the air, see ``atmosphere``

with ``share`` of the sky that places near the ground see (``ground_map``), illuminances of lamps (``night_lamps``),
``rho'`` under snow or water (``wet_surface``), and specks on top (``specks``). Snow or water covers the share
``clip(3 (p + amount - 1), 0, 1)`` of a place, p from the ground map: the lower p, the more it takes. Plants of the
ground that are darker than a lawn, such as hedges, and tips of grass stand out of the snow.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.gbuffer import GBuffer
from sim.optics import Camera, ray_of_pixel
from sim.render.attributes import SurfaceRow
from sim.render.compilation import row_kernel
from sim.render.row_stages import RowStage, light_picture
from sim.render.shadow_map import ShadowCaster
from sim.shaders.atmosphere import Air, transmittance_row, veil_row
from sim.shaders.daylight import (
    GROUND_REFLECTANCE,
    PER_PI,
    SHADOW_TEXELS,
    DaylightArrays,
    ShadowArrays,
    ShadowScratch,
    Sun,
    cosine_row,
    new_shadow_scratch,
    of_unit_luminance,
    reflectance_row,
    shadow_row,
    shadows_in_view,
)
from sim.shaders.ground_map import GroundArrays, GroundScratch, GroundView, ground_row, new_ground_scratch, place_row
from sim.shaders.night_lamps import NO_LAMPS, LampArrays, LampScratch, LampView, lamp_row, new_lamp_scratch
from sim.shaders.specks import COLUMNS, Specks, speck_row, specks_of
from sim.shaders.wet_surface import mirrored_share, wet_reflectance
from sim.world import World

ONE, HALF, ZERO, THREE = np.float32(1.0), np.float32(0.5), np.float32(0.0), np.float32(3.0)
SNOW_REFLECTANCE = (0.80, 0.83, 0.88)
"""Of fresh snow, linear R, G, B (Warren 1982: 0.8 to 0.9)."""
OPEN_FROM_M = np.float32(3.0)
"""Height above the ground from which a place sees all of the sky."""
_SHELTERED = np.float32(0.55)
"""Share of a lamp's light that reaches a place which sees no sky, beside what stands there."""
_SNOW_ON_MOVERS, _WATER_ON_MOVERS = 0.05, 0.45
"""``p`` of what moves: it sheds snow, and is always wet in rain."""
_BARE_BELOW, _COVERED_FROM = np.float32(0.04), np.float32(0.12)
"""Reflectances (green) of plants of the ground: those that stand out of the snow, and those that it covers."""
_GROUND_M = np.float32(0.02)
_ALWAYS_LIT = ShadowArrays(
    np.zeros(1, np.float32), np.zeros(1, np.float32), 1, np.zeros((3, 4), np.float32), np.float32(1.0)
)


class Cover(NamedTuple):
    """What covers the ground, for kernels.

    Attributes:
        snow, water: amounts, 0 to 1. first_mover: bodies from this index on move; mover_p: their p.
    """

    snow: np.float32
    water: np.float32
    first_mover: int
    mover_p: np.float32


class WeatherArrays(NamedTuple):
    """Light in one picture as arrays for kernels.

    Attributes:
        day: sun, sky and the light that the ground throws back; shadows only if ``sunny``.
        ground, lamps, cover, air, specks: see there.
        ray: (3, 3) float32, ``ray @ (x, y, 1)`` is the direction (world) of pixel coordinates.
    """

    day: DaylightArrays
    sunny: bool
    ground: GroundArrays
    lamps: LampArrays
    cover: Cover
    air: Air
    ray: NDArray[np.float32]
    specks: Specks


class WeatherScratch(NamedTuple):
    """Scratch of ``shade_in_weather_row``: lines (W,) of float32 each, named as what they hold."""

    shadow: ShadowScratch
    ground: GroundScratch
    lamps: LampScratch
    lit: NDArray[np.float32]
    column: NDArray[np.float32]
    row: NDArray[np.float32]
    height_m: NDArray[np.float32]
    share: NDArray[np.float32]
    cover: NDArray[np.float32]
    lamp_lx: NDArray[np.float32]
    head_lx: NDArray[np.float32]
    film: NDArray[np.float32]
    left: NDArray[np.float32]


def new_weather_scratch(width: int) -> WeatherScratch:
    """Return scratch for rows of ``width`` pixels."""
    lines = np.zeros((10, width), np.float32)
    return WeatherScratch(new_shadow_scratch(width), new_ground_scratch(width), new_lamp_scratch(width), *lines)


@row_kernel()
def shade_in_weather_row(
    light: WeatherArrays, row: int, surfaces: SurfaceRow, scratch: WeatherScratch, radiance: NDArray[np.float32]
) -> None:
    """Write the radiance (3, W) of one row."""
    depth_m, normal, share, cover = surfaces.depth_m, surfaces.normal, scratch.share, scratch.cover
    most, lowest = np.float32(light.ground.size), np.float32(-100.0)
    place_row(light.ground.from_pixel[0], row, depth_m, ZERO, most, scratch.column)
    place_row(light.ground.from_pixel[1], row, depth_m, ZERO, most, scratch.row)
    place_row(light.ground.from_pixel[2], row, depth_m, lowest, np.float32(1e6), scratch.height_m)
    ground_row(light.ground, scratch.column, scratch.row, scratch.ground, share, cover)
    _open_to_sky(scratch.height_m, share)
    if light.sunny:
        cosine_row(light.day, normal, scratch.lit)
        shadow_row(light.day.shadows, row, np.uint64(0), depth_m, scratch.lit, scratch.shadow, scratch.lit)
    if light.lamps.size > 0:
        lamp_row(
            light.lamps,
            scratch.column,
            scratch.row,
            scratch.height_m,
            normal,
            scratch.lamps,
            scratch.lamp_lx,
            scratch.head_lx,
        )
        _shelter(share, scratch.lamp_lx)
    if light.cover.snow > ZERO or light.cover.water > ZERO:
        _cover_up(light.cover, surfaces.instance_id, normal[2], cover)
    if light.cover.snow > ZERO:
        reflectance_row(surfaces.colour, np.uint32(8), radiance[0])
        _stand_out(radiance[0], scratch.height_m, cover)
    if light.cover.water > ZERO:
        _mirror(light.ray, row, normal, cover, scratch.film)
    for channel in range(3):
        reflectance_row(surfaces.colour, np.uint32(8 * channel), radiance[channel])
        if light.cover.snow > ZERO:
            _snow_over(np.float32(SNOW_REFLECTANCE[channel]), cover, radiance[channel])
        if light.cover.water > ZERO:
            _wet(light.cover.water, cover, radiance[channel])
        _light_up(light, channel, depth_m, normal[2], scratch, radiance[channel])
    count = light.specks.table.shape[0]
    if count > 0:
        speck_row(light.specks, row, True, depth_m, scratch.height_m, scratch.film, radiance)
    if light.air.beta_per_m > ZERO:
        transmittance_row(light.air, row, depth_m, scratch.left)
        for channel in range(3):
            veil_row(scratch.left, light.air.air_nit[channel], radiance[channel])
    if count > 0:
        speck_row(light.specks, row, False, depth_m, scratch.height_m, scratch.film, radiance)


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def _open_to_sky(height_m: NDArray[np.float32], share: NDArray[np.float32]) -> None:
    """Raise the share of the sky, that of the ground, to 1 at ``OPEN_FROM_M``."""
    per_m = ONE / OPEN_FROM_M
    for k in range(share.shape[0]):
        up = min(max(height_m[k] * per_m, ZERO), ONE)
        share[k] += up * (ONE - share[k])


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def _shelter(share: NDArray[np.float32], lamp_lx: NDArray[np.float32]) -> None:
    """Take light of lamps where little of the sky is seen, as below a car's side."""
    for k in range(share.shape[0]):
        lamp_lx[k] *= _SHELTERED + (ONE - _SHELTERED) * share[k]


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def _cover_up(
    cover: Cover, instance_id: NDArray[np.int32], normal_z: NDArray[np.float32], covered: NDArray[np.float32]
) -> None:
    """Turn p of each pixel into the share that snow, or else water, covers; nothing stays on steep surfaces."""
    first, missing = np.int32(cover.first_mover), ONE - max(cover.snow, cover.water)
    for k in range(covered.shape[0]):
        p = cover.mover_p if instance_id[k] >= first else covered[k]
        level = min(max((normal_z[k] - np.float32(0.3)) * np.float32(2.5), ZERO), ONE)
        covered[k] = level * min(max(THREE * (p - missing), ZERO), ONE)


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def _stand_out(green: NDArray[np.float32], height_m: NDArray[np.float32], covered: NDArray[np.float32]) -> None:
    """Take snow from dark places of the ground."""
    per = ONE / (_COVERED_FROM - _BARE_BELOW)
    for k in range(covered.shape[0]):
        held = min(max((green[k] - _BARE_BELOW) * per, ZERO), ONE)
        covered[k] *= held if height_m[k] < _GROUND_M else ONE


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def _mirror(
    ray: NDArray[np.float32],
    row: int,
    normal: NDArray[np.float32],
    covered: NDArray[np.float32],
    film: NDArray[np.float32],
) -> None:
    """Write the share of light that water mirrors: that of its cover, times Fresnel's."""
    y = np.float32(row) + HALF
    x0, y0, z0 = ray[0, 1] * y + ray[0, 2], ray[1, 1] * y + ray[1, 2], ray[2, 1] * y + ray[2, 2]
    nx, ny, nz = normal[0], normal[1], normal[2]
    for k in range(film.shape[0]):
        x = np.float32(np.int32(k)) + HALF
        rx, ry, rz = ray[0, 0] * x + x0, ray[1, 0] * x + y0, ray[2, 0] * x + z0
        towards = -(rx * nx[k] + ry * ny[k] + rz * nz[k]) / np.sqrt(rx * rx + ry * ry + rz * rz)
        film[k] = covered[k] * mirrored_share(towards)


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def _snow_over(snow: np.float32, covered: NDArray[np.float32], reflectance: NDArray[np.float32]) -> None:
    for k in range(covered.shape[0]):
        reflectance[k] += covered[k] * (snow - reflectance[k])


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def _wet(water: np.float32, covered: NDArray[np.float32], reflectance: NDArray[np.float32]) -> None:
    """Darken: all that is wet by half of what water that stands on it does."""
    for k in range(covered.shape[0]):
        reflectance[k] = wet_reflectance(reflectance[k], water * (HALF + HALF * covered[k]))


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def _light_up(
    light: WeatherArrays,
    channel: int,
    depth_m: NDArray[np.float32],
    normal_z: NDArray[np.float32],
    scratch: WeatherScratch,
    radiance: NDArray[np.float32],
) -> None:
    """Turn one channel's reflectance into radiance, see above. Where depth is inf, the sky itself is seen."""
    day, infinity = light.day, np.float32(np.inf)
    sky, bounce = day.sky[channel] * PER_PI, day.bounce[channel] * PER_PI
    level, tilt = HALF * (sky + bounce), HALF * (sky - bounce)
    share, film = scratch.share, scratch.film
    if light.lamps.size > 0:
        lamp, head = light.lamps.lamp_rgb[channel] * PER_PI, light.lamps.head_rgb[channel] * PER_PI
        lamp_lx, head_lx = scratch.lamp_lx, scratch.head_lx
        for k in range(depth_m.shape[0]):
            lamps = lamp * lamp_lx[k] + head * head_lx[k]
            out = radiance[k] * (share[k] * (level + tilt * normal_z[k]) + lamps)
            radiance[k] = out if depth_m[k] < infinity else sky
    elif light.sunny:
        sun, lit = day.sun[channel] * PER_PI, scratch.lit
        for k in range(depth_m.shape[0]):
            out = radiance[k] * (sun * lit[k] + share[k] * (level + tilt * normal_z[k]))
            radiance[k] = out if depth_m[k] < infinity else sky
    else:
        for k in range(depth_m.shape[0]):
            out = radiance[k] * (share[k] * (level + tilt * normal_z[k]))
            radiance[k] = out if depth_m[k] < infinity else sky
    if light.cover.water > ZERO:
        for k in range(depth_m.shape[0]):
            radiance[k] += film[k] * share[k] * sky if depth_m[k] < infinity else ZERO


SpeckSource = Callable[[Camera, NDArray[np.float64], int], NDArray[np.float32]]
"""Returns a table of specks (K, 12) of a picture: of a camera, its pose, a frame."""


@dataclass(frozen=True)
class Weather:
    """Sky and air of an episode.

    Attributes:
        sun: None where it does not shine.
        sky_illuminance_lx: on level ground. sky_colour_rgb: relative linear R, G, B.
        beta_per_m: extinction of the air, see ``atmosphere``. air_share: its luminance as a share of the sky's.
        snow, water: amounts on the ground, 0 to 1, of which one is 0.
    """

    sun: Sun | None
    sky_illuminance_lx: float
    sky_colour_rgb: tuple[float, float, float] = (0.86, 1.0, 1.3)
    beta_per_m: float = 0.0
    air_share: float = 1.0
    snow: float = 0.0
    water: float = 0.0


@dataclass
class AllWeatherShader:
    """Lights G-buffers of one world.

    Attributes:
        ground: of the episode. first_mover: index of the first body that moves; those after it do, too.
        lamps: None where none burns.
        sources: of specks. frame: of the next picture, for them; set it before.
        shadow_texels: see ``DaylightShader``.
    """

    world: World
    weather: Weather
    ground: GroundView
    first_mover: int
    lamps: LampView | None = None
    sources: tuple[SpeckSource, ...] = ()
    shadow_texels: int = SHADOW_TEXELS
    frame: int = field(default=0, init=False)

    lighting = RowStage(shade_in_weather_row, new_weather_scratch)

    def __post_init__(self) -> None:
        weather, towards_sun, sun_lx = self.weather, np.array([0.0, 0.0, 1.0]), np.zeros(3)
        if weather.sun is not None:
            direction = np.asarray(weather.sun.direction, dtype=float)
            towards_sun = direction / np.linalg.norm(direction)
            sun_lx = weather.sun.illuminance_lx * of_unit_luminance(weather.sun.colour_rgb)
        sky_lx = weather.sky_illuminance_lx * of_unit_luminance(weather.sky_colour_rgb)
        reflected = GROUND_REFLECTANCE + weather.snow * (np.array(SNOW_REFLECTANCE) - GROUND_REFLECTANCE)
        bounce_lx = reflected * (sun_lx * max(0.0, towards_sun[2]) + sky_lx)
        self._caster = None if weather.sun is None else ShadowCaster(self.world, towards_sun, self.shadow_texels)
        self._light = (
            towards_sun.astype(np.float32),
            sun_lx.astype(np.float32),
            sky_lx.astype(np.float32),
            bounce_lx.astype(np.float32),
        )
        self._air_nit = (weather.air_share * sky_lx / np.pi).astype(np.float32)
        mover_p = _SNOW_ON_MOVERS if weather.snow > 0.0 else _WATER_ON_MOVERS
        self._cover = Cover(np.float32(weather.snow), np.float32(weather.water), self.first_mover, np.float32(mover_p))

    def shade(self, gbuffer: GBuffer, camera: Camera, T_world_camera: NDArray[np.float64]) -> NDArray[np.float32]:
        """Return the radiance (H, 3, W) float32, see ``DaylightShader.shade``."""
        return light_picture(self.lighting, self.row_light(gbuffer.depth_m, camera, T_world_camera), gbuffer)

    def row_light(
        self, depth_m: NDArray[np.float32], camera: Camera, T_world_camera: NDArray[np.float64]
    ) -> WeatherArrays:
        """Return the present light in one camera's picture, for the row kernel; ``depth_m``: (H, W)."""
        poses = self.world.poses
        shadows = _ALWAYS_LIT
        if self._caster is not None:
            shadows = shadows_in_view(self._caster, depth_m, camera, T_world_camera)
        ground = self.ground.arrays(poses, camera, T_world_camera)
        tables = [source(camera, T_world_camera, self.frame) for source in self.sources]
        table = np.concatenate(tables) if tables else np.zeros((0, COLUMNS), np.float32)
        ray = T_world_camera[:3, :3] @ ray_of_pixel(camera)
        of_camera = np.array([1.0 / camera.focal_px, 0.5 * camera.width_px, 0.5 * camera.height_px], np.float32)
        return WeatherArrays(
            DaylightArrays(*self._light, shadows),
            self._caster is not None,
            ground,
            NO_LAMPS if self.lamps is None else self.lamps.arrays(poses, ground, camera, T_world_camera),
            self._cover,
            Air(np.float32(self.weather.beta_per_m), self._air_nit, of_camera),
            ray.astype(np.float32),
            specks_of(table, camera),
        )
