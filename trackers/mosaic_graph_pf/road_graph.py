"""A graph of centre lines out of the raw lines of a skeleton: crossings joined, spurs cut, dead ends
connected.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from trackers.kernels.roads import SPACING_M, RoadGraph

_CROSSING_M = 6.0
_SPUR_M = 9.0
_ISLAND_M = 27.0
_SMOOTHING_M = 4.0
_TANGENT_M = 12.0
_SHORTEST_TO_EXTEND_M = 14.0
_EXTENSION_M = 45.0
_JOIN_M = 4.0

Line = NDArray[np.float64]


def build_graph(lines_m: list[Line]) -> RoadGraph:
    """Return the graph of raw lines (each (n, 2) map points) that share end points where they meet."""
    sketch = _Sketch(lines_m)
    sketch.contract()
    for _ in range(2):
        sketch.cut_spurs()
        sketch.merge_chains()
    sketch.drop_islands()
    sketch.smooth()
    sketch.extend()
    return sketch.finished()


class _Sketch:
    """Edges that can still be changed: (start node, end node, points)."""

    def __init__(self, lines_m: list[Line]) -> None:
        self._nodes: dict[tuple[float, float], int] = {}
        self.edges: list[tuple[int, int, Line]] = [
            (self._node(line[0]), self._node(line[-1]), line) for line in lines_m if len(line) > 1
        ]
        self._next_node = len(self._nodes)

    def _node(self, point_m: NDArray[np.float64]) -> int:
        return self._nodes.setdefault((float(point_m[0]), float(point_m[1])), len(self._nodes))

    def _degrees(self) -> dict[int, int]:
        degree: dict[int, int] = {}
        for start, end, _ in self.edges:
            degree[start] = degree.get(start, 0) + 1
            degree[end] = degree.get(end, 0) + 1
        return degree

    def contract(self) -> None:
        """Join stops that a short line connects: a crossing of wide roads has several, near each other."""
        degree = self._degrees()
        parent = {node: node for node in degree}
        inner = [degree[s] > 1 and degree[e] > 1 and _length(p) < _CROSSING_M for s, e, p in self.edges]
        for (start, end, _), short in zip(self.edges, inner, strict=True):
            if short:
                parent[_root(parent, start)] = _root(parent, end)
        places: dict[int, list[NDArray[np.float64]]] = {}
        for start, end, points in self.edges:
            places.setdefault(_root(parent, start), []).append(points[0])
            places.setdefault(_root(parent, end), []).append(points[-1])
        centres = {node: np.mean(members, axis=0) for node, members in places.items()}
        kept = [edge for edge, short in zip(self.edges, inner, strict=True) if not short]
        joined = [(_root(parent, start), _root(parent, end), points) for start, end, points in kept]
        self.edges = [(s, e, np.vstack([centres[s], points[1:-1], centres[e]])) for s, e, points in joined]

    def cut_spurs(self) -> None:
        """Drop short dead ends, and rings too small to be streets."""
        degree = self._degrees()

        def kept(start: int, end: int, points: Line) -> bool:
            dangles = degree[start] == 1 or degree[end] == 1
            return _length(points) >= _SPUR_M or not (dangles or start == end)

        self.edges = [edge for edge in self.edges if kept(*edge)]

    def drop_islands(self) -> None:
        """Drop what is short and not connected to anything: grey roofs, not streets."""
        parent = {node: node for edge in self.edges for node in edge[:2]}
        for start, end, _ in self.edges:
            parent[_root(parent, start)] = _root(parent, end)
        length_m: dict[int, float] = {}
        for start, _, points in self.edges:
            island = _root(parent, start)
            length_m[island] = length_m.get(island, 0.0) + _length(points)
        self.edges = [edge for edge in self.edges if length_m[_root(parent, edge[0])] >= _ISLAND_M]

    def merge_chains(self) -> None:
        """Make one edge of two that meet where nothing else does."""
        for node, count in self._degrees().items():
            if count != 2:
                continue
            touching = [k for k, (start, end, _) in enumerate(self.edges) if node in (start, end)]
            if len(touching) != 2:
                continue
            one, other = (self.edges[k] for k in touching)
            if one[0] == node:
                one = (one[1], one[0], one[2][::-1])
            if other[1] == node:
                other = (other[1], other[0], other[2][::-1])
            merged = (one[0], other[1], np.vstack([one[2], other[2][1:]]))
            self.edges = [edge for k, edge in enumerate(self.edges) if k not in touching] + [merged]

    def smooth(self) -> None:
        """Resample every edge and take the stairs out of it; its ends stay where they are."""
        self.edges = [(start, end, _smoothed(points)) for start, end, points in self.edges]

    def extend(self) -> None:
        """Draw dead ends straight on to a road that they meet within ``_EXTENSION_M``. Others stay dead:
        where they lead was not seen.
        """
        for node, count in self._degrees().items():
            ending = [k for k, edge in enumerate(self.edges) if node in edge[:2]]
            # Another dead end may have been drawn on to this one meanwhile.
            if count != 1 or len(ending) != 1 or _length(self.edges[ending[0]][2]) < _SHORTEST_TO_EXTEND_M:
                continue
            _, end, points = self.edges[ending[0]]
            points = points if node == end else points[::-1]
            back = points[-1 - min(len(points) - 1, int(_TANGENT_M / SPACING_M))]
            along = (points[-1] - back) / max(float(np.linalg.norm(points[-1] - back)), 1e-9)
            steps = np.arange(0.0, _EXTENSION_M + SPACING_M, SPACING_M)[:, None]
            self._connect(node, points[-1] + steps * along, ending[0])

    def _connect(self, node: int, ray: Line, own: int) -> None:
        """Add ``ray`` as an edge from ``node`` up to where it meets another road (not ``own``) first, if it
        does.
        """
        target = -1
        for k, (start, end, points) in enumerate(self.edges):
            if k == own or node in (start, end):
                continue
            met = np.flatnonzero(np.linalg.norm(ray[:, None] - points[None], axis=-1).min(axis=1) < _JOIN_M)
            if len(met):
                target, ray = k, ray[: met[0] + 1]
        if target >= 0:
            far, last = self._split(target, ray[-1])
            self.edges.append((node, far, _smoothed(np.vstack([ray, last]))))

    def _split(self, k: int, near_m: NDArray[np.float64]) -> tuple[int, NDArray[np.float64]]:
        """Return a node, and where it is, on edge k next to ``near_m``: one of its ends, or a new one that
        cuts it in two.
        """
        start, end, points = self.edges[k]
        index = int(np.linalg.norm(points - near_m, axis=1).argmin())
        margin = int(_CROSSING_M / SPACING_M)
        if index < margin:
            return start, points[0]
        if index >= len(points) - margin:
            return end, points[-1]
        node = self._new_node()
        self.edges[k] = (start, node, points[: index + 1])
        self.edges.append((node, end, points[index:]))
        return node, points[index]

    def _new_node(self) -> int:
        self._next_node += 1
        return self._next_node - 1

    def finished(self) -> RoadGraph:
        """Return the graph with its nodes numbered from 0."""
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


def _root(parent: dict[int, int], node: int) -> int:
    """Return the node that stands for all those joined with ``node`` (union-find)."""
    while parent[node] != node:
        node = parent[node]
    return node


def _length(points: Line) -> float:
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def _smoothed(points: Line) -> Line:
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    count = max(int(np.ceil(arc[-1] / SPACING_M)) + 1, 2)
    even = np.linspace(0.0, arc[-1], count)
    line = np.column_stack([np.interp(even, arc, points[:, axis]) for axis in range(2)])
    # Point-symmetric continuation at both ends keeps the ends themselves in place.
    pad = min(count - 1, int(3 * _SMOOTHING_M / SPACING_M))
    before, after = 2 * line[0] - line[pad:0:-1], 2 * line[-1] - line[-2 : -2 - pad : -1]
    long = gaussian_filter1d(np.vstack([before, line, after]), _SMOOTHING_M / SPACING_M, axis=0, mode="nearest")
    return long[pad : pad + count]


def _tangents(points: Line) -> NDArray[np.float64]:
    difference = np.gradient(points, axis=0)
    return difference / np.maximum(np.linalg.norm(difference, axis=1, keepdims=True), 1e-9)
