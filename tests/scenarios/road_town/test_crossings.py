"""Cars at a crossing: none drives into another, those that do not meet go at the same time, all get over it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scenarios import catalog
from scenarios.road_town.plan import make_plan
from scenarios.road_town.route import POINT_SPACING_M, Passage, Route
from scenarios.road_town.traffic import Approach, Crossings, Driver, simulate
from sim.rng import episode_seed

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
