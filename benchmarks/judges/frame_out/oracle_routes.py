"""All routes over the road graph that a car may take from its place, for the guesses of ``oracle_map``."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import zip_longest

import numpy as np
from numpy.typing import NDArray

from scenarios.road_town.road_map import RoadMap
from scenarios.road_town.route import POINT_SPACING_M, Lane, route_along
from scenarios.road_town.traffic import speed_limit_mps

_REACH_M = 125.0
"""The scenario's cars cover less in 120 frames."""
_UNLIMITED_MPS = 60.0
_CLEAR_OF_CROSSING_M = 14.0
_ALONG_STREET_RAD = 0.5


class RouteFan:
    """All routes from the lane on which the car last was clearly, as arrays.

    Points are ``POINT_SPACING_M`` apart, the last one is repeated to the longest length M.

    Attributes:
        prior: (R,) share of drivers on each: equal for every way out of a crossing except back.
        points_m: (R, M, 2).
        nearest_arc_m: (R,) arc length of the point of each nearest to the car.
    """

    def __init__(self, road_map: RoadMap, poses: NDArray[np.float64]) -> None:
        """``poses``: (F, 4, 4) T_world_car of the frames so far; the last one is the present pose."""
        lane, frame = _last_clear_lane(road_map, poses)
        driven_m = float(np.linalg.norm(np.diff(poses[frame:, :2, 3], axis=0), axis=1).sum())
        lanes, shares = zip(*_onward(road_map, [lane], 1.0, driven_m + _REACH_M), strict=True)
        routes = [route_along(road_map.graph, list(each)) for each in lanes]
        longest = max(len(route.points_m) for route in routes) + 1

        def stacked(values: Iterable[NDArray[np.float64]]) -> NDArray[np.float64]:
            # Repeats the last one.
            return np.stack([each[np.minimum(np.arange(longest), len(each) - 1)] for each in values])

        self.prior = np.array(shares) / np.sum(shares)
        self.points_m = stacked(route.points_m for route in routes)
        self._heading_rad = stacked(route.heading_rad for route in routes)
        self._limits_mps = stacked(speed_limit_mps(route, _UNLIMITED_MPS) for route in routes)
        crossings = [[*(passage.enter_m for passage in route.passages), np.inf] for route in routes]
        self._crossings_m = np.array(list(zip_longest(*crossings, fillvalue=np.inf))).T
        distance_m = np.linalg.norm(self.points_m - poses[-1, :2, 3], axis=2)
        self.nearest_arc_m = POINT_SPACING_M * np.argmin(distance_m, axis=1)

    def at(
        self, route: NDArray[np.int64], arc_m: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return places (K, 2) and headings (K,) at arc lengths (K,) of routes (K,)."""
        index, fraction = self._index(arc_m)
        points = self.points_m[route, index] * (1 - fraction[:, None])
        points = points + self.points_m[route, index + 1] * fraction[:, None]
        heading = self._heading_rad[route, index] * (1 - fraction) + self._heading_rad[route, index + 1] * fraction
        return points, heading

    def limit_mps(self, route: NDArray[np.int64], arc_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the highest speed (K,) that bends at arc lengths (K,) of routes (K,), and further on, allow."""
        return self._limits_mps[route, self._index(arc_m)[0]]

    def next_crossing_m(self, route: NDArray[np.int64], arc_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the arc length (K,) at which the next crossing begins, inf if there is none."""
        crossings_m = self._crossings_m[route]
        return np.where(crossings_m >= arc_m[:, None], crossings_m, np.inf).min(axis=1)

    def _index(self, arc_m: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        place = np.clip(arc_m / POINT_SPACING_M, 0.0, self.points_m.shape[1] - 1.001)
        index = place.astype(np.int64)
        return index, place - index


def _last_clear_lane(road_map: RoadMap, poses: NDArray[np.float64]) -> tuple[Lane, int]:
    """Return the lane and the frame at which the car last drove along a street, away from its ends.

    At a crossing the lane is ambiguous. If it always was, the lane nearest at first.
    """
    places = road_map.nearest(poses[:, :2, 3])
    _, street_heading = road_map.pose_at(places.street, places.arc_m)
    along = np.cos(np.arctan2(poses[:, 1, 0], poses[:, 0, 0]) - street_heading)
    length_m = road_map.length_m[places.street]
    clear = np.minimum(places.arc_m, length_m - places.arc_m) > np.minimum(_CLEAR_OF_CROSSING_M, 0.3 * length_m)
    clear &= np.abs(along) > np.cos(_ALONG_STREET_RAD)
    frame = int(np.flatnonzero(clear)[-1]) if clear.any() else 0
    return (int(places.street[frame]), bool(along[frame] > 0)), frame


def _onward(road_map: RoadMap, lanes: list[Lane], share: float, reach_m: float) -> Iterator[tuple[list[Lane], float]]:
    """Yield every sequence of lanes that covers ``reach_m`` beyond the end of the first lane, with its share."""
    ways = [way for way in road_map.departures(*lanes[-1]) if not way.back] or list(road_map.departures(*lanes[-1]))
    if reach_m <= 0 or not ways:
        yield lanes, share
        return
    for way in ways:
        further = reach_m - float(road_map.length_m[way.street])
        yield from _onward(road_map, [*lanes, (way.street, way.forward)], share / len(ways), further)
