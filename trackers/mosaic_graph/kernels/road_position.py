"""A graph of centre lines as arrays for kernels, states of cars on it, and their association with its edges."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

SPACING_M = 1.0
"""Distance between the points of a centre line."""


class RoadGraph(NamedTuple):
    """Estimated centre lines. The points of all edges are concatenated, ``SPACING_M`` apart.

    Attributes:
        points_m: (P, 2) centre lines; edge e has rows ``first[e]`` to ``first[e + 1]`` (not included), at least two.
        tangents: (P, 2) unit vectors from start to end.
        edge_of_point: (P,) edge of each point.
        first: (E + 1,), see above.
        ends: (E, 2) node at the start and at the end of every edge.
        node_first, node_edges, node_sides: the edges that meet in node n are
            ``node_edges[node_first[n]:node_first[n + 1]]``, with their start (side 0) or their end (side 1).
    """

    points_m: NDArray[np.float64]
    tangents: NDArray[np.float64]
    edge_of_point: NDArray[np.int64]
    first: NDArray[np.int64]
    ends: NDArray[np.int64]
    node_first: NDArray[np.int64]
    node_edges: NDArray[np.int64]
    node_sides: NDArray[np.int64]

    @property
    def edge_count(self) -> int:
        """Number of edges."""
        return len(self.first) - 1


class Roads(NamedTuple):
    """Estimated roads around the target.

    Attributes:
        graph: centre lines.
        origin_m, cell_m: grid on the map: (2,) corner of its first cell, and side of a cell.
        nearest: (H, W) int32, the graph's point nearest to each cell of the grid; -1 where none is near.
    """

    graph: RoadGraph
    origin_m: NDArray[np.float64]
    cell_m: float
    nearest: NDArray[np.int32]


(
    X,
    Y,
    HEADING,
    SPEED,
    ON_ROAD,
    EDGE,
    ARC,
    DIRECTION,
    LATERAL,
    CHOICE,
    CRUISE,
    HALTS,
    URGE,
    CURVE,
    TURN,
    LOOK,
    LOG_PRIOR,
    BOUND,
    VIGOUR,
    CORNERING,
) = range(20)
"""Columns of a state:

- map position (m), heading (rad), speed (m/s);
- 1 on a road, 0 free; edge, point on it (fractional, from the edge's first), +1 or -1 along it or against it, offset to
  the right of the centre line (m);
- entry of ``node_edges`` chosen at the next crossing, or -1; desired speed (m/s); 1 if the car halts at that crossing;
- additional acceleration (m/s^2); curvature of the path (1/m), and if free the rest of a turn (rad);
- look-ahead distance (m), short for sharp corners; log-prior at birth; desired heading (rad) behind the next crossing,
  NaN = undecided;
- logarithms of the factors of the driver's accelerations along the road, and across it.
"""
COLUMNS = 20
_PROBES = 7
_ON_ROAD_WITHIN_M, _ON_ROAD_COSINE, _ON_ROAD_FREE_WEIGHT = 9.0, 0.17, 1e-9
_FREE_WITHIN_M, _FREE_COSINE, FREE_WEIGHT = 6.5, 0.64, 0.082


@njit(cache=True)
def associate(states: NDArray[np.float64], roads: Roads, uniforms: NDArray[np.float64]) -> None:
    """Associate each state with an edge near it at random, or set it free, in place.

    Candidates are the centre-line points nearest to the car and to six places ahead, straight on and to either side,
    each shifted along its edge to the point beside the car: in a turn the street is ambiguous. One is drawn with weight
    ``exp(-c / 2)``, ``c = |p - x| + 12 (1 - |cos angle|)``; being free has c = 5. Points must lie within 6.5 m and 50
    degrees. A state already on a road has limits of 9 m and 80 degrees, is set free only if there is no candidate, and
    keeps its decisions for the next crossing. A state put on a road ends its turn.

    Args:
        states: (N, COLUMNS). uniforms: (N,) in [0, 1).
    """
    for i in range(states.shape[0]):
        associate_one(states[i], roads, uniforms[i])


@njit(cache=True)
def associate_one(s: NDArray[np.float64], roads: Roads, uniform: float) -> None:
    """Associate one state, see ``associate``."""
    graph = roads.graph
    within_m, least_cosine, free_weight = _FREE_WITHIN_M, _FREE_COSINE, FREE_WEIGHT
    if s[ON_ROAD] > 0:
        within_m, least_cosine, free_weight = _ON_ROAD_WITHIN_M, _ON_ROAD_COSINE, _ON_ROAD_FREE_WEIGHT
    else:
        s[BOUND] = np.nan
        s[HALTS] = 0.0
    s[ON_ROAD] = 0.0
    s[CHOICE] = -1.0
    total = free_weight
    chosen = -1
    c, si = np.cos(s[HEADING]), np.sin(s[HEADING])
    edges = np.full(_PROBES, -1, np.int64)
    points = np.zeros(_PROBES, np.int64)
    weights = np.zeros(_PROBES)
    for probe in range(_PROBES):
        p = _probe(s, roads, probe)
        if p < 0:
            continue
        edge = graph.edge_of_point[p]
        d_x, d_y = s[X] - graph.points_m[p, 0], s[Y] - graph.points_m[p, 1]
        along = d_x * graph.tangents[p, 0] + d_y * graph.tangents[p, 1]
        p = min(max(p + int(np.round(along)), graph.first[edge]), graph.first[edge + 1] - 1)
        d_x, d_y = s[X] - graph.points_m[p, 0], s[Y] - graph.points_m[p, 1]
        distance = np.sqrt(d_x * d_x + d_y * d_y)
        cosine = abs(c * graph.tangents[p, 0] + si * graph.tangents[p, 1])
        known = False
        for earlier in range(probe):
            known = known or edges[earlier] == edge
        if known or distance > within_m or cosine < least_cosine:
            continue
        edges[probe], points[probe] = edge, p
        weights[probe] = np.exp(-0.5 * (distance + 12.0 * (1.0 - cosine)))
        total += weights[probe]
    threshold = uniform * total
    for probe in range(_PROBES):
        if edges[probe] >= 0:
            threshold -= weights[probe]
            if threshold < 0:
                chosen = points[probe]
                break
    if chosen >= 0:
        edge = graph.edge_of_point[chosen]
        t_x, t_y = graph.tangents[chosen, 0], graph.tangents[chosen, 1]
        s[ON_ROAD] = 1.0
        s[TURN] = 0.0
        s[EDGE] = edge
        s[ARC] = chosen - graph.first[edge]
        s[DIRECTION] = 1.0 if c * t_x + si * t_y > 0 else -1.0
        right = t_y * (s[X] - graph.points_m[chosen, 0]) - t_x * (s[Y] - graph.points_m[chosen, 1])
        s[LATERAL] = s[DIRECTION] * right


@njit(cache=True)
def _probe(s: NDArray[np.float64], roads: Roads, probe: int) -> int:
    """Return the centre-line point nearest to one probe: the car, or 5 or 10 m ahead, straight or 60 degrees aside."""
    ahead = 0.0 if probe == 0 else (5.0 if probe % 2 == 1 else 10.0)
    aside = 0.0 if probe < 3 else (1.05 if probe < 5 else -1.05)
    x = s[X] + ahead * np.cos(s[HEADING] + aside)
    y = s[Y] + ahead * np.sin(s[HEADING] + aside)
    return nearest_point(x, y, roads)


@njit(cache=True)
def nearest_point(x: float, y: float, roads: Roads) -> int:
    """Return the centre-line point nearest to a place on the map, -1 if none is within 12 m."""
    column = int(np.floor((x - roads.origin_m[0]) / roads.cell_m))
    row = int(np.floor((y - roads.origin_m[1]) / roads.cell_m))
    if row < 0 or column < 0 or row >= roads.nearest.shape[0] or column >= roads.nearest.shape[1]:
        return -1
    return roads.nearest[row, column]


@njit(cache=True)
def offset_to_right(
    x: float, y: float, heading_rad: float, roads: Roads, off_ends_m: float, least_cosine: float
) -> float:
    """Return the offset to the right of the nearest centre line (m), seen in the direction of travel.

    NaN if none is near, if it is not parallel to the heading, or within ``off_ends_m`` of the end of its edge.
    """
    p = nearest_point(x, y, roads)
    if p < 0:
        return np.nan
    graph = roads.graph
    edge = graph.edge_of_point[p]
    t_x, t_y = graph.tangents[p, 0], graph.tangents[p, 1]
    cosine = np.cos(heading_rad) * t_x + np.sin(heading_rad) * t_y
    if min(p - graph.first[edge], graph.first[edge + 1] - 1 - p) < off_ends_m or abs(cosine) < least_cosine:
        return np.nan
    right = t_y * (x - graph.points_m[p, 0]) - t_x * (y - graph.points_m[p, 1])
    return right if cosine > 0 else -right
