"""Routes of cars on a graph of centre lines: choice of a way at a crossing, points ahead, and progress."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from trackers.mosaic_graph.kernels.crossing import (
    CUT_M,
    curve_over,
    enter,
    fit_of_curve,
    lane_point,
    last_point,
    on_curve,
    reach_before,
    wrap,
)
from trackers.mosaic_graph.kernels.road_position import (
    ARC,
    BOUND,
    CHOICE,
    DIRECTION,
    EDGE,
    HALTS,
    HEADING,
    LATERAL,
    ON_ROAD,
    RoadGraph,
    X,
    Y,
)

_STRAIGHT_SPREAD_RAD = 0.5
_SHARPEST_RAD, _SHARPEST_SPREAD_RAD, _TURNING_BACK = 2.3, 0.15, 0.02
_SAME_WAY_RAD, _OTHER_WAY = 0.3, 1e-3
_ABREAST_WITHIN_M = 13


@njit(cache=True)
def heading_behind(graph: RoadGraph, way: int) -> float:
    """Return the heading behind a crossing of a car on a way (entry of ``node_edges``)."""
    edge, direction, arc, _ = enter(graph, way, CUT_M)
    _, _, t_x, t_y = lane_point(graph, edge, direction, arc, 0.0, 0.0)
    return np.arctan2(t_y, t_x)


@njit(cache=True)
def weight_of_turn(turn: float, turn_weight: float) -> float:
    """Return the prior weight of a way: 1 for going straight on, smoothly down to ``turn_weight`` for a turn by a right
    angle, and from 130 degrees on to 0.02 of that: drivers hardly turn back.
    """
    straight = np.exp(-0.5 * (turn / _STRAIGHT_SPREAD_RAD) ** 2)
    back = 1.0 / (1.0 + np.exp((_SHARPEST_RAD - abs(turn)) / _SHARPEST_SPREAD_RAD))
    return (straight + (1.0 - straight) * turn_weight) * (1.0 - (1.0 - _TURNING_BACK) * back)


@njit(cache=True)
def choose_way(s: NDArray[np.float64], graph: RoadGraph, turn_weight: float, lane_m: float, uniform: float) -> None:
    """Draw the way at the end of the edge and write it into the state: ``CHOICE`` (-1 at a dead end) and ``BOUND``.

    The weight is that of ``weight_of_turn`` times the agreement with the desired heading ``BOUND``, if there is one: it
    outlasts redrawn roads. For a car on the crossing the weight is also multiplied by ``fit_of_curve``, and the car is
    moved onto the path.
    """
    edge, side = int(s[EDGE]), 1 if s[DIRECTION] > 0 else 0
    node = graph.ends[edge, side]
    inside = distance_to_node_m(s, graph) < reach_before(graph, edge)
    total = 0.0
    s[CHOICE] = -1.0
    for draw in range(2):
        threshold = uniform * total
        total = 0.0
        for way in range(graph.node_first[node], graph.node_first[node + 1]):
            if graph.node_edges[way] == edge and graph.node_sides[way] == side:
                continue
            control, _, _, turn = curve_over(graph, edge, s[DIRECTION], way, lane_m)
            weight = weight_of_turn(turn, turn_weight)
            if not np.isnan(s[BOUND]):
                off = wrap(heading_behind(graph, way) - s[BOUND])
                weight *= np.exp(-0.5 * (off / _SAME_WAY_RAD) ** 2) + _OTHER_WAY
            share = 0.0
            if inside:
                fit, share = fit_of_curve(control, s[X], s[Y], s[HEADING])
                weight *= fit
            total += weight
            if draw == 1 and total >= threshold:
                s[CHOICE] = way
                s[BOUND] = heading_behind(graph, way)
                if inside:
                    _put_on_way(s, graph, share, lane_m)
                return


@njit(cache=True)
def _put_on_way(s: NDArray[np.float64], graph: RoadGraph, share: float, lane_m: float) -> None:
    """Move a car to a share of its chosen path over a crossing."""
    edge = int(s[EDGE])
    to_node = (1.0 - share) * (reach_before(graph, edge) + CUT_M) - CUT_M
    s[LATERAL] = lane_m
    if to_node > 0.0:
        s[ARC] = last_point(graph, edge) - to_node if s[DIRECTION] > 0 else to_node
    else:
        _pass_node(s, graph)


@njit(cache=True)
def _pass_node(s: NDArray[np.float64], graph: RoadGraph) -> None:
    """Move a car to the nearest point of the edge it chose."""
    way = int(s[CHOICE])
    s[CHOICE] = -1.0
    s[HALTS] = 0.0
    s[BOUND] = np.nan
    nearest, abreast = np.inf, 0.0
    for beyond in range(_ABREAST_WITHIN_M):
        edge, direction, arc, rest = enter(graph, way, float(beyond))
        x, y, _, _ = lane_point(graph, edge, direction, arc, rest, s[LATERAL])
        squared = (x - s[X]) ** 2 + (y - s[Y]) ** 2
        if squared < nearest:
            nearest, abreast = squared, float(beyond)
    s[EDGE], s[DIRECTION], s[ARC], _ = enter(graph, way, abreast)


@njit(cache=True)
def point_ahead(s: NDArray[np.float64], graph: RoadGraph, distance: float) -> tuple[float, float, float]:
    """Return the lane's point ``distance`` m ahead along the chosen way, and its heading; straight on at a dead end."""
    edge, direction = int(s[EDGE]), s[DIRECTION]
    arc, beyond = s[ARC] + direction * distance, 0.0
    if s[CHOICE] >= 0:
        back = reach_before(graph, edge)
        to_node = distance_to_node_m(s, graph)
        inside = distance - max(to_node - back, 0.0)
        if inside > 0.0:
            way = int(s[CHOICE])
            control, length, _, _ = curve_over(graph, edge, direction, way, s[LATERAL])
            # The share of the curve behind the car equals that of the way over the node.
            inside += length * max(back - to_node, 0.0) / (back + CUT_M)
            if inside < length:
                return on_curve(control, inside / length)
            edge, direction, arc, beyond = enter(graph, way, CUT_M + inside - length)
    within = min(max(arc, 0.0), last_point(graph, edge))
    beyond += abs(arc - within)
    x, y, t_x, t_y = lane_point(graph, edge, direction, within, beyond, s[LATERAL])
    return x, y, np.arctan2(t_y, t_x)


@njit(cache=True)
def distance_to_node_m(s: NDArray[np.float64], graph: RoadGraph) -> float:
    """Return the distance of a car to the end of its edge."""
    return last_point(graph, int(s[EDGE])) - s[ARC] if s[DIRECTION] > 0 else s[ARC]


@njit(cache=True)
def move_along(s: NDArray[np.float64], graph: RoadGraph, step_x: float, step_y: float) -> None:
    """Update edge and arc after a step; past a node, change to the chosen way, or set free at a dead end."""
    edge = int(s[EDGE])
    last, back = last_point(graph, edge), reach_before(graph, edge)
    length = np.sqrt(step_x * step_x + step_y * step_y)
    if s[CHOICE] >= 0 and distance_to_node_m(s, graph) < back:
        _, way_m, _, _ = curve_over(graph, edge, s[DIRECTION], int(s[CHOICE]), s[LATERAL])
        s[ARC] += s[DIRECTION] * length * (back + CUT_M) / way_m
    else:
        p = graph.first[edge] + min(max(int(np.round(s[ARC])), 0), last)
        offset_x, offset_y = s[X] - graph.points_m[p, 0], s[Y] - graph.points_m[p, 1]
        along = offset_x * graph.tangents[p, 0] + offset_y * graph.tangents[p, 1]
        # Limits both ways: inside a bend the foot of the perpendicular would jump.
        moved = s[DIRECTION] * ((p - graph.first[edge]) + along - s[ARC])
        s[ARC] += s[DIRECTION] * min(max(moved, 0.3 * length), 2.0 * length)
    if 0.0 <= s[ARC] <= last:
        return
    if s[CHOICE] < 0:
        s[ON_ROAD] = 0.0
        return
    _pass_node(s, graph)
