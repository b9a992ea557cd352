"""Who comes: as many as configured, on ways that people, cars and boats can take, in and out of cars."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from numpy.typing import NDArray

from scenarios.harbour import plan as routes
from scenarios.harbour.conditions import draw_conditions
from scenarios.harbour.intruders import Intruders
from scenarios.harbour.layout import FIXED
from scenarios.harbour.plan import Journey, Plan, Visit, draw_car, draw_person, draw_plan, names_of
from scenarios.harbour.presets import PRESETS
from sim.meshes.person import person_size_m
from sim.meshes.thermal_paint import thermal_car
from sim.world import World

SEEDS = range(12)


def rng_of(seed: int) -> np.random.Generator:
    return np.random.Generator(np.random.PCG64(seed))


def last_s(name: str) -> float:
    return PRESETS[name].frame_count / PRESETS[name].rate_hz


@pytest.fixture(scope="module")
def plans() -> list[tuple[str, Plan]]:
    """Return plans of all presets for several seeds."""
    return [(name, draw_plan(preset, rng_of(seed))) for name, preset in PRESETS.items() for seed in SEEDS]


def way_of(visit: Visit, until_s: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return times each second while it is there, and places (F, 2)."""
    time_s = np.arange(max(visit.begin_s, 0.0), min(visit.end_s, until_s), 1.0)
    return time_s, visit.journey.at(time_s)[0]


def test_as_many_come_as_configured_in_order(plans: list[tuple[str, Plan]]) -> None:
    for name, plan in plans:
        preset = PRESETS[name]
        kinds = [visit.kind for visit in plan.visits]
        counts = kinds.count("person"), kinds.count("car"), kinds.count("boat")
        assert counts == (preset.people, preset.cars, preset.boats), name
        begins = [visit.begin_s for visit in plan.visits]
        assert begins == sorted(begins)
        assert all(begin < last_s(name) for begin in begins)
        names = list(names_of(plan.visits))
        assert len(set(names)) == len(names)
        assert "person-0" in names
        assert sum(visit.begin_s < 0 for visit in plan.visits if visit.kind == "car") == preset.cars_before


def door_of(car: Journey, time_s: float) -> NDArray[np.float64]:
    """Return where one stands at the driver's door, on the car's left and somewhat before its middle."""
    (place,), (heading,), _ = car.at(np.array([time_s]))
    turn = np.array([[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]])
    return np.asarray(place + turn @ (0.2, 1.45))


def test_each_comes_from_outside_or_out_of_a_car_and_is_watched_at_some_time(plans: list[tuple[str, Plan]]) -> None:
    for name, plan in plans:
        cars = [visit.journey for visit in plan.visits if visit.kind == "car"]
        for visit in plan.visits:
            _, place = way_of(visit, last_s(name))
            three = np.column_stack([place, np.full(len(place), 0.5)])
            watched = FIXED.is_watched(three)
            if last_s(name) > 900.0:
                assert watched.any(), (name, visit)
            if visit.kind == "person":
                doors = [door_of(car, visit.begin_s) for car in cars]
                at_door = np.min(np.linalg.norm(place[0] - np.reshape(doors, (-1, 2)), axis=1), initial=9.0) < 0.1
                assert at_door or not watched[0] or visit.begin_s < 0.0
            elif visit.begin_s > 0:
                assert not watched[0]


def test_deliveries_stop_on_the_apron_along_the_quay_and_go_on_ahead() -> None:
    for seed in SEEDS:
        preset = PRESETS["paper-d"]
        cars = [visit for visit in draw_plan(preset, rng_of(seed)).visits if visit.kind == "car"]
        stops = [visit.journey for visit in cars if np.isfinite(visit.begin_s)]
        assert len(stops) == preset.deliveries == 2
        for car in stops:
            still = int(np.argmax(np.diff(car.time_s)))
            (x, _), heading = car.place_m[still], car.at(car.time_s[still : still + 1] + 1.0)[1]
            low_s, high_s = preset.car_stays_s
            assert low_s < np.diff(car.time_s)[still] < high_s + 30.0
            assert FIXED.wall_x_m + 4.0 < x < FIXED.apron_end_m - 4.0
            assert abs(np.sin(heading[0])) > 0.98
            assert not car.backwards.any()
            step = np.diff(car.place_m, axis=0)
            turns = np.diff(np.unwrap(np.arctan2(*step[np.hypot(*step.T) > 1e-9].T[::-1])))
            assert np.abs(turns).max() < 0.7


def test_who_patrols_is_there_from_the_first_picture_to_the_last_and_watched_all_the_time() -> None:
    for name in ("patrol", "quick"):
        for seed in SEEDS:
            plan = draw_plan(PRESETS[name], rng_of(seed))
            patrol = next(visit for visit in plan.visits if visit.kind == "person")
            assert patrol.begin_s < 0.0
            assert patrol.end_s > last_s(name)
            _, place = way_of(patrol, last_s(name))
            assert np.linalg.norm(np.diff(place, axis=0), axis=1).sum() > 0.5 * last_s(name)
            assert FIXED.is_watched(np.column_stack([place, np.full(len(place), 0.9)])).mean() > 0.95


def inside(place: NDArray[np.float64], low: tuple[float, float], high: tuple[float, float]) -> NDArray[np.bool_]:
    return np.asarray(((place > low) & (place < high)).all(axis=1))


def test_people_walk_around_what_is_solid(plans: list[tuple[str, Plan]]) -> None:
    for name, plan in plans:
        cars_y = [*plan.usual_y_m, *plan.before_y_m]
        for visit in plan.visits:
            if visit.kind != "person":
                continue
            _, place = way_of(visit, last_s(name))
            assert (place[:, 0] > FIXED.wall_x_m + 0.3).all()
            for y in cars_y:
                assert not inside(
                    place, (FIXED.parking_x_m - 2.0, y - 0.7), (FIXED.parking_x_m + 2.0, y + 0.7)
                ).any(), (name, y)
            # Into a shed one goes through a door.
            for shed in FIXED.sheds:
                half = 0.5 * shed.length_m
                within = inside(
                    place, (FIXED.shed_x_m, shed.y_m - half), (FIXED.shed_x_m + shed.depth_m, shed.y_m + half)
                )
                beside = np.abs(place[within, 1:] - np.array(shed.doors_y_m)).min(axis=1, initial=9.0)
                assert (beside < 1.0).all()
            steps = np.linalg.norm(np.diff(place, axis=0), axis=1)
            assert steps.max(initial=0.0) < 1.8


def test_boats_keep_to_the_water_and_off_the_others(plans: list[tuple[str, Plan]]) -> None:
    for name, plan in plans:
        for visit in plan.visits:
            if visit.kind != "boat":
                continue
            _, place = way_of(visit, last_s(name))
            assert (place[:, 0] < FIXED.wall_x_m - 1.5).all()
            for x, y in FIXED.buoys_m:
                assert np.hypot(*(place - (x, y)).T).min() > 8.5
            for berth in FIXED.berths:
                if not berth.is_free:
                    beside = np.abs(place[:, 1] - berth.y_m) < 4.5
                    assert (place[beside, 0] < FIXED.wall_x_m - 4.2).all(), (name, berth, place[beside, 0].max())


def test_someone_stands_still_for_five_minutes_in_the_long_presets(plans: list[tuple[str, Plan]]) -> None:
    for name, plan in plans:
        if last_s(name) < 900.0:
            continue
        longest = 0.0
        for visit in plan.visits:
            if visit.kind == "person":
                _, place = way_of(visit, last_s(name))
                still = np.linalg.norm(np.diff(place, axis=0), axis=1) < 1e-9
                runs = np.diff(np.flatnonzero(np.concatenate([[True], ~still, [True]])))
                longest = max(longest, float(runs.max(initial=0)))
        assert longest >= 300.0, name


def test_drivers_get_out_of_cars_that_come_and_into_cars_that_leave(plans: list[tuple[str, Plan]]) -> None:
    came = left = 0
    for name, plan in plans:
        people = [visit for visit in plan.visits if visit.kind == "person"]
        for visit in plan.visits:
            if visit.kind != "car" or last_s(name) < 900.0:
                continue
            for start_s, stop_s in visit.engine_s:
                # One run before the car's stop, one from before its start.
                door = door_of(visit.journey, stop_s if start_s < visit.begin_s else start_s)
                if start_s < visit.begin_s:
                    found = [p for p in people if 5.0 < p.begin_s - stop_s < 15.0 and near(p, p.begin_s, door)]
                    came += 1
                else:
                    found = [p for p in people if 0.0 < start_s - p.end_s < 30.0 and near(p, p.end_s - 1e-6, door)]
                    left += 1
                assert len(found) == 1, (name, visit)
    assert came > 50
    assert left > 20


def near(person: Visit, time_s: float, place: NDArray[np.float64]) -> bool:
    return bool(np.linalg.norm(person.journey.at(np.array([time_s]))[0][0] - place) < 0.1)


def test_a_car_backs_out_with_its_bonnet_behind() -> None:
    back, on = routes.out_of_bay(FIXED, 6.0, 1.0)
    way = routes.then(routes.journey(back, 1.5, 10.0, backwards=True), routes.journey(on, 4.0, 40.0))
    _, heading, speed = way.at(np.array([5.0, 12.0, 35.0, 42.0]))
    # Facing the sea in the bay, also before it starts; afterwards along the lane to the left.
    assert np.cos(heading[0] - np.pi) > 0.999
    assert np.cos(heading[1] - np.pi) > 0.999
    assert np.cos(heading[2] - 0.5 * np.pi) > 0.95
    assert np.cos(heading[3] - 0.5 * np.pi) > 0.999
    assert speed.tolist() == pytest.approx([0.0, 1.5, 0.0, 4.0])


def test_a_journey_keeps_its_speed_and_its_pauses() -> None:
    way = routes.journey([(0.0, 0.0), (10.0, 0.0), (10.0, 5.0)], 2.0, 100.0, {1: 30.0})
    place, heading, speed = way.at(np.array([99.0, 102.0, 120.0, 136.0, 138.0]))
    np.testing.assert_allclose(place, [(0, 0), (4, 0), (10, 0), (10, 2), (10, 5)])
    np.testing.assert_allclose(speed, [0, 2, 0, 2, 0])
    np.testing.assert_allclose(heading, [0, 0, 0, 0.5 * np.pi, 0.5 * np.pi])


def test_cars_come_along_the_lane_from_outside_the_picture() -> None:
    for side in (-1.0, 1.0):
        way = routes.into_bay(FIXED, -3.0, side)
        np.testing.assert_allclose(way[0], (FIXED.lane_x_m, side * FIXED.border_y_m(FIXED.lane_x_m)))
        np.testing.assert_allclose(way[-1], (FIXED.parking_x_m, -3.0))
        assert abs(way[0, 1]) - 5.9 > 0.2493 * (FIXED.lane_x_m + 100.0)


@pytest.mark.heavy
def test_true_sizes_vary_by_a_fifth_to_either_side() -> None:
    rng = rng_of(3)
    people = [draw_person(rng) for _ in range(200)]
    statures_m = np.array([person_size_m(each)[2] for each in people])
    np.testing.assert_allclose(statures_m, [each.stature_m for each in people], rtol=0.012)
    looks = [draw_car(rng) for _ in range(200)]
    factors = [
        thermal_car(each.model, each.factors).size_m / thermal_car(each.model, (1, 1, 1)).size_m for each in looks
    ]
    preset = dataclasses.replace(PRESETS["quick"], people=1, cars=0, boats=4)
    boats_m = []
    for seed in range(20):
        world = World()
        plan, conditions = draw_plan(preset, rng_of(seed)), draw_conditions(preset, rng_of(seed))
        coming = Intruders(world, plan, conditions, np.array([0.0, 2.0]), rng_of(seed))
        boats_m += [size for kind, size in zip(coming.kinds, coming.size_m, strict=True) if kind == "boat"]
    # A launch's engine hangs behind its stern.
    lengths_m = np.array([each[0] - 0.42 * (each[2] < 3.0) for each in boats_m])
    shares = [statures_m / 1.72, np.array([each.build for each in people]), *np.transpose(factors)]
    shares += [lengths_m / 8.0, np.array(boats_m)[:, 1] / 2.64]
    for share in shares:
        assert 0.785 < share.min() < 0.825
        assert 1.175 < share.max() < 1.215


@pytest.mark.parametrize(
    "change",
    [{"people": 0}, {"cars": 7}, {"boats": 5}, {"cars_before": 5}, {"start_h": (9.0, 8.0)}, {"cloud": (0.5, 1.5)}],
)
def test_an_impossible_configuration_is_named(change: dict) -> None:
    with pytest.raises(ValueError, match=f"^{next(iter(change))}: expected"):
        dataclasses.replace(PRESETS["standard"], **change)
