"""Daylight against ray casting towards the sun and plain photometry."""

from __future__ import annotations

import numpy as np
import pytest

from sim.mesh import Texture
from sim.optics import PinholeCamera, look_down_pose, rays
from sim.render.raster import Raster
from sim.render.shadow_map import BLOCK, NOTHING, TILE, ShadowCaster, bounds_across, light_axes
from sim.shaders import daylight
from sim.shaders.colour import linear_to_srgb, srgb_to_linear
from sim.shaders.daylight import DaylightShader, Sun
from sim.world import World
from tests.sim.demo_scene import box, build_town, ground, pose
from tests.sim.ray_casting import RayCaster, away_from_edges

CAMERA = PinholeCamera.from_field_of_view(320, 240, np.radians(55))
DOWN = look_down_pose(np.array([5.0, 8.0, 60.0]), 0.3, 0.2, 0.0)
GREY = Texture(np.full((4, 4, 3), 188, np.uint8), smooth=True)
REFLECTANCE = float(srgb_to_linear(np.array(188 / 255)))
SUNS = {"high": (0.5, 0.3, 0.7), "low": (1.0, -0.6, 0.35), "zenith": (0.0, 0.0, 1.0)}


def _direction(elevation_deg: float, azimuth_rad: float = 0.8) -> tuple[float, float, float]:
    e = np.radians(elevation_deg)
    return (float(np.cos(e) * np.cos(azimuth_rad)), float(np.cos(e) * np.sin(azimuth_rad)), float(np.sin(e)))


@pytest.fixture(scope="module")
def town():
    return build_town(np.random.default_rng(5), extent_m=150, houses=40, cars=12, trees=20)


@pytest.mark.parametrize("name", SUNS)
def test_shadows_are_where_a_ray_to_the_sun_is_stopped(town, name):
    gbuffer = Raster(town).gbuffer(CAMERA, DOWN)
    direction = np.array(SUNS[name]) / np.linalg.norm(SUNS[name])
    radiance = DaylightShader(town, Sun(SUNS[name], 1e5), 0.0).shade(gbuffer, CAMERA, DOWN)
    rng = np.random.default_rng(1)
    row, column = rng.integers(2, 238, 1200), rng.integers(2, 318, 1200)
    facing = gbuffer.normal_world[row, column] @ direction
    row, column, facing = (values[facing > 0.2] for values in (row, column, facing))
    normal = gbuffer.normal_world[row, column].astype(float)
    points_m = (
        DOWN[:3, 3] + rays(CAMERA, DOWN, np.column_stack([column, row]) + 0.5) * gbuffer.depth_m[row, column, None]
    )
    distance, _ = RayCaster(town).nearest(points_m + 0.02 * normal, np.tile(direction, (len(row), 1)), skip=(0,))
    # Without skylight what the sun does not reach has only the light of the ground around, at most a fifth.
    base = srgb_to_linear(gbuffer.base_colour_rgb[row, column] / 255.0)
    full = base * facing[:, None] * 1e5 / np.pi
    bounced = base * 0.2 * 1e5 * direction[2] * (1 - normal[:, 2:]) / 2 / np.pi
    lit = ((radiance[row, :, column] - bounced) / full).mean(axis=1)
    # The map's texels blur shadow edges, and its bias lights the last texels before a caster: pixels are judged whose
    # surroundings are all lit or all dark, and which are not at grazing light.
    judged = away_from_edges(gbuffer.instance_id, 2)[row, column] & ((lit < 0.05) | (lit > 0.9))
    assert judged.mean() > 0.5
    stopped = np.isfinite(distance)
    assert (stopped == (lit < 0.5))[judged].mean() > 0.99
    if name != "zenith":
        assert stopped[judged].sum() > 30
        assert (lit[judged & stopped] < 0.5).mean() > 0.9


def test_level_ground_in_sun_and_shade_has_the_luminance_of_the_book():
    sun = Sun(_direction(40.0), 80_000.0, colour_rgb=(1, 1, 1))
    world = World()
    world.add(ground(400.0, GREY), np.eye(4), name="ground", category="ground")
    world.add(box((20, 20, 12), GREY), pose(0, 0), name="block", category="building")
    shader = DaylightShader(world, sun, 15_000.0, sky_colour_rgb=(1, 1, 1))
    gbuffer = Raster(world).gbuffer(CAMERA, DOWN)
    radiance = shader.shade(gbuffer, CAMERA, DOWN)
    green = radiance[:, 1][(gbuffer.instance_id == 0) & away_from_edges(gbuffer.instance_id, 2)]
    in_sun = REFLECTANCE * (80_000 * np.sin(np.radians(40)) + 15_000) / np.pi
    in_shade = REFLECTANCE * 15_000 / np.pi
    assert green.max() == pytest.approx(in_sun, rel=0.002)
    assert green.min() == pytest.approx(in_shade, rel=0.002)
    assert ((green > 0.99 * in_sun) | (green < 1.01 * in_shade)).mean() > 0.97


def test_shadow_of_a_block_has_the_length_of_the_sun_s_height():
    world = World()
    world.add(ground(400.0, GREY), np.eye(4), name="ground", category="ground")
    world.add(box((4, 4, 10), GREY), pose(0, 0), name="block", category="building")
    T_world_camera = look_down_pose(np.array([0, 0, 80.0]), 0, 0, 0)
    shader = DaylightShader(world, Sun(_direction(45.0, np.pi), 1e5), 0.0)
    gbuffer = Raster(world).gbuffer(CAMERA, T_world_camera)
    radiance = shader.shade(gbuffer, CAMERA, T_world_camera)
    # The sun stands behind the picture's bottom; world x is up in the picture. The shadow ends at x = 2 + 10.
    column = radiance[:, 1, 160]
    dark = np.flatnonzero((gbuffer.instance_id[:, 160] == 0) & (column < 0.5 * column.max()))
    metres_per_pixel = 80.0 / CAMERA.focal_px
    assert (120 - dark.min()) * metres_per_pixel == pytest.approx(12.0, abs=1.0)


def test_light_adds_up_and_scales(town):
    gbuffer = Raster(town).gbuffer(CAMERA, DOWN)
    sun, dark = Sun(SUNS["high"], 50_000.0), Sun(SUNS["high"], 0.0)
    both = DaylightShader(town, sun, 9_000.0).shade(gbuffer, CAMERA, DOWN)
    parts = DaylightShader(town, sun, 0.0).shade(gbuffer, CAMERA, DOWN)
    parts += DaylightShader(town, dark, 9_000.0).shade(gbuffer, CAMERA, DOWN)
    np.testing.assert_allclose(both, parts, rtol=1e-4)
    double = DaylightShader(town, Sun(SUNS["high"], 100_000.0), 18_000.0).shade(gbuffer, CAMERA, DOWN)
    np.testing.assert_allclose(double, 2 * both, rtol=1e-4)


def test_a_sun_below_the_horizon_lights_nothing_level(town):
    gbuffer = Raster(town).gbuffer(CAMERA, DOWN)
    radiance = DaylightShader(town, Sun((0.3, 0.1, -0.2), 1e5), 0.0).shade(gbuffer, CAMERA, DOWN)
    assert (radiance.transpose(0, 2, 1)[gbuffer.instance_id == 0] == 0).all()


def test_a_view_is_lit_alike_whatever_was_seen_before(town):
    sun = Sun(SUNS["low"], 1e5)
    raster, shader = Raster(town), DaylightShader(town, sun, 1e4)
    gbuffer = raster.gbuffer(CAMERA, DOWN)
    alone = DaylightShader(town, sun, 1e4).shade(gbuffer, CAMERA, DOWN)
    for k in range(6):
        other = look_down_pose(np.array([20.0 * k - 50, 30.0, 40.0 + 5 * k]), 0.5 * k, 0.3, 0.1)
        shader.shade(raster.gbuffer(CAMERA, other), CAMERA, other)
    np.testing.assert_array_equal(shader.shade(gbuffer, CAMERA, DOWN), alone)


def test_shadows_move_with_their_casters():
    world = World()
    world.add(ground(400.0, GREY), np.eye(4), name="ground", category="ground")
    world.add(box((6, 6, 6), GREY), pose(-12, -12), name="block", category="building")
    car = world.add(box((4, 2, 1.5), GREY), pose(-9, -3), name="car", category="vehicle", movable=True)
    T_world_camera = look_down_pose(np.array([0, 0, 40.0]), 0, 0, 0)
    raster, shader = Raster(world), DaylightShader(world, Sun(_direction(30), 1e5), 1e4)
    for x in (-9.0, 0.0, 8.0, 300.0):
        world.move(car, pose(x, -3))
        gbuffer = raster.gbuffer(CAMERA, T_world_camera)
        fresh = DaylightShader(world, Sun(_direction(30), 1e5), 1e4)
        np.testing.assert_array_equal(
            shader.shade(gbuffer, CAMERA, T_world_camera), fresh.shade(gbuffer, CAMERA, T_world_camera)
        )


def test_map_knows_its_highest_texels_and_keeps_its_border_empty():
    rng = np.random.default_rng(8)
    world = build_town(np.random.default_rng(5), extent_m=60, houses=40, cars=8, trees=10)
    caster = ShadowCaster(world, np.array(SUNS["low"]), size=128)
    cars = [body for body in world.bodies if body.movable]
    for _ in range(12):
        for car in cars:
            world.move(car, pose(*rng.uniform(-30, 30, 2), rng.uniform(0, 6)))
        region = caster.region(*np.sort(rng.uniform(-8, 8, (2, 2)), axis=0))
        shadow_map = caster.draw(region, np.ones_like(region.arrays.drawn))
        height_m = shadow_map.height_m
        for border in (height_m[0], height_m[-1], height_m[:, 0], height_m[:, -1]):
            assert (border == NOTHING).all()
        assert (height_m[1:-1, 1:-1] > NOTHING).mean() > 0.2
        for i in range(128 // BLOCK):
            for j in range(128 // BLOCK):
                block = height_m[i * BLOCK : (i + 1) * BLOCK + 1, j * BLOCK : (j + 1) * BLOCK + 1]
                assert shadow_map.highest_m[i, j] == block.max()


def test_tiles_drawn_as_they_are_wanted_are_those_of_the_whole_map():
    rng = np.random.default_rng(3)
    world = build_town(np.random.default_rng(5), extent_m=60, houses=40, cars=8, trees=10)
    bit_by_bit, at_once = (ShadowCaster(world, np.array(SUNS["low"]), size=256) for _ in range(2))
    cars = [body for body in world.bodies if body.movable]
    corners = np.array([[-9.0, -4.0], [6.0, 8.0]])
    for _ in range(20):
        for car in cars[: rng.integers(3)]:
            world.move(car, pose(*rng.uniform(-30, 30, 2), rng.uniform(0, 6)))
        low_m, high_m = corners + rng.uniform(0, 9)
        regions = [caster.region(low_m, high_m) for caster in (bit_by_bit, at_once)]
        wanted = rng.random(regions[0].arrays.drawn.shape) < 0.15
        part = bit_by_bit.draw(regions[0], wanted)
        whole = at_once.draw(regions[1], np.ones_like(wanted))
        seen = np.repeat(np.repeat(wanted, TILE, axis=0), TILE, axis=1)
        np.testing.assert_array_equal(part.height_m[seen], whole.height_m[seen])
        for i, j in np.argwhere(wanted) * (TILE // BLOCK):
            # Of the texels that are drawn: those of the next tiles are looked up through their own blocks.
            inside = part.height_m[i * BLOCK : (i + 1) * BLOCK, j * BLOCK : (j + 1) * BLOCK]
            assert part.highest_m[i, j] >= inside.max()


def test_what_lies_beyond_the_map_is_lit(monkeypatch):
    world = World()
    world.add(ground(400.0, GREY), np.eye(4), name="ground", category="ground")
    world.add(box((300, 4, 30), GREY), pose(0, 0), name="wall", category="building")
    T_world_camera = look_down_pose(np.array([0, -30.0, 60.0]), 0, 0, 0)
    gbuffer = Raster(world).gbuffer(CAMERA, T_world_camera)
    shader = DaylightShader(world, Sun((0.0, 1.0, 1.0), 1e5, colour_rgb=(1, 1, 1)), 0.0)
    # The map is made to cover the picture's top alone.
    monkeypatch.setattr(daylight, "bounds_across", lambda depth_m, *rest: bounds_across(depth_m[:2], *rest))
    radiance = shader.shade(gbuffer, CAMERA, T_world_camera)
    sunny = REFLECTANCE * 1e5 * np.sqrt(0.5) / np.pi
    level = (gbuffer.instance_id == 0) & away_from_edges(gbuffer.instance_id, 2)
    green = radiance[:, 1]
    rows = np.arange(240)[:, None] * np.ones(320)
    assert np.median(green[level & (rows < 32)]) < 0.1 * sunny
    np.testing.assert_allclose(green[level & (rows > 200)], sunny, rtol=1e-3)


@pytest.mark.parametrize("direction", [*SUNS.values(), (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0)])
def test_light_axes_are_a_right_handed_view_from_the_sun(direction):
    right, down, towards = light_axes(np.array(direction))
    np.testing.assert_allclose(
        np.array([right, down, towards]) @ np.array([right, down, towards]).T, np.eye(3), atol=1e-12
    )
    np.testing.assert_allclose(np.cross(right, down), -towards, atol=1e-12)


def test_srgb_there_and_back():
    codes = np.linspace(0, 1, 256)
    np.testing.assert_allclose(linear_to_srgb(srgb_to_linear(codes)), codes, atol=1e-6)
    assert srgb_to_linear(np.array(0.5)) == pytest.approx(0.21404, abs=1e-5)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((Sun((0, 0, 0), 1.0), 1.0), r"sun.direction: expected a vector of length > 0, got \(0, 0, 0\)"),
        ((Sun((0, 0, 1), -1.0), 1.0), "sun.illuminance_lx: expected a number >= 0, got -1.0"),
        ((Sun((0, 0, 1), 1.0), float("nan")), "sky_illuminance_lx: expected a number >= 0, got nan"),
    ],
)
def test_impossible_light_is_named(arguments, message):
    world = World()
    with pytest.raises(ValueError, match=message):
        DaylightShader(world, *arguments)
