"""Bodies of vehicles never touch, by shapely's polygons; and no town stands still."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from scenarios.road_town.kept_apart import (
    APART_M,
    WHEELBASE_SHARE,
    Bodies,
    Room,
    any_touch,
    body_route,
    held_m,
    simulate_apart,
    zones_of,
)
from scenarios.road_town.plan import TARGET, Plan, make_plan
from scenarios.road_town.presets import NEXT_PRESETS, PRESETS
from scenarios.road_town.route import POINT_SPACING_M, Excursion, Passage, Route
from scenarios.road_town.traffic import Driver
from sim.rng import episode_seed

MIXED = NEXT_PRESETS["mixed-traffic"]
BUS, CAR = np.array([12.0, 2.55, 3.0]), np.array([4.7, 1.9, 1.5])


def straight(length_m: float, start=(0.0, 0.0), heading: float = 0.0, passages=()) -> Route:
    arc = np.arange(0, length_m, POINT_SPACING_M)
    points = np.array(start) + arc[:, None] * [np.cos(heading), np.sin(heading)]
    return Route(points, np.full(len(arc), heading), passages)


def outlines(position_m, heading_rad, size_m):
    """Return shapely's polygons (...) of vehicles at places (..., 2)."""
    corners = 0.5 * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * np.asarray(size_m)[..., None, :2]
    c, s = np.cos(heading_rad)[..., None], np.sin(heading_rad)[..., None]
    x = position_m[..., 0, None] + c * corners[..., 0] - s * corners[..., 1]
    y = position_m[..., 1, None] + s * corners[..., 0] + c * corners[..., 1]
    return shapely.polygons(np.stack([x, y], axis=-1))


def touching(plan: Plan) -> int:
    """Return on how many frames how many pairs of moving vehicles touch."""
    shapes = outlines(plan.motion.position_m, plan.motion.heading_rad, plan.sizes_m)
    pairs = 0
    for each in shapes:
        one, other = shapely.STRtree(each).query(each, predicate="intersects")
        pairs += int((one < other).sum())
    return pairs


def plan_of(preset, seed: int) -> Plan:
    return make_plan(preset, episode_seed(seed, "road-town-v2", 0), closed_loop=False)


def require_apart_and_moving(preset, seeds: range) -> None:
    for seed in seeds:
        plan = plan_of(preset, seed)
        assert touching(plan) == 0, seed
        moves = plan.motion.speed_mps > 0.3
        assert moves.mean() > 0.6, seed
        # Whoever stands in the first half has moved or will.
        assert moves.any(axis=0).all(), seed
        assert moves[-150:, TARGET].any(), seed
        assert len(plan.looks) == len(plan.sizes_m) == len(plan.routes) == moves.shape[1]


CROWDS = {
    "mixed": MIXED,
    "sixty": replace(MIXED, traffic_cars=60),
    "gipps": replace(MIXED, traffic_cars=60, driver="gipps"),
    "twins of a bus that leaves the road": replace(
        MIXED, excursions=(1, 2), target_vehicle="bus", traffic_looks="twins", traffic_side="left"
    ),
    "cars alone": replace(PRESETS["hard"], traffic_keeps_apart=True),
}


@pytest.mark.parametrize("name", ["mixed", "gipps"])
def test_no_two_bodies_touch_and_no_town_stands_still(name: str):
    require_apart_and_moving(CROWDS[name], range(1))


@pytest.mark.heavy
@pytest.mark.parametrize("name", CROWDS)
def test_no_two_bodies_touch_in_many_towns(name: str):
    require_apart_and_moving(CROWDS[name], range(1, 9))


def test_the_comparison_can_fail():
    """Of cars that keep apart on most crossings alone, some touch."""
    assert touching(plan_of(PRESETS["hard"], 1)) > 0


def test_the_presets_of_the_benchmark_are_as_they_were():
    assert not any(preset.keeps_apart for preset in PRESETS.values())
    assert replace(PRESETS["standard"], vehicles=("sedan", "bus")).keeps_apart
    assert replace(PRESETS["standard"], target_vehicle="bus").keeps_apart
    assert not replace(PRESETS["standard"], vehicles=("sedan", "van"), target_vehicle="suv").keeps_apart


rectangles = st.tuples(st.floats(-6, 6), st.floats(-6, 6), st.floats(-4, 4), st.floats(0.4, 6), st.floats(0.3, 1.3))


@settings(max_examples=300, deadline=None)
@given(rectangles, rectangles)
def test_rectangles_touch_where_shapely_says_so(one, other):
    shapes = [outlines(np.array(each[:2]), np.array(each[2]), 2 * np.array(each[3:])) for each in (one, other)]
    if 0 < shapely.distance(*shapes) < 1e-6 or 0 < shapely.intersection(*shapes).area < 1e-6:
        return
    assert any_touch(np.array([one]), np.array([other])) == shapely.intersects(*shapes)


def test_both_axles_of_a_long_vehicle_run_along_its_route():
    angle = np.arange(0.0, np.pi, POINT_SPACING_M / 15.0)
    route = Route(15.0 * np.column_stack([np.sin(angle), 1 - np.cos(angle)]), angle, ())
    path = body_route(route, 12.0)
    middle = slice(len(angle) // 4, 3 * len(angle) // 4)
    along = np.column_stack([np.cos(path.heading_rad), np.sin(path.heading_rad)])
    for sign in (-1.0, 1.0):
        axle_m = path.points_m + sign * 0.5 * WHEELBASE_SHARE * 12.0 * along
        assert np.abs(np.linalg.norm(axle_m - (0.0, 15.0), axis=1) - 15.0)[middle].max() < 0.1
    assert np.abs(path.heading_rad - angle)[middle].max() < 0.02


def test_the_free_way_ahead_ends_where_bodies_meet():
    lane, across = straight(200), straight(60, (80.0, -20.0), np.pi / 2)
    bodies = Bodies([body_route(lane, 12.0), body_route(lane, 4.7), body_route(across, 4.7)], np.array([BUS, CAR, CAR]))
    free_m, there = bodies.free_ahead(np.array([20.0, 60.0, 5.0]), 45.0)
    assert free_m[0] == pytest.approx(40.0 - 0.5 * (12.0 + 4.7) - APART_M, abs=0.51)
    assert there.tolist() == [1, -1, -1]
    assert np.isinf(free_m[1:]).all()


def placed(drivers: list[Driver], size_m: NDArray[np.float64]) -> list[Driver]:
    room = Room()
    for driver, size in zip(drivers, size_m, strict=True):
        assert room.is_free(driver, size)
        room.take(driver, size)
    return drivers


def test_a_bus_stops_behind_a_lorry_by_their_true_lengths():
    road, sizes = straight(500), np.array([[9.2, 2.5, 3.4], BUS])
    drivers = placed([Driver(road, 70.0, 9.0, stops=((120.0, 9.0),)), Driver(road, 20.0, 13.0)], sizes)
    motion, kept = simulate_apart(drivers, sizes, 300, 15.0)
    gap = motion.arc_m[:, 0] - motion.arc_m[:, 1] - 0.5 * (9.2 + 12.0)
    assert kept == [0, 1]
    assert motion.speed_mps[100:, 0].min() < 0.3
    assert 0.3 < gap.min() < 4.5


def test_of_vehicles_that_wait_for_each_other_one_is_left_out():
    """Two cars nose to nose in one lane would stand for ever."""
    east, west = straight(300), straight(300, (200.0, 0.0), np.pi)
    drivers = placed([Driver(east, 20.0, 9.0), Driver(west, 20.0, 9.0)], np.array([CAR, CAR]))
    motion, kept = simulate_apart(drivers, np.array([CAR, CAR]), 300, 15.0)
    assert kept == [TARGET]
    assert motion.speed_mps[-1, 0] == pytest.approx(9.0, abs=0.2)


def test_nobody_starts_where_another_might_have_to_stop():
    room, road = Room(), straight(300)
    room.take(Driver(road, 20.0, 12.0), CAR)
    assert not room.is_free(Driver(road, 30.0, 1.0), CAR)
    assert room.is_free(Driver(road, 40.0, 1.0), CAR)
    assert not room.is_free(Driver(road, 20.0 - 6.0, 1.0), BUS)


def test_a_way_over_a_crossing_is_held_to_where_the_vehicle_is_beyond_it():
    route = straight(300, passages=(Passage(1, 60.0, 75.0, 0.0), Passage(2, 80.0, 95.0, 0.0)))
    (both,) = zones_of(route, 12.0)
    assert both.from_m == pytest.approx(60.0 - 6.5)
    assert both.to_m == pytest.approx(95.0 + 6.5)
    assert len(zones_of(route, 2.0)) == 2
    assert held_m(30.0, 12.0, [both]) == pytest.approx(42.0)
    assert held_m(45.0, 12.0, [both]) == both.to_m
    off = zones_of(straight(300), 4.7, [Excursion(100.0, 160.0)])
    assert [round(each.to_m - each.from_m, 1) for each in off] == [18.7, 18.7]
