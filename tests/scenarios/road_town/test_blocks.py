"""No object overlaps a road or another object, in any pattern."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
import shapely

from scenarios.road_town.blocks import fill_blocks
from scenarios.road_town.patterns import STREET_PATTERNS, make_streets
from scenarios.road_town.road_map import RoadMap, road_area
from scenarios.road_town.route import random_route, with_excursion
from sim.rng import generator

EXTENT_M = 420.0


def _layout(pattern: str, seed: int):
    return fill_blocks(make_streets(pattern, generator(seed, "streets")), generator(seed, "blocks"), EXTENT_M)


def _footprint(centre_m, size_m, yaw_rad) -> shapely.Polygon:
    c, s = np.cos(yaw_rad), np.sin(yaw_rad)
    half = 0.5 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * size_m
    return shapely.Polygon(np.array(centre_m) + half @ np.array([[c, s], [-s, c]]))


@pytest.mark.heavy
@pytest.mark.parametrize("pattern", sorted(STREET_PATTERNS))
@pytest.mark.parametrize("seed", [0, 1])
def test_nothing_overlaps(pattern, seed):
    layout = _layout(pattern, seed)
    roads = road_area(layout.graph)
    standing = [_footprint(b.centre_m, b.size_m[:2], b.yaw_rad) for b in layout.buildings]
    standing += [_footprint(p.centre_m, p.size_m, p.yaw_rad) for p in layout.car_parks]
    standing += [shapely.Point(t.centre_m).buffer(0.3) for t in layout.trees]
    assert not any(thing.intersects(roads) for thing in standing)
    tree = shapely.STRtree(standing)
    pairs = tree.query(standing, predicate="intersects").T
    assert all(a == b for a, b in pairs)
    square = shapely.box(-0.5 * EXTENT_M, -0.5 * EXTENT_M, 0.5 * EXTENT_M, 0.5 * EXTENT_M)
    assert all(square.contains(thing) for thing in standing)


@pytest.mark.parametrize("pattern", sorted(STREET_PATTERNS))
def test_a_town_is_full_of_things(pattern):
    layout = _layout(pattern, 3)
    assert len(layout.buildings) >= 80
    assert len(layout.trees) >= 90
    assert len(layout.car_parks) >= 2
    for park in layout.car_parks:
        ground = _footprint(park.centre_m, park.size_m, park.yaw_rad)
        assert all(ground.contains(shapely.Point(bay[:2])) for bay in park.bays)
        gaps = [np.hypot(a[0] - b[0], a[1] - b[1]) for a, b in itertools.combinations(park.bays, 2)]
        assert min(gaps) >= 2.4


def test_same_generator_same_town():
    first, second = _layout("organic", 5), _layout("organic", 5)
    assert (first.buildings, first.trees, first.car_parks) == (second.buildings, second.trees, second.car_parks)
    assert first.buildings != _layout("organic", 6).buildings


@pytest.mark.heavy
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("clears", [True, False])
def test_excursion_leaves_the_road_clear_of_everything_and_comes_back(seed, clears):
    layout = _layout("grid", seed)
    rng = generator(seed, "route")
    route = random_route(layout.graph, rng, 300.0, keep_within_m=140.0, turn_preference=1.0)
    bent, cleared, excursion = with_excursion(
        route, layout, rng, between_m=(40.0, 280.0), aside_m=(7.0, 16.0), along_m=(34.0, 70.0), clears=clears
    )
    if excursion is None:
        assert bent is route
        assert cleared is layout
        return
    if not clears:
        assert (cleared.buildings, cleared.trees) == (layout.buildings, layout.trees)
    # At most one house is removed, and nothing is added.
    assert len(layout.buildings) - 1 <= len(cleared.buildings)
    assert set(cleared.buildings) <= set(layout.buildings)
    assert set(cleared.trees) <= set(layout.trees)
    roads = RoadMap(layout.graph)
    arc = np.arange(excursion.leave_m, excursion.return_m, 0.5)
    places, _ = bent.at(arc)
    assert (~roads.is_on_road(places)).mean() > 0.3
    ends, _ = bent.at(np.array([excursion.leave_m - 1.0, excursion.return_m + 1.0]))
    assert roads.is_on_road(ends).all()
    walls = shapely.union_all([_footprint(b.centre_m, b.size_m[:2], b.yaw_rad) for b in cleared.buildings])
    trunks = shapely.union_all([shapely.Point(t.centre_m) for t in cleared.trees])
    assert shapely.distance(walls, shapely.points(places)).min() > 1.7
    assert shapely.distance(trunks, shapely.points(places)).min() > 1.7
