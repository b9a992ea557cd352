"""Paths of cars over crossings, seen in full or in part."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.trackers.mosaic_graph.test_roads import HABITS, cars, crossing, nothing_unseen, roads_of
from trackers.mosaic_graph.kernels import road_course as rc
from trackers.mosaic_graph.kernels import road_motion as rm
from trackers.mosaic_graph.kernels import road_position as rp
from trackers.mosaic_graph.kernels.crossing import CUT_M, curve_over, fit_of_curve, on_curve
from trackers.mosaic_graph.kernels.road_position import RoadGraph
from trackers.mosaic_graph.road_graph import build_graph

_LANE_M = 1.75


def ways_from_west(graph: RoadGraph) -> tuple[int, float, dict[str, int]]:
    """Return edge and direction of the street from the west, and the ways by the direction they lead to."""
    edge = int(np.argmin([graph.points_m[a:b, 0].min() for a, b in zip(graph.first, graph.first[1:], strict=False)]))
    direction = 1.0 if graph.points_m[graph.first[edge + 1] - 1, 0] > graph.points_m[graph.first[edge], 0] else -1.0
    node = graph.ends[edge, 1 if direction > 0 else 0]
    names = {0: "straight", 1: "left", -1: "right", 2: "back", -2: "back"}
    ways = range(graph.node_first[node], graph.node_first[node + 1])
    return edge, direction, {names[round(rc.heading_behind(graph, way) / (np.pi / 2))]: way for way in ways}


@pytest.mark.parametrize(("name", "radius_m"), [("left", CUT_M + _LANE_M), ("right", CUT_M - _LANE_M)])
def test_a_turn_is_nearly_an_arc_from_lane_to_lane(name: str, radius_m: float) -> None:
    graph = crossing()
    edge, direction, ways = ways_from_west(graph)
    control, length, radius, turn = curve_over(graph, edge, direction, ways[name], _LANE_M)
    side = 1 if name == "left" else -1
    # Points of a street are up to 2 % less than 1 m apart.
    np.testing.assert_allclose(control[0], [-CUT_M, -_LANE_M], atol=0.2)
    np.testing.assert_allclose(control[3], [side * _LANE_M, side * CUT_M], atol=0.2)
    assert turn == pytest.approx(side * np.pi / 2, abs=0.01)
    assert radius == pytest.approx(radius_m, rel=0.03)
    points = np.array([on_curve(control, t)[:2] for t in np.linspace(0, 1, 200)])
    assert np.linalg.norm(np.diff(points, axis=0), axis=1).sum() == pytest.approx(length, rel=0.01)
    centre = np.array([control[0, 0], control[3, 1]])
    np.testing.assert_allclose(np.linalg.norm(points - centre, axis=1), radius, rtol=0.01)


@settings(max_examples=25, deadline=None)
@given(st.sampled_from(["left", "straight", "right"]), st.floats(0.2, 0.8))
def test_a_car_on_a_way_fits_it_best(name: str, share: float) -> None:
    graph = crossing()
    edge, direction, ways = ways_from_west(graph)
    curves = {n: curve_over(graph, edge, direction, way, _LANE_M)[0] for n, way in ways.items() if n != "back"}
    x, y, heading = on_curve(curves[name], share)
    fits = {n: fit_of_curve(control, x, y, heading) for n, control in curves.items()}
    assert max(fits, key=lambda n: fits[n][0]) == name
    assert fits[name][1] == pytest.approx(share, abs=0.07)


@pytest.mark.parametrize("name", ["left", "right"])
def test_a_car_seen_in_a_turn_finishes_it(name: str) -> None:
    """A third of the turn determines the way, even though the car is associated with its first street again."""
    rng = np.random.default_rng(0)
    graph = crossing()
    roads = roads_of(graph)
    edge, direction, ways = ways_from_west(graph)
    control = curve_over(graph, edge, direction, ways[name], _LANE_M)[0]
    x, y, heading = on_curve(control, 0.4)
    states = cars(400, x, y, heading, 4.0)
    states[:, rp.ON_ROAD] = 1
    rp.associate(states, roads, rng.random(400))
    took = []
    for state, uniform in zip(states, rng.random(400), strict=True):
        if state[rp.EDGE] == edge:
            rc.choose_way(state, graph, 0.7, _LANE_M, uniform)
            took.append(state[rp.CHOICE] == ways[name])
    assert len(took) > 100
    assert np.mean(took) > 0.95


def test_desired_headings_outlast_redrawn_roads() -> None:
    rng = np.random.default_rng(1)
    graph = crossing()
    roads = roads_of(graph)
    _, _, ways = ways_from_west(graph)
    states = cars(300, -20.0, -_LANE_M, 0.0, 8.0)
    states[:, rp.ON_ROAD] = 1
    rp.associate(states, roads, rng.random(300))
    for state in states:
        rc.choose_way(state, graph, 0.7, _LANE_M, rng.random())
    chosen = states[:, rp.CHOICE].copy()
    assert set(chosen) >= {ways["left"], ways["straight"], ways["right"]}
    rp.associate(states, roads, rng.random(300))
    assert (states[:, rp.CHOICE] == -1).all()
    for state in states:
        rc.choose_way(state, graph, 0.7, _LANE_M, rng.random())
    assert (states[:, rp.CHOICE] == chosen).mean() > 0.98


def t_junction(sag_m: float) -> list[np.ndarray]:
    """Return a street along x and one from the south, whose junction lies ``sag_m`` too far to the south, as a
    skeleton has it.
    """
    x = np.linspace(0.0, 60.0, 121)
    sag = -sag_m * np.exp(-((x / 3.0) ** 2))
    middle = np.array([0.0, -sag_m])
    return [
        np.column_stack([x, sag]),
        np.column_stack([-x, sag]),
        np.column_stack([np.zeros(121), np.linspace(middle[1], -60.0, 121)]),
    ]


def test_a_crossing_is_moved_to_the_intersection_of_its_streets() -> None:
    graph = build_graph(t_junction(3.0), nothing_unseen)
    degrees = np.bincount(graph.ends.ravel())
    assert sorted(degrees) == [1, 1, 1, 3]
    edge = int(np.flatnonzero(graph.ends[:, 0] == degrees.argmax())[0])
    node_m = graph.points_m[graph.first[edge]]
    assert np.linalg.norm(node_m) < 0.5 * 3.0
    spacing = np.linalg.norm(np.diff(graph.points_m[graph.first[edge] : graph.first[edge + 1]], axis=0), axis=1)
    assert spacing.max() < 1.05


def test_a_street_is_extended_over_a_crossing_only_into_unseen_ground() -> None:
    lines = t_junction(0.0)
    assert len(build_graph(lines, nothing_unseen).first) - 1 == 3
    graph = build_graph(lines, lambda points_m: points_m[:, 1] > 5.0)
    assert graph.edge_count == 4
    assert graph.points_m[:, 1].max() == pytest.approx(25.0, abs=0.5)
    assert np.abs(graph.points_m[graph.points_m[:, 1] > 2.0, 0]).max() < 0.3
    glimpsed = build_graph(lines, lambda points_m: (points_m[:, 1] > 5.0) & (points_m[:, 1] < 17.5))
    assert glimpsed.points_m[:, 1].max() == pytest.approx(17.0, abs=0.6)


def test_a_dead_end_runs_straight_and_not_into_a_corner_of_the_seen_ground() -> None:
    straight = np.column_stack([np.linspace(0.0, 50.0, 101), np.zeros(101)])
    corner = np.column_stack([np.linspace(50.0, 54.0, 9), np.linspace(0.0, 4.0, 9)])
    graph = build_graph([np.vstack([straight, corner[1:]])], nothing_unseen)
    assert np.abs(graph.points_m[:, 1]).max() < 0.5 * 4.0
    bend_rad = np.abs(np.diff(np.arctan2(graph.tangents[:, 1], graph.tangents[:, 0])))[-5:]
    assert bend_rad.max() < 0.02
    assert graph.points_m[:, 0].max() > 50.0


def test_no_car_decides_to_halt_in_the_middle_of_a_crossing() -> None:
    rng = np.random.default_rng(2)
    halts = []
    for x_m in (-5.0, -20.0):
        states = cars(100, x_m, -_LANE_M, 0.0, 8.0)
        states[:, rp.ON_ROAD] = 1
        roads = roads_of(crossing())
        rp.associate(states, roads, rng.random(100))
        rm.drive(
            states, roads, HABITS._replace(halt_share=1.0), 1 / 15, np.zeros((100, rm.NORMALS)), rng.random((100, 7))
        )
        halts.append(states[states[:, rp.ON_ROAD] == 1, rp.HALTS].mean())
    assert halts == [0.0, 1.0]


def speed_after_a_step(graph: RoadGraph, x_m: float, y_m: float, speed_mps: float, bound_rad: float) -> float:
    """Return the speed (m/s) a picture later of a car that comes from the west and is bound for a heading."""
    rng = np.random.default_rng(3)
    roads = roads_of(graph)
    state = cars(1, x_m, y_m, 0.0, speed_mps)
    state[:, rp.ON_ROAD] = 1
    rp.associate(state, roads, rng.random(1))
    assert state[0, rp.ON_ROAD] == 1
    state[:, [rp.BOUND, rp.CRUISE]] = [bound_rad, 14.0]
    habits = HABITS._replace(cruise_rate=0.0)
    rm.drive(state, roads, habits, 1 / 15, np.zeros((1, rm.NORMALS)), np.full((1, 7), 0.5))
    return float(state[0, rp.SPEED])


def test_the_speed_in_a_turn_does_not_depend_on_the_place_in_the_lane() -> None:
    """A car far to the right of its lane has not a sharper turn before it."""
    in_lane, aside, straight = (
        speed_after_a_step(crossing(), -14.0, y_m, 6.0, bound_rad)
        for y_m, bound_rad in ((-_LANE_M, -np.pi / 2), (-6.0, -np.pi / 2), (-_LANE_M, 0.0))
    )
    assert aside == pytest.approx(in_lane, abs=0.01)
    assert in_lane < straight - 0.03


def test_a_bend_behind_a_crossing_is_foreseen() -> None:
    """The street to the east bends sharply to the north 18 m behind the crossing."""
    ends = 60.0 * np.array([[-1, 0], [0, 1], [0, -1]])
    lines = [np.linspace(np.zeros(2), end, 121) for end in ends]
    bent = np.vstack([np.linspace([0.0, 0.0], [18.0, 0.0], 37), np.linspace([18.0, 0.5], [18.0, 60.0], 120)])
    bend_ahead = speed_after_a_step(build_graph([*lines, bent], nothing_unseen), -4.0, -_LANE_M, 12.0, 0.0)
    straight = speed_after_a_step(crossing(), -4.0, -_LANE_M, 12.0, 0.0)
    assert bend_ahead < straight - 0.03
