"""Queries of the map, compared with brute force over dense points and with shapely."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from scenarios.road_town.layout import RoadGraph, Street
from scenarios.road_town.patterns import STREET_PATTERNS, make_streets
from scenarios.road_town.road_map import FILLET_RADIUS_M, RoadMap, road_area
from sim.rng import generator


@pytest.fixture(scope="module", params=sorted(STREET_PATTERNS))
def roads(request) -> RoadMap:
    return RoadMap(make_streets(request.param, generator(4, "streets")))


def _on_the_network(roads: RoadMap, seed: int, count: int) -> tuple[np.ndarray, np.ndarray]:
    rng = generator(seed, "places")
    street = rng.integers(len(roads.length_m), size=count)
    return street, rng.uniform(0, 1, count) * roads.length_m[street]


def test_lengths_are_shapelys(roads):
    lengths = [shapely.LineString(street.centre_m).length for street in roads.graph.streets]
    np.testing.assert_allclose(roads.length_m, lengths)


@pytest.mark.heavy
def test_nearest_place_is_shapelys(roads):
    points = generator(1, "points").uniform(-205, 205, (1500, 2))
    place = roads.nearest(points)
    lines = [shapely.LineString(street.centre_m) for street in roads.graph.streets]
    distances = np.array([shapely.distance(line, shapely.points(points)) for line in lines])
    np.testing.assert_allclose(np.abs(place.lateral_m), distances.min(axis=0), atol=0.02)
    arcs = np.array([shapely.line_locate_point(line, shapely.points(points)) for line in lines])
    clearly = np.partition(distances, 1, axis=0)[1] - distances.min(axis=0) > 0.05
    chosen = place.street[clearly]
    np.testing.assert_array_equal(chosen, distances.argmin(axis=0)[clearly])
    # Along a bend, from far away, the nearest point of a polyline jumps by its corners' fans: compare where it is near.
    near = clearly & (distances.min(axis=0) < 15.0)
    np.testing.assert_allclose(place.arc_m[near], arcs[place.street[near], np.nonzero(near)[0]], atol=0.02)


def test_place_and_pose_are_inverse(roads):
    street, arc_m = _on_the_network(roads, 2, 800)
    lateral_m = generator(2, "lateral").uniform(-3.5, 3.5, 800)
    inner = (arc_m > 8.0) & (arc_m < roads.length_m[street] - 8.0)
    street, arc_m, lateral_m = street[inner], arc_m[inner], lateral_m[inner]
    position_m, _ = roads.pose_at(street, arc_m, lateral_m)
    place = roads.nearest(position_m)
    np.testing.assert_array_equal(place.street, street)
    np.testing.assert_allclose(place.lateral_m, lateral_m, atol=0.02)
    # Off the centre line, arc lengths are as accurate as the sampled heading.
    np.testing.assert_allclose(place.arc_m, arc_m, atol=0.06)


def test_heading_is_the_direction_of_travel(roads):
    street, arc_m = _on_the_network(roads, 3, 500)
    arc_m = np.clip(arc_m, 3.0, roads.length_m[street] - 3.0)
    ahead_m, _ = roads.pose_at(street, arc_m + 1.0)
    behind_m, _ = roads.pose_at(street, arc_m - 1.0)
    _, heading_rad = roads.pose_at(street, arc_m)
    way = ahead_m - behind_m
    turn = np.angle(np.exp(1j * (np.arctan2(way[:, 1], way[:, 0]) - heading_rad)))
    np.testing.assert_allclose(turn, 0.0, atol=0.01)


def test_ends_are_nodes_and_arcs_are_held_at_them(roads):
    for index, street in enumerate(roads.graph.streets):
        for arc_m, node in ((-5.0, street.start), (roads.length_m[index] + 5.0, street.end)):
            np.testing.assert_allclose(roads.pose_at(index, arc_m)[0], roads.graph.nodes_m[node], atol=1e-6)
        assert roads.node_reached(index, True) == street.end
        assert roads.node_reached(index, False) == street.start


def test_departures_are_all_the_streets_of_a_node(roads):
    for index in range(len(roads.graph.streets)):
        for forward in (True, False):
            node = roads.node_reached(index, forward)
            ways = roads.departures(index, forward)
            expected = sum((s.start == node) + (s.end == node) for s in roads.graph.streets)
            assert len(ways) == expected
            assert [way.back for way in ways] == [False] * (expected - 1) + [True]
            back = ways[-1]
            assert (back.street, back.forward) == (index, not forward)
            assert abs(abs(back.turn_rad) - np.pi) < 0.01
            turns = [way.turn_rad for way in ways[:-1]]
            assert turns == sorted(turns)
            for way in ways:
                start_m, _ = roads.pose_at(way.street, 0.0 if way.forward else roads.length_m[way.street])
                np.testing.assert_allclose(start_m, roads.graph.nodes_m[node], atol=1e-6)


def test_turns_at_a_plus_crossing():
    """East, north, west and south of a crossing: straight on is 0, left positive."""
    ends = np.array([[0, 0], [60, 0], [0, 60], [-60, 0], [0, -60.0]])
    streets = tuple(Street(0, k, np.linspace(ends[0], ends[k], 64), 8.0) for k in range(1, 5))
    roads = RoadMap(RoadGraph(ends, streets))
    from_south = roads.departures(3, forward=False)
    assert [(way.street, round(np.degrees(way.turn_rad))) for way in from_south[:3]] == [(0, -90), (1, 0), (2, 90)]
    assert all(way.forward for way in from_south)
    assert roads.nearest(np.array([30.0, 2.0])).lateral_m == pytest.approx(2.0)
    assert roads.nearest(np.array([30.0, -2.0])).lateral_m == pytest.approx(-2.0)
    # The corner of the crossing is rounded: the fillet's corner is on the road, its inside is not.
    corner, bulge = 4.0, FILLET_RADIUS_M * (1 - np.sqrt(0.5))
    inside = np.array([[corner + 0.9 * bulge, corner + 0.9 * bulge], [corner + 1.1 * bulge, corner + 1.1 * bulge]])
    assert roads.is_on_road(inside).tolist() == [True, False]


def test_on_road_is_within_half_a_width_but_for_the_fillets(roads):
    points = generator(5, "points").uniform(-200, 200, (4000, 2))
    on_road = roads.is_on_road(points)
    place = roads.nearest(points)
    within = np.abs(place.lateral_m) < roads.width_m[place.street] / 2 - 0.05
    assert on_road[within].all()
    beyond = on_road & (np.abs(place.lateral_m) > roads.width_m[place.street] / 2 + 0.05)
    to_node_m = np.linalg.norm(points[beyond, None] - roads.graph.nodes_m, axis=-1).min(axis=1)
    assert (to_node_m < 30.0).all()
    assert on_road.mean() == pytest.approx(road_area(roads.graph).area / 400.0**2, rel=0.1)


@settings(max_examples=20, deadline=None)
@given(shape=st.sampled_from([(), (1,), (7,), (2, 3), (0,)]))
def test_any_shape_of_points(shape):
    roads = RoadMap(make_streets("winding", generator(0, "streets")))
    points = generator(0, "points").uniform(-100, 100, (*shape, 2))
    place = roads.nearest(points)
    assert place.street.shape == place.arc_m.shape == place.lateral_m.shape == shape
    assert roads.is_on_road(points).shape == shape
    position_m, heading_rad = roads.pose_at(place.street, place.arc_m, place.lateral_m)
    assert position_m.shape == (*shape, 2)
    assert heading_rad.shape == shape
