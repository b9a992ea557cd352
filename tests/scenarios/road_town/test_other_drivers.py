"""Presets that violate a tracker's assumptions: left-hand traffic, another model of drivers, other speeds and towns."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scenarios.road_town import gipps
from scenarios.road_town.patterns import make_streets
from scenarios.road_town.plan import make_plan
from scenarios.road_town.presets import ABLATIONS, STANDARD, FrameOuts
from scenarios.road_town.road_map import RoadMap
from scenarios.road_town.route import random_route
from scenarios.road_town.traffic import Driver, simulate
from sim.rng import generator
from tests.scenarios.road_town.test_traffic import _circle, _straight


def test_each_differs_from_standard_in_one_attribute():
    for preset in ABLATIONS.values():
        names = {name for name in vars(preset) if getattr(preset, name) != getattr(STANDARD, name)}
        assert len(names - {"summary"}) == 1


def test_speeds_differ_by_30_percent_and_the_town_is_another():
    for name, factor in (("standard-slow", 0.7), ("standard-fast", 1.3)):
        np.testing.assert_allclose(ABLATIONS[name].cruise_mps, factor * np.array(STANDARD.cruise_mps))
    assert not set(ABLATIONS["standard-other-town"].street_patterns) & set(STANDARD.street_patterns)


@pytest.mark.parametrize("side", ["right", "left"])
def test_all_cars_keep_to_the_side_of_the_traffic(side):
    preset = replace(
        STANDARD,
        traffic_side=side,
        frame_count=120,
        frame_outs=FrameOuts(count=(1, 1), frames=(5, 20)),
        excursions=(0, 0),
    )
    plan = make_plan(preset, 7, closed_loop=False)
    roads = RoadMap(plan.layout.graph)
    place = roads.nearest(plan.motion.position_m)
    along = np.cos(roads.pose_at(place.street, place.arc_m)[1] - plan.motion.heading_rad)
    to_right_m = -place.lateral_m * np.sign(along)
    on_street = np.abs(along) > 0.98
    on_side = (1 if side == "right" else -1) * to_right_m[on_street] > 0
    assert on_street.mean() > 0.5
    assert on_side.mean() > 0.98


def test_left_hand_lanes_mirror_right_hand_ones():
    graph = make_streets("organic", generator(1, "streets"))
    right, left = (
        random_route(each, generator(1, "route"), 300.0, keep_within_m=140.0, turn_preference=1.0)
        for each in (graph, replace(graph, traffic_side="left"))
    )
    for route, sign in ((right, -1.0), (left, 1.0)):
        clear = [
            s for s in range(0, 250, 5) if all(abs(s - p.enter_m) > 15 < abs(s - p.leave_m) for p in route.passages)
        ]
        position, heading = route.at(np.array(clear, dtype=float))
        to_left = np.column_stack([-np.sin(heading), np.cos(heading)])
        beyond = np.abs(RoadMap(graph).nearest(position - sign * 1.85 * to_left).lateral_m)
        assert np.median(beyond) < 0.5


def _gipps(drivers: list[Driver], frames: int = 300):
    return simulate(drivers, frames, 15.0, "gipps")


def test_a_free_gipps_driver_reaches_its_speed_and_a_bend_limits_it():
    free = _gipps([Driver(_straight(500), 0.0, 10.0)])
    assert free.speed_mps[-1, 0] == pytest.approx(10.0, abs=0.1)
    bend = _gipps([Driver(_circle(20.0), 0.0, 15.0)], 100)
    allowed = np.sqrt(gipps.LATERAL_ACCELERATION_MPS2 * 20.0)
    assert bend.speed_mps[-1, 0] == pytest.approx(allowed, rel=0.05)


def test_gipps_drivers_keep_their_distance_and_stop_at_the_line():
    road = _straight(400)
    motion = _gipps([Driver(road, 40.0, 9.0, stops=((90.0, 5.0),)), Driver(road, 20.0, 13.0)])
    standing = motion.speed_mps[:, 0] < 0.3
    assert 0.7 * 75 <= standing.sum() <= 150
    assert (motion.arc_m[standing, 0] < 90.0).all()
    assert motion.arc_m[-1, 0] > 100.0
    assert (motion.arc_m[:, 0] - motion.arc_m[:, 1]).min() > 4.8


def test_gipps_drivers_slow_down_in_time_for_a_bend_and_drive_through_it_faster():
    straight, circle = _straight(100), _circle(12.0)
    points = np.concatenate([straight.points_m, circle.points_m[1:100] + straight.points_m[-1]])
    heading = np.concatenate([straight.heading_rad, circle.heading_rad[1:100]])
    route = replace(straight, points_m=points, heading_rad=heading)
    idm, other = (simulate([Driver(route, 0.0, 12.0)], 180, 15.0, model) for model in ("idm", "gipps"))
    entered, inside = (float(np.interp(arc_m, other.arc_m[:, 0], other.speed_mps[:, 0])) for arc_m in (101.0, 110.0))
    allowed = np.sqrt(gipps.LATERAL_ACCELERATION_MPS2 * 12.0)
    assert entered < 1.15 * allowed
    assert inside == pytest.approx(allowed, rel=0.06)
    assert inside > float(np.interp(110.0, idm.arc_m[:, 0], idm.speed_mps[:, 0])) + 0.5


def test_the_accelerations_of_gipps_drivers_stay_physical():
    motion = _gipps([Driver(_circle(25.0), 0.0, 12.0, stops=((60.0, 1.0),))], 200)
    acceleration = np.diff(motion.speed_mps[:, 0]) * 15.0
    assert 1.0 < acceleration.max() <= 1.1 * gipps.ACCELERATION_MPS2 + 1e-6
    assert -6.0 - 1e-6 <= acceleration.min() < -1.0
