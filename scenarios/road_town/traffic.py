"""Traffic: cars move along their routes, keep their distance and share crossings.

Speeds follow the intelligent driver model (Treiber, Hennecke, Helbing 2000), limited by the bends ahead, or the
model of ``gipps``. One car at a time uses a crossing, first come, first served; some cars stop there first.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from scenarios.road_town import gipps
from scenarios.road_town.route import POINT_SPACING_M, Route, Routes

_APART_M = 2.6
"""Two cars pass each other on ways that are so far apart."""
_SAME_LINE_M = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Approach:
    """A car at a crossing.

    Attributes:
        car: index. node: of the crossing.
        line_m: distance from its front to where the crossing begins; negative beyond that.
        is_first: whether no other car stands in between.
        way_m: (K, 2) points of its way over the crossing, from the line on.
    """

    car: int
    node: int
    line_m: float
    is_first: bool
    way_m: NDArray[np.float64]

    def is_in_the_way_of(self, other: Approach) -> bool:
        """Return whether two cars would meet; one that follows another over the same line keeps its distance."""
        if np.linalg.norm(self.way_m[0] - other.way_m[0]) < _SAME_LINE_M:
            return False
        return bool(np.linalg.norm(self.way_m[:, None] - other.way_m, axis=2).min() < _APART_M)


class Crossings:
    """All crossings of a town: a car waits until all that came before it, and are in its way, have left."""

    def __init__(self, at_start: Sequence[Approach]) -> None:
        """Begin with the cars that are near a crossing at frame 0, those that are furthest over the line first."""
        # Node → car → its approach, and the cars for which it waits.
        self._came: defaultdict[int, dict[int, tuple[Approach, list[int]]]] = defaultdict(dict)
        for approach in sorted(at_start, key=lambda each: each.line_m):
            self.may_enter(approach)

    def may_enter(self, approach: Approach) -> bool:
        """Return whether a car near the crossing may drive on; called for it on every frame.

        A car behind another one is not registered yet, or both would wait for each other.
        """
        came = self._came[approach.node]
        if approach.car not in came:
            if not approach.is_first:
                return False
            waits_for = [car for car, (before, _) in came.items() if before.is_in_the_way_of(approach)]
            came[approach.car] = (approach, waits_for)
        return not any(car in came for car in came[approach.car][1])

    def leave(self, car: int, node: int) -> None:
        """Give the crossing to other cars."""
        self._came[node].pop(car, None)


LATERAL_ACCELERATION_MPS2 = 2.2
BRAKING_MPS2 = 2.5
ACCELERATION_MPS2 = 1.8
HARDEST_BRAKING_MPS2 = 5.0
TIME_GAP_S = 1.2
STANDSTILL_GAP_M = 2.5
SLOWEST_LIMIT_MPS = 2.0
HALTS_BELOW_MPS, PASSED_STOP_M = 0.3, 2.0
"""A car below this speed close to its stop waits; a car this far beyond its stop has passed it."""
_CAR_LENGTH_M = 4.8
_NEAR_CROSSING_M = 8.0
_LOOK_AHEAD_M = np.arange(1.0, 42.0, 1.5)
_HERE_AND_AHEAD_M = np.concatenate([[0.0], _LOOK_AHEAD_M])
_SAME_LANE_M = 1.7


@dataclass(frozen=True, eq=False)
class Driver:
    """The plan of one car.

    Attributes:
        route: the path.
        start_m: arc length at frame 0.
        cruise_mps: speed on a free straight.
        stops: (arc length, seconds) of halts, in order.
        start_mps: speed at frame 0; None for the highest one that the bends allow.
    """

    route: Route
    start_m: float
    cruise_mps: float
    stops: tuple[tuple[float, float], ...] = ()
    start_mps: float | None = None


@dataclass(frozen=True, eq=False)
class Motion:
    """Motion of N cars over T frames.

    Attributes:
        position_m: (T, N, 2). heading_rad: (T, N). speed_mps: (T, N). arc_m: (T, N), along each car's route.
    """

    position_m: NDArray[np.float64]
    heading_rad: NDArray[np.float64]
    speed_mps: NDArray[np.float64]
    arc_m: NDArray[np.float64]

    @cached_property
    def T_world_car(self) -> NDArray[np.float64]:
        """Poses (T, N, 4, 4): origin on the ground under the car's centre, x forward. Read only."""
        poses = np.zeros((*self.heading_rad.shape, 4, 4))
        c, s = np.cos(self.heading_rad), np.sin(self.heading_rad)
        poses[..., 0, 0], poses[..., 0, 1], poses[..., 1, 0], poses[..., 1, 1] = c, -s, s, c
        poses[..., :2, 3] = self.position_m
        poses[..., 2, 2] = poses[..., 3, 3] = 1.0
        return poses


def simulate(
    drivers: list[Driver],
    frame_count: int,
    rate_hz: float,
    model: Literal["idm", "gipps"] = "idm",
) -> Motion:
    """Return the motion of all cars over ``frame_count`` frames.

    Args:
        model: sets their speeds.
    """
    state = (State if model == "idm" else GippsState)(drivers)
    arcs, speeds = np.empty((2, frame_count, len(drivers)))
    for frame in range(frame_count):
        arcs[frame], speeds[frame] = state.arc_m, state.speed_mps
        state.step(1.0 / rate_hz)
    placed = [driver.route.at(arcs[:, car]) for car, driver in enumerate(drivers)]
    return Motion(
        position_m=np.stack([position for position, _ in placed], axis=1),
        heading_rad=np.stack([heading for _, heading in placed], axis=1),
        speed_mps=speeds,
        arc_m=arcs,
    )


def speed_limit_mps(route: Route, cruise_mps: float) -> NDArray[np.float64]:
    """Return the highest speed (M,) at each point of a route that the bends there and ahead allow."""
    curvature = np.maximum(np.abs(route.curvature_per_m()), 1e-6)
    limit = np.minimum(cruise_mps, np.sqrt(LATERAL_ACCELERATION_MPS2 / curvature))
    limit = np.maximum(limit, SLOWEST_LIMIT_MPS)
    # v² may fall by 2 a ds from point to point: the running minimum of v² + 2 a s, taken from the far end.
    energy = limit**2 + 2 * BRAKING_MPS2 * POINT_SPACING_M * np.arange(len(limit))
    energy = np.minimum.accumulate(energy[::-1])[::-1]
    return np.sqrt(np.maximum(energy - 2 * BRAKING_MPS2 * POINT_SPACING_M * np.arange(len(limit)), 0.0))


@dataclass(eq=False)
class State:
    """Places and speeds of all cars, and which may enter each crossing."""

    drivers: list[Driver]
    arc_m: NDArray[np.float64] = field(init=False)
    speed_mps: NDArray[np.float64] = field(init=False)

    def __post_init__(self) -> None:
        self.limits = [speed_limit_mps(d.route, d.cruise_mps) for d in self.drivers]
        self.places = [np.arange(len(limits), dtype=float) for limits in self.limits]
        self.routes = Routes([driver.route for driver in self.drivers])
        self.lengths_m = np.array([driver.route.length_m for driver in self.drivers])
        self.arc_m = np.array([d.start_m for d in self.drivers])
        limits = [self._limit(car) for car in range(len(self.drivers))]
        self.speed_mps = np.array(
            [
                limit if d.start_mps is None else min(d.start_mps, limit)
                for d, limit in zip(self.drivers, limits, strict=True)
            ]
        )
        self.next_passage = [sum(p.leave_m <= d.start_m for p in d.route.passages) for d in self.drivers]
        self.stops = [list(d.stops) for d in self.drivers]
        self.waited_s = np.zeros(len(self.drivers))
        self.half_m = np.full(len(self.drivers), 0.5 * _CAR_LENGTH_M)
        self._begin()

    def _begin(self) -> None:
        """Let those into crossings that are at one."""
        self.ways_m: dict[tuple[int, int], NDArray[np.float64]] = {}
        self.crossings = Crossings(self._near_crossings())

    def step(self, dt_s: float) -> None:
        free_m = self._gap_to_cars()
        for car in range(len(self.drivers)):
            crossing_m = self._gap_to_crossing(car, free_m[car])
            free_m[car] = min(free_m[car], crossing_m, self._gap_to_stop(car, dt_s))
        speed = self.speed_mps
        self.speed_mps = np.maximum(speed + self._acceleration(free_m) * dt_s, 0.0)
        self.arc_m = np.minimum(self.arc_m + 0.5 * (speed + self.speed_mps) * dt_s, self.lengths_m)

    def _acceleration(self, free_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the acceleration (N,) of every car with a free distance (N,) ahead of it."""
        limit = np.array([self._limit(car) for car in range(len(self.drivers))])
        wanted_gap = STANDSTILL_GAP_M + self.speed_mps * TIME_GAP_S
        acceleration = ACCELERATION_MPS2 * (
            1 - (self.speed_mps / np.maximum(limit, 0.5)) ** 4 - (wanted_gap / np.maximum(free_m, 0.3)) ** 2
        )
        return np.clip(acceleration, -HARDEST_BRAKING_MPS2, ACCELERATION_MPS2)

    def _limit(self, car: int) -> float:
        return float(np.interp(self.arc_m[car] / POINT_SPACING_M, self.places[car], self.limits[car]))

    def _gap_to_cars(self) -> NDArray[np.float64]:
        """Return the free distance (N,) to the next car on each car's path."""
        path = self.routes.at(self.arc_m[:, None] + _HERE_AND_AHEAD_M)
        here, ahead = path[:, 0], path[:, 1:]
        # (N, N, K): the places of cars last would make rows too short for fast loops.
        across, along = (ahead[:, None, :, k] - here[None, :, k, None] for k in range(2))
        near = np.sqrt(across * across + along * along) < _SAME_LANE_M
        near[np.arange(len(here)), np.arange(len(here))] = False
        blocked: NDArray[np.bool_] = np.asarray(near.any(axis=1))
        first = np.where(blocked.any(axis=1), _LOOK_AHEAD_M[np.argmax(blocked, axis=1)], np.inf)
        return first - _CAR_LENGTH_M

    def _gap_to_crossing(self, car: int, free_m: float) -> float:
        """Return the distance to a crossing that the car may not enter; ``free_m`` is that to the next car."""
        approach = self._approach(car, free_m)
        if approach is None or self.crossings.may_enter(approach):
            return np.inf
        return approach.line_m + STANDSTILL_GAP_M

    def _approach(self, car: int, free_m: float) -> Approach | None:
        """Return the car's approach to a crossing, None if it is near none; leave those that it has passed."""
        passages, arc = self.drivers[car].route.passages, self.arc_m[car]
        while self.next_passage[car] < len(passages):
            passage = passages[self.next_passage[car]]
            if arc <= passage.leave_m + 0.6 * _CAR_LENGTH_M:
                line_m = passage.enter_m - arc - 0.5 * _CAR_LENGTH_M
                near = line_m < _NEAR_CROSSING_M + self.speed_mps[car] ** 2 / (2 * BRAKING_MPS2)
                return Approach(car, passage.node, line_m, free_m > line_m, self._way_m(car)) if near else None
            self.crossings.leave(car, passage.node)
            self.next_passage[car] += 1
        return None

    def _way_m(self, car: int) -> NDArray[np.float64]:
        """Return points (K, 2) of a car's way over its next crossing."""
        route, k = self.drivers[car].route, self.next_passage[car]
        if (car, k) not in self.ways_m:
            passage = route.passages[k]
            self.ways_m[car, k] = route.at(np.arange(passage.enter_m, passage.leave_m + _CAR_LENGTH_M, 1.0))[0]
        return self.ways_m[car, k]

    def _near_crossings(self) -> list[Approach]:
        free_m = self._gap_to_cars()
        found = (self._approach(car, free_m[car]) for car in range(len(self.drivers)))
        return [approach for approach in found if approach is not None]

    def _gap_to_stop(self, car: int, dt_s: float) -> float:
        """Return the distance to the car's next stop."""
        if not self.stops[car]:
            return np.inf
        place_m, seconds = self.stops[car][0]
        gap = place_m - self.arc_m[car] - self.half_m[car]
        if self.speed_mps[car] < HALTS_BELOW_MPS and gap < 2 * STANDSTILL_GAP_M:
            self.waited_s[car] += dt_s
        if self.waited_s[car] >= seconds or gap < -PASSED_STOP_M:
            self.stops[car].pop(0)
            self.waited_s[car] = 0.0
            return np.inf
        return max(gap, 0.0) + STANDSTILL_GAP_M


@dataclass(eq=False)
class GippsState(State):
    """The same with the speeds of ``gipps``."""

    def __post_init__(self) -> None:
        self.bends = [gipps.bend_speeds_mps(d.route, d.cruise_mps) for d in self.drivers]
        super().__post_init__()

    def _acceleration(self, free_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the acceleration (N,) of every car with a free distance (N,) ahead of it."""
        cruise = np.array([driver.cruise_mps for driver in self.drivers])
        safe = np.array(
            [gipps.speed_for_bends_mps(*each) for each in zip(self.bends, self.arc_m, self.speed_mps, strict=True)]
        )
        return gipps.acceleration_mps2(self.speed_mps, cruise, safe, free_m - STANDSTILL_GAP_M)
