"""Paths over a crossing: from a point of one lane to a point of the next, along nearly an arc of a circle."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from trackers.mosaic_graph.kernels.road_position import RoadGraph

CUT_M = 9.0
"""Distance from a crossing's middle at which a car leaves its lane, and at which it is in the next."""
_FIT_STEPS = 8
_PLACE_M, _HEADING_RAD, _LEAST_FIT = 1.0, 0.15, 1e-3


@njit(cache=True)
def wrap(angle: float) -> float:
    """Return an angle wrapped to [-pi, pi)."""
    return (angle + np.pi) % (2 * np.pi) - np.pi


@njit(cache=True)
def last_point(graph: RoadGraph, edge: int) -> int:
    """Return the index of an edge's last point along the edge."""
    return graph.first[edge + 1] - graph.first[edge] - 1


@njit(cache=True)
def enter(graph: RoadGraph, way: int, beyond: float) -> tuple[int, float, float, float]:
    """Return the place of a car ``beyond`` points past the node on a way (entry of ``node_edges``): edge, direction,
    point on it (at most its end), and distance past its end.
    """
    edge = graph.node_edges[way]
    direction = 1.0 if graph.node_sides[way] == 0 else -1.0
    last = last_point(graph, edge)
    along = min(beyond, last)
    return edge, direction, along if direction > 0 else last - along, beyond - along


@njit(cache=True)
def lane_point(
    graph: RoadGraph, edge: int, direction: float, arc: float, beyond: float, lateral: float
) -> tuple[float, float, float, float]:
    """Return the point (x, y) of a lane at point ``arc`` of an edge, ``beyond`` m straight on, and its unit tangent."""
    whole = min(int(arc), last_point(graph, edge) - 1)
    fraction = arc - whole
    p = graph.first[edge] + whole
    t_x, t_y = direction * graph.tangents[p, 0], direction * graph.tangents[p, 1]
    x = (1 - fraction) * graph.points_m[p, 0] + fraction * graph.points_m[p + 1, 0] + beyond * t_x
    y = (1 - fraction) * graph.points_m[p, 1] + fraction * graph.points_m[p + 1, 1] + beyond * t_y
    return x + lateral * t_y, y - lateral * t_x, t_x, t_y


@njit(cache=True)
def reach_before(graph: RoadGraph, edge: int) -> float:
    """Return the distance before the end of an edge at which the crossing begins."""
    return min(CUT_M, 1.0 * last_point(graph, edge))


@njit(cache=True)
def curve_over(
    graph: RoadGraph, edge: int, direction: float, way: int, lateral: float
) -> tuple[NDArray[np.float64], float, float, float]:
    """Return the control points (4, 2) of the cubic Bézier curve from lane to lane, its length, radius and turn.

    Handles of ``4/3 tan(turn/4) r`` make it nearly an arc of a circle if it begins and ends equally far from the
    crossing's middle. Length and radius are always those of that arc, even if a short street makes it asymmetric.
    """
    last = last_point(graph, edge)
    back = reach_before(graph, edge)
    arc = last - back if direction > 0 else back
    x_0, y_0, a_x, a_y = lane_point(graph, edge, direction, arc, 0.0, lateral)
    edge_2, direction_2, arc_2, rest = enter(graph, way, CUT_M)
    x_3, y_3, b_x, b_y = lane_point(graph, edge_2, direction_2, arc_2, rest, lateral)
    chord = max(np.sqrt((x_3 - x_0) ** 2 + (y_3 - y_0) ** 2), 0.1)
    turn = np.arctan2(a_x * b_y - a_y * b_x, a_x * b_x + a_y * b_y)
    half = max(0.5 * abs(turn), 1e-3)
    radius = 0.5 * chord / np.sin(half)
    handle = 4.0 / 3.0 * np.tan(0.5 * half) * radius
    control = np.empty((4, 2))
    control[0, 0], control[0, 1] = x_0, y_0
    control[1, 0], control[1, 1] = x_0 + handle * a_x, y_0 + handle * a_y
    control[2, 0], control[2, 1] = x_3 - handle * b_x, y_3 - handle * b_y
    control[3, 0], control[3, 1] = x_3, y_3
    return control, 2.0 * half * radius, radius, turn


@njit(cache=True)
def on_curve(control: NDArray[np.float64], t: float) -> tuple[float, float, float]:
    """Return the point (x, y) of a cubic Bézier curve at ``t`` in [0, 1], and the heading there."""
    u = 1.0 - t
    b_0, b_1, b_2, b_3 = u * u * u, 3 * u * u * t, 3 * u * t * t, t * t * t
    d_0, d_1, d_2 = u * u, 2 * u * t, t * t
    x = b_0 * control[0, 0] + b_1 * control[1, 0] + b_2 * control[2, 0] + b_3 * control[3, 0]
    y = b_0 * control[0, 1] + b_1 * control[1, 1] + b_2 * control[2, 1] + b_3 * control[3, 1]
    d_x = (
        d_0 * (control[1, 0] - control[0, 0])
        + d_1 * (control[2, 0] - control[1, 0])
        + d_2 * (control[3, 0] - control[2, 0])
    )
    d_y = (
        d_0 * (control[1, 1] - control[0, 1])
        + d_1 * (control[2, 1] - control[1, 1])
        + d_2 * (control[3, 1] - control[2, 1])
    )
    return x, y, np.arctan2(d_y, d_x)


@njit(cache=True)
def fit_of_curve(control: NDArray[np.float64], x: float, y: float, heading: float) -> tuple[float, float]:
    """Return the fit of a car's place and heading to a path over a crossing, and the share of the path behind it.

    The fit is ``exp(-c) + 0.001``, with c half the sum of the squared deviations in units of 1 m and 0.15 rad.
    """
    best, best_t = 1e9, 0.0
    for step in range(_FIT_STEPS + 1):
        t = step / _FIT_STEPS
        c_x, c_y, c_heading = on_curve(control, t)
        turned = wrap(c_heading - heading)
        aside = ((c_x - x) ** 2 + (c_y - y) ** 2) / _PLACE_M**2
        cost = 0.5 * aside + 0.5 * (turned / _HEADING_RAD) ** 2
        if cost < best:
            best, best_t = cost, t
    return np.exp(-best) + _LEAST_FIT, best_t
