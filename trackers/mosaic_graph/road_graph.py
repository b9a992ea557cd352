"""Construction of the graph of centre lines from the raw lines of a skeleton, by way of an editable graph.

Crossings are joined and centred, spurs cut, dead ends connected, streets extended into unseen ground.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.cluster.hierarchy import DisjointSet
from scipy.ndimage import gaussian_filter1d

from trackers.mosaic_graph.kernels.road_position import SPACING_M, RoadGraph

CROSSING_M = 6.0
"""Nodes nearer to each other than this belong to one crossing."""
_SMOOTHING_M = 4.0

Line = NDArray[np.float64]


class Arm(NamedTuple):
    """An edge as seen from one of its nodes.

    Attributes:
        edge: index.
        ends_here: whether the edge ends at the node, instead of starting there.
        points: (n, 2), starting at the node.
    """

    edge: int
    ends_here: bool
    points: Line


class RoadSketch:
    """Edges between numbered nodes.

    Attributes:
        edges: start node, end node and points (n, 2) of each.
    """

    def __init__(self, lines_m: list[Line]) -> None:
        """Begin with lines that share end points where they meet."""
        self._nodes: dict[tuple[float, float], int] = {}
        self.edges: list[tuple[int, int, Line]] = [
            (self._node(line[0]), self._node(line[-1]), line) for line in lines_m if len(line) > 1
        ]
        self._next_node = len(self._nodes)

    def _node(self, point_m: NDArray[np.float64]) -> int:
        return self._nodes.setdefault((float(point_m[0]), float(point_m[1])), len(self._nodes))

    def new_node(self) -> int:
        """Return the number of a new node."""
        self._next_node += 1
        return self._next_node - 1

    def degrees(self) -> Counter[int]:
        """Return the number of edges' ends at each node."""
        return Counter(node for edge in self.edges for node in edge[:2])

    def arms(self, node: int) -> list[Arm]:
        """Return the edges at a node."""
        found = []
        for k, (start, end, points) in enumerate(self.edges):
            if start == node:
                found.append(Arm(k, False, points))
            if end == node:
                found.append(Arm(k, True, points[::-1]))
        return found

    def replace(self, arm: Arm, points: Line) -> None:
        """Replace the points of an arm's edge by (n, 2), starting at the node."""
        start, end, _ = self.edges[arm.edge]
        self.edges[arm.edge] = (start, end, points[::-1] if arm.ends_here else points)

    def split(self, edge: int, near_m: NDArray[np.float64]) -> tuple[int, NDArray[np.float64]]:
        """Return a node on an edge near ``near_m`` (2,), and its place (2,): an end, or a new node that splits it."""
        start, end, points = self.edges[edge]
        index = int(np.linalg.norm(points - near_m, axis=1).argmin())
        margin = int(CROSSING_M / SPACING_M)
        if index < margin:
            return start, points[0]
        if index >= len(points) - margin:
            return end, points[-1]
        node = self.new_node()
        self.edges[edge] = (start, node, points[: index + 1])
        self.edges.append((node, end, points[index:]))
        return node, points[index]

    def finished(self) -> RoadGraph:
        """Return the graph as arrays, with nodes numbered from 0."""
        edges = [edge for edge in self.edges if len(edge[2]) > 1]
        number: dict[int, int] = {}
        ends = [[number.setdefault(node, len(number)) for node in edge[:2]] for edge in edges]
        ends_array = np.array(ends, dtype=np.int64).reshape(-1, 2)
        counts = np.array([len(points) for _, _, points in edges], dtype=np.int64)
        first = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
        incidence = sorted((node, e, side) for e, pair in enumerate(ends) for side, node in enumerate(pair))
        meeting = np.array(incidence, dtype=np.int64).reshape(-1, 3)
        return RoadGraph(
            points_m=np.vstack([np.empty((0, 2)), *(points for _, _, points in edges)]),
            tangents=np.vstack([np.empty((0, 2)), *(_tangents(points) for _, _, points in edges)]),
            edge_of_point=np.repeat(np.arange(len(edges)), counts),
            first=first,
            ends=ends_array,
            node_first=np.searchsorted(meeting[:, 0], np.arange(len(number) + 1)),
            node_edges=meeting[:, 1].copy(),
            node_sides=meeting[:, 2].copy(),
        )


def length_m(points: Line) -> float:
    """Return the length of a line (n, 2)."""
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def direction(points: Line, from_point: int, to_point: int) -> NDArray[np.float64]:
    """Return the unit vector (2,) from one point of a line (n, 2) to another, or to its last."""
    along = points[min(to_point, len(points) - 1)] - points[from_point]
    unit: NDArray[np.float64] = along / max(float(np.linalg.norm(along)), 1e-9)
    return unit


def even(points: Line) -> Line:
    """Return a line with points at most ``SPACING_M`` apart and the same ends."""
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    wanted = np.linspace(0.0, arc[-1], max(int(np.ceil(arc[-1] / SPACING_M)) + 1, 2))
    return np.column_stack([np.interp(wanted, arc, points[:, axis]) for axis in range(2)])


def smoothed(points: Line) -> Line:
    """Return a line, ``even`` and smoothed by a Gaussian of 4 m, with the same ends."""
    line = even(points)
    # Point-symmetric padding keeps the ends in place.
    pad = min(len(line) - 1, int(3 * _SMOOTHING_M / SPACING_M))
    before, after = 2 * line[0] - line[pad:0:-1], 2 * line[-1] - line[-2 : -2 - pad : -1]
    long = gaussian_filter1d(np.vstack([before, line, after]), _SMOOTHING_M / SPACING_M, axis=0, mode="nearest")
    return long[pad : pad + len(line)]


def _tangents(points: Line) -> NDArray[np.float64]:
    difference = np.gradient(points, axis=0)
    return difference / np.maximum(np.linalg.norm(difference, axis=1, keepdims=True), 1e-9)


_SPUR_M = 9.0
_ISLAND_M = 27.0
# Points of a line are SPACING_M apart.
_TANGENT_POINTS = 12
_FRAYED_POINTS = 6
_SHORTEST_TO_EXTEND_M = 14.0
_EXTENSION_M = 45.0
_JOIN_M = 4.0
_NEAR_POINTS, _FAR_POINTS, _LEAST_POINTS = 6, 16, 11
_LEAST_ACROSS = 0.3
_ARM_POINTS, _SAME_WAY_COSINE = 25, 0.64
_LOOKED_AT, _MOSTLY = slice(7, 14), 0.6

Unseen = Callable[[NDArray[np.float64]], NDArray[np.bool_]]
"""Returns which map points (n, 2) no picture has shown: (n,)."""


def build_graph(lines_m: list[Line], unseen: Unseen) -> RoadGraph:
    """Return the graph of raw lines (each (n, 2) map points) that share end points where they meet.

    For ``unseen`` see ``branch``.
    """
    sketch = RoadSketch(lines_m)
    contract(sketch)
    for _ in range(2):
        cut_spurs(sketch)
        merge_chains(sketch)
    drop_islands(sketch)
    sketch.edges = [(start, end, smoothed(points)) for start, end, points in sketch.edges]
    straighten_ends(sketch)
    extend(sketch)
    centre_crossings(sketch)
    branch(sketch, unseen)
    return sketch.finished()


def contract(sketch: RoadSketch) -> None:
    """Join nodes that a short line connects: a skeleton has several at a crossing of wide roads."""
    degree = sketch.degrees()
    crossings = DisjointSet(degree)
    inner = [degree[s] > 1 and degree[e] > 1 and length_m(p) < CROSSING_M for s, e, p in sketch.edges]
    for (start, end, _), short in zip(sketch.edges, inner, strict=True):
        if short:
            crossings.merge(start, end)
    places: defaultdict[int, list[NDArray[np.float64]]] = defaultdict(list)
    for start, end, points in sketch.edges:
        places[crossings[start]].append(points[0])
        places[crossings[end]].append(points[-1])
    centres = {node: np.mean(members, axis=0) for node, members in places.items()}
    kept = [edge for edge, short in zip(sketch.edges, inner, strict=True) if not short]
    joined = [(crossings[start], crossings[end], points) for start, end, points in kept]
    sketch.edges = [(s, e, np.vstack([centres[s], points[1:-1], centres[e]])) for s, e, points in joined]


def cut_spurs(sketch: RoadSketch) -> None:
    """Drop short dead ends and small rings."""
    degree = sketch.degrees()

    def kept(start: int, end: int, points: Line) -> bool:
        dangles = degree[start] == 1 or degree[end] == 1
        return length_m(points) >= _SPUR_M or not (dangles or start == end)

    sketch.edges = [edge for edge in sketch.edges if kept(*edge)]


def drop_islands(sketch: RoadSketch) -> None:
    """Drop short connected parts: grey roofs."""
    islands = DisjointSet(sketch.degrees())
    for start, end, _ in sketch.edges:
        islands.merge(start, end)
    total_m: defaultdict[int, float] = defaultdict(float)
    for start, _, points in sketch.edges:
        total_m[islands[start]] += length_m(points)
    sketch.edges = [edge for edge in sketch.edges if total_m[islands[edge[0]]] >= _ISLAND_M]


def merge_chains(sketch: RoadSketch) -> None:
    """Join two edges that meet at a node of degree two."""
    for node, count in sketch.degrees().items():
        if count != 2:
            continue
        arms = sketch.arms(node)
        if arms[0].edge == arms[1].edge:
            continue
        one, other = arms
        start, end = (sketch.edges[arm.edge][:2][0 if arm.ends_here else 1] for arm in arms)
        kept = [edge for k, edge in enumerate(sketch.edges) if k not in (one.edge, other.edge)]
        sketch.edges = [*kept, (start, end, np.vstack([one.points[::-1], other.points[1:]]))]


def straighten_ends(sketch: RoadSketch) -> None:
    """Straighten the last metres of dead ends: at the border of the seen ground a skeleton bends into a corner."""
    for node, count in sketch.degrees().items():
        for arm in sketch.arms(node) if count == 1 else ():
            if len(arm.points) <= _FRAYED_POINTS + _TANGENT_POINTS:
                continue
            stem = arm.points[_FRAYED_POINTS:]
            outward = -direction(stem, 0, _TANGENT_POINTS)
            tip = stem[0] + SPACING_M * np.arange(_FRAYED_POINTS, 0, -1)[:, None] * outward
            sketch.replace(arm, np.vstack([tip, stem]))


def extend(sketch: RoadSketch) -> None:
    """Extend dead ends straight to the first road within ``_EXTENSION_M``; others stay."""
    for node, count in sketch.degrees().items():
        arms = sketch.arms(node)
        # An earlier extension may have reached this end.
        if count != 1 or len(arms) != 1 or length_m(arms[0].points) < _SHORTEST_TO_EXTEND_M:
            continue
        outward = -direction(arms[0].points, 0, _TANGENT_POINTS)
        steps = np.arange(0.0, _EXTENSION_M + SPACING_M, SPACING_M)[:, None]
        _connect(sketch, node, arms[0].points[0] + steps * outward, arms[0].edge)


def _connect(sketch: RoadSketch, node: int, ray: Line, own: int) -> None:
    """Add ``ray`` as an edge from ``node`` to the first road it meets (except ``own``), if there is one."""
    target = -1
    for k, (start, end, points) in enumerate(sketch.edges):
        if k == own or node in (start, end):
            continue
        met = np.flatnonzero(np.linalg.norm(ray[:, None] - points[None], axis=-1).min(axis=1) < _JOIN_M)
        if len(met):
            target, ray = k, ray[: met[0] + 1]
    if target >= 0:
        far, last = sketch.split(target, ray[-1])
        sketch.edges.append((node, far, smoothed(np.vstack([ray, last]))))


def centre_crossings(sketch: RoadSketch) -> None:
    """Move every crossing to the intersection of its streets, as they run 6 to 16 m away from it.

    A skeleton deviates towards the mouth of a side street, and smoothing rounds it off. The point with the least sum of
    squared distances to the streets' lines solves ``sum (I - u u^T) x = sum (I - u u^T) p``. The crossing stays if the
    streets are nearly parallel, too short, or intersect more than 6 m away.
    """
    for node, count in sketch.degrees().items():
        if count < 2:
            continue
        arms = sketch.arms(node)
        across, place = np.zeros((2, 2)), np.zeros(2)
        for arm in arms:
            if len(arm.points) < _LEAST_POINTS:
                continue
            along = direction(arm.points, _NEAR_POINTS, _FAR_POINTS)
            projector = np.eye(2) - np.outer(along, along)
            across += projector
            place += projector @ arm.points[_NEAR_POINTS]
        if np.linalg.eigvalsh(across)[0] < _LEAST_ACROSS:
            continue
        middle = np.linalg.solve(across, place)
        if np.linalg.norm(middle - arms[0].points[0]) > _NEAR_POINTS * SPACING_M:
            continue
        for end in arms:
            # Moving one end of a ring changes the points of the other.
            arm = next(a for a in sketch.arms(node) if (a.edge, a.ends_here) == (end.edge, end.ends_here))
            sketch.replace(arm, even(np.vstack([middle, arm.points[min(_NEAR_POINTS, len(arm.points) - 1) :]])))


def branch(sketch: RoadSketch, unseen: Unseen) -> None:
    """Extend every street straight over a crossing into unseen ground, unless another street leads there.

    At the border of the seen ground some streets of a crossing are not drawn yet.
    """
    for node, count in sketch.degrees().items():
        if count < 3:
            continue
        arms = sketch.arms(node)
        ways = [direction(arm.points, 0, _TANGENT_POINTS) for arm in arms]
        for way in list(ways):
            ray = arms[0].points[0] - SPACING_M * np.arange(0, _ARM_POINTS + 1)[:, None] * way
            hidden = unseen(ray)
            taken = max(float(-way @ other) for other in ways) > _SAME_WAY_COSINE
            if not taken and hidden[_LOOKED_AT].mean() > _MOSTLY:
                shown = np.flatnonzero(~hidden[_LOOKED_AT.stop :])
                end = _LOOKED_AT.stop + int(shown[0]) if len(shown) else len(ray)
                sketch.edges.append((node, sketch.new_node(), ray[:end]))
                ways.append(-way)
