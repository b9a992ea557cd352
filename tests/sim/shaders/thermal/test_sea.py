"""The sea in a thermal picture: Fresnel's law on flat water, means over slopes, and what stands before it mirrored."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.constants import Boltzmann, Planck, speed_of_light
from scipy.integrate import quad

from sim.optics import PinholeCamera, project, ray_of_pixel
from sim.render.protocol import create_renderer
from sim.shaders.thermal.mirror import image_of, mirror_arrays
from sim.shaders.thermal.sea import (
    SINES,
    SLOPES,
    STEEPEST,
    Sea,
    glitter,
    glitter_arrays,
    levels_of,
    may_glitter,
    radiance_table,
)
from sim.shaders.thermal.shader import ThermalShader
from sim.thermal.radiance import Air, air_mass, band_radiance, reflectance, sky_radiance
from sim.thermal.waves import CELLS, LEVELS, SeaState, SeaWaves
from sim.world import World
from tests.sim.demo_scene import box, ground
from tests.sim.waterfront import overview, plain

CAMERA = PinholeCamera(160, 120, 320.0)
AIR = Air(temperature_k=288.0, attenuation_per_m=0.0, zenith_emissivity=0.3)
CALM = SeaState(wind_wave_m=1e-6, swell_m=0.0, fine_slope=0.01)
SEA_K, WALL_K = 290.0, 330.0


def _seen(state: SeaState, *, wall: bool, level_m: float = 0.0) -> tuple[NDArray, NDArray]:
    """Return radiance (H, W) and ids of a sea, with a wall across it at x = 0."""
    world = World()
    sea = world.add(ground(900.0, plain(0)), _at(0.0, level_m), name="sea", category="ground", movable=True)
    shader = ThermalShader(world, 50.0, AIR)
    if wall:
        body = world.add(box((2.0, 300.0, 12.0), plain(0)), _at(1.0, -8.0), name="wall", category="building")
        shader.set_parts(body, np.array([WALL_K]), np.array([WALL_K]), np.ones(1))
    shader.sea = Sea(sea, SeaWaves(state, np.random.default_rng(0)), SEA_K)
    gbuffer = create_renderer("raster", world).gbuffer(CAMERA, overview())
    return shader.shade(gbuffer, CAMERA, overview())[:, 0], gbuffer.instance_id


def _at(x_m: float, z_m: float) -> NDArray[np.float64]:
    T = np.eye(4)
    T[0, 3], T[2, 3] = x_m, z_m
    return T


def _directions() -> NDArray[np.float64]:
    x, y = np.meshgrid(np.arange(CAMERA.width_px) + 0.5, np.arange(CAMERA.height_px) + 0.5)
    way = np.stack([x, y, np.ones_like(x)], axis=-1) @ (overview()[:3, :3] @ ray_of_pixel(CAMERA)).T
    return way / np.linalg.norm(way, axis=-1, keepdims=True)


def test_flat_water_emits_and_mirrors_the_sky_by_fresnel():
    radiance, ids = _seen(CALM, wall=False)
    sine = -_directions()[..., 2]
    sea = (ids == 0) & (sine > 0.14)
    assert sea.mean() > 0.4
    share = reflectance(sine[sea])
    wanted = (1 - share) * band_radiance(SEA_K) + share * sky_radiance(AIR, sine[sea])
    np.testing.assert_allclose(radiance[sea], wanted, rtol=2e-3)


def test_calm_water_mirrors_a_wall_up_to_where_its_top_is_seen():
    radiance, ids = _seen(CALM, wall=True)
    ways, sine = _directions(), -_directions()[..., 2]
    sea = ids == 0
    # Where the line of sight meets the water, and how high the mirrored one is when it comes to the wall.
    x_m = overview()[0, 3] + ways[..., 0] * overview()[2, 3] / sine
    rise_m = -x_m * sine / ways[..., 0]
    share = reflectance(sine)
    wall = (1 - share) * band_radiance(SEA_K) + share * band_radiance(WALL_K)
    sky = (1 - share) * band_radiance(SEA_K) + share * sky_radiance(AIR, sine)
    mirrors_wall, mirrors_sky = sea & (x_m < -2) & (rise_m < 3.0), sea & (rise_m > 5.2)
    assert min(mirrors_wall.sum(), mirrors_sky.sum()) > 1000
    np.testing.assert_allclose(radiance[mirrors_wall], wall[mirrors_wall], rtol=3e-3)
    np.testing.assert_allclose(radiance[mirrors_sky], sky[mirrors_sky], rtol=3e-3)


def test_waves_stir_what_is_mirrored():
    calm, ids = _seen(CALM, wall=True)
    rough, _ = _seen(SeaState(wind_wave_m=0.1, swell_m=0.1, fine_slope=0.1), wall=True)
    x_m = overview()[0, 3] + (_directions() / -_directions()[..., 2:])[..., 0] * overview()[2, 3]
    edge = (ids == 0) & (x_m > -40) & (x_m < -5)
    wall, sky = (np.percentile(calm[edge], share) for share in (97, 3))
    between = [np.mean(np.abs(each[edge] - 0.5 * (wall + sky)) < 0.3 * (wall - sky)) for each in (calm, rough)]
    assert between[1] > 3 * between[0]
    assert rough[edge].mean() == pytest.approx(calm[edge].mean(), rel=0.03)


def test_the_mirror_rises_with_the_tide():
    low, high = (_seen(CALM, wall=True, level_m=level) for level in (0.0, 1.0))
    lit = [(picture[0] > band_radiance(SEA_K) + 0.3) & (picture[1] == 0) for picture in (low, high)]
    # A metre less of the wall stands above the water: the reflection is shorter by more than that, seen from above.
    assert lit[1].sum() < 0.85 * lit[0].sum()


def test_a_table_is_the_mean_over_fine_slopes():
    table = radiance_table(AIR, SEA_K, 0.08).reshape(SINES, SLOPES, 2).sum(axis=-1)
    rng = np.random.default_rng(1)
    for m, n in ((20, 32), (40, 20), (70, 45)):
        grazing = np.arcsin(m / (SINES - 1))
        seen = np.arctan(-STEEPEST + 2 * STEEPEST * n / (SLOPES - 1) + 0.08 * rng.normal(size=100_000))
        weight = np.maximum(np.sin(grazing + seen), 0.0) / np.cos(seen)
        share = reflectance(np.clip(np.sin(grazing + seen), 0.0, 1.0))
        sky = sky_radiance(AIR, np.maximum(np.sin(grazing + 2 * seen), 0.0))
        wanted = np.average((1 - share) * band_radiance(SEA_K) + share * sky, weights=weight)
        assert table[m, n] == pytest.approx(wanted, rel=2e-3)


def test_levels_are_means_of_four():
    slopes = np.random.default_rng(2).normal(size=(CELLS, CELLS, 2)).astype(np.float32)
    levels, first = levels_of(slopes), 0
    for level in range(LEVELS):
        side = CELLS >> level
        blocks = slopes.reshape(side, 1 << level, side, 1 << level, 2).mean(axis=(1, 3))
        np.testing.assert_allclose(levels[first : first + side * side].reshape(side, side, 2), blocks, atol=1e-6)
        first += side * side
    assert first == len(levels)


def test_the_image_of_a_camera_sees_mirrored_points_in_mirrored_rows():
    points = np.random.default_rng(3).uniform((-20, -15, 0), (20, 15, 6), (50, 3))
    image, T_world_image = image_of(CAMERA, overview(), -1.8)
    found, _ = project(image, T_world_image, points)
    mirrored = points * (1.0, 1.0, -1.0) + (0.0, 0.0, -3.6)
    straight, _ = project(CAMERA, overview(), mirrored)
    nothing = np.zeros((image.height_px, image.width_px), np.float32)
    arrays = mirror_arrays(image, CAMERA, nothing, nothing)
    np.testing.assert_allclose(found[:, 0], arrays.across + arrays.scale * straight[:, 0], atol=1e-4)
    np.testing.assert_allclose(found[:, 1], arrays.down - arrays.scale * straight[:, 1], atol=1e-4)
    assert np.linalg.det(T_world_image[:3, :3]) == pytest.approx(1.0)


def test_the_sun_glitters_where_facets_mirror_it():
    # Facets are drawn one by one: those that mirror the sun's disc, blown up to 3 degrees, show it.
    rng, fine, disc = np.random.default_rng(4), 0.1, np.radians(3.0)
    towards = np.array([0.8, 0.15, 0.6])
    towards /= np.linalg.norm(towards)
    sun = glitter_arrays(towards.astype(np.float32), AIR)
    outside = quad(_planck_of_sun, 8e-6, 14e-6)[0] * 6.8e-5
    passed = (1 - AIR.zenith_emissivity) ** float(air_mass(towards[2]))
    assert float(sun.irradiance) == pytest.approx(outside * passed, rel=1e-3)
    grazing = np.radians(25.0)
    view = np.array([-np.cos(grazing), 0.0, np.sin(grazing)])
    slopes = rng.normal((0.02, -0.03), fine, (400_000, 2))
    normals = np.column_stack([-slopes, np.ones(len(slopes))])
    tilt = 1.0 / np.linalg.norm(normals, axis=1)
    facing = (normals @ view) * tilt
    mirrored = 2.0 * facing[:, None] * normals * tilt[:, None] - view
    hits = mirrored @ towards > np.cos(disc)
    disc_radiance = float(sun.irradiance) / (2 * np.pi * (1 - np.cos(disc)))
    shown = np.where(hits, facing / tilt * reflectance(np.clip(facing, 0, 1)), 0.0)
    wanted = disc_radiance * shown.mean() / np.sin(grazing)
    one, zero = np.float32(1), np.float32(0)
    found = glitter(sun, one, zero, *(np.float32(x) for x in (np.sin(grazing), 0.02, -0.03, fine)))
    assert found == pytest.approx(wanted, rel=0.05)
    assert may_glitter(sun, one, zero, np.float32(np.sin(grazing)), np.float32(fine))
    assert not may_glitter(sun, zero, one, np.float32(np.sin(grazing)), np.float32(fine))
    assert glitter_arrays(-towards.astype(np.float32), AIR).irradiance == 0


def _planck_of_sun(wavelength_m: float) -> float:
    photon = Planck * speed_of_light / (wavelength_m * Boltzmann * 5772.0)
    return 2 * Planck * speed_of_light**2 / wavelength_m**5 / np.expm1(photon)
