"""Light of lamps against photometry by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim.gbuffer import SKY, GBuffer
from sim.optics import PinholeCamera, look_down_pose, rays
from sim.shaders.colour import LUMINANCE_WEIGHTS, black_body_rgb, srgb_to_linear
from sim.shaders.lamps import BrightArea, Lamp, LampShader, Surroundings

BLACK_ROOM = Surroundings(surface_m2=100.0, reflectance=0.0)
CAMERA = PinholeCamera(40, 30, 35.0)
UP = np.array([[0.0, 0.0, 1.0]])


def _window(luminance_nit: float, side_m: float, height_m: float) -> BrightArea:
    """A square above the origin that faces down."""
    half = 0.5 * side_m
    corner, a, b = np.array([-half, -half, height_m]), np.array([0.0, side_m, 0.0]), np.array([side_m, 0.0, 0.0])
    return BrightArea(7, corner, a, b, luminance_nit, 6500.0)


def _luminous(illuminance_lx: np.ndarray) -> np.ndarray:
    return illuminance_lx @ LUMINANCE_WEIGHTS


def test_a_lamp_of_one_candela_gives_one_lux_at_one_metre():
    shader = LampShader([Lamp((0.0, 0.0, 1.0), 4 * np.pi, 2700.0)], BLACK_ROOM)
    assert _luminous(shader.illuminance_lx(np.zeros((1, 3)), UP))[0] == pytest.approx(1.0)


@given(st.floats(0.2, 20.0), st.floats(0.0, 1.5), st.floats(1.0, 5000.0))
@settings(max_examples=50)
def test_light_falls_with_the_square_of_distance_and_the_cosine(distance_m, angle_rad, flux_lm):
    shader = LampShader([Lamp((0.0, 0.0, distance_m), flux_lm, 4000.0)], BLACK_ROOM)
    normal = np.array([[np.sin(angle_rad), 0.0, np.cos(angle_rad)]])
    expected = flux_lm / (4 * np.pi * distance_m**2) * np.cos(angle_rad)
    assert _luminous(shader.illuminance_lx(np.zeros((1, 3)), normal))[0] == pytest.approx(expected)


def test_what_faces_away_gets_only_what_the_room_throws_back():
    lamp = Lamp((0.0, 0.0, 2.0), 1000.0, 3000.0)
    assert (LampShader([lamp], BLACK_ROOM).illuminance_lx(np.zeros((1, 3)), -UP) == 0).all()
    grey = LampShader([lamp], Surroundings(surface_m2=80.0, reflectance=0.5))
    # An integrating sphere's wall: flux / area * rho / (1 - rho).
    assert _luminous(grey.illuminance_lx(np.zeros((1, 3)), -UP))[0] == pytest.approx(1000.0 / 80.0)


def test_all_light_of_a_lamp_arrives_on_a_sphere_around_it():
    shader = LampShader([Lamp((1.0, -2.0, 0.5), 700.0, 5000.0)], BLACK_ROOM)
    directions = np.random.default_rng(0).normal(size=(2000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    arriving = _luminous(shader.illuminance_lx(np.array([1.0, -2.0, 0.5]) + 3.0 * directions, -directions))
    assert arriving.mean() * 4 * np.pi * 3.0**2 == pytest.approx(700.0)


def test_lights_add_up():
    lamps = [Lamp((0.0, 1.0, 2.0), 500.0, 2700.0), Lamp((1.0, 0.0, 3.0), 900.0, 6500.0)]
    points, normals = np.random.default_rng(1).uniform(-1, 1, (20, 3)), np.tile(UP, (20, 1))
    room = Surroundings(60.0, 0.4)
    both, one, other = (LampShader(lit, room).illuminance_lx(points, normals) for lit in (lamps, lamps[:1], lamps[1:]))
    np.testing.assert_allclose(both, one + other)


def test_a_far_window_is_a_small_source_of_luminance_times_area():
    shader = LampShader([], BLACK_ROOM, [_window(luminance_nit=800.0, side_m=0.5, height_m=20.0)])
    expected = 800.0 * 0.25 / 20.0**2
    assert _luminous(shader.illuminance_lx(np.zeros((1, 3)), UP))[0] == pytest.approx(expected, rel=0.002)


def test_a_window_as_near_as_wide_has_the_view_factor_of_the_book():
    # A square of side 2 h at height h over a point: E = pi L F, F = 4 times the corner's factor (Howell C-11).
    shader = LampShader([], BLACK_ROOM, [_window(luminance_nit=100.0, side_m=2.0, height_m=1.0)])
    corner = 2 / np.sqrt(2) * np.arctan(1 / np.sqrt(2)) / (2 * np.pi)
    lx = _luminous(shader.illuminance_lx(np.zeros((1, 3)), UP))[0]
    assert lx == pytest.approx(np.pi * 100.0 * 4 * corner, rel=0.02)


@pytest.mark.parametrize("height_m", [0.05, 0.1, 0.2, 0.3, 0.6, 1.2])
def test_a_patch_is_right_also_where_it_is_near(height_m):
    shader = LampShader([], BLACK_ROOM, [_window(luminance_nit=100.0, side_m=0.6, height_m=height_m)])
    x = 0.3 / height_m
    corner = x / np.sqrt(1 + x * x) * np.arctan(x / np.sqrt(1 + x * x)) / np.pi
    lx = _luminous(shader.illuminance_lx(np.zeros((1, 3)), UP))[0]
    # A square is no disc.
    assert lx == pytest.approx(np.pi * 100.0 * 4 * corner, rel=0.012)


def test_nothing_comes_from_behind_a_window():
    window = _window(luminance_nit=800.0, side_m=0.5, height_m=-3.0)
    assert (LampShader([], BLACK_ROOM, [window]).illuminance_lx(np.zeros((1, 3)), -UP) == 0).all()


def test_a_windows_flux_comes_back_from_the_room():
    shader = LampShader([], Surroundings(50.0, 0.5), [_window(luminance_nit=200.0, side_m=1.5, height_m=2.0)])
    assert _luminous(shader.illuminance_lx(np.zeros((1, 3)), -UP))[0] == pytest.approx(np.pi * 200.0 * 2.25 / 50.0)


def test_the_picture_shows_reflectance_times_illuminance_over_pi():
    rng = np.random.default_rng(2)
    shape = (CAMERA.height_px, CAMERA.width_px)
    normals = rng.normal(size=(*shape, 3)).astype(np.float32)
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    depth_m = rng.uniform(1.0, 6.0, shape).astype(np.float32)
    depth_m[:5] = np.inf
    instance_id = np.full(shape, SKY, np.int32)
    instance_id[20:, :8] = 7
    gbuffer = GBuffer(rng.integers(0, 256, (*shape, 3), dtype=np.uint8), depth_m, instance_id, normals)
    T_world_camera = look_down_pose(np.array([1.0, 2.0, 5.0]), 0.4, 0.2, -0.1)
    lamps = [Lamp((0.0, 1.0, 3.0), 500.0, 2700.0), Lamp((2.0, 0.0, 4.0), 900.0, 6500.0)]
    window = _window(luminance_nit=900.0, side_m=1.0, height_m=4.0)
    shader = LampShader(lamps, Surroundings(60.0, 0.4), [window])
    radiance = shader.shade(gbuffer, CAMERA, T_world_camera)
    assert radiance.dtype == np.float32
    assert (radiance[:5] == 0).all()
    row, column = (g[5:] for g in np.mgrid[: shape[0], : shape[1]])
    directions = rays(CAMERA, T_world_camera, np.stack([column, row], axis=-1) + 0.5)
    points = T_world_camera[:3, 3] + directions * depth_m[5:, :, None]
    lx = shader.illuminance_lx(points.reshape(-1, 3), normals[5:].reshape(-1, 3).astype(float))
    expected = srgb_to_linear(gbuffer.base_colour_rgb[5:] / 255.0) * lx.reshape(points.shape) / np.pi
    expected[instance_id[5:] == 7] = 900.0 * black_body_rgb(6500.0)
    np.testing.assert_allclose(radiance[5:].transpose(0, 2, 1), expected, rtol=2e-5, atol=1e-6)


def test_a_lamps_colour_is_its_temperatures():
    shader = LampShader([Lamp((0.0, 0.0, 1.0), 100.0, 2200.0)], BLACK_ROOM)
    lx = shader.illuminance_lx(np.zeros((1, 3)), UP)[0]
    np.testing.assert_allclose(lx / _luminous(lx), black_body_rgb(2200.0))


def test_an_impossible_window_is_named():
    with pytest.raises(ValueError, match=r"luminance_nit: expected a number >= 0, got -2\.0"):
        LampShader([], BLACK_ROOM, [_window(luminance_nit=-2.0, side_m=1.0, height_m=1.0)])
    with pytest.raises(ValueError, match="side_a_m, side_b_m: expected sides of a rectangle"):
        LampShader([], BLACK_ROOM, [_window(luminance_nit=2.0, side_m=0.0, height_m=1.0)])


@pytest.mark.parametrize(
    ("lamp", "room", "message"),
    [
        (Lamp((0, 0, 1), -1.0, 3000.0), BLACK_ROOM, "flux_lm: expected a number >= 0, got -1.0"),
        (Lamp((0, 0, 1), float("nan"), 3000.0), BLACK_ROOM, "flux_lm: expected a number >= 0, got nan"),
        (Lamp((0, 0, 1), 1.0, 3000.0), Surroundings(0.0, 0.5), "surface_m2: expected a number > 0, got 0.0"),
        (Lamp((0, 0, 1), 1.0, 3000.0), Surroundings(9.0, 1.0), r"reflectance: expected a number in \[0, 1\), got 1.0"),
    ],
)
def test_impossible_light_is_named(lamp, room, message):
    with pytest.raises(ValueError, match=message):
        LampShader([lamp], room)
