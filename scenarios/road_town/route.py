"""Paths of cars: lanes of streets on the side of the traffic, joined by smooth curves over the crossings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from scenarios.road_town.layout import RoadGraph

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
