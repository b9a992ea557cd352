"""Geometry of a road network, for traffic, reference trackers and scores.

A place on the network is (street, arc_m, lateral_m): the street, the distance along its centre line from its start, and
the distance to the *left* of it, seen from start to end (so a lane driven forward has a negative offset).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import KDTree

from scenarios.road_town.layout import RoadGraph

FILLET_RADIUS_M = 5.0
"""Radius of the rounded kerb corners at crossings."""


@dataclass(frozen=True, slots=True)
class RoadPlace:
    """Places on the network; every array has the shape of the queried points.

    Attributes:
        street: (...) int, index into ``RoadGraph.streets``.
        arc_m: (...) along the centre line from the street's start, within [0, its length].
        lateral_m: (...) signed distance from the centre line, positive to the left; beyond a street's end the distance
            to that end, with the sign of the side.
    """

    street: NDArray[np.int64]
    arc_m: NDArray[np.float64]
    lateral_m: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Departure:
    """A way to continue from a node.

    Attributes:
        street: index of the street.
        forward: True to drive it from its start to its end.
        turn_rad: change of heading from the arriving street, in (-pi, pi], positive to the left.
        back: True for turning back into the arriving street.
    """

    street: int
    forward: bool
    turn_rad: float
    back: bool


def road_area(graph: RoadGraph) -> shapely.Geometry:
    """Return the carriageways with rounded kerb corners at crossings, as shapely polygons in metres."""
    strips = [shapely.LineString(street.centre_m).simplify(0.02).buffer(street.width_m / 2) for street in graph.streets]
    # Growing and shrinking again fills the corners of crossings with fillets.
    return shapely.union_all(strips).buffer(FILLET_RADIUS_M).buffer(-FILLET_RADIUS_M)


class RoadMap:
    """A road graph prepared for fast queries.

    Attributes:
        graph: the network.
        length_m: (S,) of every street.
        width_m: (S,) kerb to kerb.
        area: shapely polygon of the carriageways.
    """

    def __init__(self, graph: RoadGraph) -> None:
        self.graph = graph
        counts = np.array([len(street.centre_m) for street in graph.streets])
        self._first = np.concatenate([[0], np.cumsum(counts)[:-1]])
        self._last = self._first + counts - 1
        self._points_m = np.concatenate([street.centre_m for street in graph.streets])
        self._street = np.repeat(np.arange(len(counts)), counts)
        arcs = [_arc_lengths(street.centre_m) for street in graph.streets]
        self._arc_m = np.concatenate(arcs)
        self._tangent = np.concatenate([_tangents(street.centre_m) for street in graph.streets])
        self.length_m = np.array([arc[-1] for arc in arcs])
        self.width_m = np.array([street.width_m for street in graph.streets])
        self._tree = KDTree(self._points_m)
        self.area = road_area(graph)
        shapely.prepare(self.area)

    def nearest(self, points_m: NDArray[np.float64]) -> RoadPlace:
        """Return the place on the network nearest to each point (..., 2)."""
        points_m = np.asarray(points_m, dtype=float)
        flat = points_m.reshape(-1, 2)
        index = self._tree.query(flat)[1]
        # The nearest sample has the nearest point of the polyline on one of its two segments.
        street = self._street[index]
        best = [
            self._on_segment(flat, np.clip(index + d, self._first[street], self._last[street] - 1)) for d in (-1, 0)
        ]
        distance, arc_m, side = np.where(best[0][0] < best[1][0], best[0], best[1])
        shape = points_m.shape[:-1]
        return RoadPlace(street.reshape(shape), arc_m.reshape(shape), (side * distance).reshape(shape))

    def pose_at(
        self,
        street: NDArray[np.int64] | int,
        arc_m: NDArray[np.float64] | float,
        lateral_m: NDArray[np.float64] | float = 0.0,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return positions (..., 2), m, and headings (...), rad, of the street there (start to end).

        ``arc_m`` is clamped to the street.
        """
        index, fraction = self._between(np.asarray(street), np.asarray(arc_m, dtype=float))
        blend = fraction[..., None]
        tangent = (1 - blend) * self._tangent[index] + blend * self._tangent[index + 1]
        tangent /= np.linalg.norm(tangent, axis=-1, keepdims=True)
        left = np.stack([-tangent[..., 1], tangent[..., 0]], axis=-1)
        position_m = (1 - blend) * self._points_m[index] + blend * self._points_m[index + 1]
        position_m = position_m + np.asarray(lateral_m)[..., None] * left
        return position_m, np.arctan2(tangent[..., 1], tangent[..., 0])

    def node_reached(self, street: int, forward: bool) -> int:
        """Return the node at the far end of a street in this direction."""
        return self.graph.streets[street].end if forward else self.graph.streets[street].start

    def departures(self, street: int, forward: bool) -> tuple[Departure, ...]:
        """Return every way to continue at the end of a street, sharpest right turn first, turning back last."""
        node = self.node_reached(street, forward)
        _, heading = self.pose_at(street, self.length_m[street] if forward else 0.0)
        arriving = float(heading) + (0.0 if forward else np.pi)
        ways = []
        for index, other in enumerate(self.graph.streets):
            for starts_here, onward in ((other.start == node, True), (other.end == node, False)):
                if not starts_here:
                    continue
                _, heading = self.pose_at(index, 0.0 if onward else self.length_m[index])
                leaving = float(heading) + (0.0 if onward else np.pi)
                turn = float(-((-(leaving - arriving) + np.pi) % (2 * np.pi) - np.pi))
                ways.append(Departure(index, onward, turn, back=index == street and onward != forward))
        return tuple(sorted(ways, key=lambda way: (way.back, way.turn_rad)))

    def is_on_road(self, points_m: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return whether each point (..., 2) lies on a carriageway, crossings' rounded corners included."""
        points_m = np.asarray(points_m, dtype=float)
        inside: NDArray[np.bool_] = shapely.contains_xy(self.area, points_m[..., 0], points_m[..., 1])
        return inside

    def _between(
        self, street: NDArray[np.int64], arc_m: NDArray[np.float64]
    ) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Return the sample before each place and the fraction (0-1) to the next. Samples are equally spaced."""
        intervals = self._last[street] - self._first[street]
        steps = np.clip(arc_m / self.length_m[street], 0.0, 1.0) * intervals
        whole = np.minimum(steps.astype(np.int64), intervals - 1)
        return self._first[street] + whole, steps - whole

    def _on_segment(
        self, points_m: NDArray[np.float64], index: NDArray[np.int64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Return distance, arc length and side (+1 left, -1 right) of points (N, 2) from segments (N,)."""
        start = self._points_m[index]
        along = self._points_m[index + 1] - start
        offset = points_m - start
        fraction = np.clip(np.sum(offset * along, axis=1) / np.sum(along * along, axis=1), 0.0, 1.0)
        distance = np.linalg.norm(offset - fraction[:, None] * along, axis=1)
        arc_m = self._arc_m[index] + fraction * (self._arc_m[index + 1] - self._arc_m[index])
        side = np.where(along[:, 0] * offset[:, 1] - along[:, 1] * offset[:, 0] < 0, -1.0, 1.0)
        return distance, arc_m, side


def _arc_lengths(line_m: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line_m, axis=0), axis=1))])


def _tangents(line_m: NDArray[np.float64]) -> NDArray[np.float64]:
    tangent = np.gradient(line_m, axis=0, edge_order=2)
    unit: NDArray[np.float64] = tangent / np.linalg.norm(tangent, axis=1, keepdims=True)
    return unit
