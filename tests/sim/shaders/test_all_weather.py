"""The shader of all weather: daylight as its limit, fog, water and snow one by one, and lamps after dark."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from sim.optics import Intrinsics, look_down_pose
from sim.render.pipeline import capture
from sim.render.raster import Raster
from sim.sensors.camera_sensor import CameraSensor
from sim.sensors.config import SensorConfig
from sim.shaders.all_weather import AllWeatherShader, Weather
from sim.shaders.daylight import DaylightShader, Sun
from sim.shaders.ground_map import COARSE_M, FINER, Footprint, ground_map
from sim.shaders.night_lamps import LampView
from sim.shaders.specks import COLUMNS, COVER, GREEN, LONG, SHORT, X, Y
from sim.world import World

CAMERA = Intrinsics(96, 72, 90.0)
DOWN = look_down_pose(np.array([0.0, 0.0, 60.0]), 0.3, 0.0, 0.0)
SUN = Sun((0.4, 0.3, 0.8), 90_000.0)
CELLS = 260


def shader(town: World, weather: Weather, cover: int = 255, share: float = 1.0, **others: Any) -> AllWeatherShader:
    fine = FINER * CELLS
    ground = ground_map(
        np.full((CELLS, CELLS), share, np.float32), np.full((fine, fine), cover, np.uint8), np.empty((0, 7))
    )
    return AllWeatherShader(town, weather, ground.view([]), len(town.bodies), **others)


@pytest.fixture(scope="module")
def gbuffer(town):
    return Raster(town).gbuffer(CAMERA, DOWN)


def lit(town, gbuffer, weather: Weather, **others: Any) -> np.ndarray:
    return shader(town, weather, **others).shade(gbuffer, CAMERA, DOWN)


def test_in_clear_air_below_an_open_sky_it_is_daylight(town, gbuffer):
    np.testing.assert_allclose(
        lit(town, gbuffer, Weather(SUN, 18_000.0)),
        DaylightShader(town, SUN, 18_000.0).shade(gbuffer, CAMERA, DOWN),
        rtol=1e-4,
    )


def test_no_fog_is_the_limit_of_fog_and_thick_fog_is_all_that_is_seen(town, gbuffer):
    clear, thin, thick = (
        lit(town, gbuffer, Weather(None, 9_000.0, (1.0, 1.0, 1.0), beta, 0.6)) for beta in (0.0, 1e-7, 1.0)
    )
    np.testing.assert_allclose(thin, clear, rtol=1e-3, atol=0.05)
    np.testing.assert_allclose(thick, 0.6 * 9_000.0 / np.pi, rtol=1e-3)
    np.testing.assert_array_equal(clear, lit(town, gbuffer, Weather(None, 9_000.0, (1.0, 1.0, 1.0))))


def test_without_rain_or_snow_what_may_be_covered_changes_nothing(town, gbuffer):
    dry = Weather(SUN, 18_000.0, snow=0.0, water=0.0)
    np.testing.assert_array_equal(lit(town, gbuffer, dry, cover=0), lit(town, gbuffer, dry, cover=255))


def test_wet_surfaces_are_darker_but_for_what_they_mirror(town, gbuffer):
    sky = Weather(None, 9_000.0, (1.0, 1.0, 1.0))
    wet = Weather(None, 9_000.0, (1.0, 1.0, 1.0), water=1.0)
    dry_nit, damp_nit, wet_nit = (
        lit(town, gbuffer, weather, cover=cover) for weather, cover in ((sky, 0), (wet, 0), (wet, 255))
    )
    assert (damp_nit <= dry_nit + 1e-2).all()
    assert damp_nit.mean() < 0.85 * dry_nit.mean()
    # Nearly straight from above a film mirrors little more than 2 % of the sky.
    assert (wet_nit <= dry_nit + 0.2 * 9_000.0 / np.pi).all()
    level = gbuffer.normal_world[..., 2] > 0.9
    assert wet_nit[:, 1][level].min() > 0.018 * 9_000.0 / np.pi


def test_snow_whitens_what_is_level_and_spares_walls(town, gbuffer):
    snow = lit(town, gbuffer, Weather(None, 9_000.0, (1.0, 1.0, 1.0), snow=1.0))[:, 1]
    bare = lit(town, gbuffer, Weather(None, 9_000.0, (1.0, 1.0, 1.0)))[:, 1]
    level = gbuffer.normal_world[..., 2] > 0.9
    raised = level & (gbuffer.depth_m < 57.0)
    assert snow[raised].min() > 0.75 * 9_000.0 / np.pi
    walls = np.abs(gbuffer.normal_world[..., 2]) < 0.1
    # What walls see of the ground is brighter now, their own colour stays.
    assert (snow[walls] < 0.75 * 9_000.0 / np.pi).all()
    assert (snow[walls] >= bare[walls] - 1e-3).all()


def test_a_hidden_sky_darkens_the_ground_and_not_the_roofs(town, gbuffer):
    weather = Weather(None, 9_000.0)
    open_nit, hidden_nit = (lit(town, gbuffer, weather, share=share)[:, 1] for share in (1.0, 0.25))
    ground = gbuffer.depth_m > 59.5
    high = gbuffer.depth_m < 56.0
    np.testing.assert_allclose(hidden_nit[high], open_nit[high], rtol=1e-5)
    assert hidden_nit[ground].mean() < 0.4 * open_nit[ground].mean()


def lamps(light_lx: np.ndarray, cars: list[Footprint]) -> LampView:
    white = np.ones(3)
    return LampView(light_lx, cars, lamp_rgb=white, head_rgb=white, height_m=8.0)


def test_lamps_light_by_the_part_of_their_vector_along_the_normal(town, gbuffer):
    light_lx = np.zeros((CELLS, CELLS, 6), np.float32)
    light_lx[..., 2] = 20.0
    dark, lit_nit = (
        shader(town, Weather(None, 0.0), lamps=each).shade(gbuffer, CAMERA, DOWN)[:, 1]
        for each in (lamps(np.zeros_like(light_lx), []), lamps(light_lx, []))
    )
    assert not dark.any()
    full = DaylightShader(town, Sun((0.0, 0.0, 1.0), 20.0, (1, 1, 1)), 0.0).shade(gbuffer, CAMERA, DOWN)[:, 1]
    # Light that the sun throws from the ground onto walls is none of theirs.
    ground = (gbuffer.depth_m > 59.5) & (gbuffer.normal_world[..., 2] > 0.99)
    shadowless = ground & (full > 0.0)
    np.testing.assert_allclose(lit_nit[shadowless].max(), full[shadowless].max(), rtol=1e-3)
    assert not lit_nit[gbuffer.depth_m < 60.0 - 8.5].any()


def test_specks_add_their_light_or_hide_what_is_behind(town, gbuffer):
    table = np.zeros((2, COLUMNS), np.float32)
    table[:, X], table[:, Y], table[:, LONG], table[:, SHORT] = (30.5, 60.5), 40.5, 3.0, 3.0
    table[:, 2] = 1.0
    table[0, GREEN], table[1, COVER] = 700.0, 1.0
    weather = Weather(None, 9_000.0)
    plain = lit(town, gbuffer, weather)
    seen = lit(town, gbuffer, weather, sources=(lambda camera, pose, frame: table,))
    assert seen[40, 1, 30] - plain[40, 1, 30] == pytest.approx(700.0, rel=1e-3)
    np.testing.assert_allclose(seen[40, :, 60], 0.0, atol=1e-3)
    changed = (seen != plain).any(axis=1)
    assert changed[38:44, 27:34].any()
    assert not changed[:36].any()


def test_rows_and_the_gbuffer_give_the_same_picture(town):
    sources = (lambda camera, pose, frame: np.zeros((0, COLUMNS), np.float32),)
    weather = Weather(SUN, 18_000.0, beta_per_m=0.004, water=0.7)
    for each in (weather, Weather(None, 2.0, snow=0.5)):
        lit_by = None
        if each.sun is None:
            light_lx = np.random.default_rng(0).random((CELLS, CELLS, 6)).astype(np.float32) * 20
            lit_by = lamps(light_lx, [])
        made = shader(town, each, cover=120, sources=sources, lamps=lit_by)
        pictures = []
        for renderer in (Raster(town), _Plain(Raster(town))):
            sensor = CameraSensor(SensorConfig(), np.random.Generator(np.random.PCG64(0)))
            pictures.append(capture(renderer, made, sensor, CAMERA, DOWN, 0).picture.image_rgb)
        np.testing.assert_array_equal(*pictures)


class _Plain:
    """A renderer that draws G-buffers alone."""

    def __init__(self, renderer: Raster) -> None:
        self.gbuffer, self.normals = renderer.gbuffer, renderer.normals


def test_the_map_is_wider_than_what_the_camera_sees():
    assert CELLS * COARSE_M > 200.0
