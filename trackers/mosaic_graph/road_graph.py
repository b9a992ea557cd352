"""Construction of the graph of centre lines from the raw lines of a skeleton.

Crossings are joined and centred, spurs cut, dead ends connected, streets extended into unseen ground.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.cluster.hierarchy import DisjointSet

from trackers.mosaic_graph.kernels.roads import SPACING_M, RoadGraph
from trackers.mosaic_graph.road_sketch import CROSSING_M, Line, RoadSketch, direction, even, length_m, smoothed

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
