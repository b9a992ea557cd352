"""Editable graph of streets: lines between nodes that can be joined, cut and moved."""

from __future__ import annotations

from collections import Counter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from trackers.mosaic_graph.kernels.roads import SPACING_M, RoadGraph

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
