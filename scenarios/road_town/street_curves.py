"""Smooth streets from a sketch of roads (control points), and the check of the resulting graph."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from scenarios.road_town.layout import RoadGraph, Street

SAMPLE_M = 0.95
"""Nominal spacing along centre lines (the contract allows 1 m)."""
MIN_RADIUS_M = 20.0
"""Tightest bend of any street."""
MIN_STREET_M = 25.0
MIN_ANGLE_RAD = np.deg2rad(48.0)
"""Sharpest angle between two streets that meet."""
MIN_GAP_M = 16.0
"""Smallest distance between the centre lines of streets that do not meet."""


@dataclass(frozen=True)
class Road:
    """A long curve through control points; it crosses or meets other roads at shared points.

    Attributes:
        points: indices into the sketch's control points, in order.
        width_m: kerb to kerb.
        closed: True for a ring (the first point is not repeated).
    """

    points: tuple[int, ...]
    width_m: float
    closed: bool = False


def graph_of_roads(points_m: NDArray[np.float64], roads: list[Road]) -> RoadGraph:
    """Cut roads into streets at shared control points and at ends.

    Each road is one C2 cubic spline through its control points (chord-length parameter), so streets continue through a
    crossing without a kink.

    Args:
        points_m: (P, 2) control points.
        roads: through these points.

    Returns:
        The graph; its nodes are the control points that several roads share, and the ends of open roads.
    """
    uses = Counter(point for road in roads for point in road.points)
    ends = {point for road in roads if not road.closed for point in (road.points[0], road.points[-1])}
    node_points = sorted(point for point, count in uses.items() if count > 1 or point in ends)
    node_of_point = {point: node for node, point in enumerate(node_points)}
    streets: list[Street] = []
    for road in roads:
        spline, knots, order = _spline(points_m, road)
        cuts = [i for i, point in enumerate(order) if point in node_of_point]
        if road.closed:
            # Begin the ring at its first node, so that the sketch's first point does not cut a street.
            turned = road.points[cuts[0] :] + road.points[: cuts[0]]
            spline, knots, order = _spline(points_m, Road(turned, road.width_m, closed=True))
            cuts = [i for i, point in enumerate(order) if point in node_of_point]
        for a, b in pairwise(cuts):
            centre_m = _equal_steps(spline, knots[a], knots[b])
            centre_m[[0, -1]] = points_m[[order[a], order[b]]]
            streets.append(Street(node_of_point[order[a]], node_of_point[order[b]], centre_m, road.width_m))
    return RoadGraph(points_m[node_points], tuple(streets))


def curvature_per_m(centre_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the signed curvature (M,), 1/m, of a line (M, 2) sampled at equal steps; positive bends to the left."""
    velocity = np.gradient(centre_m, axis=0, edge_order=2)
    acceleration = np.gradient(velocity, axis=0, edge_order=2)
    cross = velocity[:, 0] * acceleration[:, 1] - velocity[:, 1] * acceleration[:, 0]
    curvature = cross / np.linalg.norm(velocity, axis=1) ** 3
    # One-sided second differences are inaccurate at the ends; use the neighbour's curvature there.
    curvature[:2], curvature[-2:] = curvature[2], curvature[-3]
    return curvature


def fault_of(graph: RoadGraph, half_m: float, min_radius_m: float = MIN_RADIUS_M) -> str | None:
    """Return why a graph is invalid as a road network, or None if it is valid.

    Args:
        half_m: every centre line must stay within ``|x|, |y| <= half_m``.
        min_radius_m: tightest bend allowed.
    """
    for index, street in enumerate(graph.streets):
        if np.abs(street.centre_m).max() > half_m:
            return f"street {index} leaves the town"
        if len(street.centre_m) * SAMPLE_M < MIN_STREET_M:
            return f"street {index} is too short"
        if np.abs(curvature_per_m(street.centre_m)).max() > 1.0 / min_radius_m:
            return f"street {index} bends too sharply"
    return _fault_of_meetings(graph)


def _spline(points_m: NDArray[np.float64], road: Road) -> tuple[CubicSpline, NDArray[np.float64], tuple[int, ...]]:
    order = road.points + road.points[:1] if road.closed else road.points
    control_m = points_m[list(order)]
    knots = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(control_m, axis=0), axis=1))])
    return CubicSpline(knots, control_m, bc_type="periodic" if road.closed else "natural"), knots, order


def _equal_steps(spline: CubicSpline, start: float, end: float) -> NDArray[np.float64]:
    """Return points (M, 2) of the curve between two parameters, at equal steps of arc length, at most 1 m."""
    dense = np.linspace(start, end, max(16, int((end - start) * 8)))
    arc_m = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(spline(dense), axis=0), axis=1))])
    count = max(8, int(np.ceil(arc_m[-1] / SAMPLE_M))) + 1
    centre_m: NDArray[np.float64] = spline(np.interp(np.linspace(0.0, arc_m[-1], count), arc_m, dense))
    return centre_m


def _fault_of_meetings(graph: RoadGraph) -> str | None:
    """Return which streets meet at too sharp an angle or come too close without meeting, None if there are none."""
    departures: dict[int, list[float]] = {}
    for street in graph.streets:
        for node, inward in ((street.start, street.centre_m), (street.end, street.centre_m[::-1])):
            along = inward[8] - inward[0]
            departures.setdefault(node, []).append(float(np.arctan2(along[1], along[0])))
    for node, headings in departures.items():
        ordered = np.sort(headings)
        gaps = np.diff(np.append(ordered, ordered[0] + 2 * np.pi))
        if len(headings) > 1 and gaps.min() < MIN_ANGLE_RAD:
            return f"streets meet too sharply at node {node}"
    lines = [shapely.LineString(street.centre_m[::4]) for street in graph.streets]
    for i, first in enumerate(graph.streets):
        for j in range(i):
            second = graph.streets[j]
            if not {first.start, first.end} & {second.start, second.end}:
                if lines[i].distance(lines[j]) < MIN_GAP_M:
                    return f"streets {j} and {i} come too close"
            elif _apart_from_nodes(first, second):
                return f"streets {j} and {i} come too close beyond their crossing"
    return None


def _apart_from_nodes(first: Street, second: Street, clear_m: float = 22.0) -> bool:
    """Return whether two streets that meet come too close again away from their shared nodes."""
    shared = {first.start, first.end} & {second.start, second.end}
    trimmed = []
    for street in (first, second):
        low = int(clear_m) if street.start in shared else 0
        high = len(street.centre_m) - (int(clear_m) if street.end in shared else 0)
        if high - low < 2:
            return False
        trimmed.append(shapely.LineString(street.centre_m[low:high:2] if high - low > 4 else street.centre_m[low:high]))
    return bool(trimmed[0].distance(trimmed[1]) < MIN_GAP_M)
