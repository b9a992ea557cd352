"""Routes of people, cars and boats over the site, and where one is at any time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from scenarios.harbour.layout import (
    APRON_END_M,
    FAIRWAY_X_M,
    GAP_Y_M,
    LANE_X_M,
    PARKING_X_M,
    PARKING_Y_M,
    SHED_X_M,
    SHEDS,
    WALL_X_M,
    border_y_m,
)

Points = NDArray[np.float64]

_BEHIND_SHEDS_X_M = 64.0
_ACROSS = (APRON_END_M - 0.2, PARKING_X_M + 4.2)
"""x before and behind the row of parked cars."""


class Journey(NamedTuple):
    """A way with its times: knots ``time_s`` (K,) and ``place_m`` (K, 2); which of the K - 1 legs go backwards."""

    time_s: NDArray[np.float64]
    place_m: Points
    backwards: NDArray[np.bool_]

    def at(self, time_s: NDArray[np.float64]) -> tuple[Points, NDArray[np.float64], NDArray[np.float64]]:
        """Return places (F, 2), headings (F,) and speeds (F,) at times (F,); at rest one keeps one's heading."""
        x, y = (np.interp(time_s, self.time_s, column) for column in self.place_m.T)
        step, lasts = np.diff(self.place_m, axis=0), np.diff(self.time_s)
        length = np.hypot(*step.T)
        moves = np.flatnonzero(length > 1e-9)
        heading = np.arctan2(step[moves, 1], step[moves, 0]) + np.pi * self.backwards[moves]
        leg = np.clip(np.searchsorted(self.time_s, time_s, "right") - 1, 0, len(lasts) - 1)
        latest = np.clip(np.searchsorted(moves, leg, "right") - 1, 0, len(moves) - 1)
        is_on_way = (time_s >= self.time_s[0]) & (time_s < self.time_s[-1])
        speed = np.where(is_on_way, (length / np.maximum(lasts, 1e-9))[leg], 0.0)
        return np.column_stack([x, y]), heading[latest], speed


def journey(
    points_m: Sequence[tuple[float, float]] | Points,
    speed_mps: float,
    start_s: float,
    pauses_s: Mapping[int, float] | None = None,
    backwards: bool = False,
) -> Journey:
    """Return a way through points (n, 2) at one speed, with pauses at some of them, by index."""
    points = np.asarray(points_m, dtype=float)
    time, knots, places = start_s, [start_s], [points[0]]
    for k, point in enumerate(points):
        if k > 0:
            time += float(np.hypot(*(point - points[k - 1]))) / speed_mps
            knots.append(time)
            places.append(point)
        if pauses_s and k in pauses_s:
            time += pauses_s[k]
            knots.append(time)
            places.append(point)
    return Journey(np.array(knots), np.array(places), np.full(len(knots) - 1, backwards))


def then(first: Journey, second: Journey) -> Journey:
    """Return one way after the other, with a rest between where the second starts later."""
    return Journey(
        np.concatenate([first.time_s, second.time_s]),
        np.concatenate([first.place_m, second.place_m]),
        np.concatenate([first.backwards, [False], second.backwards]),
    )


def rounded(points_m: Sequence[tuple[float, float]], times: int = 3) -> Points:
    """Return a polyline with its corners cut off ``times`` times at a quarter of each side (Chaikin 1974)."""
    points = np.asarray(points_m, dtype=float)
    for _ in range(times):
        a, b = points[:-1], points[1:]
        cut = np.stack([0.75 * a + 0.25 * b, 0.25 * a + 0.75 * b], axis=1).reshape(-1, 2)
        points = np.concatenate([points[:1], cut[1:-1], points[-1:]])
    return points


def gate(rng: np.random.Generator) -> list[tuple[float, float]]:
    """Draw a way in on foot: points from outside the watched volume to where one is on the site.

    Doors of sheds, both ends of the quay and of the lane, and the road between the sheds.
    """
    kind = int(rng.choice(4, p=[0.35, 0.25, 0.15, 0.25]))
    side = float(rng.choice([-1.0, 1.0]))
    if kind == 0:
        shed = SHEDS[int(rng.integers(len(SHEDS)))]
        inner = [y for y in shed.doors_y_m if abs(y) < 20.0]
        y = inner[int(rng.integers(len(inner)))]
        return [(SHED_X_M + 1.5, y), (SHED_X_M - 0.8, y), (rng.uniform(31.0, 36.0), y + rng.uniform(-1.0, 1.0))]
    if kind == 3:
        far = (_BEHIND_SHEDS_X_M, GAP_Y_M + side * 12.0)
        return [
            far,
            (_BEHIND_SHEDS_X_M - 1.0, GAP_Y_M + 2.0 * side),
            (SHED_X_M - 2.0, GAP_Y_M + rng.uniform(-3.0, 3.0)),
        ]
    x = rng.uniform(WALL_X_M + 1.8, 9.0) if kind == 1 else rng.uniform(21.5, 33.0)
    border = side * border_y_m(x)
    return [(x, border), (x + rng.uniform(-0.5, 0.5), border - side * rng.uniform(7.0, 12.0))]


def place_on_site(rng: np.random.Generator) -> tuple[float, float]:
    """Draw a place where people go: the quay's edge, the apron, between parked cars, the lane, before the sheds."""
    kind = int(rng.choice(5, p=[0.3, 0.25, 0.15, 0.15, 0.15]))
    if kind == 2:
        return (rng.uniform(PARKING_X_M - 2.5, PARKING_X_M + 3.0), corridor_y(rng.uniform(-14.0, 14.0)))
    low, high = (
        (WALL_X_M + 1.8, WALL_X_M + 2.6),
        (-7.5, 10.5),
        (0.0, 0.0),
        (21.0, 33.0),
        (40.0, 44.0),
    )[kind]
    half = 14.5 if kind < 3 else 15.5
    return (rng.uniform(low, high), rng.uniform(-half, half))


def corridor_y(y_m: float) -> float:
    """Return the nearest y between two parked cars."""
    between = np.array(PARKING_Y_M[:-1]) + 1.5
    return float(between[np.argmin(np.abs(between - y_m))])


def on_foot(places: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return a way through places that passes the row of parked cars only between two of them."""
    way = [places[0]]
    for there in places[1:]:
        way += [*_around_cars(way[-1], there), there]
    return way


def _around_cars(here: tuple[float, float], there: tuple[float, float]) -> list[tuple[float, float]]:
    """Return the ends of the corridors to take from a place to another, in order."""
    # 0 is the apron, 1 within the row, 2 the lane.
    zones = [int(x > _ACROSS[0]) + int(x > _ACROSS[1]) for x, _ in (here, there)]
    if zones == [1, 1]:
        return [] if here[1] == there[1] else [(_ACROSS[1], here[1]), (_ACROSS[1], there[1])]
    if zones[0] == zones[1]:
        return []
    if 1 in zones:
        y, outside = (here[1], zones[1]) if zones[0] == 1 else (there[1], zones[0])
        return [(_ACROSS[0] if outside == 0 else _ACROSS[1], y)]
    y = corridor_y(0.5 * (here[1] + there[1]))
    ends = [(x, y) for x in _ACROSS]
    return ends if zones[0] == 0 else ends[::-1]


def into_bay(bay_y_m: float, side: float) -> Points:
    """Return a car's way from the end of the lane on a side (1 = left) into a bay, where it stands facing the sea."""
    return rounded(
        [
            (LANE_X_M, side * border_y_m(LANE_X_M)),
            (LANE_X_M, bay_y_m + side * 6.5),
            (LANE_X_M - 0.5, bay_y_m + side * 1.0),
            (PARKING_X_M + 4.5, bay_y_m),
            (PARKING_X_M, bay_y_m),
        ]
    )


def out_of_bay(bay_y_m: float, side: float) -> tuple[Points, Points]:
    """Return the way backwards into the lane, and the way on to the lane's end on a side."""
    turned = (LANE_X_M, bay_y_m - side * 6.0)
    back = rounded(
        [(PARKING_X_M, bay_y_m), (PARKING_X_M + 5.0, bay_y_m), (LANE_X_M - 0.5, bay_y_m - side * 1.0), turned]
    )
    return back, np.array([turned, (LANE_X_M, side * border_y_m(LANE_X_M))])


def across_apron(first_y_m: float, last_y_m: float, place: tuple[float, float], side: float) -> tuple[Points, Points]:
    """Return a car's ways from the lane's end on a side to a place on the apron, and away to the other end, both ahead.

    It comes through one open bay and leaves through another; on the apron it drives along the quay.
    """
    ahead = float(np.sign(last_y_m - first_y_m))
    border, (x, y) = border_y_m(LANE_X_M), place
    towards = [
        (LANE_X_M, side * border),
        (LANE_X_M, first_y_m + side * 6.5),
        (LANE_X_M - 0.5, first_y_m + side * 1.0),
        (PARKING_X_M + 4.5, first_y_m),
        (APRON_END_M - 2.0, first_y_m),
        (x, y - ahead * 5.0),
        place,
    ]
    away = [
        place,
        (x, y + ahead * 5.0),
        (APRON_END_M - 2.0, last_y_m),
        (PARKING_X_M + 4.5, last_y_m),
        (LANE_X_M - 0.5, last_y_m - side * 1.0),
        (LANE_X_M, last_y_m - side * 6.5),
        (LANE_X_M, -side * border),
    ]
    return rounded(towards), rounded(away)


def past(x_m: float, side: float) -> Points:
    """Return a boat's way along the fairway, from a side to the other."""
    border = border_y_m(x_m, beyond_m=9.0)
    drift = 0.3 * (FAIRWAY_X_M[1] - FAIRWAY_X_M[0])
    return rounded([(x_m, side * border), (x_m + drift, 0.0), (x_m, -side * border)])


def alongside(x_m: float, berth: tuple[float, float], heading_rad: float) -> tuple[Points, Points]:
    """Return a boat's ways to a berth along the wall, and away from it, both ahead."""
    ahead = float(np.sign(np.sin(heading_rad)))
    border = border_y_m(x_m, beyond_m=9.0)
    x, y = berth
    towards = [
        (x_m, -ahead * border),
        (x_m, y - ahead * 15.0),
        (x - 2.5, y - ahead * 7.0),
        (x - 0.2, y - ahead * 2.5),
        berth,
    ]
    away = [berth, (x - 1.2, y + ahead * 3.0), (x_m, y + ahead * 12.0), (x_m, ahead * border)]
    return rounded(towards), rounded(away)
