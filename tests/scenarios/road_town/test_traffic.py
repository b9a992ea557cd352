"""Cars keep within physical limits, keep their distance, stop where they should and wait for each other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scenarios.road_town import plan
from scenarios.road_town.presets import PRESETS
from scenarios.road_town.route import POINT_SPACING_M, Passage, Route
from scenarios.road_town.traffic import LATERAL_ACCELERATION_MPS2, Driver, simulate, speed_limit_mps


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
