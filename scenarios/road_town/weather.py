"""Light and weather of a town's episodes: what is drawn, and the shader and sensor that follow from it."""

from __future__ import annotations

import math
import pickle
from collections.abc import Hashable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from scenarios.road_town.cover import CoverKind, paint_cover
from scenarios.road_town.layout import Layout
from scenarios.road_town.presets import RoadTown
from scenarios.road_town.street_lamps import lamp_heads_m
from scenarios.scenario import Setup
from sim.checks import check
from sim.meshes.lamp_post import HEIGHT_M
from sim.optics import Camera
from sim.rng import generator
from sim.sensors.camera_sensor import CameraSensor
from sim.sensors.config import SensorConfig
from sim.sensors.lens_drops import WetCameraSensor, draw_drops
from sim.shaders.all_weather import AllWeatherShader, SpeckSource, Weather
from sim.shaders.atmosphere import CONTRAST_LEFT, extinction_of_fog, extinction_of_rain
from sim.shaders.colour import black_body_rgb
from sim.shaders.daylight import DaylightShader, Sun
from sim.shaders.ground_map import FINER, Footprint, GroundMap, ground_map, heights_from_above, sky_shares
from sim.shaders.lamp_specks import HEAD_K, car_light_specks, street_lamp_specks
from sim.shaders.night_lamps import LampView, bake_lamps, intensity_down_cd
from sim.shaders.precipitation import falling_specks
from sim.shaders.twilight import HEADLIGHTS_BELOW_LX, LAMPS_BELOW_LX, Cloud, sun_and_sky_lx
from sim.world import Body, World
from trackers.types import CameraModel

NIGHT_SENSOR = SensorConfig(
    # A low-light camera: pixels of 8.4 µm behind a lens at f/1.4. Longer exposures would blur what a helicopter sees.
    electrons_per_nit_s=900.0 * (8.4 / 3.45) ** 2 * (2.8 / 1.4) ** 2,
    full_well_e=60_000.0,
    read_noise_e=3.0,
    longest_exposure_s=1.0 / 300.0,
    largest_gain=512.0,
    # Night shall look like night.
    mid_grey=0.075,
)
SNOWFALL_MM_H = 1.0
_SNOWFALL_VISIBILITY_M = 900.0
"""Of moderate snow (WMO: 500 to 1,000 m)."""
_WET_FROM_MM_H = 1.2
_NO_HEADLIGHTS_FROM_DEG = 2.0
"""A clear sky gives 1,300 lx with the sun at this height."""
_CLOUDS: dict[str, Cloud] = {
    "clear": "none",
    "overcast": "stratocumulus",
    "rain": "nimbostratus",
    "fog": "stratus",
    "snow": "nimbostratus",
}
_AIR_SHARES = {"rain": 0.2, "fog": 0.6, "snow": 0.5}
"""Luminance of the air, seen from above, as a share of the sky's: drops scatter light onwards, few of it back."""
_DAY_SENSORS = {
    "rain": SensorConfig(mid_grey=0.14, longest_exposure_s=1e-3),
    "fog": SensorConfig(mid_grey=0.33, longest_exposure_s=2e-3),
    "snow": SensorConfig(mid_grey=0.36, longest_exposure_s=2e-3),
}
"""As photographers set it: fog and snow are brighter than grey, a rainy day is darker; gain before blur."""
_CLOUD_RGB, _TWILIGHT_RGB, _GLOW_RGB = (0.98, 1.0, 1.05), (0.72, 0.96, 1.6), (1.1, 1.0, 0.86)
_LED_K, _SODIUM_K = (3000.0, 4000.0), 2050.0
_LED_SHARE, _FLUX_LM = 0.6, (5000.0, 7000.0)


@dataclass(frozen=True)
class Conditions:
    """Light and weather of one episode.

    Attributes:
        weather: see ``RoadTown``. season: likewise.
        sun_elevation_rad, sun_azimuth_rad: direction of the sun.
        sun_illuminance_lx, sky_illuminance_lx: see ``Light``.
        visibility_m: meteorological, inf in clear air. rain_mm_h: rate of rain. snow_cover: amount on the ground.
        street_lamps_on, headlights_on: whether they burn.
    """

    weather: str
    season: str
    sun_elevation_rad: float
    sun_azimuth_rad: float
    sun_illuminance_lx: float
    sky_illuminance_lx: float
    visibility_m: float
    rain_mm_h: float
    snow_cover: float
    street_lamps_on: bool
    headlights_on: bool

    @property
    def is_plain(self) -> bool:
        """Whether nothing but sun, sky and shadows light the town."""
        return self.weather == "clear" and self.snow_cover == 0.0 and not self.headlights_on

    @property
    def sun_direction(self) -> NDArray[np.float64]:
        """Unit vector (3,) towards the sun."""
        c = np.cos(self.sun_elevation_rad)
        azimuth = self.sun_azimuth_rad
        return np.array([c * np.cos(azimuth), c * np.sin(azimuth), np.sin(self.sun_elevation_rad)])


def draw_conditions(preset: RoadTown, seed: int, sun_azimuth_rad: float, sun_elevation_rad: float) -> Conditions:
    """Draw the weather of an episode, whose sun is drawn already."""
    rng = generator(seed, "weather")
    visibility_m = float(np.exp(rng.uniform(*np.log(preset.fog_visibility_m))))
    rain_mm_h = float(rng.uniform(*preset.rain_mm_h))
    snow_cover = float(rng.uniform(*preset.snow_cover))
    weather, elevation_deg = preset.weather, math.degrees(sun_elevation_rad)
    sun_lx, sky_lx = sun_and_sky_lx(elevation_deg, _CLOUDS[weather])
    level_lx = sun_lx * max(math.sin(sun_elevation_rad), 0.0) + sky_lx
    if weather == "rain" and rain_mm_h > 0.0:
        visibility_m = CONTRAST_LEFT / extinction_of_rain(rain_mm_h)
    elif weather != "fog":
        visibility_m = _SNOWFALL_VISIBILITY_M if weather == "snow" else math.inf
    return Conditions(
        weather,
        preset.season,
        sun_elevation_rad,
        sun_azimuth_rad,
        sun_lx,
        sky_lx,
        visibility_m,
        rain_mm_h if weather == "rain" else 0.0,
        snow_cover,
        preset.has_lamp_posts and level_lx < LAMPS_BELOW_LX,
        level_lx < HEADLIGHTS_BELOW_LX or weather in ("rain", "fog", "snow"),
    )


def kind_of_ground(preset: RoadTown) -> Hashable:
    """Return what of a configuration decides what ``GroundLight`` is; None where no episode needs one."""
    is_high = preset.sun_elevation_deg[0] >= _NO_HEADLIGHTS_FROM_DEG
    is_plain = preset.weather == "clear" and preset.snow_cover == (0.0, 0.0) and is_high
    return None if is_plain else (cover_kind(preset), preset.sun_elevation_deg[0] <= 0.0)


def cover_kind(preset: RoadTown) -> CoverKind:
    """Return what may cover the ground."""
    if preset.weather == "rain":
        return "rain"
    return "snow" if preset.snow_cover[1] > 0.0 else "none"


@dataclass(frozen=True, eq=False)
class GroundLight:
    """What of the light is the same in all episodes of a town.

    Attributes:
        ground: its map. lamps_m: (K, 3) lamps. down_cd: (K,) their intensity straight down.
        lamp_rgb: (3,) their colour. baked_lx: see ``bake_lamps``; None where none may burn.
    """

    ground: GroundMap
    lamps_m: NDArray[np.float64]
    down_cd: NDArray[np.float64]
    lamp_rgb: NDArray[np.float64]
    baked_lx: NDArray[np.float32] | None


def light_ground(world: World, layout: Layout, preset: RoadTown, seed: int) -> GroundLight:
    """Measure the sky over a town's ground, and bake the light of its lamps.

    Args:
        world: the town, without an episode's cars.
    """
    rng = generator(seed, "ground light")
    heights = heights_from_above(world, layout.extent_m)
    size_px = FINER * len(heights.solid_m)
    cover = paint_cover(layout, cover_kind(preset), size_px, heights.side_m, rng)
    parked = [body for body in world.bodies if body.category == "vehicle" and not body.movable]
    ground = ground_map(sky_shares(heights), cover, _boxes(world, parked))
    kelvin = float(rng.uniform(*_LED_K)) if rng.random() < _LED_SHARE else _SODIUM_K
    flux_lm = rng.uniform(*_FLUX_LM) * rng.normal(1.0, 0.06, len(layout.lamps))
    lamps_m = lamp_heads_m(layout.lamps)
    down_cd = np.array([intensity_down_cd(float(each)) for each in flux_lm])
    may_burn = preset.sun_elevation_deg[0] <= 0.0
    baked_lx = bake_lamps(lamps_m, flux_lm, heights) if may_burn else None
    return GroundLight(ground, lamps_m, down_cd, black_body_rgb(kelvin), baked_lx)


_latest: tuple[tuple[object, ...], GroundLight] | None = None
"""What the latest light of the ground was measured of, and the light, as ``town`` keeps the latest town."""


def ground_light_of(world: World, layout: Layout, preset: RoadTown, seed: int) -> GroundLight | None:
    """Return the light of a town's ground, None where no episode of the configuration needs it.

    Args:
        world: the town. seed: of its episode.
    """
    global _latest
    kind = kind_of_ground(preset)
    if kind is None:
        return None
    key, latest = (pickle.dumps(layout), seed, kind), _latest
    if latest is None or latest[0] != key:
        latest = _latest = key, light_ground(world, layout, preset, seed)
    return latest[1]


def _boxes(world: World, bodies: list[Body]) -> NDArray[np.float64]:
    """Return the boxes (P, 7) of bodies that stay, see ``ground_map``."""
    rows = []
    for body in bodies:
        pose = world.poses[body.index]
        rows.append((pose[0, 3], pose[1, 3], pose[0, 0], pose[1, 0], *body.mesh.size_m.tolist()))
    return np.array(rows, dtype=float).reshape(-1, 7)


class CarLights:
    """Head and rear lamps of the cars that drive.

    Attributes:
        braking: (K,) whether each brakes now; set on every frame.
    """

    def __init__(self, world: World, cars: list[Footprint]) -> None:
        self._world, self._cars = world, cars
        self._bodies = np.array([car.body for car in cars], dtype=np.int64)
        self.braking = np.zeros(len(cars), np.bool_)

    def specks(self, camera: Camera, T_world_camera: NDArray[np.float64], frame: int) -> NDArray[np.float32]:
        """Return them as specks of a picture."""
        poses = self._world.poses[self._bodies]
        return car_light_specks(camera, T_world_camera, self._cars, poses, self.braking)


def shader_in(
    conditions: Conditions,
    world: World,
    cars: list[Body],
    sizes_m: NDArray[np.float64],
    light: GroundLight | None,
    seed: int,
    shadow_texels: int,
) -> tuple[DaylightShader | AllWeatherShader, CarLights | None]:
    """Return the shader of an episode, and the lights of its cars if they burn.

    Args:
        cars: those that drive, of sizes (N, 3), the last bodies of the world.
        light: of the ground; None in plain daylight alone.
    """
    sun = Sun(conditions.sun_direction, conditions.sun_illuminance_lx)
    if conditions.is_plain:
        return DaylightShader(world, sun, conditions.sky_illuminance_lx, shadow_texels=shadow_texels), None
    check("light", light is not None, "the ground's light", light)
    assert light is not None
    footprints = [Footprint(body.index, *size) for body, size in zip(cars, sizes_m.tolist(), strict=True)]
    car_lights = CarLights(world, footprints)
    sources: list[SpeckSource] = []
    if conditions.headlights_on:
        sources.append(car_lights.specks)
    if conditions.street_lamps_on:
        wet = conditions.rain_mm_h > 0.0

        def street_lamps(camera: Camera, T_world_camera: NDArray[np.float64], frame: int) -> NDArray[np.float32]:
            return street_lamp_specks(camera, T_world_camera, light.lamps_m, light.down_cd, light.lamp_rgb, wet=wet)

        sources.append(street_lamps)
    if conditions.weather in ("rain", "snow"):
        sources.append(_falling(conditions, seed))
    dark = conditions.sun_elevation_rad <= 0.0
    lamps = None
    if dark:
        baked_lx = light.baked_lx
        assert baked_lx is not None
        lamps = LampView(
            baked_lx if conditions.street_lamps_on else np.zeros_like(baked_lx),
            footprints,
            lamp_rgb=light.lamp_rgb,
            head_rgb=black_body_rgb(HEAD_K),
            height_m=HEIGHT_M,
        )
    shader = AllWeatherShader(
        world,
        _weather(conditions, sun),
        light.ground.view(footprints),
        cars[0].index,
        lamps,
        tuple(sources),
        shadow_texels,
    )
    return shader, car_lights


def _weather(conditions: Conditions, sun: Sun) -> Weather:
    sky_rgb: tuple[float, float, float] = (0.86, 1.0, 1.3)
    if conditions.weather != "clear":
        sky_rgb = _CLOUD_RGB
    elif conditions.sun_elevation_rad <= 0.0:
        sky_rgb = _TWILIGHT_RGB if conditions.sky_illuminance_lx > 1.0 else _GLOW_RGB
    return Weather(
        sun if conditions.sun_illuminance_lx > 0.0 else None,
        conditions.sky_illuminance_lx,
        sky_rgb,
        extinction_of_fog(conditions.visibility_m),
        _AIR_SHARES.get(conditions.weather, 1.0),
        snow=conditions.snow_cover,
        water=1.0 - math.exp(-conditions.rain_mm_h / _WET_FROM_MM_H),
    )


def sensor_in(conditions: Conditions, setup: Setup, camera: CameraModel) -> CameraSensor:
    """Return the sensor of an episode: behind a window with drops in rain, one for little light in the dark."""
    if conditions.sun_elevation_rad <= 0.0:
        config = NIGHT_SENSOR
    else:
        config = _DAY_SENSORS.get(conditions.weather, SensorConfig())
    rng, preset = setup.rng("sensor"), setup.preset
    if conditions.rain_mm_h == 0.0:
        return CameraSensor(config, rng)
    aspect, duration_s = camera.height_px / camera.width_px, preset.frame_count / preset.rate_hz
    drops = draw_drops(conditions.rain_mm_h, duration_s, aspect, setup.rng("drops on the window"))
    return WetCameraSensor(config, rng, drops, camera, preset.rate_hz)


def _falling(conditions: Conditions, seed: int) -> SpeckSource:
    """Return the drops or flakes before the camera: lit by the sky as a white surface is, drops by half of it."""
    kind: Literal["rain", "snow"] = "rain" if conditions.weather == "rain" else "snow"
    rate_mm_h = conditions.rain_mm_h if kind == "rain" else SNOWFALL_MM_H
    nit = np.full(3, conditions.sky_illuminance_lx / np.pi * (0.5 if kind == "rain" else 0.8))

    def falling(camera: Camera, T_world_camera: NDArray[np.float64], frame: int) -> NDArray[np.float32]:
        return falling_specks(kind, rate_mm_h, seed, frame, camera, T_world_camera, nit)

    return falling
