"""Swimming pools in gardens: rounded, with a rim of stone, deeper towards one end."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import affinity

from scenarios.road_town.blocks import PAVEMENT_WIDTH_M
from scenarios.road_town.canvas import Canvas, rectangle
from scenarios.road_town.layout import Building, Layout
from scenarios.road_town.palette import PATHS, Rgb, pick
from scenarios.road_town.road_map import road_area

MARGIN_M = 1.5
"""Least free ground between a pool's deck and houses, pavements, car parks, trunks and other pools."""
_SHARE = 0.14
_TRIES = 8
_BEHIND_M = (6.0, 11.0)
"""Distance of a pool's middle behind its house: terraces reach less far."""
_RIM_M, DECK_M = 0.35, 0.9
_RIM: Rgb = (186, 180, 168)
_SHALLOW, _DEEP = np.array([128.0, 172.0, 172.0]), np.array([44.0, 104.0, 128.0])
_DEPTHS = 6


def place_pools(layout: Layout, rng: np.random.Generator) -> list[shapely.Polygon]:
    """Draw the outlines of pools behind some houses, where their decks fit with ``MARGIN_M`` around."""
    houses = [shapely.Polygon(rectangle(b.centre_m, b.size_m[:2], b.yaw_rad)) for b in layout.buildings]
    parks = [shapely.Polygon(rectangle(park.centre_m, park.size_m, park.yaw_rad)) for park in layout.car_parks]
    trunks = [shapely.Point(tree.centre_m).buffer(0.5) for tree in layout.trees]
    taken = shapely.STRtree([*houses, *parks, *trunks, road_area(layout.graph).buffer(PAVEMENT_WIDTH_M)])
    half_m = 0.5 * layout.extent_m - MARGIN_M
    inside = shapely.box(-half_m, -half_m, half_m, half_m)
    pools: list[shapely.Polygon] = []
    for building in layout.buildings:
        if rng.random() >= _SHARE:
            continue
        for _ in range(_TRIES):
            pool = _draw_pool(building, rng)
            around = pool.buffer(DECK_M + MARGIN_M)
            is_free = not len(taken.query(around, predicate="intersects"))
            if is_free and inside.contains(around) and not any(around.intersects(other) for other in pools):
                pools.append(pool)
                break
    return pools


def _draw_pool(building: Building, rng: np.random.Generator) -> shapely.Polygon:
    """Draw a pool behind a house: a rectangle with round corners, or two discs grown together."""
    length, width = float(rng.uniform(4.5, 7.5)), float(rng.uniform(2.6, 3.8))
    if rng.random() < 0.6:
        corner = float(rng.uniform(0.7, 0.5 * width - 0.1))
        shape = shapely.box(-0.5 * length + corner, -0.5 * width + corner, 0.5 * length - corner, 0.5 * width - corner)
        shape = shape.buffer(corner)
    else:
        ends = [shapely.Point(side * 0.25 * length, 0.12 * side * width).buffer(0.5 * width) for side in (-1.0, 1.0)]
        shape = shapely.union_all(ends).buffer(0.8).buffer(-0.8)
    c, s = np.cos(building.yaw_rad), np.sin(building.yaw_rad)
    along = float(rng.uniform(-0.4, 0.4)) * building.size_m[0]
    behind = -0.5 * building.size_m[1] - float(rng.uniform(*_BEHIND_M))
    x, y = building.centre_m[0] + c * along - s * behind, building.centre_m[1] + s * along + c * behind
    turn_deg = float(np.degrees(building.yaw_rad) + rng.normal(0.0, 6.0))
    return affinity.translate(affinity.rotate(shape, turn_deg, origin=(0.0, 0.0)), x, y)


def paint_pool(canvas: Canvas, pool: shapely.Polygon, rng: np.random.Generator) -> None:
    """Paint a deck, the rim, and water that grows darker towards the deep end."""
    canvas.area(pool.buffer(DECK_M), pick(PATHS, rng))
    canvas.area(pool.buffer(_RIM_M), pick((_RIM,), rng, 5.0))
    tint = rng.normal(0.0, 7.0, 3)
    turn = np.exp(2j * np.pi * rng.random())
    for step in range(_DEPTHS):
        share = step / (_DEPTHS - 1)
        deep = affinity.translate(pool.buffer(-0.2 * step), 0.12 * step * turn.real, 0.12 * step * turn.imag)
        canvas.area(deep.intersection(pool), _water(share, tint))


def _water(depth_share: float, tint: NDArray[np.float64]) -> Rgb:
    red, green, blue = np.clip(_SHALLOW + depth_share * (_DEEP - _SHALLOW) + tint, 0, 255).astype(int).tolist()
    return red, green, blue
