"""Traffic whose bodies never touch, of vehicles of any length.

Every vehicle holds a stretch of its path: from where it is to where it can stop, braking as hard as it can. No two
stretches touch, at first and ever after: a vehicle lengthens its own only over free ground, and where the ground is not
free it brakes, which keeps it inside the stretch that it has. (Collision-free following from a known braking
distance is Gipps' idea, 1981; here it holds in the plane, for all bodies.)

On a crossing, and where a way leaves or joins a lane, nobody may have to wait: a vehicle enters with all of the way
beyond it in its hands, or behind another one that drives ahead on the same way. So nobody stands in another's way for
good, but for rings of waiting vehicles, out of which one is taken.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scenarios.road_town.route import POINT_SPACING_M, Excursion, Passage, Route
from scenarios.road_town.traffic import (
    BRAKING_MPS2,
    STANDSTILL_GAP_M,
    Driver,
    GippsState,
    Motion,
    State,
    speed_limit_mps,
)

WHEELBASE_SHARE = 0.55
"""Distance of the axles as a share of a vehicle's length: 2.6 m of 4.7 m, 6.6 m of a bus of 12 m."""
APART_M = 0.3
"""Vehicles keep further apart than this, anywhere."""
_STEP_M = 0.5
"""Bodies on a way are looked at so often; between two of them a corner moves by less than half of ``APART_M``."""
BRAKING_TO_STOP_MPS2 = 6.0
"""Harder than any driver brakes of its own accord."""
_BEFORE_LINE_M = 0.5
_JOINS_OVER_M = 13.0
"""Length of the stretch over which an excursion leaves the lane, or comes back to it."""
_SEEN_M = 45.0
_NEAR_ZONE_M = 8.0
_FOLLOWS_FROM_MPS, _FOLLOWS_WITHIN_M = 3.0, 60.0
_SAME_WAY_M = 1.0
_COMES_NEARER_M = 2.0
"""More than the way of a frame, and what the stretch grows by in it."""
_LOOKS_EVERY, _STUCK_S, _STANDS_MPS = 15, 2.0, 0.3


def body_route(route: Route, length_m: float) -> Route:
    """Return the path of a vehicle's centre, with the vehicle's heading, at the same arc lengths.

    Both axles run along the route, so that the middle of a long vehicle cuts a bend and its ends swing out.
    """
    points, n = route.points_m, max(round(0.5 * WHEELBASE_SHARE * length_m / POINT_SPACING_M), 1)
    steps = np.arange(n, 0, -1)[:, None]
    before = points[0] - steps * (points[1] - points[0])
    beyond = points[-1] + steps[::-1] * (points[-1] - points[-2])
    line = np.concatenate([before, points, beyond])
    rear, front = line[: -2 * n], line[2 * n :]
    along = front - rear
    return Route(0.5 * (rear + front), np.unwrap(np.arctan2(along[:, 1], along[:, 0])), route.passages)


class Bodies:
    """N vehicles, each of one size on its own path, as rectangles (x, y, heading, half length, half width)."""

    def __init__(self, paths: list[Route], size_m: NDArray[np.float64]) -> None:
        """``paths``: see ``body_route``. ``size_m``: (N, 2 or more) length and width."""
        self._path = np.concatenate([np.column_stack([path.points_m, path.heading_rad]) for path in paths])
        self._count = np.array([len(path.points_m) for path in paths])
        self._first = np.cumsum(self._count) - self._count
        self._half_m = 0.5 * size_m[:, :2] + 0.5 * APART_M

    def along(self, car: int, from_m: float, to_m: float) -> NDArray[np.float64]:
        """Return the rectangles (K, 5) of a vehicle on a stretch of its path, widened by half of ``APART_M``."""
        return _along(self._path, self._first[car], self._count[car], self._half_m[car], from_m, to_m)

    def first_in_the_way(
        self,
        car: int,
        stretch_m: tuple[float, float],
        from_m: NDArray[np.float64],
        to_m: NDArray[np.float64],
        ignored: NDArray[np.bool_],
    ) -> int:
        """Return a vehicle whose stretch (N,) of its path touches the given one of ``car``; -1 if there is none."""
        mine = self.along(car, *stretch_m)
        return int(_first_touched(mine, car, self._path, self._first, self._count, self._half_m, from_m, to_m, ignored))

    def free_ahead(self, arc_m: NDArray[np.float64], reach_m: float) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """Return how far (N,) every vehicle is free ahead, inf beyond the reach, and the vehicle there or -1."""
        return _free_ahead(self._path, self._first, self._count, self._half_m, arc_m, reach_m)


@dataclass(frozen=True)
class Zone:
    """A stretch of a path on which a vehicle must not have to wait.

    Attributes:
        from_m, to_m: arc lengths of the vehicle's middle.
        passages: crossings that it leads over.
    """

    from_m: float
    to_m: float
    passages: tuple[Passage, ...] = ()


def zones_of(route: Route, length_m: float, excursions: Sequence[Excursion] = ()) -> list[Zone]:
    """Return the zones of a vehicle's way, in order; those that leave no room for it in between are one."""
    before = 0.5 * length_m + _BEFORE_LINE_M
    found = [Zone(each.enter_m - before, each.leave_m + before, (each,)) for each in route.passages]
    for each in excursions:
        found.append(Zone(each.leave_m - before, each.leave_m + _JOINS_OVER_M + before))
        found.append(Zone(each.return_m - _JOINS_OVER_M - before, each.return_m + before))
    zones: list[Zone] = []
    for zone in sorted(found, key=lambda each: each.from_m):
        if zones and zone.from_m <= zones[-1].to_m:
            last = zones.pop()
            zone = Zone(last.from_m, max(last.to_m, zone.to_m), last.passages + zone.passages)
        zones.append(zone)
    return zones


def held_m(arc_m: float, speed_mps: float, zones: Sequence[Zone]) -> float:
    """Return the arc length to which a vehicle holds its path: where it can stop, beyond zones that it is bound for."""
    end = arc_m + speed_mps**2 / (2 * BRAKING_TO_STOP_MPS2)
    for zone in zones:
        if zone.to_m > arc_m and zone.from_m < end:
            end = max(end, zone.to_m)
    return end


class Room:
    """Places at the start for vehicles whose stretches touch no other's."""

    def __init__(self) -> None:
        self._taken = np.empty((0, 5))

    def is_free(self, driver: Driver, size_m: NDArray[np.float64]) -> bool:
        """Return whether the stretch that a driver holds at the start touches no other that is taken."""
        return not any_touch(_first_stretch(driver, size_m, ()), self._taken)

    def take(self, driver: Driver, size_m: NDArray[np.float64], excursions: Sequence[Excursion] = ()) -> None:
        """Take this stretch; ``excursions`` are those of the driver's route."""
        self._taken = np.concatenate([self._taken, _first_stretch(driver, size_m, excursions)])


def _first_stretch(driver: Driver, size_m: NDArray[np.float64], excursions: Sequence[Excursion]) -> NDArray[np.float64]:
    """Return the rectangles (K, 5) of the stretch that a driver holds at the start, see ``Bodies.along``."""
    route, arc, length = driver.route, driver.start_m, float(size_m[0])
    limits = speed_limit_mps(route, driver.cruise_mps)
    speed = float(np.interp(arc / POINT_SPACING_M, np.arange(len(limits)), limits))
    speed = speed if driver.start_mps is None else min(speed, driver.start_mps)
    end = held_m(arc, speed, zones_of(route, length, excursions))
    return Bodies([body_route(route, length)], size_m[None]).along(0, arc, end)


def simulate_apart(
    drivers: Sequence[Driver],
    size_m: NDArray[np.float64],
    frame_count: int,
    rate_hz: float,
    model: Literal["idm", "gipps"] = "idm",
    excursions: Sequence[Excursion] = (),
) -> tuple[Motion, list[int]]:
    """Return the motion of vehicles, and which of them it is of: one of each ring of waiting ones is left out.

    Args:
        drivers: start where ``Room`` has let them; the first one is never left out.
        size_m: (N, 2 or more) length and width.
        excursions: of the first one.
    """
    kept = list(range(len(drivers)))
    while True:
        state = (_IdmApart if model == "idm" else _GippsApart)([drivers[car] for car in kept])
        state.prepare(size_m[kept], excursions, rate_hz)
        arcs, speeds = np.empty((2, frame_count, len(kept)))
        for frame in range(frame_count):
            arcs[frame], speeds[frame] = state.arc_m, state.speed_mps
            state.step(1.0 / rate_hz)
            if frame % _LOOKS_EVERY == 0:
                ring = state.ring()
                if ring:
                    del kept[max(ring)]
                    break
        else:
            return _motion(state.paths, arcs, speeds), kept


def _motion(paths: list[Route], arc_m: NDArray[np.float64], speed_mps: NDArray[np.float64]) -> Motion:
    """Return the motion of the middles of bodies, which is slower than that along the way where they cut bends."""
    placed = [path.at(arc_m[:, car]) for car, path in enumerate(paths)]
    for car, path in enumerate(paths):
        stretch = np.linalg.norm(np.gradient(path.points_m, POINT_SPACING_M, axis=0), axis=1)
        speed_mps[:, car] *= np.interp(arc_m[:, car] / POINT_SPACING_M, np.arange(len(stretch)), stretch)
    return Motion(
        position_m=np.stack([position for position, _ in placed], axis=1),
        heading_rad=np.stack([heading for _, heading in placed], axis=1),
        speed_mps=speed_mps,
        arc_m=arc_m,
    )


@dataclass(eq=False)
class _Apart(State):
    """Places and speeds of vehicles, and the stretches that they hold."""

    paths: list[Route] = field(init=False)

    def _begin(self) -> None:
        """Crossings are the zones' part here."""

    def prepare(self, size_m: NDArray[np.float64], excursions: Sequence[Excursion], rate_hz: float) -> None:
        """Take over the sizes; every vehicle holds its first stretch."""
        count = len(self.drivers)
        self.half_m = 0.5 * size_m[:, 0] + _BEFORE_LINE_M
        self.paths = [
            body_route(driver.route, length) for driver, length in zip(self.drivers, size_m[:, 0], strict=True)
        ]
        self._bodies = Bodies(self.paths, size_m)
        self._zones = [
            zones_of(driver.route, length, () if car else excursions)
            for car, (driver, length) in enumerate(zip(self.drivers, size_m[:, 0], strict=True))
        ]
        self._held_m = np.array([held_m(*each) for each in zip(self.arc_m, self.speed_mps, self._zones, strict=True)])
        # The first zone that a vehicle has not been let into.
        self._next_zone = [
            sum(zone.from_m < held for zone in zones) for zones, held in zip(self._zones, self._held_m, strict=True)
        ]
        self._asked_at = np.full(count, np.inf)
        self._waits_for = np.full(count, -1)
        self._stands_frames = np.zeros(count, int)
        self._stuck_frames = round(_STUCK_S * rate_hz)
        self._frame = 0

    def step(self, dt_s: float) -> None:
        free_m, waits_for = self._bodies.free_ahead(self.arc_m, _SEEN_M)
        self._waits_for = np.where(free_m < 2 * STANDSTILL_GAP_M, waits_for, -1)
        # Those that have waited longest ask first.
        for car in np.argsort(self._asked_at, kind="stable").tolist():
            free_m[car] = min(free_m[car], self._gap_to_zone(car), self._gap_to_stop(car, dt_s))
        wanted = np.maximum(self.speed_mps + self._acceleration(free_m) * dt_s, 0.0)
        for car in range(len(self.drivers)):
            self._move(car, float(wanted[car]), dt_s)
        self._stands_frames = np.where(self.speed_mps < _STANDS_MPS, self._stands_frames + 1, 0)
        self._frame += 1

    def ring(self) -> list[int]:
        """Return vehicles, without the first, that stand and wait for each other in a ring; none if there is none."""
        stuck = (self._stands_frames > self._stuck_frames) & (self._waits_for >= 0)
        for start in np.flatnonzero(stuck).tolist():
            way = [start]
            while stuck[way[-1]]:
                other = int(self._waits_for[way[-1]])
                if other in way:
                    return [car for car in way[way.index(other) :] if car]
                way.append(other)
        return []

    def _gap_to_zone(self, car: int) -> float:
        """Return the distance to a zone that the vehicle may not enter yet; let it in if all of the way is free."""
        zones, at = self._zones[car], self._next_zone[car]
        if at == len(zones):
            return np.inf
        zone, arc, speed = zones[at], float(self.arc_m[car]), float(self.speed_mps[car])
        gap = zone.from_m - arc
        if gap > _NEAR_ZONE_M + speed**2 / (2 * BRAKING_MPS2):
            return np.inf
        self._asked_at[car] = min(self._asked_at[car], self._frame)
        if not self._halts_before(car, zone):
            other, follows = self._in_the_way(car, zone)
            if other < 0 and not follows:
                self._held_m[car] = max(self._held_m[car], zone.to_m)
                self._let_in(car)
                return self._gap_to_zone(car)
            if other < 0:
                if gap < speed**2 / (2 * BRAKING_TO_STOP_MPS2) + _COMES_NEARER_M:
                    self._let_in(car)
                return np.inf
            self._waits_for[car] = other
        return max(gap, 0.0) + STANDSTILL_GAP_M

    def _let_in(self, car: int) -> None:
        self._next_zone[car] += 1
        self._asked_at[car] = np.inf

    def _halts_before(self, car: int, zone: Zone) -> bool:
        return bool(self.stops[car]) and self.stops[car][0][0] < zone.to_m

    def _in_the_way(self, car: int, zone: Zone) -> tuple[int, bool]:
        """Return a vehicle on the way to a zone's end, -1 if there is none; and whether others lead there."""
        ignored = np.zeros(len(self.drivers), bool)
        stretch = max(float(self._held_m[car]), float(self.arc_m[car])), zone.to_m
        while True:
            other = self._bodies.first_in_the_way(car, stretch, self.arc_m, self._held_m, ignored)
            if other < 0 or not self._leads(other, car, zone):
                return other, bool(ignored.any())
            ignored[other] = True

    def _leads(self, other: int, car: int, zone: Zone) -> bool:
        """Return whether another vehicle drives ahead on the same way over the crossings of a zone."""
        if not zone.passages or self.speed_mps[other] < _FOLLOWS_FROM_MPS:
            return False
        first, last = zone.passages[0], zone.passages[-1]
        before_m = first.enter_m - self.arc_m[car]
        theirs = self.drivers[other].route
        for each in theirs.passages:
            beyond_m = self.arc_m[other] - each.enter_m
            if each.node == first.node and -before_m < beyond_m < _FOLLOWS_WITHIN_M:
                ours_m = self.drivers[car].route.at(np.array([first.enter_m, last.leave_m]))[0]
                theirs_m = theirs.at(each.enter_m + np.array([0.0, last.leave_m - first.enter_m]))[0]
                return bool(np.abs(theirs_m - ours_m).max() < _SAME_WAY_M)
        return False

    def _move(self, car: int, wanted_mps: float, dt_s: float) -> None:
        """Move a vehicle at the wanted speed if its stretch may be as long as that needs; else brake it."""
        speed, arc, held = float(self.speed_mps[car]), float(self.arc_m[car]), float(self._held_m[car])
        moved = min(arc + 0.5 * (speed + wanted_mps) * dt_s, float(self.lengths_m[car]))
        end = moved + wanted_mps**2 / (2 * BRAKING_TO_STOP_MPS2)
        if end > held and not self._may_hold(car, held, end):
            wanted_mps = speed - BRAKING_TO_STOP_MPS2 * dt_s
            moved = arc + 0.5 * (speed + wanted_mps) * dt_s
            if wanted_mps < 0.0:
                wanted_mps, moved = 0.0, arc + speed**2 / (2 * BRAKING_TO_STOP_MPS2)
            end = held
        self.speed_mps[car], self.arc_m[car] = wanted_mps, moved
        zones, at = self._zones[car], self._next_zone[car]
        # A zone that was entered is held to its end; else the stretch shrinks with the speed.
        inside = at > 0 and zones[at - 1].to_m <= held and moved < zones[at - 1].to_m
        self._held_m[car] = max(end, zones[at - 1].to_m) if inside else end

    def _may_hold(self, car: int, held_m: float, end_m: float) -> bool:
        zones, at = self._zones[car], self._next_zone[car]
        if at < len(zones) and end_m > zones[at].from_m:
            return False
        ignored = np.zeros(len(self.drivers), bool)
        other = self._bodies.first_in_the_way(car, (held_m, end_m), self.arc_m, self._held_m, ignored)
        if other >= 0:
            self._waits_for[car] = other
        return other < 0


@dataclass(eq=False)
class _IdmApart(_Apart):
    """With the speeds of the intelligent driver model."""


@dataclass(eq=False)
class _GippsApart(_Apart, GippsState):
    """With the speeds of ``gipps``."""


@njit(cache=True)
def any_touch(ours, theirs):
    """Return whether any rectangle (K, 5) touches any other (L, 5)."""
    for k in range(len(ours)):
        for other in range(len(theirs)):
            if _touch(ours[k], theirs[other]):
                return True
    return False


@njit(cache=True)
def _touch(a, b):
    """Return whether two rectangles touch: no axis of either separates them (Gottschalk 1996, in the plane)."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    reach = a[3] + a[4] + b[3] + b[4]
    if dx * dx + dy * dy > reach * reach:
        return False
    c, s = np.cos(b[2] - a[2]), np.sin(b[2] - a[2])
    ac, as_ = np.cos(a[2]), np.sin(a[2])
    bc, bs = np.cos(b[2]), np.sin(b[2])
    c, s = abs(c), abs(s)
    if abs(ac * dx + as_ * dy) > a[3] + c * b[3] + s * b[4]:
        return False
    if abs(-as_ * dx + ac * dy) > a[4] + s * b[3] + c * b[4]:
        return False
    if abs(bc * dx + bs * dy) > b[3] + c * a[3] + s * a[4]:
        return False
    return abs(-bs * dx + bc * dy) <= b[4] + s * a[3] + c * a[4]


@njit(cache=True)
def _place(path, first, count, half, arc, into):
    """Write the rectangle at an arc length, clamped to the path."""
    place = min(max(arc / POINT_SPACING_M, 0.0), count - 1.000001)
    index = int(place)
    share = place - index
    for k in range(3):
        low = path[first + index, k]
        into[k] = low + share * (path[first + index + 1, k] - low)
    into[3], into[4] = half[0], half[1]


@njit(cache=True)
def _along(path, first, count, half, from_m, to_m):
    steps = max(int(np.ceil((to_m - from_m) / _STEP_M)), 0)
    rectangles = np.empty((steps + 1, 5))
    for k in range(steps + 1):
        _place(path, first, count, half, min(from_m + k * _STEP_M, max(to_m, from_m)), rectangles[k])
    return rectangles


@njit(cache=True)
def _first_touched(mine, car, path, first, count, half, from_m, to_m, ignored):
    middle = mine[len(mine) // 2]
    reach = 0.0
    for k in range(len(mine)):
        reach = max(reach, np.hypot(mine[k, 0] - middle[0], mine[k, 1] - middle[1]))
    reach += half[car, 0] + half[car, 1]
    other = np.empty(5)
    for j in range(len(first)):
        if j == car or ignored[j]:
            continue
        _place(path, first[j], count[j], half[j], from_m[j], other)
        within = reach + half[j, 0] + half[j, 1] + max(to_m[j] - from_m[j], 0.0)
        if np.hypot(other[0] - middle[0], other[1] - middle[1]) > within:
            continue
        theirs = _along(path, first[j], count[j], half[j], from_m[j], to_m[j])
        if any_touch(mine, theirs):
            return j
    return -1


@njit(cache=True)
def _free_ahead(path, first, count, half, arc_m, reach_m):
    n = len(first)
    now = np.empty((n, 5))
    for j in range(n):
        _place(path, first[j], count[j], half[j], arc_m[j], now[j])
    free, blocker = np.full(n, np.inf), np.full(n, -1)
    ahead = np.empty(5)
    near = np.empty(n, np.int64)
    for i in range(n):
        found = 0
        for j in range(n):
            within = reach_m + half[i, 0] + half[i, 1] + half[j, 0] + half[j, 1]
            if j != i and np.hypot(now[j, 0] - now[i, 0], now[j, 1] - now[i, 1]) < within:
                near[found] = j
                found += 1
        k = 1
        while found and k * _STEP_M <= reach_m and blocker[i] < 0:
            _place(path, first[i], count[i], half[i], arc_m[i] + k * _STEP_M, ahead)
            for m in range(found):
                if _touch(ahead, now[near[m]]):
                    free[i], blocker[i] = (k - 1) * _STEP_M, near[m]
                    break
            k += 1
    return free, blocker
