"""Who comes, when, and where they are on every frame."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from scenarios.harbour import routes
from scenarios.harbour.layout import BERTHS, FAIRWAY_X_M, OPEN_BAYS_Y_M, PARKING_X_M, PARKING_Y_M, WALL_X_M
from scenarios.harbour.presets import Harbour
from scenarios.harbour.routes import Journey
from sim.meshes.person_parts import PersonLook
from sim.meshes.vehicle import VEHICLES

_USUAL_CARS = 5
"""Cars that stand in bays on all days; each stands for one of the site's own."""
_GET_OUT_S, _GET_IN_S = (6.0, 14.0), (10.0, 25.0)
"""From the car's stop to its driver at its door; from the driver's getting in to the start."""
_DELIVERED_X_M = (-6.0, 4.0)
_BOAT_OFF_WALL_M = 0.6
_LEAVES_BEFORE_END_S = 60.0
"""Who would leave later stays."""
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

    towards: routes.Points
    door_m: tuple[float, float]
    away: tuple[tuple[routes.Points, bool], ...]


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


def draw_plan(preset: Harbour, rng: np.random.Generator) -> Plan:
    """Draw an episode's visits."""
    last_s = preset.frame_count / preset.rate_hz
    bays = [y for y in PARKING_Y_M if abs(y) < 15.5 and y not in OPEN_BAYS_Y_M]
    bays = [bays[k] for k in rng.permutation(len(bays))]
    taken = tuple(bays[: preset.cars])
    others = [y for y in PARKING_Y_M if y not in OPEN_BAYS_Y_M and y not in taken]
    usual = tuple(sorted(others[k] for k in rng.permutation(len(others))[:_USUAL_CARS]))
    visits, people = _drives(preset, taken, last_s, rng)
    visits += _sails(preset, last_s, rng)
    visits += [_patrols(last_s, rng) for _ in range(preset.patrols)]
    visits += _walks(preset.people - preset.patrols - people, last_s, rng)
    visits = [replace(each, end_s=min(each.end_s, last_s + 1.0)) for each in visits]
    visits.sort(key=lambda each: each.begin_s)
    return Plan(tuple(visits), preset.buoys, usual, taken[: preset.cars_before])


def _drives(
    preset: Harbour, bays: tuple[float, ...], last_s: float, rng: np.random.Generator
) -> tuple[list[Visit], int]:
    """Return the cars with those who get out of them and into them, and the number of these people."""
    visits: list[Visit] = []
    people = 0
    for k, bay in enumerate(bays):
        spare = preset.people - preset.patrols - people
        if k < preset.cars_before:
            side = float(rng.choice([-1.0, 1.0]))
            came_s, (_, door, away) = -np.inf, _parking(bay, side)
            way = routes.journey([(PARKING_X_M + 0.1, bay), (PARKING_X_M, bay)], 1.0, -1e4)
            engine = []
            leaves_s = last_s * rng.uniform(0.7, 0.88) if rng.random() < 0.4 else np.inf
            leaves_s = np.inf if k < preset.cars_without_contrast else leaves_s
        else:
            came_s = last_s * (0.04 + 0.55 * (k - preset.cars_before + rng.uniform(0.0, 0.5)) / preset.cars)
            side = float(rng.choice([-1.0, 1.0]))
            if k < preset.cars - preset.deliveries:
                towards, door, away = _parking(bay, side)
            else:
                towards, door, away = _delivery(side, rng)
            way = routes.journey(towards, rng.uniform(2.8, 4.2), came_s)
            stopped_s = float(way.time_s[-1])
            if stopped_s + 60.0 < last_s and spare > 0:
                visits.append(_gets_out(door, stopped_s + rng.uniform(*_GET_OUT_S), rng))
                people += 1
                spare -= 1
            engine = [(-600.0 + came_s, stopped_s)]
            leaves_s = stopped_s + rng.uniform(*preset.car_stays_s)
        leaves = spare > 0 and leaves_s < last_s - _LEAVES_BEFORE_END_S
        if leaves:
            visits.append(_gets_in(door, leaves_s, rng))
            people += 1
            start_s = leaves_s + rng.uniform(*_GET_IN_S)
            for points, backwards in away:
                speed_mps = 1.3 if backwards else rng.uniform(3.0, 4.5)
                way = routes.then(way, routes.journey(points, speed_mps, start_s, backwards=backwards))
                start_s = float(way.time_s[-1]) + 2.0
            engine.append((leaves_s + 5.0, float(way.time_s[-1])))
        end_s = float(way.time_s[-1]) if leaves else np.inf
        visits.append(Visit("car", way, came_s, end_s, tuple(engine), k < preset.cars_without_contrast))
    return visits, people


def _parking(bay_y_m: float, side: float) -> _Stop:
    back, on = routes.out_of_bay(bay_y_m, side)
    return _Stop(routes.into_bay(bay_y_m, side), _door((PARKING_X_M, bay_y_m), np.pi), ((back, True), (on, False)))


def _delivery(side: float, rng: np.random.Generator) -> _Stop:
    first, last = OPEN_BAYS_Y_M[:: int(rng.choice([-1, 1]))]
    place = (rng.uniform(*_DELIVERED_X_M), 0.5 * (first + last) + rng.uniform(-1.0, 1.0))
    towards, away = routes.across_apron(first, last, place, side)
    return _Stop(towards, _door(place, 0.5 * np.pi * float(np.sign(last - first))), ((away, False),))


def _door(place: tuple[float, float], heading_rad: float) -> tuple[float, float]:
    """Return where one stands at the driver's door of a car, on its left."""
    ahead = np.array([np.cos(heading_rad), np.sin(heading_rad)])
    x, y = np.array(place) + 0.2 * ahead + 1.45 * np.array([-ahead[1], ahead[0]])
    return (float(x), float(y))


def _gets_out(door: tuple[float, float], at_s: float, rng: np.random.Generator) -> Visit:
    way = routes.on_foot([door, *_sometimes_a_stop(rng), *routes.gate(rng)[::-1]])
    return _person(way, at_s, rng)


def _gets_in(door: tuple[float, float], at_s: float, rng: np.random.Generator) -> Visit:
    way = routes.on_foot([*routes.gate(rng), *_sometimes_a_stop(rng), door])
    return _person(way, at_s, rng, arrives=True)


def _sometimes_a_stop(rng: np.random.Generator) -> list[tuple[float, float]]:
    return [routes.place_on_site(rng)] if rng.random() < 0.8 else []


def _person(
    way: list[tuple[float, float]],
    at_s: float,
    rng: np.random.Generator,
    *,
    pauses_s: dict[int, float] | None = None,
    arrives: bool = False,
) -> Visit:
    """Return a walk that starts at a time, or that arrives then."""
    made = routes.journey(way, float(rng.uniform(0.9, 1.6)), at_s, pauses_s)
    if arrives:
        made = made._replace(time_s=made.time_s - (made.time_s[-1] - at_s))
    return Visit("person", made, float(made.time_s[0]), float(made.time_s[-1]))


def _walks(count: int, last_s: float, rng: np.random.Generator) -> list[Visit]:
    """Return people on foot: some in pairs, one who stands still for five minutes if there is time."""
    visits: list[Visit] = []
    stands = int(count > 2 and last_s > 900.0)
    while len(visits) < count:
        share = (len(visits) + rng.random()) / count
        at_s = last_s * (0.92 * share if last_s > 900.0 else 0.35 * share)
        if stands > 0 and share > 0.2:
            stands -= 1
            visits.append(_stands(min(at_s, last_s - 500.0), rng))
            continue
        places = [routes.place_on_site(rng) for _ in range(int(rng.integers(1, 4)))]
        way = routes.on_foot([*routes.gate(rng), *places, *routes.gate(rng)[::-1]])
        pauses = {k: float(rng.exponential(30.0)) for k in range(2, len(way) - 2) if rng.random() < 0.5}
        visits.append(_person(way, at_s, rng, pauses_s=pauses))
        if len(visits) < count and rng.random() < 0.25:
            visits.append(_beside(visits[-1], rng))
    return visits


def _patrols(last_s: float, rng: np.random.Generator) -> Visit:
    """Return a person who walks about from before the first picture until after the last, with short stops."""
    speed_mps = float(rng.uniform(0.9, 1.5))
    way = [routes.place_on_site(rng)]
    pauses_s: dict[int, float] = {}
    made = routes.journey([way[0], way[0]], speed_mps, -1.0)
    while made.time_s[-1] <= last_s:
        way = routes.on_foot([*way, routes.place_on_site(rng)])
        if rng.random() < 0.3:
            pauses_s[len(way) - 1] = float(rng.uniform(3.0, 12.0))
        made = routes.journey(way, speed_mps, -1.0, pauses_s)
    return Visit("person", made, -1.0, float(made.time_s[-1]))


def _stands(at_s: float, rng: np.random.Generator) -> Visit:
    """Return a person who goes to a place on the quay, stands there for five minutes and more, and goes away."""
    place = (rng.uniform(WALL_X_M + 1.8, 5.0), rng.uniform(-13.0, 13.0))
    before, after = routes.gate(rng), routes.gate(rng)[::-1]
    way = routes.on_foot([*before, place])
    stood = len(way) - 1
    return _person([*way, *routes.on_foot([place, *after])[1:]], at_s, rng, pauses_s={stood: rng.uniform(300.0, 420.0)})


def _beside(other: Visit, rng: np.random.Generator) -> Visit:
    """Return who walks along, 0.45 m to a side and somewhat behind."""
    place_m, heading, _ = other.journey.at(other.journey.time_s)
    offset = 0.45 * float(rng.choice([-1.0, 1.0]))
    aside = place_m + offset * np.column_stack([-np.sin(heading), np.cos(heading)])
    late_s = float(rng.uniform(0.4, 1.5))
    made = other.journey._replace(place_m=aside, time_s=other.journey.time_s + late_s)
    return Visit("person", made, other.begin_s + late_s, other.end_s + late_s)


def _sails(preset: Harbour, last_s: float, rng: np.random.Generator) -> list[Visit]:
    """Return boats that pass, or lie at the free berth for a while; the first does so if there is time."""
    visits = []
    count = preset.boats
    berth = next(each for each in BERTHS if each.is_free)
    for k in range(count):
        at_s = last_s * (0.9 * (k + rng.uniform(0.1, 0.6)) / count if last_s > 900.0 else rng.uniform(0.0, 0.15))
        x, speed = float(rng.uniform(*FAIRWAY_X_M)), float(rng.uniform(1.0, 1.8))
        if k == 0 and last_s > 900.0 and rng.random() < 0.6:
            place = (WALL_X_M - _BOAT_OFF_WALL_M - 1.4, berth.y_m)
            towards, away = routes.alongside(x, place, berth.heading_rad)
            way = routes.journey(towards, speed, at_s)
            arrived_s = float(way.time_s[-1])
            stays_s = float(rng.uniform(*preset.boat_stays_s))
            way = routes.then(way, routes.journey(away, speed, arrived_s + stays_s))
            engine: tuple[tuple[float, float], ...] = (
                (-900.0 + at_s, arrived_s + 30.0),
                (arrived_s + stays_s - 60.0, float(way.time_s[-1])),
            )
        else:
            way = routes.journey(routes.past(x, float(rng.choice([-1.0, 1.0]))), speed, at_s)
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
    model = str(rng.choice(list(VEHICLES)))
    length, width, height = (float(each) for each in rng.uniform(*SIZE_FACTORS, 3))
    return CarLook(model, (length, width, height))


def names_of(visits: tuple[Visit, ...]) -> Iterator[str]:
    """Yield names by kind in order: ``person-0`` …"""
    count: dict[str, int] = {}
    for each in visits:
        number = count.get(each.kind, 0)
        count[each.kind] = number + 1
        yield f"{each.kind}-{number}"
