"""Routes are smooth, keep to the right, and record their crossings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scenarios.road_town.layout import RoadGraph
from scenarios.road_town.patterns import make_streets
from scenarios.road_town.road_map import RoadMap
from scenarios.road_town.route import POINT_SPACING_M, Route, Routes, random_route
from sim.rng import generator


def _route(seed: int, pattern: str = "organic"):
    graph = make_streets(pattern, generator(seed, "streets"))
    return graph, random_route(graph, generator(seed, "route"), 300.0, keep_within_m=140.0, turn_preference=1.0)


@pytest.mark.parametrize("pattern", ["grid", "organic", "ring", "winding"])
def test_route_is_long_enough_evenly_spaced_and_drivable(pattern):
    for seed in range(3):
        _, route = _route(seed, pattern)
        assert route.length_m >= 300.0
        step = np.linalg.norm(np.diff(route.points_m, axis=0), axis=1)
        # A chord is never longer than its arc, and hardly shorter on a drivable curve.
        assert step.max() <= POINT_SPACING_M + 1e-9
        assert step.min() > 0.98 * POINT_SPACING_M
        assert np.abs(route.curvature_per_m()).max() < 1 / 2.5


def test_lanes_are_on_the_right_of_the_centre_line():
    graph, route = _route(1)
    arc = np.arange(0, route.length_m, 5.0)
    away = np.array([all(abs(a - p.enter_m) > 15 and abs(a - p.leave_m) > 15 for p in route.passages) for a in arc])
    away &= np.array([not any(p.enter_m < a < p.leave_m for p in route.passages) for a in arc])
    position, heading = route.at(arc[away])
    right = np.column_stack([np.sin(heading), -np.cos(heading)])
    roads = RoadMap(graph)
    # Two metres further right is nearer to the kerb, two metres to the left is the centre line.
    centre_distance = np.abs(roads.nearest(position - 2.0 * right).lateral_m)
    assert np.median(centre_distance) < 0.6
    assert np.abs(roads.nearest(position + 2.0 * right).lateral_m).min() > 3.0


def test_passages_turn_by_what_their_headings_say():
    _, route = _route(2)
    for passage in route.passages:
        before, after = route.at(np.array([passage.enter_m, passage.leave_m]))[1]
        assert passage.turn_rad == pytest.approx(after - before, abs=0.15)
        assert passage.is_turn == (abs(passage.turn_rad) > 0.6)


@settings(max_examples=20, deadline=None)
@given(st.floats(-50, 700))
def test_places_off_the_ends_are_clamped(arc_m):
    _, route = _route(3)
    position, heading = route.at(np.array(arc_m))
    assert np.isfinite(position).all()
    assert np.isfinite(heading)
    assert np.linalg.norm(route.points_m - position, axis=1).min() <= 0.5 * POINT_SPACING_M + 1e-6


def test_many_routes_answer_as_each_one_does() -> None:
    rng = np.random.default_rng(2)
    graph = make_streets("grid", rng, 420.0)
    routes = [random_route(graph, rng, 200.0, keep_within_m=150.0, turn_preference=1.0) for _ in range(3)]
    arcs_m = rng.uniform(-20.0, 400.0, (3, 50))
    together = Routes(routes).at(arcs_m)
    for route, arc_m, places_m in zip(routes, arcs_m, together, strict=True):
        np.testing.assert_array_equal(places_m, route.at(arc_m)[0])


def test_routes_that_share_a_lane_are_as_if_each_had_drawn_it() -> None:
    graph = make_streets("grid", np.random.default_rng(2), 420.0)

    def route(on: RoadGraph) -> Route:
        return random_route(on, np.random.default_rng(5), 200.0, keep_within_m=150.0, turn_preference=1.0)

    first, again, mirrored = route(graph), route(graph), route(replace(graph, traffic_side="left"))
    np.testing.assert_array_equal(again.points_m, first.points_m)
    assert not np.allclose(mirrored.points_m[:100], first.points_m[:100]), "lanes are of one side of the traffic"
