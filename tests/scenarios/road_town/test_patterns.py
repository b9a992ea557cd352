"""Every street pattern gives a drivable network for any seed: connected, smooth, without stubs."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from scenarios.road_town.layout import RoadGraph, Street
from scenarios.road_town.patterns import STREET_PATTERNS, make_streets, street_pattern
from scenarios.road_town.street_curves import (
    MIN_GAP_M,
    MIN_RADIUS_M,
    Road,
    curvature_per_m,
    fault_of,
    graph_of_roads,
)
from sim.rng import generator

ANY_PATTERN = st.sampled_from(sorted(STREET_PATTERNS))
ANY_SEED = st.integers(0, 2**63 - 1)


def _circumradius_m(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Return the radii of circles through three points each: product of sides over four times the area."""
    sides = [np.linalg.norm(p - q, axis=1) for p, q in ((a, b), (b, c), (c, a))]
    area = 0.5 * np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    return sides[0] * sides[1] * sides[2] / np.maximum(4 * area, 1e-12)


@settings(max_examples=40, deadline=None)
@given(pattern=ANY_PATTERN, seed=ANY_SEED)
def test_network_is_connected_without_dead_ends_and_stays_in_town(pattern, seed):
    graph = make_streets(pattern, generator(seed, "streets"), 420.0)
    nodes = len(graph.nodes_m)
    starts, ends = np.array([(street.start, street.end) for street in graph.streets]).T
    links = coo_array((np.ones(len(starts)), (starts, ends)), shape=(nodes, nodes))
    assert connected_components(links, directed=False)[0] == 1
    assert min(Counter([*starts, *ends]).values()) >= 3
    for street in graph.streets:
        np.testing.assert_allclose(street.centre_m[0], graph.nodes_m[street.start], atol=1e-6)
        np.testing.assert_allclose(street.centre_m[-1], graph.nodes_m[street.end], atol=1e-6)
        assert np.abs(street.centre_m).max() < 210.0 - 20.0
        assert 7.0 <= street.width_m <= 9.0


@settings(max_examples=40, deadline=None)
@given(pattern=ANY_PATTERN, seed=ANY_SEED)
def test_streets_are_finely_sampled_and_bend_gently(pattern, seed):
    for street in make_streets(pattern, generator(seed, "streets"), 420.0).streets:
        steps_m = np.linalg.norm(np.diff(street.centre_m, axis=0), axis=1)
        assert steps_m.max() <= 1.0
        # Chords of equal arcs are equal, except for the shortening by bends.
        assert np.ptp(steps_m) < 0.01
        radius_m = _circumradius_m(street.centre_m[:-4], street.centre_m[2:-2], street.centre_m[4:])
        assert radius_m.min() >= 0.98 * MIN_RADIUS_M


@settings(max_examples=12, deadline=None)
@given(pattern=ANY_PATTERN, seed=ANY_SEED)
def test_streets_meet_at_nodes_only(pattern, seed):
    graph = make_streets(pattern, generator(seed, "streets"), 420.0)
    lines = [shapely.LineString(street.centre_m) for street in graph.streets]
    for i, first in enumerate(graph.streets):
        for j, second in enumerate(graph.streets[:i]):
            shared = {first.start, first.end} & {second.start, second.end}
            if not shared:
                assert lines[i].distance(lines[j]) > MIN_GAP_M - 1.0
            else:
                meeting = lines[i].intersection(lines[j])
                nodes = shapely.MultiPoint(graph.nodes_m[sorted(shared)])
                assert shapely.get_coordinates(meeting).shape[0] == len(shared)
                assert meeting.hausdorff_distance(nodes) < 1e-6


@settings(max_examples=15, deadline=None)
@given(seed=ANY_SEED, extent_m=st.floats(300.0, 600.0))
def test_extent_scales_the_town(seed, extent_m):
    graph = make_streets("organic", generator(seed, "streets"), extent_m)
    reach_m = max(np.abs(street.centre_m).max() for street in graph.streets)
    assert 0.3 * extent_m < reach_m < 0.5 * extent_m


@settings(max_examples=10, deadline=None)
@given(seed=ANY_SEED)
def test_winding_road_has_the_bends_of_the_papers_experiment(seed):
    """The main road (the widest) has bends of 25 to 60 m radius to both sides."""
    graph = make_streets("winding", generator(seed, "streets"))
    widest = max(street.width_m for street in graph.streets)
    bends = np.concatenate([curvature_per_m(s.centre_m) for s in graph.streets if s.width_m == widest])
    assert 1 / 60.0 < np.abs(bends).max() < 1 / 23.5
    assert (bends > 1 / 60.0).any()
    assert (bends < -1 / 100.0).any()


@pytest.mark.parametrize("pattern", sorted(STREET_PATTERNS))
def test_same_generator_same_streets(pattern):
    first, second, other = (make_streets(pattern, generator(seed, "streets")) for seed in (0, 0, 1))
    assert all(np.array_equal(a.centre_m, b.centre_m) for a, b in zip(first.streets, second.streets, strict=True))
    assert not np.array_equal(first.nodes_m, other.nodes_m)


def test_patterns_differ_in_their_crossings():
    """Every pattern but the winding road has T and X crossings."""
    for pattern in ("grid", "organic", "ring"):
        degrees = set()
        for seed in range(6):
            graph = make_streets(pattern, generator(seed, "streets"))
            degrees |= set(Counter(node for s in graph.streets for node in (s.start, s.end)).values())
        assert {3, 4} <= degrees


def test_roads_go_on_through_crossings_without_a_kink():
    points = np.array([[-80.0, 0], [0, 6], [80, 0], [0, -70], [0, 80]])
    graph = graph_of_roads(points, [Road((0, 1, 2), 8.0), Road((3, 1, 4), 7.0)])
    assert len(graph.streets) == 4
    before, after = graph.streets[:2]
    arriving, leaving = before.centre_m[-1] - before.centre_m[-2], after.centre_m[1] - after.centre_m[0]
    turn = np.arctan2(*arriving[::-1]) - np.arctan2(*leaving[::-1])
    assert abs(turn) < np.deg2rad(1.5)


@settings(max_examples=30, deadline=None)
@given(radius_m=st.floats(8.0, 500.0), turn=st.sampled_from([-1.0, 1.0]))
def test_curvature_of_a_circle(radius_m, turn):
    angle = np.arange(0, min(40.0 / radius_m, 3.0), 0.9 / radius_m)
    arc = radius_m * np.column_stack([np.cos(turn * angle), np.sin(turn * angle)])
    np.testing.assert_allclose(curvature_per_m(arc), turn / radius_m, rtol=0.02)


def test_faults_are_found():
    def street(points: list[tuple[float, float]], start: int, end: int) -> Street:
        ends = np.array(points, dtype=float)
        line = shapely.LineString(ends).segmentize(0.9)
        return Street(start, end, shapely.get_coordinates(line), 8.0)

    apart = street([(0, 0), (100, 0)], 0, 1), street([(0, 60), (100, 60)], 2, 3)
    nodes = np.zeros((4, 2))
    assert fault_of(RoadGraph(nodes, apart), 150.0) is None
    assert "leaves the town" in fault_of(RoadGraph(nodes, apart), 90.0)
    close = apart[0], street([(0, 10), (100, 10)], 2, 3)
    assert "too close" in fault_of(RoadGraph(nodes, close), 150.0)
    sharp = apart[0], street([(0, 0), (100, 40)], 0, 3)
    assert "too sharply" in fault_of(RoadGraph(nodes, sharp), 150.0)
    again = apart[0], street([(0, 0), (30, 40), (70, 40), (80, 8)], 0, 3)
    assert fault_of(RoadGraph(nodes, again), 150.0) is not None
    assert "too short" in fault_of(RoadGraph(nodes, (street([(0, 0), (10, 0)], 0, 1),)), 150.0)


def test_bad_arguments_are_named():
    rng = generator(0, "streets")
    with pytest.raises(ValueError, match=r"pattern: expected one of .*'grid'.*got 'gird'"):
        make_streets("gird", rng)
    with pytest.raises(ValueError, match="extent_m: expected at least 300, got 200"):
        make_streets("grid", rng, 200.0)
    with pytest.raises(ValueError, match="extent_m: expected at least 300, got nan"):
        make_streets("grid", rng, float("nan"))
    with pytest.raises(ValueError, match="name: expected a new street pattern, got 'grid'"):
        street_pattern("grid")(STREET_PATTERNS["grid"])


def test_a_new_pattern_is_one_decorated_function():
    @street_pattern("triangle")
    def triangle(rng: np.random.Generator, extent_m: float) -> RoadGraph:
        angles = np.arange(12) * np.pi / 6
        points = 0.3 * extent_m * np.column_stack([np.cos(angles), np.sin(angles)])
        return graph_of_roads(points, [Road(tuple(range(12)), 8.0, closed=True), Road((0, 6), 7.0)])

    try:
        graph = make_streets("triangle", generator(0, "streets"))
        assert fault_of(graph, 200.0) is None
    finally:
        del STREET_PATTERNS["triangle"]
