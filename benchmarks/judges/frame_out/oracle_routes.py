"""All routes over the road graph that a car may take from its place, for the guesses of ``oracle_map``."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenarios.road_town.road_map import RoadMap
from scenarios.road_town.route import POINT_SPACING_M, Lane, Route, route_along
from scenarios.road_town.traffic import speed_limit_mps

_REACH_M = 125.0
"""The scenario's cars cover less in 120 frames."""
_UNLIMITED_MPS = 60.0
_CLEAR_OF_CROSSING_M = 14.0
_ALONG_STREET_RAD = 0.5


@dataclass(frozen=True, eq=False)
class RouteFan:
    """R routes as arrays; points are ``POINT_SPACING_M`` apart, the last one is repeated to the longest length M.

    Attributes:
        prior: (R,) share of drivers on each: equal for every way out of a crossing except back.
        points_m: (R, M, 2). heading_rad: (R, M).
        limits_mps: (R, M) highest speed that bends here and ahead allow.
        crossings_m: R arrays of arc lengths at which crossings begin.
        nearest_arc_m: (R,) arc length of the point of each nearest to the car.
    """

    prior: NDArray[np.float64]
    points_m: NDArray[np.float64]
    heading_rad: NDArray[np.float64]
    limits_mps: NDArray[np.float64]
    crossings_m: tuple[NDArray[np.float64], ...]
    nearest_arc_m: NDArray[np.float64]

    def at(
        self, route: NDArray[np.int64], arc_m: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return places (K, 2) and headings (K,) at arc lengths (K,) of routes (K,)."""
        index, fraction = self._index(arc_m)
        points = self.points_m[route, index] * (1 - fraction[:, None])
        points = points + self.points_m[route, index + 1] * fraction[:, None]
        heading = self.heading_rad[route, index] * (1 - fraction) + self.heading_rad[route, index + 1] * fraction
        return points, heading

    def limit_mps(self, route: NDArray[np.int64], arc_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the speed limits (K,) at arc lengths (K,) of routes (K,)."""
        return self.limits_mps[route, self._index(arc_m)[0]]

    def next_crossing_m(self, route: NDArray[np.int64], arc_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the arc length (K,) at which the next crossing begins, inf if there is none."""
        ahead = np.full(len(route), np.inf)
        for k, crossings in enumerate(self.crossings_m):
            own = route == k
            padded = np.append(crossings, np.inf)
            ahead[own] = padded[np.searchsorted(crossings, arc_m[own])]
        return ahead

    def _index(self, arc_m: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        place = np.clip(arc_m / POINT_SPACING_M, 0.0, self.points_m.shape[1] - 1.001)
        index = place.astype(np.int64)
        return index, place - index


def fan_of_routes(road_map: RoadMap, poses: NDArray[np.float64]) -> RouteFan:
    """Return all routes from the lane on which the car last was clearly.

    Args:
        poses: (F, 4, 4) T_world_car of the frames so far; the last one is the present pose.
    """
    lane, frame = _last_clear_lane(road_map, poses)
    driven_m = float(np.linalg.norm(np.diff(poses[frame:, :2, 3], axis=0), axis=1).sum())
    lanes, shares = zip(*_onward(road_map, [lane], 1.0, driven_m + _REACH_M), strict=True)
    routes = [route_along(road_map.graph, list(each)) for each in lanes]
    return _as_arrays(routes, np.array(shares), poses[-1, :2, 3])


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


def _as_arrays(routes: list[Route], shares: NDArray[np.float64], place_m: NDArray[np.float64]) -> RouteFan:
    longest = max(len(route.points_m) for route in routes) + 1

    def padded(values: NDArray[np.float64]) -> NDArray[np.float64]:
        width = [(0, longest - len(values))] + [(0, 0)] * (values.ndim - 1)
        return np.pad(values, width, mode="edge")

    points_m = np.stack([padded(route.points_m) for route in routes])
    distance_m = np.linalg.norm(points_m - place_m, axis=2)
    return RouteFan(
        prior=shares / shares.sum(),
        points_m=points_m,
        heading_rad=np.stack([padded(route.heading_rad) for route in routes]),
        limits_mps=np.stack([padded(speed_limit_mps(route, _UNLIMITED_MPS)) for route in routes]),
        crossings_m=tuple(np.array([p.enter_m for p in route.passages]) for route in routes),
        nearest_arc_m=POINT_SPACING_M * np.argmin(distance_m, axis=1),
    )
