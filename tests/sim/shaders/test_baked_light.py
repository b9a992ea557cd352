"""Pictures in baked light against what is known of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sim.gbuffer import SKY
from sim.mesh import Texture, TexturedMesh
from sim.optics import PinholeCamera, look_down_pose, rays
from sim.render.pipeline import capture
from sim.render.raster import Raster
from sim.sensors.camera_sensor import CameraSensor
from sim.sensors.config import SensorConfig
from sim.shaders.baked.bake import Panel, Sky, bake_light, mean_reflectance
from sim.shaders.baked.shader import BakedLightShader
from sim.shaders.colour import black_body_rgb, srgb_to_linear
from sim.shaders.daylight import Sun
from sim.shaders.lamps import BrightArea, Lamp
from sim.world import World
from tests.sim.demo_scene import box, pose

CAMERA = PinholeCamera.from_field_of_view(160, 120, np.radians(70))
GREY = Texture(np.full((4, 4, 3), 188, np.uint8), smooth=True)
RHO = float(srgb_to_linear(np.array(188 / 255)))
X, Y, Z = np.eye(3)
SUN = Sun((-1.0, 0.0, 1.0), 60_000.0, colour_rgb=(1, 1, 1))
INTO_YARD = look_down_pose(np.array([0.5, 2.0, 1.2]), 0.0, np.pi / 2 - 0.15, 0.0)


def _mesh(corner, side_a, side_b) -> TexturedMesh:
    corners = np.array([corner, corner + side_a, corner + side_a + side_b, corner + side_b], np.float32)
    normal = np.cross(side_a, side_b)
    normals = np.tile(normal / np.linalg.norm(normal), (4, 1)).astype(np.float32)
    uv = np.array([(0, 1), (1, 1), (1, 0), (0, 0)], np.float32)
    return TexturedMesh(corners, normals, uv, np.array([(0, 1, 2), (0, 2, 3)], np.int32), GREY)


def _add(world, panels, corner, side_a, side_b):
    corner, side_a, side_b = (np.asarray(each, dtype=float) for each in (corner, side_a, side_b))
    body = world.add(_mesh(corner, side_a, side_b), np.eye(4), name="panel", category="building")
    panels.append(Panel(body.index, corner, side_a, side_b, mean_reflectance(GREY)))
    return body


@pytest.fixture(scope="module")
def yard():
    """A roofed half and a sunny half, a bright area in the first, a box that moves."""
    panels: list[Panel] = []
    world = World()
    _add(world, panels, (0, 0, 0), 4 * X, 4 * Y)
    _add(world, panels, (4, 0, 0), 6 * X, 4 * Y)
    _add(world, panels, (0, 0, 3), 4 * Y, 4 * X)
    _add(world, panels, (0, 4, 0), 4 * X, 3 * Z)
    _add(world, panels, (4, 0, 0), -4 * X, 3 * Z)
    _add(world, panels, (10, 4, 0), -4 * Y, Z)
    area = BrightArea(len(world.bodies), np.array([1.5, 1.5, 2.99]), Y, X, 500.0, 4000.0)
    world.add(_mesh(area.corner_m, area.side_a_m, area.side_b_m), np.eye(4), name="light", category="building")
    world.add(box((0.4, 0.4, 1.6), GREY), pose(3.0, 2.5), name="walker", category="person", movable=True)
    baked = bake_light(panels, {"light": [area], "sun": [SUN], "sky": [Sky(2000.0)]})
    return world, baked


def _radiance(world, shader, T_world_camera=INTO_YARD):
    gbuffer = Raster(world).gbuffer(CAMERA, T_world_camera)
    return shader.shade(gbuffer, CAMERA, T_world_camera), gbuffer


def _sensor(seed=0, **options):
    return CameraSensor(SensorConfig(**options), np.random.default_rng(seed))


@pytest.mark.parametrize("glare", [0.0, 0.04])
def test_fused_pictures_are_those_of_the_stages(yard, glare):
    world, baked = yard
    shader, raster = BakedLightShader(world, baked), Raster(world)
    fused, staged = _sensor(veiling_glare=glare), _sensor(veiling_glare=glare)
    for frame in range(4):
        world.move(world.bodies[-1], pose(3.0 + frame, 2.5, 0.3 * frame))
        seen = capture(raster, shader, fused, CAMERA, INTO_YARD, frame)
        gbuffer = raster.gbuffer(CAMERA, INTO_YARD)
        picture = staged.expose(shader.shade(gbuffer, CAMERA, INTO_YARD), CAMERA, frame)
        np.testing.assert_array_equal(seen.depth_m, gbuffer.depth_m)
        np.testing.assert_array_equal(seen.instance_id, gbuffer.instance_id)
        difference = np.abs(seen.picture.image_rgb.astype(int) - picture.image_rgb)
        assert (difference > 0).mean() < 1e-3
        assert difference.max() <= 1
        assert seen.picture.settings.exposure_s == pytest.approx(picture.settings.exposure_s, rel=1e-5)


def test_the_same_pictures_again_are_byte_identical(yard):
    world, baked = yard
    runs = []
    for _ in range(2):
        shader, raster, sensor = BakedLightShader(world, baked), Raster(world), _sensor(veiling_glare=0.03)
        runs.append([])
        for frame in range(3):
            world.move(world.bodies[-1], pose(3.0 + frame, 2.5))
            runs[-1].append(capture(raster, shader, sensor, CAMERA, INTO_YARD, frame).picture.image_rgb)
    np.testing.assert_array_equal(*runs)


@pytest.mark.parametrize("glare", [0.0, 0.04])
def test_the_second_camera_of_a_pair_follows_the_first(yard, glare):
    world, baked = yard
    shader, raster = BakedLightShader(world, baked), Raster(world)
    left, right = _sensor(0, veiling_glare=glare), _sensor(1, veiling_glare=glare)
    for frame in range(3):
        first = capture(raster, shader, left, CAMERA, INTO_YARD, frame).picture
        given = replace(first.settings, gain=1.02 * first.settings.gain)
        second = capture(raster, shader, right, CAMERA, INTO_YARD, frame, settings=given).picture
        assert second.settings == given
        assert right.settings is None
        # The same light, brighter by its gain, with noise of its own.
        assert second.image_rgb.mean() > first.image_rgb.mean()
        assert (second.image_rgb != first.image_rgb).mean() > 0.3


def test_panels_show_reflectance_times_what_falls_on_them(yard):
    world, baked = yard
    world.move(world.bodies[-1], pose(-50.0, 0.0))
    shader = BakedLightShader(world, baked)
    shader.set_strengths({"sun": 0.0, "sky": 0.5})
    radiance, gbuffer = _radiance(world, shader)
    expected = 0.5 * baked.maps_lx[2] + baked.maps_lx[0]
    directions = rays(CAMERA, INTO_YARD, np.stack(np.meshgrid(np.arange(160), np.arange(120)), axis=-1) + 0.5)
    points_m = INTO_YARD[:3, 3] + directions * gbuffer.depth_m[..., None].clip(0, 100)
    shown = np.argwhere((gbuffer.instance_id >= 0) & (gbuffer.instance_id < len(baked.panels)))
    for row, column in np.random.default_rng(3).choice(shown, 60):
        r = int(gbuffer.instance_id[row, column])
        panel = baked.panels[r]
        from_corner = points_m[row, column] - panel.corner_m
        columns, rows = int(baked.where.columns[r]), int(baked.where.rows[r])
        x = from_corner @ panel.side_a_m / (panel.side_a_m @ panel.side_a_m) * (columns - 1)
        y = from_corner @ panel.side_b_m / (panel.side_b_m @ panel.side_b_m) * (rows - 1)
        lx = expected[baked.where.first[r] :][: columns * rows].reshape(rows, columns, 3)
        j, i = min(int(x), columns - 2), min(int(y), rows - 2)
        x, y = x - j, y - i
        upper = lx[i, j] * (1 - x) + lx[i, j + 1] * x
        lower = lx[i + 1, j] * (1 - x) + lx[i + 1, j + 1] * x
        value = RHO / np.pi * (upper * (1 - y) + lower * y)
        np.testing.assert_allclose(radiance[row, :, column], value, rtol=2e-3)


def test_strengths_add_up(yard):
    world, baked = yard
    world.move(world.bodies[-1], pose(6.0, 2.5))
    shader = BakedLightShader(world, baked)
    parts = []
    for name in baked.groups:
        shader.set_strengths({**dict.fromkeys(baked.groups, 0.0), name: 1.0})
        parts.append(_radiance(world, shader)[0])
    shader.set_strengths({"light": 3.0, "sun": 0.5, "sky": 2.0})
    together, _ = _radiance(world, shader)
    np.testing.assert_allclose(together, 3 * parts[0] + 0.5 * parts[1] + 2 * parts[2], rtol=2e-4, atol=1e-3)
    with pytest.raises(ValueError, match="strengths: expected groups of light, sun, sky, got moon"):
        shader.set_strengths({"moon": 1.0})
    with pytest.raises(ValueError, match=r"strengths\['sun'\]: expected a number >= 0, got -1"):
        shader.set_strengths({"sun": -1.0})


def test_bright_areas_and_the_sky_show_their_own_luminance(yard):
    world, baked = yard
    shader = BakedLightShader(world, baked)
    shader.set_strengths({"light": 0.5, "sky": 2.0})
    up = look_down_pose(np.array([0.3, 2.0, 1.2]), 0.0, np.pi / 2 + 0.3, 0.0)
    radiance, gbuffer = _radiance(world, shader, up)
    lit = gbuffer.instance_id == 6
    assert lit.sum() > 100
    np.testing.assert_allclose(
        radiance.transpose(0, 2, 1)[lit], np.broadcast_to(250.0 * black_body_rgb(4000.0), (lit.sum(), 3)), rtol=1e-5
    )
    seen = radiance.transpose(0, 2, 1)[gbuffer.instance_id == SKY]
    mean = 2.0 * Sky(2000.0).radiance
    assert len(seen) > 500
    assert (seen > 0.7 * mean).all()
    assert (seen < 1.5 * mean).all()


def test_things_that_move_cast_shadows_in_the_sun_and_darken_the_ground_they_stand_on(yard):
    world, baked = yard
    shader = BakedLightShader(world, baked)
    down = look_down_pose(np.array([7.0, 2.0, 8.0]), 0.0, 0.0, 0.0)

    def light(x: float, **strengths) -> np.ndarray:
        world.move(world.bodies[-1], pose(x, 2.0))
        shader.set_strengths({"light": 0.0, "sun": 0.0, "sky": 0.0, **strengths})
        return _radiance(world, shader, down)[0][:, 1]

    def at(x_m: float, y_m: float) -> tuple[int, int]:
        scale = CAMERA.focal_px / 8.0
        return int(60 - (x_m - 7.0) * scale), int(80 - (y_m - 2.0) * scale)

    sunny, shaded = light(-50.0, sun=1.0), light(8.0, sun=1.0)
    # The sun is 45 degrees up behind: the shadow goes to larger x by the box's height. Up to x = 7 is the roof's.
    assert shaded[at(9.0, 2.0)] < 0.2 * sunny[at(9.0, 2.0)]
    assert shaded[at(7.4, 2.0)] == pytest.approx(sunny[at(7.4, 2.0)], rel=0.01)
    assert shaded[at(9.0, 3.0)] == pytest.approx(sunny[at(9.0, 3.0)], rel=0.01)
    assert sunny[at(6.5, 2.0)] < 0.1 * sunny[at(7.4, 2.0)]
    open_sky, beside = light(-50.0, sky=1.0), light(8.0, sky=1.0)
    assert 0.2 < (beside / open_sky)[at(7.65, 2.0)] < 0.95
    assert beside[at(6.0, 2.0)] == pytest.approx(open_sky[at(6.0, 2.0)], rel=0.02)
    # Where it was, the light is back.
    np.testing.assert_array_equal(light(-50.0, sky=1.0), open_sky)


def test_a_shoe_shades_the_floor_where_panels_are_not_raised():
    panels: list[Panel] = []
    beyond = look_down_pose(np.array([4.0, 2.0, 8.0]), 0.0, 0.0, 0.0)
    world = World()
    _add(world, panels, (0, 0, 0), 6 * X, 4 * Y)
    shoe = world.add(box((0.1, 0.4, 0.12), GREY), pose(2.0, 2.0), name="shoe", category="person", movable=True)
    baked = bake_light(panels, {"sun": [SUN]})

    def at_the_foot(x_m: float, *, panels_raised: bool) -> float:
        # A coarse map, with a bias of more than the shoe's height.
        shader = BakedLightShader(world, baked, shadow_texels=64, panels_raised=panels_raised)
        world.move(shoe, pose(x_m, 2.0))
        row = int(60 + (4.0 - 2.1) * CAMERA.focal_px / 8.0)
        return float(_radiance(world, shader, beyond)[0][row, 1, 80])

    sunny = at_the_foot(-50.0, panels_raised=False)
    # The shoe ends at x = 2.05, and the sun stands behind it, 45 degrees high.
    assert at_the_foot(2.0, panels_raised=False) < 0.3 * sunny
    assert at_the_foot(2.0, panels_raised=True) > 0.9 * sunny


def test_illuminance_is_that_of_cubes_and_sun(yard):
    world, baked = yard
    shader = BakedLightShader(world, baked)
    points_m, up = np.array([[7.0, 2.0, 1.0], [3.5, 2.0, 1.0]]), np.tile(Z, (2, 1))
    lit, roofed = shader.illuminance_lx(points_m, up)
    shader.set_strengths({"sun": 0.0})
    without, still_roofed = shader.illuminance_lx(points_m, up)
    np.testing.assert_allclose(lit - without, 60_000.0 * np.sqrt(0.5), rtol=0.05)
    assert roofed[1] > 1.05 * still_roofed[1]
    assert roofed[1] < 0.2 * lit[1]


def test_a_wall_keeps_light_from_what_stands_behind_it():
    panels: list[Panel] = []
    world = World()
    _add(world, panels, (0, 0, 0), 6 * X, 4 * Y)
    _add(world, panels, (3.2, 0, 0), 4 * Y, 3 * Z)
    _add(world, panels, (3.2, 4, 0), -4 * Y, 3 * Z)
    baked = bake_light(panels, {"lamp": [Lamp((1.0, 2.0, 2.5), 2000.0, 4000.0)]})
    lx = BakedLightShader(world, baked).illuminance_lx(np.array([[3.1, 2.0, 1.0], [3.3, 2.0, 1.0]]), np.tile(Z, (2, 1)))
    assert lx[0, 1] > 10.0
    # On the floor, one panel, a little light runs on beneath the wall.
    assert lx[1].max() < 1e-3 * lx[0, 1]
