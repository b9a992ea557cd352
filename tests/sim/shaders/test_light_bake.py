"""Baked light against photometry by hand."""

from __future__ import annotations

import numpy as np
import pytest

from sim.shaders.baked.bake import Panel, Sky, bake_light
from sim.shaders.baked.direct import resample
from sim.shaders.baked.light_maps import samples
from sim.shaders.baked.rays import blocked, nearest, rectangles, sphere_directions
from sim.shaders.colour import LUMINANCE_WEIGHTS, black_body_rgb
from sim.shaders.daylight import Sun
from sim.shaders.lamps import BrightArea, Lamp, LampShader, Surroundings

NO_ROOM = Surroundings(1.0, 0.0)
X, Y, Z = np.eye(3)


def rectangle(corner, side_a, side_b, reflectance=0.0, instance_id=-1) -> Panel:
    corner_m, side_a_m, side_b_m = (np.array(each, dtype=float) for each in (corner, side_a, side_b))
    return Panel(instance_id, corner_m, side_a_m, side_b_m, np.full(3, reflectance))


def room(size_m, reflectance) -> list[Panel]:
    """A closed box with one corner at the origin: floor, ceiling, four walls."""
    x, y, z = (axis * length for axis, length in zip((X, Y, Z), size_m, strict=True))
    return [
        rectangle(corner, a, b, reflectance)
        for corner, a, b in ((0 * X, x, y), (z, y, x), (0 * X, y, z), (x, z, y), (0 * X, z, x), (y, x, z))
    ]


def mean_lx(baked, group: int, r: int) -> float:
    """Mean luminous illuminance of a panel by the trapezium rule."""
    columns, rows, first = baked.where.columns[r], baked.where.rows[r], baked.where.first[r]
    lx = baked.maps_lx[group, first : first + columns * rows].reshape(rows, columns, 3) @ LUMINANCE_WEIGHTS
    weights = np.ones((rows, columns))
    weights[[0, -1]] *= 0.5
    weights[:, [0, -1]] *= 0.5
    return float((weights * lx).sum() / weights.sum())


def areas_m2(panels) -> np.ndarray:
    return np.array([np.linalg.norm(np.cross(panel.side_a_m, panel.side_b_m)) for panel in panels])


def luminous(lx) -> np.ndarray:
    return np.asarray(lx) @ LUMINANCE_WEIGHTS


@pytest.mark.parametrize("reflectance", [0.0, 0.5, 0.8])
def test_light_in_a_closed_room_adds_up_as_in_an_integrating_sphere(reflectance):
    panels = room((5.0, 4.0, 3.0), reflectance)
    baked = bake_light(panels, {"lamp": [Lamp((2.2, 1.7, 1.4), 1000.0, 4000.0)]})
    arriving = sum(mean_lx(baked, 0, r) * area for r, area in enumerate(areas_m2(panels)))
    assert arriving == pytest.approx(1000.0 / (1 - reflectance), rel=0.025)


def test_light_straight_from_lamps_and_areas_is_that_of_the_lamp_shader():
    window = BrightArea(0, np.array([0.01, 1.0, 0.8]), 1.6 * Y, 1.4 * Z, 800.0, 6500.0)
    lamp = Lamp((3.0, 2.0, 2.5), 900.0, 2700.0)
    panels = room((5.0, 4.0, 3.0), 0.0)
    baked = bake_light(panels, {"all": [lamp, window]})
    points_m, owner = samples(baked.geometry, baked.where)
    expected = LampShader([lamp], NO_ROOM, [window]).illuminance_lx(points_m, baked.geometry.normal[owner])
    # The wall behind the window is not in the open.
    seen = owner != 2
    np.testing.assert_allclose(baked.maps_lx[0, seen], expected[seen], rtol=1e-4, atol=1e-3)


def test_behind_a_wall_there_is_only_what_is_thrown_there():
    panels = room((6.0, 3.0, 3.0), 0.0)
    lamp = Lamp((1.0, 1.5, 1.5), 1000.0, 4000.0)
    between = [rectangle((3.0, 0.0, 0.0), 2.0 * Y, 3.0 * Z, 0.0), rectangle((3.0, 2.0, 0.0), -2.0 * Y, 3.0 * Z, 0.0)]
    dark = bake_light([*panels, *between], {"lamp": [lamp]})
    points_m, owner = samples(dark.geometry, dark.where)
    far_wall = owner == 3
    # Past the wall's edge, seen from the lamp: (2 - 1.5) / 2 of the way aside for each metre.
    shaded = far_wall & (points_m[:, 1] < 1.5 + 0.25 * 5.0 - 0.05)
    assert shaded.sum() > 50
    assert (dark.maps_lx[0, shaded] == 0).all()
    assert (dark.maps_lx[0, far_wall & (points_m[:, 1] > 2.85)] > 0).all()
    grey = bake_light([*room((6.0, 3.0, 3.0), 0.5), *between], {"lamp": [lamp]})
    assert (grey.maps_lx[0, shaded] > 0.3).all()
    assert grey.maps_lx[0, shaded].max() < 0.3 * grey.maps_lx[0, owner == 2].max()


def test_a_bright_ceiling_has_the_view_factor_of_the_book():
    # Two equal parallel squares, as far apart as they are wide: F = 0.19982 (Howell C-11).
    panels = [rectangle((0, 0, 0), 3 * X, 3 * Y), rectangle((0, 0, -9), X, Y)]
    ceiling = BrightArea(-1, 3 * Z, 3 * Y, 3 * X, 100.0, 6504.0)
    baked = bake_light(panels, {"ceiling": [ceiling]})
    assert mean_lx(baked, 0, 0) == pytest.approx(np.pi * 100.0 * 0.19982, rel=0.01)


def test_a_floor_throws_on_a_wall_what_the_book_says():
    # Squares at a right angle with a common edge: F = 0.20004 (Howell C-14).
    ceiling = {"down": [BrightArea(0, np.array([-3.0, -3.0, 2.9]), 9 * Y, 9 * X, 100.0, 6504.0)]}
    floor, grey_floor = (rectangle((0, 0, 0), 3 * X, 3 * Y, reflectance) for reflectance in (0.0, 0.5))
    wall = rectangle((3, 0, 0), 3 * Z, 3 * Y)
    grey, black = bake_light([grey_floor, wall], ceiling), bake_light([floor, wall], ceiling)
    thrown_lx = mean_lx(grey, 0, 1) - mean_lx(black, 0, 1)
    assert thrown_lx == pytest.approx(0.5 * mean_lx(black, 0, 0) * 0.20004, rel=0.05)
    # What hides the wall from the floor keeps that from it.
    screen = rectangle((2.5, -1, 0), 5 * Y, 2.8 * Z)
    screened, behind = (bake_light([each, wall, screen], ceiling) for each in (grey_floor, floor))
    assert mean_lx(screened, 0, 1) - mean_lx(behind, 0, 1) < 0.3 * thrown_lx


def test_an_open_plane_gets_pi_times_the_skys_luminance_and_half_of_it_beside_a_wall():
    open_ground = bake_light([rectangle((0, 0, 0), 10 * X, 10 * Y)], {"sky": [Sky(100.0)]})
    np.testing.assert_allclose(luminous(open_ground.maps_lx[0]), np.pi * 100.0, rtol=0.01)
    wall = rectangle((0, -10, 0), 20 * Y, 10 * Z)
    beside = bake_light([rectangle((0, -0.5, 0), X, Y), wall], {"sky": [Sky(100.0)]})
    near = luminous(beside.maps_lx[0, : beside.where.columns[0] * beside.where.rows[0] : beside.where.columns[0]])
    np.testing.assert_allclose(near, 0.5 * np.pi * 100.0, rtol=0.03)


def test_the_sun_gives_its_illuminance_times_the_cosine_but_behind_a_wall():
    sun = Sun((0.0, -1.0, 1.0), 80_000.0)
    panels = [rectangle((0, 0, 0), 6 * X, 6 * Y, 0.0), rectangle((-9, 1, 0), 30 * X, 2 * Z, 0.0)]
    baked = bake_light(panels, {"sun": [sun]})
    light = baked.sun
    assert light is not None
    np.testing.assert_allclose(luminous(light.square_lx), 80_000.0)
    rows, columns = light.where.rows[0], light.where.columns[0]
    share = light.share[light.where.first[0] :][: rows * columns].reshape(rows, columns)
    y_m = np.linspace(0, 6, rows)
    assert (share[(y_m < 0.9) | (y_m > 3.1)] == 1).all()
    assert (share[(y_m > 1.1) & (y_m < 2.9)] == 0).all()
    assert (baked.maps_lx == 0).all()
    # Which the grid's rays and the patches see: a grey ground throws light on the wall's front.
    grey = bake_light([rectangle((0, 0, 0), 6 * X, 6 * Y, 0.5), panels[1]], {"sun": [sun]})
    assert grey.maps_lx[0, grey.where.first[1] :].max() > 100.0


def test_cubes_between_alike_walls_are_alike_on_all_sides():
    panels = room((6.0, 6.0, 3.0), 0.5)
    # A dark lamp in each group but one keeps the groups apart.
    baked = bake_light(
        panels, {"off": [Lamp((3.0, 3.0, 1.5), 0.0, 4000.0)], "on": [Lamp((3.0, 3.0, 1.5), 500.0, 4000.0)]}
    )
    assert (baked.cubes_lx[0] == 0).all()
    # A cube's opposite sides together get the same whichever way: the lamp is in the middle.
    total = luminous(baked.cubes_lx[1]).mean(axis=0)
    assert total[0] == pytest.approx(total[3], rel=0.03)
    assert total[1] == pytest.approx(total[4], rel=0.03)
    sky = bake_light([rectangle((0, 0, 0), 5 * X, 5 * Y, 0.0)], {"sky": [Sky(100.0)]})
    up = luminous(sky.cubes_lx[0, :, 2])
    np.testing.assert_allclose(up, np.pi * 100.0, rtol=0.02)


def test_groups_are_their_lights_alone_and_together_their_sum():
    panels = room((5.0, 4.0, 3.0), 0.6)
    lamps = {"one": [Lamp((1.0, 1.0, 2.0), 700.0, 2700.0)], "other": [Lamp((4.0, 3.0, 1.0), 400.0, 6500.0)]}
    apart = bake_light(panels, lamps)
    together = bake_light(panels, {"both": [*lamps["one"], *lamps["other"]]})
    np.testing.assert_allclose(apart.maps_lx.sum(axis=0), together.maps_lx[0], rtol=5e-3)
    np.testing.assert_allclose(apart.cubes_lx.sum(axis=0), together.cubes_lx[0], rtol=5e-3)
    again = bake_light(panels, lamps)
    np.testing.assert_array_equal(apart.maps_lx, again.maps_lx)
    np.testing.assert_array_equal(apart.cubes_lx, again.cubes_lx)


def test_what_hangs_on_a_wall_does_not_darken_it_around():
    picture = [rectangle((0.02, 1.4, 1.0), 1.0 * Y, 1.0 * Z, 0.0)]
    lamp = {"lamp": [Lamp((3.0, 2.0, 1.5), 1000.0, 4000.0)]}
    panels = room((5.0, 4.0, 3.0), 0.0)
    bare, hung = bake_light(panels, lamp), bake_light([*panels, *picture], lamp)
    points_m, owner = samples(bare.geometry, bare.where)
    beside = (owner == 2) & ((points_m[:, 1] < 1.35) | (points_m[:, 1] > 2.45))
    np.testing.assert_allclose(hung.maps_lx[0, : len(owner)][beside], bare.maps_lx[0, beside], rtol=1e-5)
    behind = (owner == 2) & (abs(points_m[:, 1] - 1.9) < 0.2) & (abs(points_m[:, 2] - 1.5) < 0.2)
    np.testing.assert_allclose(hung.maps_lx[0, : len(owner)][behind], bare.maps_lx[0, behind], rtol=0.15)


def test_rays_meet_the_rectangles_that_plain_geometry_says():
    rng = np.random.default_rng(4)
    corner_m, side_a_m = rng.uniform(-5, 5, (2, 30, 3))
    side_b_m = np.cross(side_a_m, rng.normal(size=(30, 3)))
    side_b_m *= 3 / np.linalg.norm(side_b_m, axis=1, keepdims=True)
    them, room_to_work = rectangles(corner_m, side_a_m, side_b_m), np.empty(30, np.float32)
    for _ in range(300):
        start, along = rng.uniform(-5, 5, 3), rng.uniform(-10, 10, 3)
        met = []
        for r in range(30):
            u, v, t = np.linalg.solve(np.stack([side_a_m[r], side_b_m[r], -along], axis=1), start - corner_m[r])
            if 0 <= u <= 1 and 0 <= v <= 1 and t > 0:
                met.append((t, r, u, v))
        met.sort()
        assert blocked(them, *start, *along, 1.0) == any(t < 1 for t, *_ in met)
        found, u, v, front = nearest(them, *start, *along, room_to_work)
        assert found == (met[0][1] if met else -1)
        if met:
            assert (u, v) == pytest.approx(met[0][2:], abs=1e-3)
            assert front == (np.cross(side_a_m[found], side_b_m[found]) @ along < 0)


def test_directions_are_spread_evenly():
    directions = sphere_directions(500)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0)
    np.testing.assert_allclose(directions.mean(axis=0), 0.0, atol=0.005)
    np.testing.assert_allclose(directions.T @ directions / 500, np.eye(3) / 3, atol=0.005)


def test_resampling_keeps_what_is_linear():
    panels = [rectangle((0, 0, 0), 3 * X, 2 * Y)]
    baked = bake_light(panels, {"none": []})
    columns, rows = int(baked.where.columns[0]), int(baked.where.rows[0])
    ramp = (np.linspace(0, 1, columns)[None] + 2 * np.linspace(0, 1, rows)[:, None]).astype(np.float32).reshape(-1, 1)
    finer = baked.where._replace(columns=np.array([40], np.int32), rows=np.array([30], np.int32), total=1200)
    result = np.empty((1200, 1), np.float32)
    resample(baked.where, ramp, finer, 1, result)
    expected = np.linspace(0, 1, 40)[None] + 2 * np.linspace(0, 1, 30)[:, None]
    np.testing.assert_allclose(result.reshape(30, 40), expected, atol=1e-5)


@pytest.mark.parametrize(
    ("panels", "lights", "message"),
    [
        ([], {}, "panels: expected at least one, got 0"),
        ([rectangle((0, 0, 0), X, Y)], {}, "lights: expected at least one group, got 0"),
        ([rectangle((0, 0, 0), X, Y, 1.0)], {"a": []}, r"reflectance_rgb: expected three numbers in \[0, 1\)"),
        ([rectangle((0, 0, 0), X, X, 0.5)], {"a": []}, "side_a_m, side_b_m: expected sides of a rectangle"),
        ([rectangle((0, 0, 0), X, Y)], {"sky": [Sky(1.0), Sky(2.0)]}, "lights: expected one sky at most, got 2"),
        (
            [rectangle((0, 0, 0), X, Y)],
            {"a": [Sun(Z, 1.0)], "b": [Sun(Z, 1.0)]},
            "lights: expected one sun at most, got 2",
        ),
    ],
)
def test_impossible_worlds_are_named(panels, lights, message):
    with pytest.raises(ValueError, match=message):
        bake_light(panels, lights)


def test_a_lamps_colour_is_kept_between_grey_walls():
    baked = bake_light(room((4.0, 4.0, 3.0), 0.5), {"lamp": [Lamp((2.0, 2.0, 1.5), 500.0, 2700.0)]})
    colour = baked.maps_lx[0] / luminous(baked.maps_lx[0])[:, None]
    np.testing.assert_allclose(colour, np.broadcast_to(black_body_rgb(2700.0), colour.shape), rtol=0.02)
