"""Traffic: speeds, gaps between cars, and crossings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scenarios import catalog
from scenarios.road_town import plan
from scenarios.road_town.plan import make_plan
from scenarios.road_town.presets import PRESETS
from scenarios.road_town.route import POINT_SPACING_M, Passage, Route
from scenarios.road_town.traffic import (
    LATERAL_ACCELERATION_MPS2,
    Approach,
    Crossings,
    Driver,
    simulate,
    speed_limit_mps,
)
from sim.rng import episode_seed


def _straight(length_m: float, start=(0.0, 0.0), heading: float = 0.0, passages=()) -> Route:
    arc = np.arange(0, length_m, POINT_SPACING_M)
    points = np.array(start) + arc[:, None] * [np.cos(heading), np.sin(heading)]
    return Route(points, np.full(len(arc), heading), passages)


def _circle(radius_m: float) -> Route:
    arc = np.arange(0, 2 * np.pi * radius_m, POINT_SPACING_M)
    angle = arc / radius_m
    return Route(radius_m * np.column_stack([np.sin(angle), 1 - np.cos(angle)]), angle, ())


def test_free_car_reaches_its_cruising_speed_and_moves_by_it():
    motion = simulate([Driver(_straight(500), 0.0, 10.0)], 300, 15.0)
    assert motion.speed_mps[-1, 0] == pytest.approx(10.0, abs=0.1)
    travelled = np.linalg.norm(np.diff(motion.position_m[:, 0], axis=0), axis=1) * 15.0
    assert np.abs(travelled - 0.5 * (motion.speed_mps[1:, 0] + motion.speed_mps[:-1, 0])).max() < 1e-6


def test_bends_limit_the_speed_as_the_lateral_acceleration_says():
    limit = speed_limit_mps(_circle(20.0), 15.0)
    assert limit[len(limit) // 2] == pytest.approx(np.sqrt(LATERAL_ACCELERATION_MPS2 * 20.0), rel=1e-3)


def test_follower_never_touches_the_leader_that_stops():
    road = _straight(400)
    leader = Driver(road, 40.0, 9.0, stops=((90.0, 5.0),))
    motion = simulate([leader, Driver(road, 20.0, 13.0)], 300, 15.0)
    gap = motion.arc_m[:, 0] - motion.arc_m[:, 1]
    assert motion.speed_mps[:, 0].min() < 0.3
    assert gap.min() > 4.8


def test_stop_is_made_before_the_line_and_left_again():
    motion = simulate([Driver(_straight(300), 0.0, 10.0, stops=((80.0, 2.0),))], 300, 15.0)
    standing = motion.speed_mps[:, 0] < 0.3
    assert 0.7 * 30 <= standing.sum() <= 90
    assert np.all(motion.arc_m[standing, 0] < 80.0)
    assert motion.arc_m[-1, 0] > 100.0


def test_one_car_at_a_time_on_a_crossing():
    east = _straight(200, (-60.0, 0.0), 0.0, (Passage(7, 55.0, 65.0, 0.0),))
    north = _straight(200, (0.0, -60.0), np.pi / 2, (Passage(7, 55.0, 65.0, 0.0),))
    motion = simulate([Driver(east, 10.0, 9.0), Driver(north, 10.0, 9.0)], 300, 15.0)
    inside = (motion.arc_m > 55.0) & (motion.arc_m < 65.0)
    assert inside.any(axis=0).all()
    assert not inside.all(axis=1).any()
    assert np.linalg.norm(motion.position_m[:, 0] - motion.position_m[:, 1], axis=1).min() > 4.8


def test_accelerations_stay_physical():
    motion = simulate([Driver(_circle(25.0), 0.0, 12.0, stops=((60.0, 1.0),))], 200, 15.0)
    acceleration = np.diff(motion.speed_mps[:, 0]) * 15.0
    assert acceleration.max() <= 1.8 + 1e-6
    assert acceleration.min() >= -5.0 - 1e-6


def test_as_many_cars_drive_as_the_town_has_room_for(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(plan, "_MOST_DRAWS", 30)
    monkeypatch.setattr(plan, "_SPAWN_GAP_M", 150.0)
    crowded = replace(PRESETS["quick"], traffic_cars=60)
    made = plan.make_plan(crowded, 3, closed_loop=False)
    assert 1 < len(made.looks) < 61
    assert len(made.looks) == len(made.sizes_m) == len(made.routes) == made.motion.position_m.shape[1]
    starts = made.motion.position_m[0]
    apart_m = np.linalg.norm(starts[:, None] - starts[None], axis=-1) + 1e9 * np.eye(len(starts))
    assert apart_m.min() > 140.0


LANE_M, REACH_M, HALF_M = 1.75, 90.0, 8.0
HALF_LENGTH_M, NEAREST_M = 1.5, 1.9
"""Of points on a car's axis from its middle; cars whose axes are nearer touch: they are about 1.9 m wide."""


def way(side: int, turn: int) -> Route:
    """Over the crossing of two streets at (0, 0), from one of four sides; ``turn`` -1 = right, 0 = straight, 1 = left.

    Right-hand traffic: the car comes along y = -1.75 m, turned by ``side`` quarters.
    """
    corner = np.array([[-REACH_M, -LANE_M], [-HALF_M, -LANE_M]])
    angle = np.linspace(0.0, 0.5 * np.pi, 30)
    radius = HALF_M + turn * LANE_M
    bend = np.column_stack([-HALF_M + radius * np.sin(angle), turn * radius * (1 - np.cos(angle)) - LANE_M])
    far = [[turn * LANE_M, turn * REACH_M]] if turn else [[REACH_M, -LANE_M]]
    points = np.vstack([corner, bend[1:] if turn else np.array([[HALF_M, -LANE_M]]), far])
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    places = np.arange(0.0, arc[-1], POINT_SPACING_M)
    points = np.column_stack([np.interp(places, arc, points[:, k]) for k in (0, 1)])
    c, s = np.cos(0.5 * np.pi * side), np.sin(0.5 * np.pi * side)
    points = points @ np.array([[c, s], [-s, c]])
    ahead = np.gradient(points, axis=0)
    leave_m = arc[-2]
    return Route(points, np.arctan2(ahead[:, 1], ahead[:, 0]), (Passage(0, REACH_M - HALF_M, leave_m, 0.0),))


def nearest_m(motion) -> float:
    """Smallest distance between two cars' axes, at three points of each."""
    along = np.stack([np.cos(motion.heading_rad), np.sin(motion.heading_rad)], axis=-1)
    points = np.stack([motion.position_m + at * along for at in (-HALF_LENGTH_M, 0.0, HALF_LENGTH_M)], axis=2)
    count, nearest = points.shape[1], np.inf
    for i in range(count):
        for j in range(i):
            between = points[:, i, :, None] - points[:, j, None]
            nearest = min(nearest, np.linalg.norm(between, axis=-1).min())
    return nearest


@settings(max_examples=15, deadline=None)
@given(st.lists(st.tuples(st.integers(-1, 1), st.floats(30.0, 70.0), st.floats(7.0, 12.0)), min_size=4, max_size=4))
def test_none_drives_into_another_and_all_get_over_it(cars: list[tuple[int, float, float]]) -> None:
    drivers = [Driver(way(side, turn), start, speed) for side, (turn, start, speed) in enumerate(cars)]
    motion = simulate(drivers, 450, 15.0)
    assert nearest_m(motion) > NEAREST_M
    assert all(arc > driver.route.passages[0].leave_m for arc, driver in zip(motion.arc_m[-1], drivers, strict=True))


def test_cars_that_enter_when_they_come_drive_into_another(monkeypatch: pytest.MonkeyPatch) -> None:
    """So the test above can fail."""
    monkeypatch.setattr(Crossings, "may_enter", lambda self, approach: True)
    starts = np.random.default_rng(0).uniform(0.0, 70.0, (12, 4))
    worst = min(
        nearest_m(simulate([Driver(way(k, 1), start, 9.0) for k, start in enumerate(row)], 300, 15.0)) for row in starts
    )
    assert worst < NEAREST_M


def test_cars_that_do_not_meet_go_at_the_same_time() -> None:
    """From opposite sides, straight on; a third one from the right waits until both are over."""
    drivers = [Driver(way(side, 0), start, 9.0) for side, start in ((0, 40.0), (2, 40.0), (1, 38.0))]
    inside = simulate(drivers, 300, 15.0).arc_m
    on = np.array([(inside[:, k] > REACH_M - HALF_M) & (inside[:, k] < REACH_M + HALF_M) for k in range(3)])
    assert on.any(axis=1).all()
    assert (on[0] & on[1]).any()
    assert not (on[2] & (on[0] | on[1])).any()


def test_the_first_to_come_is_the_first_to_enter() -> None:
    ways = {car: way(side, 0).at(np.arange(80.0, 105.0))[0] for car, side in ((3, 0), (5, 1), (7, 2))}
    ask = {car: Approach(car, 0, 5.0, True, way_m) for car, way_m in ways.items()}
    crossings = Crossings([])
    assert [crossings.may_enter(ask[car]) for car in (5, 3, 7, 5)] == [True, False, False, True]
    crossings.leave(5, 0)
    # 7 comes the other way along the same street as 3.
    assert crossings.may_enter(ask[3])
    assert crossings.may_enter(ask[7])


@pytest.mark.parametrize("seed", [404, 408])
def test_no_car_of_a_town_drives_into_another(seed: int) -> None:
    """Two episodes in which two pairs collided, and four, when any car that waited could be next."""
    scenario = catalog.scenario("road-town")
    plan = make_plan(scenario.presets["hard"], episode_seed(seed, scenario.id, 0), closed_loop=False)
    assert nearest_m(plan.motion) > NEAREST_M
