"""The visits of an episode: people, cars and boats, with their times and places."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from scenarios.harbour.layout import FIXED, GAP_Y_M, OPEN_BAYS_Y_M, PARKING_Y_M, Site
from scenarios.harbour.presets import Harbour
from sim.meshes.person_parts import PersonLook
from sim.meshes.vehicle import CARS

Points = NDArray[np.float64]

_BEHIND_SHEDS_M = 18.0
_TRIES = 60


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


def gate(site: Site, rng: np.random.Generator) -> list[tuple[float, float]]:
    """Draw a way in on foot: points from outside the watched volume to where one is on the site.

    Doors of sheds, both ends of the quay and of the lane, and the road between the sheds.
    """
    for _ in range(_TRIES):
        way = _gate(site, rng)
        if all(map(site.is_clear, way)):
            break
    return way


def _gate(site: Site, rng: np.random.Generator) -> list[tuple[float, float]]:
    kind = int(rng.choice(4, p=[0.35, 0.25, 0.15, 0.25]))
    side = float(rng.choice([-1.0, 1.0]))
    if kind == 0:
        sheds = site.gate_sheds
        shed = sheds[int(rng.integers(len(sheds)))]
        inner = [y for y in shed.doors_y_m if abs(y) < 20.0]
        y = inner[int(rng.integers(len(inner)))]
        x = site.shed_x_m
        return [(x + 1.5, y), (x - 0.8, y), (rng.uniform(x - 15.0, x - 10.0), y + rng.uniform(-1.0, 1.0))]
    if kind == 3:
        far = (site.shed_x_m + _BEHIND_SHEDS_M, GAP_Y_M + side * 12.0)
        return [
            far,
            (site.shed_x_m + _BEHIND_SHEDS_M - 1.0, GAP_Y_M + 2.0 * side),
            (site.shed_x_m - 2.0, GAP_Y_M + rng.uniform(-3.0, 3.0)),
        ]
    on_apron, on_lane = (site.wall_x_m + 1.8, site.apron_end_m - 3.0), (site.parking_x_m + 5.0, site.shed_x_m - 13.0)
    x = rng.uniform(*on_apron) if kind == 1 else rng.uniform(*on_lane)
    border = side * site.border_y_m(x, side)
    return [(x, border), (x + rng.uniform(-0.5, 0.5), border - side * rng.uniform(7.0, 12.0))]


def place_on_site(site: Site, rng: np.random.Generator) -> tuple[float, float]:
    """Draw a place where people go: the quay's edge, the apron, between parked cars, the lane, before the sheds.

    It is one that the picture shows, if one of many is.
    """
    for _ in range(_TRIES):
        place = _somewhere(site, rng)
        if site.sees(place) and site.is_clear(place):
            break
    return place


def _somewhere(site: Site, rng: np.random.Generator) -> tuple[float, float]:
    kind = int(rng.choice(5, p=[0.3, 0.25, 0.15, 0.15, 0.15]))
    if kind == 2:
        return (
            rng.uniform(site.parking_x_m - 2.5, site.parking_x_m + 3.0),
            corridor_y(rng.uniform(0.5 - site.walks_y_m, site.walks_y_m - 0.5)),
        )
    low, high = (
        (site.wall_x_m + 1.8, site.wall_x_m + 2.6),
        (site.wall_x_m + 7.5, site.apron_end_m - 1.5),
        (0.0, 0.0),
        (site.parking_x_m + 4.5, site.shed_x_m - 13.0),
        (site.shed_x_m - 6.0, site.shed_x_m - 2.0),
    )[kind]
    half = site.walks_y_m if kind < 3 else site.walks_y_m + 1.0
    return (rng.uniform(low, high), rng.uniform(-half, half))


def corridor_y(y_m: float) -> float:
    """Return the nearest y between two parked cars."""
    between = np.array(PARKING_Y_M[:-1]) + 1.5
    return float(between[np.argmin(np.abs(between - y_m))])


def on_foot(site: Site, places: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return a way through places that passes the row of parked cars only between two of them, and around goods."""
    way = [places[0]]
    for there in places[1:]:
        for end in (*_around_cars(site, way[-1], there), there):
            way += [*_around_goods(site, way[-1], end), end]
    return way


def _around_goods(site: Site, here: tuple[float, float], there: tuple[float, float]) -> list[tuple[float, float]]:
    """Return the points beside goods that lie on the straight way from a place to another, in order."""
    way = [here, *_beside_goods(site, here, there, 0.65), there]
    # What is beside the one may lead through the next.
    legs = [[start, *_beside_goods(site, start, end, 0.0)] for start, end in pairwise(way)]
    return [place for leg in legs for place in leg][1:]


def _beside_goods(
    site: Site, here: tuple[float, float], there: tuple[float, float], margin_m: float
) -> list[tuple[float, float]]:
    start, way = np.array(here), np.subtract(there, here)
    length_m = float(np.hypot(*way))
    if length_m < 1e-6:
        return []
    ahead = way / length_m
    left, met = np.array([-ahead[1], ahead[0]]), []
    for x, y, radius in site.goods:
        along, aside = float(ahead @ ((x, y) - start)), float(left @ ((x, y) - start))
        if 0.0 < along < length_m and abs(aside) < radius + margin_m:
            beside = (x, y) - np.copysign(radius + 1.05, aside) * left
            met.append((along, (float(beside[0]), float(beside[1]))))
    return [point for _, point in sorted(met)]


def _around_cars(site: Site, here: tuple[float, float], there: tuple[float, float]) -> list[tuple[float, float]]:
    """Return the ends of the corridors to take from a place to another, in order."""
    # 0 is the apron, 1 within the row, 2 the lane.
    across = site.apron_end_m - 0.2, site.parking_x_m + 4.2
    zones = [int(x > across[0]) + int(x > across[1]) for x, _ in (here, there)]
    if zones == [1, 1]:
        return [] if here[1] == there[1] else [(across[1], here[1]), (across[1], there[1])]
    if zones[0] == zones[1]:
        return []
    if 1 in zones:
        y, outside = (here[1], zones[1]) if zones[0] == 1 else (there[1], zones[0])
        return [(across[0] if outside == 0 else across[1], y)]
    y = corridor_y(0.5 * (here[1] + there[1]))
    ends = [(x, y) for x in across]
    return ends if zones[0] == 0 else ends[::-1]


def into_bay(site: Site, bay_y_m: float, side: float) -> Points:
    """Return a car's way from the end of the lane on a side (1 = left) into a bay, where it stands facing the sea."""
    return rounded(
        [
            (site.lane_x_m, side * site.border_y_m(site.lane_x_m, side)),
            (site.lane_x_m, bay_y_m + side * 6.5),
            (site.lane_x_m - 0.5, bay_y_m + side * 1.0),
            (site.parking_x_m + 4.5, bay_y_m),
            (site.parking_x_m, bay_y_m),
        ]
    )


def out_of_bay(site: Site, bay_y_m: float, side: float) -> tuple[Points, Points]:
    """Return the way backwards into the lane, and the way on to the lane's end on a side."""
    turned = (site.lane_x_m, bay_y_m - side * 6.0)
    back = rounded(
        [
            (site.parking_x_m, bay_y_m),
            (site.parking_x_m + 5.0, bay_y_m),
            (site.lane_x_m - 0.5, bay_y_m - side * 1.0),
            turned,
        ]
    )
    return back, np.array([turned, (site.lane_x_m, side * site.border_y_m(site.lane_x_m, side))])


def across_apron(
    site: Site, first_y_m: float, last_y_m: float, place: tuple[float, float], side: float
) -> tuple[Points, Points]:
    """Return a car's ways from the lane's end on a side to a place on the apron, and away to the other end, both ahead.

    It comes through one open bay and leaves through another; on the apron it drives along the quay.
    """
    ahead = float(np.sign(last_y_m - first_y_m))
    ends, (x, y) = [one * site.border_y_m(site.lane_x_m, one) for one in (side, -side)], place
    towards = [
        (site.lane_x_m, ends[0]),
        (site.lane_x_m, first_y_m + side * 6.5),
        (site.lane_x_m - 0.5, first_y_m + side * 1.0),
        (site.parking_x_m + 4.5, first_y_m),
        (site.apron_end_m - 2.0, first_y_m),
        (x, y - ahead * 5.0),
        place,
    ]
    away = [
        place,
        (x, y + ahead * 5.0),
        (site.apron_end_m - 2.0, last_y_m),
        (site.parking_x_m + 4.5, last_y_m),
        (site.lane_x_m - 0.5, last_y_m - side * 1.0),
        (site.lane_x_m, last_y_m - side * 6.5),
        (site.lane_x_m, ends[1]),
    ]
    return rounded(towards), rounded(away)


def past(site: Site, x_m: float, side: float) -> Points:
    """Return a boat's way along the fairway, from a side to the other."""
    drift = 0.3 * (site.fairway_x_m[1] - site.fairway_x_m[0])
    return rounded([*site.at_sea(x_m, side)[::-1], (x_m + drift, 0.0), *site.at_sea(x_m, -side)])


def alongside(site: Site, x_m: float, berth: tuple[float, float], heading_rad: float) -> tuple[Points, Points]:
    """Return a boat's ways to a berth along the wall, and away from it, both ahead."""
    ahead = float(np.sign(np.sin(heading_rad)))
    x, y = berth
    towards = [
        *site.at_sea(x_m, -ahead)[::-1],
        (x_m, y - ahead * 15.0),
        (x - 2.5, y - ahead * 7.0),
        (x - 0.2, y - ahead * 2.5),
        berth,
    ]
    away = [berth, (x - 1.2, y + ahead * 3.0), (x_m, y + ahead * 12.0), *site.at_sea(x_m, ahead)]
    return rounded(towards), rounded(away)


_USUAL_CARS = 5
"""Cars that stand in bays on all days; each stands for one of the site's own."""
_GET_OUT_S, _GET_IN_S = (6.0, 14.0), (10.0, 25.0)
"""From the car's stop to its driver at its door; from the driver's getting in to the start."""
_BOAT_OFF_WALL_M = 0.6
_LEAVES_BEFORE_END_S = 60.0
"""A visit that would end later lasts to the end."""
SIZE_FACTORS = (0.8, 1.2)
"""True sizes of people, cars and boats vary by these."""


@dataclass(frozen=True, slots=True)
class Visit:
    """One appearance of a person, car or boat.

    Attributes:
        kind: ``person``, ``car`` or ``boat``.
        journey: where it is.
        begin_s, end_s: when it is there, maybe from before the first frame.
        engine_s: from when to when its engine runs, one row (2,) each; for people empty.
        is_cold: a car that is as warm as the level ground about it.
    """

    kind: str
    journey: Journey
    begin_s: float
    end_s: float
    engine_s: tuple[tuple[float, float], ...] = ()
    is_cold: bool = False


class _Stop(NamedTuple):
    """Where a car stops.

    Attributes:
        towards: its way there. door_m: where one stands at the driver's door.
        away: its ways on, and whether it drives them backwards.
    """

    towards: Points
    door_m: tuple[float, float]
    away: tuple[tuple[Points, bool], ...]


@dataclass(frozen=True, slots=True)
class CarLook:
    """A car's model, and the factors of its length, width and height."""

    model: str
    factors: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Plan:
    """A whole episode: V visits in order of their coming.

    Attributes:
        visits: (V,).
        buoys: how many boats lie at buoys on all days.
        usual_y_m: bays of cars that stand there on all days. before_y_m: of those that came before the first picture.
    """

    visits: tuple[Visit, ...]
    buoys: int
    usual_y_m: tuple[float, ...]
    before_y_m: tuple[float, ...]


def draw_plan(
    preset: Harbour, rng: np.random.Generator, day_rng: np.random.Generator | None = None, site: Site = FIXED
) -> Plan:
    """Draw an episode's visits; from ``day_rng``, None = the same, in which bays cars stand."""
    last_s = preset.frame_count / preset.rate_hz
    day_rng = rng if day_rng is None else day_rng
    bays = [y for y in PARKING_Y_M if abs(y) < 15.5 and y not in OPEN_BAYS_Y_M]
    bays = [bays[k] for k in day_rng.permutation(len(bays))]
    taken = tuple(bays[: preset.cars])
    others = [y for y in PARKING_Y_M if y not in OPEN_BAYS_Y_M and y not in taken]
    usual = tuple(sorted(others[k] for k in day_rng.permutation(len(others))[:_USUAL_CARS]))
    visits, people = _drives(site, preset, taken, last_s, rng)
    visits += _sails(site, preset, last_s, rng)
    visits += [_patrols(site, last_s, rng) for _ in range(preset.patrols)]
    visits += _walks(site, preset.people - preset.patrols - people, last_s, rng)
    visits = [replace(each, end_s=min(each.end_s, last_s + 1.0)) for each in visits]
    visits.sort(key=lambda each: each.begin_s)
    return Plan(tuple(visits), preset.buoys, usual, taken[: preset.cars_before])


def _drives(
    site: Site, preset: Harbour, bays: tuple[float, ...], last_s: float, rng: np.random.Generator
) -> tuple[list[Visit], int]:
    """Return the cars with those who get out of them and into them, and the number of these people."""
    visits: list[Visit] = []
    people = 0
    for k, bay in enumerate(bays):
        spare = preset.people - preset.patrols - people
        if k < preset.cars_before:
            side = float(rng.choice([-1.0, 1.0]))
            came_s, (_, door, away) = -np.inf, _parking(site, bay, side)
            way = journey([(site.parking_x_m + 0.1, bay), (site.parking_x_m, bay)], 1.0, -1e4)
            engine = []
            leaves_s = last_s * rng.uniform(0.7, 0.88) if rng.random() < 0.4 else np.inf
            leaves_s = np.inf if k < preset.cars_without_contrast else leaves_s
        else:
            came_s = last_s * (0.04 + 0.55 * (k - preset.cars_before + rng.uniform(0.0, 0.5)) / preset.cars)
            side = float(rng.choice([-1.0, 1.0]))
            if k < preset.cars - preset.deliveries:
                towards, door, away = _parking(site, bay, side)
            else:
                towards, door, away = _delivery(site, side, rng)
            way = journey(towards, rng.uniform(2.8, 4.2), came_s)
            stopped_s = float(way.time_s[-1])
            if stopped_s + 60.0 < last_s and spare > 0:
                visits.append(_gets_out(site, door, stopped_s + rng.uniform(*_GET_OUT_S), rng))
                people += 1
                spare -= 1
            engine = [(-600.0 + came_s, stopped_s)]
            leaves_s = stopped_s + rng.uniform(*preset.car_stays_s)
        leaves = spare > 0 and leaves_s < last_s - _LEAVES_BEFORE_END_S
        if leaves:
            visits.append(_gets_in(site, door, leaves_s, rng))
            people += 1
            start_s = leaves_s + rng.uniform(*_GET_IN_S)
            for points, backwards in away:
                speed_mps = 1.3 if backwards else rng.uniform(3.0, 4.5)
                way = then(way, journey(points, speed_mps, start_s, backwards=backwards))
                start_s = float(way.time_s[-1]) + 2.0
            engine.append((leaves_s + 5.0, float(way.time_s[-1])))
        end_s = float(way.time_s[-1]) if leaves else np.inf
        visits.append(Visit("car", way, came_s, end_s, tuple(engine), k < preset.cars_without_contrast))
    return visits, people


def _parking(site: Site, bay_y_m: float, side: float) -> _Stop:
    back, on = out_of_bay(site, bay_y_m, side)
    return _Stop(into_bay(site, bay_y_m, side), _door((site.parking_x_m, bay_y_m), np.pi), ((back, True), (on, False)))


def _delivery(site: Site, side: float, rng: np.random.Generator) -> _Stop:
    first, last = OPEN_BAYS_Y_M[:: int(rng.choice([-1, 1]))]
    place = (rng.uniform(site.wall_x_m + 9.0, site.apron_end_m - 8.0), 0.5 * (first + last) + rng.uniform(-1.0, 1.0))
    towards, away = across_apron(site, first, last, place, side)
    return _Stop(towards, _door(place, 0.5 * np.pi * float(np.sign(last - first))), ((away, False),))


def _door(place: tuple[float, float], heading_rad: float) -> tuple[float, float]:
    """Return where one stands at the driver's door of a car, on its left."""
    ahead = np.array([np.cos(heading_rad), np.sin(heading_rad)])
    x, y = np.array(place) + 0.2 * ahead + 1.45 * np.array([-ahead[1], ahead[0]])
    return (float(x), float(y))


def _gets_out(site: Site, door: tuple[float, float], at_s: float, rng: np.random.Generator) -> Visit:
    way = on_foot(site, [door, *_sometimes_a_stop(site, rng), *gate(site, rng)[::-1]])
    return _person(way, at_s, rng)


def _gets_in(site: Site, door: tuple[float, float], at_s: float, rng: np.random.Generator) -> Visit:
    way = on_foot(site, [*gate(site, rng), *_sometimes_a_stop(site, rng), door])
    return _person(way, at_s, rng, arrives=True)


def _sometimes_a_stop(site: Site, rng: np.random.Generator) -> list[tuple[float, float]]:
    return [place_on_site(site, rng)] if rng.random() < 0.8 else []


def _person(
    way: list[tuple[float, float]],
    at_s: float,
    rng: np.random.Generator,
    *,
    pauses_s: dict[int, float] | None = None,
    arrives: bool = False,
) -> Visit:
    """Return a walk that starts at a time, or that arrives then."""
    made = journey(way, float(rng.uniform(0.9, 1.6)), at_s, pauses_s)
    if arrives:
        made = made._replace(time_s=made.time_s - (made.time_s[-1] - at_s))
    return Visit("person", made, float(made.time_s[0]), float(made.time_s[-1]))


def _walks(site: Site, count: int, last_s: float, rng: np.random.Generator) -> list[Visit]:
    """Return people on foot: some in pairs, one who stands still for five minutes if there is time."""
    visits: list[Visit] = []
    stands = int(count > 2 and last_s > 900.0)
    while len(visits) < count:
        share = (len(visits) + rng.random()) / count
        at_s = last_s * (0.92 * share if last_s > 900.0 else 0.35 * share)
        if stands > 0 and share > 0.2:
            stands -= 1
            visits.append(_stands(site, min(at_s, last_s - 500.0), rng))
            continue
        places = [place_on_site(site, rng) for _ in range(int(rng.integers(1, 4)))]
        way = on_foot(site, [*gate(site, rng), *places, *gate(site, rng)[::-1]])
        pauses = {k: float(rng.exponential(30.0)) for k in range(2, len(way) - 2) if rng.random() < 0.5}
        visits.append(_person(way, at_s, rng, pauses_s=pauses))
        if len(visits) < count and rng.random() < 0.25:
            visits.append(_beside(visits[-1], rng))
    return visits


def _patrols(site: Site, last_s: float, rng: np.random.Generator) -> Visit:
    """Return a person who walks about from before the first picture until after the last, with short stops."""
    speed_mps = float(rng.uniform(0.9, 1.5))
    way = [place_on_site(site, rng)]
    pauses_s: dict[int, float] = {}
    made = journey([way[0], way[0]], speed_mps, -1.0)
    while made.time_s[-1] <= last_s:
        way = on_foot(site, [*way, place_on_site(site, rng)])
        if rng.random() < 0.3:
            pauses_s[len(way) - 1] = float(rng.uniform(3.0, 12.0))
        made = journey(way, speed_mps, -1.0, pauses_s)
    return Visit("person", made, -1.0, float(made.time_s[-1]))


def _stands(site: Site, at_s: float, rng: np.random.Generator) -> Visit:
    """Return a person who goes to a place on the quay, stands there for five minutes and more, and goes away."""
    half = site.walks_y_m - 1.5
    for _ in range(_TRIES):
        place = (rng.uniform(site.wall_x_m + 1.8, site.apron_end_m - 7.0), rng.uniform(-half, half))
        if site.sees(place) and site.is_clear(place):
            break
    before, after = gate(site, rng), gate(site, rng)[::-1]
    way = on_foot(site, [*before, place])
    stood = len(way) - 1
    return _person([*way, *on_foot(site, [place, *after])[1:]], at_s, rng, pauses_s={stood: rng.uniform(300.0, 420.0)})


def _beside(other: Visit, rng: np.random.Generator) -> Visit:
    """Return who walks along, 0.45 m to a side and somewhat behind."""
    place_m, heading, _ = other.journey.at(other.journey.time_s)
    offset = 0.45 * float(rng.choice([-1.0, 1.0]))
    aside = place_m + offset * np.column_stack([-np.sin(heading), np.cos(heading)])
    late_s = float(rng.uniform(0.4, 1.5))
    made = other.journey._replace(place_m=aside, time_s=other.journey.time_s + late_s)
    return Visit("person", made, other.begin_s + late_s, other.end_s + late_s)


def _sails(site: Site, preset: Harbour, last_s: float, rng: np.random.Generator) -> list[Visit]:
    """Return boats that pass, or lie at the free berth for a while; the first does so if there is time."""
    visits = []
    count = preset.boats
    berth = next(each for each in site.berths if each.is_free)
    for k in range(count):
        at_s = last_s * (0.9 * (k + rng.uniform(0.1, 0.6)) / count if last_s > 900.0 else rng.uniform(0.0, 0.15))
        x, speed = float(rng.uniform(*site.fairway_x_m)), float(rng.uniform(1.0, 1.8))
        if k == 0 and last_s > 900.0 and rng.random() < 0.6:
            place = (site.wall_x_m - _BOAT_OFF_WALL_M - 1.4, berth.y_m)
            towards, away = alongside(site, x, place, berth.heading_rad)
            way = journey(towards, speed, at_s)
            arrived_s = float(way.time_s[-1])
            stays_s = float(rng.uniform(*preset.boat_stays_s))
            way = then(way, journey(away, speed, arrived_s + stays_s))
            engine: tuple[tuple[float, float], ...] = (
                (-900.0 + at_s, arrived_s + 30.0),
                (arrived_s + stays_s - 60.0, float(way.time_s[-1])),
            )
        else:
            way = journey(past(site, x, float(rng.choice([-1.0, 1.0]))), speed, at_s)
            engine = ((-900.0 + at_s, float(way.time_s[-1])),)
        visits.append(Visit("boat", way, at_s, float(way.time_s[-1]), engine))
    return visits


def draw_person(rng: np.random.Generator) -> PersonLook:
    """Draw a person by size and cut; statures differ from 1.72 m by up to 20 %, girths from those of that stature."""
    return PersonLook(
        stature_m=1.72 * float(rng.uniform(*SIZE_FACTORS)),
        build=float(rng.uniform(*SIZE_FACTORS)),
        hair_style=rng.choice(["short", "long"]),
        sleeves=rng.choice(["long", "short"], p=[0.75, 0.25]),
        legwear=rng.choice(["trousers", "shorts"], p=[0.85, 0.15]),
        backpack_rgb=(0, 0, 0) if rng.random() < 0.2 else None,
    )


def draw_car(rng: np.random.Generator) -> CarLook:
    """Draw a car; its sizes differ from its model's by up to 20 %, models from each other by more."""
    model = str(rng.choice(CARS))
    length, width, height = (float(each) for each in rng.uniform(*SIZE_FACTORS, 3))
    return CarLook(model, (length, width, height))


def names_of(visits: tuple[Visit, ...]) -> Iterator[str]:
    """Yield names by kind in order: ``person-0`` …"""
    count: dict[str, int] = {}
    for each in visits:
        number = count.get(each.kind, 0)
        count[each.kind] = number + 1
        yield f"{each.kind}-{number}"
