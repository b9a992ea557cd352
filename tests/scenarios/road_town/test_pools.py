"""Pools lie in gardens, away from everything, and grow darker towards their middle."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from scenarios.road_town.blocks import PAVEMENT_WIDTH_M, fill_blocks
from scenarios.road_town.canvas import Canvas, rectangle
from scenarios.road_town.ground import DECK_M, MARGIN_M, paint_pool, place_pools
from scenarios.road_town.layout import Layout
from scenarios.road_town.patterns import make_streets
from scenarios.road_town.road_map import road_area
from sim.rng import generator

ROUNDING_M = 0.02
"""Circles of polygons with finitely many corners lie a little inside."""


@pytest.fixture(scope="module", params=[2, 5])
def layout(request) -> Layout:
    streets = make_streets("organic", generator(request.param, "streets"))
    return fill_blocks(streets, generator(request.param, "blocks"), 420.0)


def test_pools_keep_their_distance(layout):
    pools = place_pools(layout, generator(1, "town"))
    assert 5 <= len(pools) <= 30
    houses = [rectangle(b.centre_m, b.size_m[:2], b.yaw_rad) for b in layout.buildings]
    parks = [rectangle(park.centre_m, park.size_m, park.yaw_rad) for park in layout.car_parks]
    assert parks
    others = [shapely.Polygon(corners) for corners in [*houses, *parks]]
    others += [shapely.Point(t.centre_m) for t in layout.trees]
    others.append(road_area(layout.graph).buffer(PAVEMENT_WIDTH_M))
    for k, pool in enumerate(pools):
        assert 6.0 < pool.area < 30.0
        # Rounded: well off the corners of the smallest rectangle around it.
        assert pool.area < 0.99 * pool.minimum_rotated_rectangle.area
        for other in [*others, *pools[:k]]:
            assert pool.distance(other) > MARGIN_M + DECK_M - ROUNDING_M


def test_water_is_darker_in_the_middle_and_has_a_pale_rim():
    pool = shapely.box(-3.5, -1.5, 3.5, 1.5).buffer(0.5)
    canvas = Canvas(np.zeros((400, 400, 3), np.uint8), 20.0)
    paint_pool(canvas, pool, generator(4, "town"))
    brightness = canvas.picture.mean(axis=2)
    middle, shore, rim = (float(brightness[200 - round(20 * y), 200]) for y in (0.0, 1.9, 2.2))
    assert middle < 0.85 * shore < rim
    blue = canvas.picture[200, 200].astype(int)
    assert blue[2] > blue[0] + 20
