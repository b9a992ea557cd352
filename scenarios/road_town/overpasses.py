"""Bridges and covers over streets: where they stand in a town, and their bodies.

A car under one is hidden, though it is not outside the picture.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import NDArray

from scenarios.road_town.blocks import PAVEMENT_WIDTH_M
from scenarios.road_town.canvas import rectangle
from scenarios.road_town.layout import Layout, Overpass, Rectangle
from scenarios.road_town.road_map import RoadMap
from scenarios.road_town.route import Excursion, Route
from sim.mesh import TexturedMesh
from sim.meshes.overpass import PARAPET_M, Surface, cover, deck, embankment, pier, stairs
from sim.pose import pose_on_ground
from sim.rng import generator
from sim.world import World

CLEAR_M = 5.0
"""Height under a deck: no vehicle is higher."""
KINDS, _SHARES = ("footbridge", "road", "rail", "cover"), (0.22, 0.14, 0.14, 0.5)
_TRIES = 60
_FROM_START_M = 30.0
"""The target drives so far in the open first."""
_APART_M = 26.0
_STAIRS_M = (9.0, 2.0)
"""Run and width of stairs."""
_BANK_M, _COVER_M, _BEND_M = 6.5, (20.0, 40.0), 0.6
"""Width of a cover's banks, range of its length along the street, and the most that the street may bend under it."""
_VIADUCT_WIDTH_M = {"road": 10.0, "rail": 9.0}
_BAY_M, _PIER_M = 18.0, 1.2
"""Distance of a viaduct's piers, and their length."""
_LOST = {"footbridge": 1, "cover": 5, "road": 14, "rail": 14}
"""Most houses that give way to one of each kind."""
_RAMP_M, _FLAT_M, _FLAT_TOP_M = 64.0, 240.0, 0.12
"""Lengths, outside the town, of a viaduct's ramp and of the level way after it, and how high the latter lies."""


@dataclass(frozen=True, eq=False)
class Way:
    """The way of the target, over which overpasses are built.

    Attributes:
        span_m: arc lengths between which they may stand. excursions: parts off the road, to be left free.
    """

    route: Route
    span_m: tuple[float, float]
    excursions: tuple[Excursion, ...]


def with_overpasses(layout: Layout, numbers: tuple[int, int], seed: int, way: Way | None = None) -> Layout:
    """Return a town with overpasses, without the houses, trees and other things that stand where they do.

    Args:
        numbers: range of how many there are; fewer where there is no room.
        way: of the target; None: they stand over any streets.
    """
    rng = generator(seed, "overpasses")
    wanted = int(rng.integers(numbers[0], numbers[1] + 1))
    roads = RoadMap(layout.graph)
    kept_free = _kept_free(layout, roads, way)
    for _ in range(_TRIES * wanted):
        if len(layout.overpasses) == wanted:
            break
        kind = KINDS[int(rng.choice(len(KINDS), p=_SHARES))]
        if kind in _VIADUCT_WIDTH_M and any(each.kind in _VIADUCT_WIDTH_M for each in layout.overpasses):
            continue
        street, arc_m = _draw_place(roads, way, rng)
        made = _DRAWN.get(kind, _viaduct)(kind, layout, roads, street, arc_m, rng)
        if made is None or _is_in_the_way(made, layout, kept_free):
            continue
        cleared = _cleared(layout, made)
        if len(layout.buildings) - len(cleared.buildings) <= _LOST[kind]:
            layout = replace(cleared, overpasses=(*layout.overpasses, made))
    return layout


def _kept_free(layout: Layout, roads: RoadMap, way: Way | None) -> shapely.Geometry:
    """Return the ground on which nothing of an overpass may stand: streets, pavements, car parks, excursions."""
    areas = [roads.area.buffer(PAVEMENT_WIDTH_M - 0.1)]
    areas += [_polygon((park.centre_m, park.size_m, park.yaw_rad)).buffer(0.5) for park in layout.car_parks]
    for excursion in way.excursions if way is not None else ():
        arcs = np.arange(excursion.leave_m - 2.0, excursion.return_m + 2.0)
        assert way is not None
        areas.append(shapely.LineString(way.route.at(arcs)[0]).buffer(2.6))
    return shapely.union_all(areas)


def _draw_place(roads: RoadMap, way: Way | None, rng: np.random.Generator) -> tuple[int, float]:
    if way is None:
        street = int(rng.integers(len(roads.length_m)))
        return street, float(rng.uniform(0.0, roads.length_m[street]))
    place = roads.nearest(way.route.at(np.array(rng.uniform(way.span_m[0] + _FROM_START_M, way.span_m[1])))[0])
    return int(place.street), float(place.arc_m)


def _axis(roads: RoadMap, street: int, arc_m: float, from_ends_m: float) -> tuple[tuple[float, float], float] | None:
    """Return a place on a street's middle and the direction across it; None near its ends."""
    if not from_ends_m < arc_m < roads.length_m[street] - from_ends_m:
        return None
    place_m, heading_rad = roads.pose_at(street, arc_m)
    return (float(place_m[0]), float(place_m[1])), float(heading_rad) + 0.5 * np.pi


def _footbridge(
    kind: str, layout: Layout, roads: RoadMap, street: int, arc_m: float, rng: np.random.Generator
) -> Overpass | None:
    axis = _axis(roads, street, arc_m, 22.0)
    if axis is None:
        return None
    half_m = 0.5 * roads.width_m[street] + PAVEMENT_WIDTH_M + 0.4
    run_m, width_m = _STAIRS_M
    turns = rng.choice([-1.0, 1.0], 2)
    solids = []
    for side, turn in zip((-1.0, 1.0), turns, strict=True):
        middle = _on(axis, side * (half_m + 0.5 * width_m), turn * (0.5 * run_m))
        solids.append((middle, (width_m + 0.1, run_m + width_m), axis[1]))
    return Overpass(
        kind, *axis, -half_m, half_m, 3.0, CLEAR_M, CLEAR_M + 0.5, tuple(solids), stairs=tuple(map(float, turns))
    )


def _cover(
    kind: str, layout: Layout, roads: RoadMap, street: int, arc_m: float, rng: np.random.Generator
) -> Overpass | None:
    length_m = float(rng.uniform(*_COVER_M))
    axis = _axis(roads, street, arc_m, 0.5 * length_m + 14.0)
    if axis is None:
        return None
    along = arc_m + np.linspace(-0.5, 0.5, 9) * length_m
    bent_m = roads.pose_at(street, along)[0] - axis[0]
    if np.abs(bent_m @ (np.cos(axis[1]), np.sin(axis[1]))).max() > _BEND_M:
        return None
    half_m = 0.5 * roads.width_m[street] + PAVEMENT_WIDTH_M + 1.2
    solids = []
    for side in (-1.0, 1.0):
        middle = _on(axis, side * (half_m + 0.5 * _BANK_M - 0.2), 0.0)
        solids.append((middle, (_BANK_M + 0.4, length_m), axis[1]))
    return Overpass(kind, *axis, -half_m, half_m, length_m, CLEAR_M, CLEAR_M + 0.9, tuple(solids))


def _viaduct(
    kind: str, layout: Layout, roads: RoadMap, street: int, arc_m: float, rng: np.random.Generator
) -> Overpass | None:
    """Return a viaduct through the whole town, in the direction in which the fewest houses stand and no street runs."""
    axis = _axis(roads, street, arc_m, 18.0)
    if axis is None:
        return None
    width_m = _VIADUCT_WIDTH_M[kind]
    best: tuple[float, Overpass] | None = None
    for turn in rng.uniform(-0.5, 0.5, 9):
        tried = (axis[0], axis[1] + float(turn))
        start_m, end_m = _ends(tried, 0.5 * layout.extent_m - 12.0)
        made = Overpass(kind, *tried, start_m, end_m, width_m, CLEAR_M + 0.2, CLEAR_M + 1.2, ())
        under = _polygon(made.rectangle)
        middles = shapely.MultiLineString([each.centre_m for each in layout.graph.streets])
        lost = sum(_polygon((b.centre_m, b.size_m[:2], b.yaw_rad)).intersects(under) for b in layout.buildings)
        cost = 4.0 * lost + middles.intersection(under).length
        if best is None or cost < best[0]:
            best = cost, made
    assert best is not None
    made = best[1]
    paved = shapely.union_all(
        [roads.area.buffer(PAVEMENT_WIDTH_M + 0.3)]
        + [_polygon((park.centre_m, park.size_m, park.yaw_rad)) for park in layout.car_parks]
    )
    shapely.prepare(paved)
    piers, solids = [], []
    for at_m in np.arange(made.start_m + 0.5 * _BAY_M, made.end_m, _BAY_M):
        for shift_m in (0.0, -3.0, 3.0, -6.0, 6.0):
            place = float(at_m + shift_m)
            solid: Rectangle = (_on((made.centre_m, made.yaw_rad), place, 0.0), (_PIER_M, 0.6 * width_m), made.yaw_rad)
            if not paved.intersects(_polygon(solid)):
                piers.append(place)
                solids.append(solid)
                break
    return replace(made, solids=tuple(solids), piers_m=tuple(piers))


_DRAWN = {"footbridge": _footbridge, "cover": _cover}


def _ends(axis: tuple[tuple[float, float], float], half_m: float) -> tuple[float, float]:
    """Return where an axis leaves a square of ``2 * half_m``, before and after its origin."""
    direction = np.array([np.cos(axis[1]), np.sin(axis[1])])
    with np.errstate(divide="ignore"):
        to_sides = np.stack([(-half_m - np.array(axis[0])) / direction, (half_m - np.array(axis[0])) / direction])
    return float(to_sides.min(axis=0).max()), float(to_sides.max(axis=0).min())


def _is_in_the_way(made: Overpass, layout: Layout, kept_free: shapely.Geometry) -> bool:
    if any(kept_free.intersects(_polygon(solid)) for solid in made.solids):
        return True
    ground = _ground_of(made)
    for other in layout.overpasses:
        if ground.intersects(_ground_of(other)):
            return True
        if np.hypot(*(np.array(made.centre_m) - other.centre_m)) < _APART_M:
            return True
    half_m = 0.5 * layout.extent_m - 1.0
    inside = shapely.box(-half_m, -half_m, half_m, half_m)
    return not all(inside.contains(_polygon(solid)) for solid in made.solids)


def _ground_of(overpass: Overpass) -> shapely.Geometry:
    """Return all the ground that an overpass stands on or covers."""
    return shapely.union_all([_polygon(each) for each in (overpass.rectangle, *overpass.solids)])


def _cleared(layout: Layout, made: Overpass) -> Layout:
    ground = _ground_of(made)
    solids = shapely.union_all([_polygon(each) for each in made.solids])
    shapely.prepare(ground)
    under = ground if made.kind == "cover" else solids
    wide = ground.buffer(0.8)
    return replace(
        layout,
        buildings=tuple(
            b for b in layout.buildings if not wide.intersects(_polygon((b.centre_m, b.size_m[:2], b.yaw_rad)))
        ),
        trees=tuple(t for t in layout.trees if ground.distance(shapely.Point(t.centre_m)) > 0.5 + 0.8 * t.radius_m),
        lamps=tuple(p for p in layout.lamps if ground.distance(shapely.Point(p.centre_m)) > 3.0),
        props=tuple(p for p in layout.props if under.distance(_polygon(p.rectangle)) > 0.4),
    )


def _polygon(place: Rectangle) -> shapely.Polygon:
    return shapely.Polygon(rectangle(*place))


def _on(axis: tuple[tuple[float, float], float], along_m: float, across_m: float) -> tuple[float, float]:
    """Return a place in an overpass's frame."""
    c, s = np.cos(axis[1]), np.sin(axis[1])
    return float(axis[0][0] + c * along_m - s * across_m), float(axis[0][1] + s * along_m + c * across_m)


def deck_boxes(overpasses: Sequence[Overpass]) -> list[tuple[Rectangle, float, float]]:
    """Return the decks as boxes: rectangle, lower and upper height."""
    return [(each.rectangle, each.under_m, each.top_m + 0.5 * PARAPET_M) for each in overpasses]


def add_overpasses(world: World, layout: Layout) -> None:
    """Add the bodies of all overpasses to a town."""
    for k, overpass in enumerate(layout.overpasses):
        _ADDED.get(overpass.kind, _add_viaduct)(world, f"overpass-{k}", overpass, layout)


def _add(world: World, name: str, mesh: TexturedMesh, pose: NDArray[np.float64]) -> None:
    world.add(mesh, pose, name=name, category="overpass")


def _add_footbridge(world: World, name: str, overpass: Overpass, layout: Layout) -> None:
    axis, (run_m, width_m) = (overpass.centre_m, overpass.yaw_rad), _STAIRS_M
    span_m = overpass.end_m - overpass.start_m
    middle = deck("path", span_m, overpass.width_m, overpass.under_m, overpass.top_m)
    _add(world, f"{name} deck", middle, pose_on_ground(*overpass.centre_m, overpass.yaw_rad))
    flight = stairs(overpass.top_m, run_m, width_m)
    for side, turn in zip((-1.0, 1.0), overpass.stairs, strict=True):
        foot = _on(axis, side * (overpass.end_m + 0.5 * width_m), 0.5 * turn * width_m)
        _add(world, f"{name} stairs {side:+.0f}", flight, pose_on_ground(*foot, overpass.yaw_rad + turn * 0.5 * np.pi))


def _add_cover(world: World, name: str, overpass: Overpass, layout: Layout) -> None:
    made = cover(overpass.width_m, overpass.end_m - overpass.start_m, overpass.under_m, overpass.top_m, _BANK_M)
    _add(world, name, made, pose_on_ground(*overpass.centre_m, overpass.yaw_rad))


def _add_viaduct(world: World, name: str, overpass: Overpass, layout: Layout) -> None:
    axis, surface = (overpass.centre_m, overpass.yaw_rad), _surface(overpass.kind)
    count = max(1, round((overpass.end_m - overpass.start_m) / 24.0))
    piece_m = (overpass.end_m - overpass.start_m) / count
    piece = deck(surface, piece_m, overpass.width_m, overpass.under_m, overpass.top_m, ends=False)
    for k in range(count):
        middle = _on(axis, overpass.start_m + (k + 0.5) * piece_m, 0.0)
        _add(world, f"{name} deck {k}", piece, pose_on_ground(*middle, overpass.yaw_rad))
    under = pier(overpass.width_m, overpass.under_m)
    for k, at_m in enumerate(overpass.piers_m):
        _add(world, f"{name} pier {k}", under, pose_on_ground(*_on(axis, at_m, 0.0), overpass.yaw_rad))
    ramp = embankment(surface, _RAMP_M, overpass.width_m, overpass.top_m, _FLAT_TOP_M)
    flat = embankment(surface, _FLAT_M, overpass.width_m, _FLAT_TOP_M, _FLAT_TOP_M)
    for end_m, yaw_rad in ((overpass.end_m, overpass.yaw_rad), (overpass.start_m, overpass.yaw_rad + np.pi)):
        out = np.sign(end_m)
        _add(world, f"{name} ramp {out:+.0f}", ramp, pose_on_ground(*_on(axis, end_m, 0.0), yaw_rad))
        _add(world, f"{name} way {out:+.0f}", flat, pose_on_ground(*_on(axis, end_m + out * _RAMP_M, 0.0), yaw_rad))


def _surface(kind: str) -> Surface:
    return "rail" if kind == "rail" else "road"


_ADDED = {"footbridge": _add_footbridge, "cover": _add_cover}
