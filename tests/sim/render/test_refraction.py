"""What is seen through ripples, against Fermat's principle, flat water and the other renderer."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

from sim.optics import intersect_plane, look_down_pose, project, rays
from sim.render.protocol import create_renderer
from sim.render.refraction import ThroughWater, project_through
from tests.sim.water_scene import FLOOR, HIGH_M, LEVEL_M, LOW_M, RIM_M, WALLS, looking, surface, tank

ANGLES_DEG = [0, 25, 50]
FLAT = 0.0


def _places(count, rng, margin_m=0.03):
    low, high = np.array([*LOW_M, 0.0]), np.array([*HIGH_M, LEVEL_M])
    return rng.uniform(
        low + np.array([margin_m, margin_m, 0.004]), high - np.array([margin_m, margin_m, 0.01]), (count, 3)
    )


def _fermat(water, camera, T_world_camera, point_m):
    """Return the pixel of the place on the surface where the way from a point to the camera takes the least time."""
    eye = T_world_camera[:3, 3]

    def on_surface(xy):
        return np.array([*xy, water.level_m + water.height_and_slope(np.array([xy]))[0, 0]])

    def time(xy):
        place = on_surface(xy)
        return 1e3 * (np.linalg.norm(eye - place) + water.refractive_index * np.linalg.norm(place - point_m))

    share = (water.level_m - point_m[2]) / (eye[2] - point_m[2])
    start = point_m[:2] + 0.7 * share * (eye - point_m)[:2]
    found = minimize(time, start, method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-14, "maxiter": 2000})
    return project(camera, T_world_camera, on_surface(found.x)[None])[0][0]


@pytest.mark.parametrize("angle_deg", ANGLES_DEG)
def test_points_are_seen_along_the_fastest_way(angle_deg):
    water, (camera, T_world_camera) = surface(0.02), looking(angle_deg)
    points_m = _places(12, np.random.default_rng(angle_deg))
    expected = [_fermat(water, camera, T_world_camera, point) for point in points_m]
    np.testing.assert_allclose(project_through(water, camera, T_world_camera, points_m), expected, atol=0.01)


def test_straight_down_flat_water_looks_three_quarters_deep():
    water, (camera, T_world_camera) = surface(FLAT), looking(0)
    T_world_camera[:3, 3] = 0.0, 0.0, 1.2
    points_m = np.array([[0.002, 0.0, 0.03], [0.0, -0.003, 0.0]])
    raised_m = points_m.copy()
    raised_m[:, 2] = LEVEL_M - (LEVEL_M - points_m[:, 2]) / 1.333
    seen = project_through(water, camera, T_world_camera, points_m)
    np.testing.assert_allclose(seen, project(camera, T_world_camera, raised_m)[0], atol=1e-3)


def test_points_outside_the_water_are_seen_straight_on_and_those_behind_not_at_all():
    water, (camera, T_world_camera) = surface(), looking(30)
    points_m = np.array([[0.0, 0.0, 0.2], [0.5, 0.0, 0.0], [-3.0, 0.0, 5.0], [0.1, 0.1, 0.05]])
    seen, straight = (
        project_through(water, camera, T_world_camera, points_m),
        project(camera, T_world_camera, points_m)[0],
    )
    np.testing.assert_array_equal(seen[:2], straight[:2])
    assert np.isnan(seen[2]).all()
    assert np.abs(seen[3] - straight[3]).max() > 1.0
    assert project_through(water, camera, T_world_camera, np.empty((0, 3))).shape == (0, 2)


@pytest.mark.heavy
@pytest.mark.parametrize("renderer", ["raster", "pybullet"])
@pytest.mark.parametrize("angle_deg", ANGLES_DEG)
def test_boxes_are_drawn_where_their_middles_are_projected(renderer, angle_deg):
    """In rough water: without the ripples, or with those of the next frame, the places fit clearly worse."""
    water, (camera, T_world_camera) = surface(0.1), looking(angle_deg)
    rng = np.random.default_rng(8)
    grid = np.stack(np.meshgrid(np.linspace(-0.24, 0.24, 7), np.linspace(-0.15, 0.15, 5)), -1).reshape(-1, 2)
    points_m = np.column_stack([grid, rng.uniform(0.01, 0.1, len(grid))])
    world = tank(points_m)
    seen = ThroughWater(create_renderer(renderer, world), water).gbuffer(camera, T_world_camera)
    pixels = project_through(water, camera, T_world_camera, points_m)
    # The near wall's rim hides some from everyone.
    angle = np.radians(angle_deg + 6)
    run = np.tan(np.arcsin(np.sin(angle) / 1.333)) * (LEVEL_M - points_m[:, 2]) + np.tan(angle) * (RIM_M - LEVEL_M)
    within = (points_m[:, 0] - run > LOW_M[0]) & (
        (pixels > 12) & (pixels < np.array([camera.width_px, camera.height_px]) - 12)
    ).all(axis=1)
    assert within.sum() > 15
    middles = []
    for k in np.flatnonzero(within):
        rows, columns = np.nonzero(seen.instance_id == WALLS + 1 + k)
        # Ripples make some boxes small.
        assert len(rows) > 4
        middles.append(np.array([columns.mean(), rows.mean()]) + 0.5)
    away = np.array(middles) - pixels[within]
    # A box of five pixels; its middle is not quite that of the part that is seen.
    assert np.abs(np.median(away, axis=0)).max() < 0.2
    assert rms(away) < 0.7
    for other in (surface(FLAT), surface(0.1, time_s=water.time_s + 1 / 30)):
        assert rms(away) < 0.3 * rms(middles - project_through(other, camera, T_world_camera, points_m[within]))


def rms(off_px):
    return np.sqrt((np.asarray(off_px) ** 2).sum(axis=1).mean())


@pytest.mark.parametrize("angle_deg", ANGLES_DEG)
def test_depth_through_flat_water_is_that_of_the_floor(angle_deg):
    camera, T_world_camera = looking(angle_deg)
    world = tank()
    seen = ThroughWater(create_renderer("raster", world), surface(FLAT)).gbuffer(camera, T_world_camera)
    rows, columns = np.nonzero(seen.instance_id == FLOOR)
    chosen = np.random.default_rng(0).choice(len(rows), 400)
    pixels = np.column_stack([columns, rows])[chosen] + 0.5
    on_level = np.column_stack([intersect_plane(camera, T_world_camera, pixels, LEVEL_M), np.full(400, LEVEL_M)])
    inside = ((on_level[:, :2] > np.array(LOW_M)) & (on_level[:, :2] < np.array(HIGH_M))).all(axis=1)
    down = rays(camera, T_world_camera, pixels)
    down /= np.linalg.norm(down, axis=1, keepdims=True)
    sine = np.hypot(down[:, 0], down[:, 1]) / 1.333
    run = LEVEL_M * sine / np.sqrt(1 - sine**2)
    on_floor = on_level + np.column_stack(
        [down[:, :2] / np.maximum(np.hypot(*down[:, :2].T), 1e-12)[:, None] * run[:, None], np.full(400, -LEVEL_M)]
    )
    expected = (on_floor - T_world_camera[:3, 3]) @ T_world_camera[:3, 2]
    inside &= on_floor[:, 0] > LOW_M[0] + LEVEL_M * np.tan(np.radians(angle_deg + 5))
    assert inside.sum() > 250
    np.testing.assert_allclose(seen.depth_m[rows, columns][chosen][inside], expected[inside], atol=4e-4)


@pytest.mark.heavy
def test_both_renderers_see_the_same():
    water, (camera, T_world_camera) = surface(), looking(35)
    world = tank(_places(20, np.random.default_rng(4)), 0.012)
    a, b = (
        ThroughWater(create_renderer(name, world), water).gbuffer(camera, T_world_camera)
        for name in ("raster", "pybullet")
    )
    same = a.instance_id == b.instance_id
    assert same.mean() > 0.998
    np.testing.assert_allclose(a.depth_m[same], b.depth_m[same], atol=2e-3)
    np.testing.assert_array_equal(a.base_colour_rgb[same], b.base_colour_rgb[same])


def test_what_is_above_or_beside_the_water_is_seen_as_it_is():
    camera, T_world_camera = looking(20)
    world = tank()
    plain = create_renderer("raster", world)
    dry, wet = plain.gbuffer(camera, T_world_camera), ThroughWater(plain, surface()).gbuffer(camera, T_world_camera)
    rows, columns = np.mgrid[:480, :640]
    ray = rays(camera, T_world_camera, np.stack([columns, rows], -1) + 0.5)
    height_m = T_world_camera[2, 3] + ray[..., 2] * dry.depth_m
    above = height_m > LEVEL_M + 0.002
    assert above.sum() > 2000
    for name in ("base_colour_rgb", "instance_id", "depth_m", "normal_world"):
        np.testing.assert_array_equal(getattr(wet, name)[above], getattr(dry, name)[above])
    assert (wet.depth_m != dry.depth_m)[(height_m < 0.5 * LEVEL_M) & (dry.instance_id == WALLS)].mean() > 0.9
    assert (wet.depth_m != dry.depth_m)[dry.instance_id == FLOOR].mean() > 0.9


def test_ripples_move_and_come_back():
    water, (camera, T_world_camera) = surface(), looking(0)
    world = tank(_places(10, np.random.default_rng(1)), 0.01)
    through = ThroughWater(create_renderer("raster", world), water)
    pictures = []
    for water.time_s in (0.0, 0.1, 0.0):
        pictures.append(through.gbuffer(camera, T_world_camera).instance_id)
    assert (pictures[0] != pictures[1]).any()
    np.testing.assert_array_equal(pictures[0], pictures[2])


def test_a_camera_in_the_water_is_refused():
    camera, pose = looking(0)[0], look_down_pose(np.array([0.0, 0.0, 0.1]), 0.0, 0.0, 0.0)
    with pytest.raises(ValueError, match="T_world_camera: expected a camera above the water"):
        project_through(surface(), camera, pose, np.zeros((1, 3)))
