"""Paths of cars: lanes of streets on the side of the traffic, joined by smooth curves over the crossings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from scenarios.road_town.layout import Layout, RoadGraph
from scenarios.road_town.swing_geometry import smooth_step

POINT_SPACING_M = 0.5
_TURN_THRESHOLD_RAD = 0.6


@dataclass(frozen=True, slots=True)
class Passage:
    """The part of a path over one crossing.

    Attributes:
        node: the crossing.
        enter_m, leave_m: arc lengths where the lane ends and where the next one starts.
        turn_rad: change of heading, positive to the left.
    """

    node: int
    enter_m: float
    leave_m: float
    turn_rad: float

    @property
    def is_turn(self) -> bool:
        """Whether the car turns by more than about 34 degrees."""
        return abs(self.turn_rad) > _TURN_THRESHOLD_RAD


@dataclass(frozen=True, eq=False)
class Route:
    """A drivable path.

    Attributes:
        points_m: (M, 2), ``POINT_SPACING_M`` apart.
        heading_rad: (M,) unwrapped.
        passages: crossings in driving order.
    """

    points_m: NDArray[np.float64]
    heading_rad: NDArray[np.float64]
    passages: tuple[Passage, ...]

    @property
    def length_m(self) -> float:
        """Arc length."""
        return POINT_SPACING_M * (len(self.points_m) - 1)

    def at(self, arc_m: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return positions (..., 2) and headings (...) at arc lengths (...), clamped to the path."""
        place = np.clip(np.asarray(arc_m) / POINT_SPACING_M, 0, len(self.points_m) - 1.000001)
        index = place.astype(int)
        fraction = place - index
        points = self.points_m
        position = points[index] + fraction[..., None] * (points[index + 1] - points[index])
        heading = self.heading_rad[index] + fraction * (self.heading_rad[index + 1] - self.heading_rad[index])
        return position, heading

    def curvature_per_m(self) -> NDArray[np.float64]:
        """Return the signed curvature (M,) of the path."""
        return np.gradient(self.heading_rad, POINT_SPACING_M)


class Routes:
    """Routes of N cars, of which ``at`` answers all at once."""

    def __init__(self, routes: Sequence[Route]) -> None:
        self._points_m = np.concatenate([route.points_m for route in routes])
        counts = np.array([len(route.points_m) for route in routes])
        self._first, self._last = np.cumsum(counts)[:, None] - counts[:, None], counts[:, None] - 1.000001

    def at(self, arc_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the positions (N, K, 2) of ``Route.at`` at arc lengths (N, K), bit for bit."""
        place = np.clip(arc_m / POINT_SPACING_M, 0, self._last)
        index = place.astype(int)
        fraction = place - index
        index += self._first
        before = self._points_m[index]
        return before + fraction[..., None] * (self._points_m[index + 1] - before)


def random_route(
    graph: RoadGraph,
    rng: np.random.Generator,
    length_m: float,
    *,
    keep_within_m: float,
    turn_preference: float,
) -> Route:
    """Return a route of at least ``length_m`` that starts at a random place.

    Args:
        keep_within_m: preferred largest distance from the town's centre along x and y.
        turn_preference: weight of turning against going straight on, > 0; 1 = no preference.
    """
    outgoing = _outgoing_lanes(graph)
    lane = _random_first_lane(graph, rng, keep_within_m)
    lanes = [lane]
    covered = len(_lane_points(graph, lane)) * POINT_SPACING_M
    while covered < length_m + 60.0:
        lane = _next_lane(graph, outgoing, lane, rng, keep_within_m, turn_preference)
        lanes.append(lane)
        covered += len(_lane_points(graph, lane)) * POINT_SPACING_M
    return route_along(graph, lanes)


Lane = tuple[int, bool]
"""(street, whether it is driven from its start to its end)."""


def route_along(graph: RoadGraph, lanes: list[Lane]) -> Route:
    """Return the route over lanes, each of which must start at the node where the one before ends."""
    pieces = [_lane_points(graph, lanes[0])]
    joints: list[tuple[int, int, int]] = []
    count = len(pieces[0])
    for before, after in pairwise(lanes):
        following = _lane_points(graph, after)
        connector = _connect(pieces[-1], following)
        joints.append((_end_node(graph, before), count - 1, count + len(connector)))
        pieces += [connector, following]
        count += len(connector) + len(following)
    rough = np.concatenate(pieces)
    points, arc_of_rough = resample(rough)
    heading = smooth_heading(points)
    passages = []
    for node, first, last in joints:
        enter, leave = arc_of_rough[first], arc_of_rough[last]
        i, j = (min(round(a / POINT_SPACING_M), len(heading) - 1) for a in (enter, leave))
        passages.append(Passage(node, float(enter), float(leave), float(heading[j] - heading[i])))
    return Route(points, heading, tuple(passages))


def _end_node(graph: RoadGraph, lane: Lane) -> int:
    street = graph.streets[lane[0]]
    return street.end if lane[1] else street.start


def _outgoing_lanes(graph: RoadGraph) -> list[list[Lane]]:
    """Return for each node the lanes that leave it."""
    lanes: list[list[Lane]] = [[] for _ in graph.nodes_m]
    for index, street in enumerate(graph.streets):
        lanes[street.start].append((index, True))
        lanes[street.end].append((index, False))
    return lanes


def _lane_points(graph: RoadGraph, lane: Lane) -> NDArray[np.float64]:
    """Return the lane's centre line between the crossings (M, 2), in driving direction; read only."""
    if lane not in graph.lanes_m:
        graph.lanes_m[lane] = _drawn_lane(graph, lane)
    return graph.lanes_m[lane]


def _drawn_lane(graph: RoadGraph, lane: Lane) -> NDArray[np.float64]:
    street = graph.streets[lane[0]]
    centre = street.centre_m if lane[1] else street.centre_m[::-1]
    centre, _ = resample(centre)
    tangent = np.gradient(centre, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    right = np.column_stack([tangent[:, 1], -tangent[:, 0]])
    length = POINT_SPACING_M * (len(centre) - 1)
    trim = round(min(1.1 * street.width_m, 0.3 * length) / POINT_SPACING_M)
    return (centre + graph.right_sign * 0.25 * street.width_m * right)[trim : len(centre) - trim]


def _connect(before: NDArray[np.float64], after: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the inner points of the cubic Bézier curve from the end of one lane to the start of the next."""
    start, end = before[-1], after[0]
    leaving, arriving = before[-1] - before[-3], after[2] - after[0]
    handle = 0.42 * float(np.linalg.norm(end - start))
    control = np.array(
        [
            start,
            start + handle * leaving / np.linalg.norm(leaving),
            end - handle * arriving / np.linalg.norm(arriving),
            end,
        ]
    )
    t = np.linspace(0, 1, max(4, int(2.4 * handle / POINT_SPACING_M)))[1:-1, None]
    basis = np.concatenate([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3], axis=1)
    return basis @ control


def resample(points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return points ``POINT_SPACING_M`` apart along a polyline, and the arc lengths of the given ones."""
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    wanted = np.arange(0.0, arc[-1], POINT_SPACING_M)
    return np.column_stack([np.interp(wanted, arc, points[:, k]) for k in (0, 1)]), arc


def smooth_heading(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return headings (M,) of a path, over a window of about a car's wheelbase."""
    ahead = np.minimum(np.arange(len(points)) + 3, len(points) - 1)
    behind = np.maximum(np.arange(len(points)) - 3, 0)
    step = points[ahead] - points[behind]
    return np.unwrap(np.arctan2(step[:, 1], step[:, 0]))


def _random_first_lane(graph: RoadGraph, rng: np.random.Generator, keep_within_m: float) -> Lane:
    inner = [
        index
        for index, street in enumerate(graph.streets)
        if np.abs(street.centre_m).max() < keep_within_m and len(street.centre_m) > 25
    ]
    candidates = inner or list(range(len(graph.streets)))
    return candidates[int(rng.integers(len(candidates)))], bool(rng.integers(2))


def _next_lane(
    graph: RoadGraph,
    outgoing: list[list[Lane]],
    lane: Lane,
    rng: np.random.Generator,
    keep_within_m: float,
    turn_preference: float,
) -> Lane:
    """Draw the lane after a lane: not back; rarely out of the town or into a hairpin."""
    node = _end_node(graph, lane)
    direction = _unit(np.diff(_lane_points(graph, lane)[-3:], axis=0).sum(axis=0))
    options, weights = [], []
    for option in outgoing[node]:
        if option[0] == lane[0] and len(outgoing[node]) > 1:
            continue
        points = _lane_points(graph, option)
        turn_cosine = float(direction @ _unit(points[2] - points[0]))
        far = np.abs(points[-1]).max() > keep_within_m
        weight = (1.0 if turn_cosine > np.cos(_TURN_THRESHOLD_RAD) else turn_preference) * (1e-3 if far else 1)
        options.append(option)
        weights.append(weight * (1e-4 if turn_cosine < -0.5 else 1.0))
    chosen = rng.choice(len(options), p=np.array(weights) / np.sum(weights))
    return options[int(chosen)]


def _unit(vector: NDArray[np.float64]) -> NDArray[np.float64]:
    return vector / np.linalg.norm(vector)


_CLEARANCE_M = 1.8
_LEAVE_OVER_M = 13.0
_TRIES = 150


@dataclass(frozen=True, slots=True)
class Excursion:
    """A stretch of a route that is off the road.

    Attributes:
        leave_m, return_m: arc lengths on the bent route where it leaves the road, and where it is back.
    """

    leave_m: float
    return_m: float


def with_excursion(
    route: Route,
    layout: Layout,
    rng: np.random.Generator,
    *,
    between_m: tuple[float, float],
    aside_m: tuple[float, float],
    along_m: tuple[float, float],
    clears: bool = True,
) -> tuple[Route, Layout, Excursion | None]:
    """Bend a route off the road where the fewest obstacles stand, and remove those: trees, props, at most one house.

    Args:
        between_m: arc lengths between which the excursion lies.
        aside_m: range of the sideways distance from the lane.
        along_m: range of the distance driven off the road.
        clears: False: only where nothing has to be removed.

    Returns:
        The bent route, the layout without the obstacles, and the excursion; or the same route and layout and None if
        there is no room.
    """
    if between_m[1] - between_m[0] < along_m[0]:
        return route, layout, None
    obstacles = _Obstacles(layout)
    arc = np.arange(len(route.points_m), dtype=float) * POINT_SPACING_M
    best: tuple[float, _Hits, NDArray[np.float64], float, float] | None = None
    for _ in range(_TRIES):
        leave = float(rng.uniform(*between_m))
        along = float(rng.uniform(*along_m))
        aside = float(rng.uniform(*aside_m)) * (1 if rng.integers(2) else -1)
        # To the other side, the route first crosses the opposite lane.
        side = layout.graph.right_sign
        aside += 3.5 * side if aside * side > 0 else 0.0
        if leave + along > between_m[1] or any(
            p.enter_m - 2 < leave + along and p.leave_m + 2 > leave for p in route.passages
        ):
            continue
        share = aside_share(arc, leave, along)
        left = np.column_stack([-np.sin(route.heading_rad), np.cos(route.heading_rad)])
        bent = route.points_m + (aside * share)[:, None] * left
        off = share > 0.05
        hits = obstacles.hits(bent[off])
        if hits.staying or len(hits.buildings) > 1 or np.abs(bent[off]).max() > 0.45 * layout.extent_m:
            continue
        cost = 10.0 * len(hits.buildings) + len(hits.trees) + 0.2 * len(hits.props)
        if (clears or cost == 0) and (best is None or cost < best[0]):
            best = cost, hits, bent, leave, leave + along
        if cost == 0:
            break
    if best is None:
        return route, layout, None
    _, hits, bent, leave, back = best
    cleared = replace(
        layout,
        buildings=tuple(b for k, b in enumerate(layout.buildings) if k not in hits.buildings),
        trees=tuple(t for k, t in enumerate(layout.trees) if k not in hits.trees),
        lamps=tuple(p for k, p in enumerate(layout.lamps, len(layout.trees)) if k not in hits.trees),
        props=tuple(p for k, p in enumerate(layout.props) if k not in hits.props),
    )
    bent_route, excursion = _rebuilt(route, bent, leave, back)
    return bent_route, cleared, excursion


def aside_share(
    arc_m: NDArray[np.float64], leave_m: float | NDArray[np.float64], along_m: float | NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return an excursion's sideways distance at arc lengths, as a share (0-1) of its largest.

    It is a smooth step out and one back.

    Args:
        leave_m: arc length where it leaves the road.
        along_m: distance from there to where it is back.
    """
    back_m = arc_m - leave_m - along_m + _LEAVE_OVER_M
    return smooth_step((arc_m - leave_m) / _LEAVE_OVER_M) - smooth_step(back_m / _LEAVE_OVER_M)


def _rebuilt(route: Route, bent: NDArray[np.float64], leave_m: float, return_m: float) -> tuple[Route, Excursion]:
    points, arc = resample(bent)

    def moved(old_m: float) -> float:
        return float(np.interp(old_m, np.arange(len(bent)) * POINT_SPACING_M, arc))

    passages = tuple(Passage(p.node, moved(p.enter_m), moved(p.leave_m), p.turn_rad) for p in route.passages)
    return Route(points, smooth_heading(points), passages), Excursion(moved(leave_m), moved(return_m))


@dataclass(frozen=True, slots=True)
class _Hits:
    """Obstacles of a path: indices of buildings, props, and trees and after them street lamps; whether others stay."""

    buildings: frozenset[int]
    props: frozenset[int]
    trees: frozenset[int]
    staying: bool


class _Obstacles:
    """Buildings, props, trees, street lamps, parked cars and overpasses of a town."""

    def __init__(self, layout: Layout) -> None:
        boxes = [(b.centre_m, b.size_m[:2], b.yaw_rad) for b in layout.buildings]
        self._buildings = len(boxes)
        boxes += [prop.rectangle for prop in layout.props]
        self._removable = len(boxes)
        for park in layout.car_parks:
            for (x, y, yaw), taken in zip(park.bays, park.taken, strict=True):
                if taken:
                    boxes.append(((x, y), (5.0, 2.2), yaw))
        boxes += [solid for overpass in layout.overpasses for solid in overpass.solids]
        self._centre = np.array([box[0] for box in boxes]).reshape(-1, 2)
        self._half = 0.5 * np.array([box[1] for box in boxes]).reshape(-1, 2)
        yaws = np.array([box[2] for box in boxes])
        self._axis = np.column_stack([np.cos(yaws), np.sin(yaws)])
        standing = [tree.centre_m for tree in layout.trees] + [lamp.centre_m for lamp in layout.lamps]
        self._trees = np.array(standing).reshape(-1, 2)

    def hits(self, points_m: NDArray[np.float64]) -> _Hits:
        """Return the obstacles within ``_CLEARANCE_M`` of any of the points (M, 2)."""
        offset = points_m[:, None] - self._centre[None]
        lengthwise = np.einsum("mbk,bk->mb", offset, self._axis)
        across = offset[..., 1] * self._axis[:, 0] - offset[..., 0] * self._axis[:, 1]
        outside = np.maximum(np.abs(np.stack([lengthwise, across], axis=-1)) - self._half, 0.0)
        near_boxes = np.flatnonzero((np.linalg.norm(outside, axis=-1) < _CLEARANCE_M).any(axis=0))
        tree_distance = np.linalg.norm(points_m[:, None] - self._trees[None], axis=-1)
        return _Hits(
            frozenset(int(k) for k in near_boxes if k < self._buildings),
            frozenset(int(k) - self._buildings for k in near_boxes if self._buildings <= k < self._removable),
            frozenset(np.flatnonzero((tree_distance < _CLEARANCE_M).any(axis=0)).tolist()),
            bool((near_boxes >= self._removable).any()),
        )
