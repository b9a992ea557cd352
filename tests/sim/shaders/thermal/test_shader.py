"""Thermal radiance of a waterfront against the law of each part of it, written anew."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray

from sim.gbuffer import SKY
from sim.optics import PinholeCamera, ray_of_pixel
from sim.render.pipeline import capture
from sim.render.protocol import create_renderer
from sim.sensors.thermal_sensor import ThermalConfig, ThermalSensor
from sim.shaders.thermal.shader import ThermalShader
from sim.thermal.radiance import Air, band_radiance, sky_radiance
from sim.thermal.weather import Weather
from sim.world import World
from tests.sim.demo_scene import box, ground
from tests.sim.waterfront import Waterfront, overview, plain

CAMERA = PinholeCamera(128, 96, 257.0)
AIR = Air(temperature_k=285.0, attenuation_per_m=1e-3)
BLOCK_K, GROUND_K = 310.0, 290.0


class _Yard:
    """A block on level ground, in front of the overview camera."""

    def __init__(self, *, emissivity: float = 1.0) -> None:
        self.world = World()
        self.ground = self.world.add(ground(600.0, plain(0)), np.eye(4), name="ground", category="ground")
        self.block = self.world.add(box((8.0, 8.0, 8.0), plain(0, 1)), np.eye(4), name="block", category="building")
        self.shader = ThermalShader(self.world, 60.0, AIR)
        e = np.array([emissivity])
        self.shader.set_parts(self.ground, np.array([GROUND_K]), np.array([GROUND_K + 20]), e)
        self.shader.set_parts(self.block, *(np.repeat(x, 2) for x in ([BLOCK_K], [BLOCK_K + 20], e)))

    def seen(self, renderer: str = "raster") -> tuple[NDArray, NDArray, NDArray]:
        """Return radiance (H, W), ids and distances (H, W)."""
        gbuffer = create_renderer(renderer, self.world).gbuffer(CAMERA, overview())
        radiance = self.shader.shade(gbuffer, CAMERA, overview())
        assert radiance.shape == (96, 1, 128)
        return radiance[:, 0], gbuffer.instance_id, gbuffer.depth_m * _lengths()


def _directions() -> NDArray[np.float64]:
    x, y = np.meshgrid(np.arange(128) + 0.5, np.arange(96) + 0.5)
    return np.stack([x, y, np.ones_like(x)], axis=-1) @ (overview()[:3, :3] @ ray_of_pixel(CAMERA)).T


def _lengths() -> NDArray[np.float64]:
    return np.linalg.norm(_directions(), axis=-1)


@pytest.fixture
def yard() -> Iterator[_Yard]:
    """Yield a yard of black bodies at night."""
    return _Yard()


@pytest.mark.parametrize("renderer", ["raster", "pybullet"])
def test_black_bodies_are_dimmed_by_beers_law(yard, renderer):
    radiance, ids, away_m = yard.seen(renderer)
    for body, kelvin in ((yard.ground, GROUND_K), (yard.block, BLOCK_K)):
        seen = ids == body.index
        assert seen.sum() > 300
        passed = np.exp(-AIR.attenuation_per_m * away_m[seen])
        wanted = passed * band_radiance(kelvin) + (1 - passed) * band_radiance(AIR.temperature_k)
        np.testing.assert_allclose(radiance[seen], wanted, rtol=1e-4)


def test_the_sky_is_that_of_the_air(yard):
    T = overview()
    T[:3, :3] = T[:3, :3] @ np.array([[1, 0, 0], [0, np.cos(0.4), -np.sin(0.4)], [0, np.sin(0.4), np.cos(0.4)]])
    gbuffer = create_renderer("raster", yard.world).gbuffer(CAMERA, T)
    radiance, is_sky = yard.shader.shade(gbuffer, CAMERA, T)[:, 0], gbuffer.instance_id == SKY
    x, y = np.meshgrid(np.arange(128) + 0.5, np.arange(96) + 0.5)
    way = np.stack([x, y, np.ones_like(x)], axis=-1) @ (T[:3, :3] @ ray_of_pixel(CAMERA)).T
    sine = way[..., 2] / np.linalg.norm(way, axis=-1)
    assert is_sky.mean() > 0.5
    high = is_sky & (sine > 0.05)
    np.testing.assert_allclose(radiance[high], sky_radiance(AIR, sine[high]), rtol=5e-3)


def test_grey_bodies_mirror_sky_and_ground():
    grey = _Yard(emissivity=0.7)
    radiance, ids, away_m = grey.seen()
    sine = np.linspace(0, 1, 2001)
    sky = np.trapezoid(2 * sine * sky_radiance(AIR, sine), sine)
    level = ids == grey.ground.index
    passed = np.exp(-AIR.attenuation_per_m * away_m[level])
    own = 0.7 * band_radiance(GROUND_K) + 0.3 * sky
    wanted = passed * own + (1 - passed) * band_radiance(AIR.temperature_k)
    np.testing.assert_allclose(radiance[level], wanted, rtol=5e-4)


def test_parts_have_their_own_temperatures_and_fine_variations():
    yard = _Yard()
    yard.shader.set_air(Air(attenuation_per_m=0.0))
    yard.shader.set_parts(yard.block, np.array([300.0, 320.0]), np.array([300.0, 320.0]), np.ones(2))
    radiance, ids, _ = yard.seen()
    block = radiance[ids == yard.block.index]
    # Faces take parts 0 and 1 in turn; -x and the top are seen.
    np.testing.assert_allclose(np.unique(np.round(block, 2)), band_radiance(np.array([300.0, 320.0])), atol=0.01)
    texture = plain(0)
    texture.rgb[..., 1] = 128 + 64
    warm = yard.world.add(ground(20.0, texture), _raised(8.2), name="warm", category="ground")
    yard.shader.set_parts(warm, np.array([300.0]), np.array([300.0]), np.ones(1))
    radiance, ids, _ = yard.seen()
    np.testing.assert_allclose(radiance[ids == warm.index], band_radiance(300.0 + 64 * 4 / 127), rtol=1e-4)


def test_sun_warms_what_faces_it_and_shadows_stay_cool(yard):
    yard.shader.set_air(Air(attenuation_per_m=0.0))
    towards = np.array([-1.0, 1.0, 1.0]) / np.sqrt(3.0)
    yard.shader.set_sun([towards], [1.0])
    radiance, ids, away_m = yard.seen()
    block, level = ids == yard.block.index, ids == yard.ground.index
    lit_k = BLOCK_K + 20.0 / np.sqrt(3.0)
    assert np.median(radiance[block]) == pytest.approx(float(band_radiance(lit_k)), rel=1e-3)
    places = overview()[:3, 3] + _directions() * np.where(level, away_m / _lengths(), np.nan)[..., None]
    # The shadow falls along (1, -1): from the block's right rear side over the square beside it.
    x, y = places[..., 0], places[..., 1]
    back = -y - 4.0
    shaded = level & (back > 1.0) & (back < 6.0) & (x - back > -2.0) & (x - back < 2.0)
    open_ground = level & ((y > 6.0) | (x < -8.0))
    assert shaded.sum() > 15
    np.testing.assert_allclose(radiance[shaded], band_radiance(GROUND_K), rtol=1e-4)
    np.testing.assert_allclose(radiance[open_ground], band_radiance(GROUND_K + 20 / np.sqrt(3)), rtol=1e-4)


def test_stone_remembers_where_the_sun_stood(yard):
    yard.shader.set_air(Air(attenuation_per_m=0.0))
    up, low = np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.8, 0.6])
    yard.shader.set_sun([up, low], [0.7, 0.3])
    radiance, ids, _ = yard.seen()
    level = np.median(radiance[ids == yard.ground.index])
    assert level == pytest.approx(float(band_radiance(GROUND_K + 20 * (0.7 + 0.3 * 0.6))), rel=1e-3)
    with pytest.raises(ValueError, match=r"^weights: expected 1 numbers, got 2"):
        yard.shader.set_sun([up], [0.5, 0.5])


def test_movers_cast_no_thermal_shadow():
    yard = _Yard()
    yard.shader.set_sun([np.array([0.0, 0.0, 1.0])], [1.0])
    before = yard.seen()[0]
    body = yard.world.add(box((4.0, 4.0, 0.5), plain(0)), _raised(20.0), name="gull", category="bird", movable=True)
    after, ids, _ = yard.seen()
    others = ids != body.index
    np.testing.assert_array_equal(before[others], after[others])


@pytest.mark.parametrize("weights", [[0.7, 0.3], [0.4, 0.6]])
def test_weights_that_change_light_what_stands_still_anew(yard, weights):
    """What can move has the light of the strongest sun, also while it stands; the others that of all of them."""
    box_m = box((6.0, 6.0, 9.0), plain(0))
    mover = yard.world.add(box_m, _beside(12.0), name="car", category="vehicle", movable=True)
    fresh = ThermalShader(yard.world, 60.0, AIR)
    suns = [np.array([-0.6, 0.0, 0.8]), np.array([0.0, 0.6, 0.8])]
    for shader in (yard.shader, fresh):
        for body in (yard.ground, yard.block, mover):
            shader.set_parts(body, *np.repeat([[290.0], [310.0], [1.0]], 2, axis=1))
    yard.shader.set_sun(suns, [0.8, 0.2])
    before, ids, _ = yard.seen()
    yard.shader.set_sun(suns, weights)
    again = yard.seen()[0]
    fresh.set_sun(suns, weights)
    yard.shader = fresh
    assert yard.seen()[0].tobytes() == again.tobytes()
    moves = ids == mover.index
    assert moves.sum() > 300
    # Only where the strongest has changed is its light another one.
    assert (again[moves] != before[moves]).any() == (weights[0] < weights[1])
    assert (again[ids == yard.block.index] != before[ids == yard.block.index]).mean() > 0.3


def test_a_camera_at_rest_finds_the_sun_only_on_what_moved(yard):
    mover = yard.world.add(box((6.0, 6.0, 9.0), plain(0)), _beside(12.0), name="car", category="vehicle", movable=True)
    suns = [np.array([-0.6, 0.0, 0.8]), np.array([0.0, 0.6, 0.8])]
    yard.shader.set_sun(suns, [0.8, 0.2])
    _, before, _ = yard.seen()
    kept = yard.shader.row_light(np.empty((0, 0)), CAMERA, overview()).kept
    kept.light[:] = -9.0
    yard.shader.set_sun(suns, [0.6, 0.4])
    yard.world.move(mover, _beside(13.0))
    _, after, _ = yard.seen()
    again = yard.shader.row_light(np.empty((0, 0)), CAMERA, overview()).kept
    found = (again.light > -9.0).all(axis=1)
    near = (before == mover.index) | (after == mover.index)
    assert 100 < found.sum() <= near.sum()
    assert not found[~near].any()


def test_pictures_in_sequence_equal_those_of_a_new_shader():
    front = Waterfront(Weather(cloud=0.1), np.random.default_rng(0), boats=3, people=3)
    front.set_hour(9.0)
    renderer = create_renderer("raster", front.world)
    # Nothing changes but what moves; then the sun, the air and temperatures do, and it becomes night.
    hours = [9.0] * 4 + [9.2] * 2 + [2.0] * 2
    for k, hour in enumerate(hours):
        front.set_hour(hour)
        front.move_to(2.0 * k)
        fresh = ThermalShader(front.world, 120.0)
        kept, front.shader = front.shader, fresh
        fresh.sea = kept.sea
        front.set_hour(hour)
        front.shader = kept
        gbuffer = renderer.gbuffer(CAMERA, overview())
        whole, again = (each.shade(gbuffer, CAMERA, overview()) for each in (fresh, kept))
        assert whole.tobytes() == again.tobytes()


def test_rows_give_the_picture_that_stages_give():
    front = Waterfront(Weather(), np.random.default_rng(1), boats=2, people=2)
    front.set_hour(7.0)
    pose, renderer = overview(), create_renderer("raster", front.world)
    for k in range(3):
        front.move_to(2.0 * k)
        by_rows = capture(renderer, front.shader, _sensor(), CAMERA, pose, k)
        radiance = front.shader.shade(renderer.gbuffer(CAMERA, pose), CAMERA, pose)
        by_stages = _sensor().expose(radiance, CAMERA, k)
        assert by_rows.picture.counts.tobytes() == by_stages.counts.tobytes()
        assert by_rows.picture.image_rgb.tobytes() == by_stages.image_rgb.tobytes()


def test_impossible_parts_are_refused(yard):
    with pytest.raises(ValueError, match=r"^shaded_k: expected 1 to 16 parts, got 17"):
        yard.shader.set_parts(yard.block, *np.full((3, 17), 290.0))
    with pytest.raises(ValueError, match=r"^reach_m: expected a number > 0, got 0"):
        ThermalShader(yard.world, 0.0)


def _sensor() -> ThermalSensor:
    return ThermalSensor(ThermalConfig(), np.random.default_rng(3))


def _beside(y_m: float) -> NDArray[np.float64]:
    T = np.eye(4)
    T[1, 3] = y_m
    return T


def _raised(z_m: float) -> NDArray[np.float64]:
    T = np.eye(4)
    T[2, 3] = z_m
    return T
