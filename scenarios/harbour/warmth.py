"""Temperatures of all that stands, floats, walks and drives in the harbour."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenarios.harbour.conditions import Conditions, Day
from scenarios.harbour.scenery import (
    GROUND_VIEW,
    LAMP,
    VENT,
    WALL_BANDS,
    WALL_FOOT_M,
    WALL_TOP_M,
    YARD,
)
from sim.meshes.boat import BoatPart
from sim.meshes.thermal_paint import CarPart, PersonPart
from sim.thermal.heat import MATERIALS, Course, Surface, course, shade_light_wm2, worn_k
from sim.thermal.weather import Weather

Kelvins = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]
"""Temperatures of parts in the shade and facing the sun, and their emissivities, each (P,)."""

_VENT_K, _LAMP_K = 9.0, 25.0
"""How much warmer an outlet of warm air and a lamp at night are than the air."""
_DRYING_H = 2.5
"""Time constant with which a wall that the tide has left becomes like dry stone."""
_MEMORY_H = np.arange(0.0, 13.01, 0.2)
"""How long ago the tide is looked up; longer than from one high water to the next."""
_WORN_EMISSIVITY = 0.96
_UPRIGHT_VIEW = 0.5
"""Share of sky in the surroundings of people and of low birds; the rest is ground."""


class DayWarmth:
    """Surfaces over one day under its weather: materials by name and share of sky."""

    def __init__(self, day: Day, kinds: Iterable[tuple[str, float]], first_h: float, last_h: float) -> None:
        self.weather = day.weather
        known = sorted({(name, view) for name, view in kinds if name in MATERIALS})
        self._column = {kind: k for k, kind in enumerate(known)}
        self._course: Course = course(
            [Surface(MATERIALS[name], view) for name, view in known], day.weather, first_h, last_h
        )

    def at(self, hour: float) -> None:
        """Set the hour."""
        self._shaded_k, self._sunlit_k = self._course.at(hour)
        self.hour = hour
        self._air_k = float(self.weather.air_k(hour))

    def of(self, materials: Sequence[str], sky_view: float) -> Kelvins:
        """Return the temperatures of parts by the names of their materials."""
        parts = [self._one(name, sky_view) for name in materials]
        shaded, sunlit, emissivity = np.array(parts).T
        return shaded, sunlit, emissivity

    def _one(self, name: str, sky_view: float) -> tuple[float, float, float]:
        if name == VENT:
            return (self._air_k + _VENT_K, self._air_k + _VENT_K, 0.95)
        if name == LAMP:
            is_dark = self.weather.towards_sun(self.hour)[2] < 0.0
            warm_k = self._air_k + (_LAMP_K if is_dark else 1.0)
            return (warm_k, warm_k, 0.9)
        k = self._column[name, sky_view]
        return float(self._shaded_k[k]), float(self._sunlit_k[k]), float(self._course.emissivity[k])


def wet_wall(dry: Kelvins, sea_k: float, conditions: Conditions, time_s: float) -> Kelvins:
    """Return the temperatures of the wall's bands, of dry ones (P,): the sea's where it lately was, then drying."""
    past_m = conditions.tide.level_m(time_s - 3600.0 * _MEMORY_H)
    middles_m = WALL_FOOT_M + (np.arange(WALL_BANDS) + 0.5) * (WALL_TOP_M - WALL_FOOT_M) / WALL_BANDS
    was_under = past_m[:, None] > middles_m
    since_h = np.where(was_under.any(axis=0), _MEMORY_H[was_under.argmax(axis=0)], np.inf)
    wet = np.concatenate([[1.0], np.exp(-since_h / _DRYING_H)])
    shaded, sunlit, emissivity = dry
    return shaded + wet * (sea_k - shaded), sunlit + wet * (sea_k - sunlit), emissivity


@dataclass(frozen=True, slots=True)
class Clothes:
    """Insulation of a person's parts in clo (6,), by ``PersonPart``, and what share of sunlight they absorb (6,)."""

    clo: NDArray[np.float64]
    absorptivity: NDArray[np.float64]


def draw_clothes(weather: Weather, rng: np.random.Generator) -> Clothes:
    """Draw clothes: thicker ones on cold days, and in rain a coat whose hood some put up."""
    coat = float(np.clip((292.0 - weather.mean_air_k) / 12.0, 0.0, 1.0))
    rains = weather.rain_mm_h > 0.0
    coat, hood = (max(coat, 0.7), 0.8 * float(rng.random() < 0.6)) if rains else (coat, 0.0)
    clo = {
        PersonPart.SKIN: 0.06,
        PersonPart.HAIR: rng.uniform(0.35, 0.8) + hood,
        PersonPart.TOP: rng.uniform(0.35, 0.6) + coat * rng.uniform(0.4, 0.9),
        PersonPart.LEGS: rng.uniform(0.4, 0.6) + 0.3 * coat,
        PersonPart.SHOES: rng.uniform(1.0, 1.6),
        PersonPart.BACKPACK: 3.0,
    }
    return Clothes(np.array([clo[part] for part in PersonPart]), rng.uniform(0.4, 0.9, len(PersonPart)))


def person_kelvins(clothes: Clothes, warmth: DayWarmth) -> Kelvins:
    """Return the temperatures of a person's parts."""
    weather, hour = warmth.weather, warmth.hour
    shaded = np.array([worn_k(weather, hour, float(clo)) for clo in clothes.clo])
    # Cloth has hardly any mass: sunlight leaves it at once through convection, radiation, and inwards.
    leaves_wm2k = 5.7 + 3.8 * weather.wind_mps + 6.0 + 1.0 / (0.155 * clothes.clo)
    # Rain takes its share of what the body gives off, as of any surface, see ``sim.thermal.heat``.
    air_k, all_wm2k = float(weather.air_k(hour)), leaves_wm2k + min(8.0 * weather.rain_mm_h, 40.0)
    light_wm2 = float(shade_light_wm2(weather, hour, _UPRIGHT_VIEW))
    shaded = air_k + ((shaded - air_k) * leaves_wm2k + clothes.absorptivity * light_wm2) / all_wm2k
    sunlit = shaded + clothes.absorptivity * float(weather.direct_wm2(hour)) / all_wm2k
    return shaded, sunlit, np.full(len(shaded), _WORN_EMISSIVITY)


def level_ground(warmth: DayWarmth, parts: int, excess_k: float) -> Kelvins:
    """Return the temperatures of parts (P,) that are by so much warmer than the level yard, whichever way they face."""
    shaded, sunlit, emissivity = (np.full(parts, each[0]) for each in warmth.of((YARD,), GROUND_VIEW))
    upwards = max(float(warmth.weather.towards_sun(warmth.hour)[2]), 0.0)
    ground = shaded + upwards * (sunlit - shaded) + excess_k
    return ground, ground, emissivity


def gull_kelvins(warmth: DayWarmth) -> Kelvins:
    """Return the temperatures of a gull's body, wings and head: down keeps it as warm as a well clothed person."""
    weather, hour = warmth.weather, warmth.hour
    shaded = np.array([worn_k(weather, hour, clo, skin_k=312.0) for clo in (1.6, 2.5, 0.7)])
    k_per_wm2 = 0.3 / (14.0 + 3.8 * weather.wind_mps)
    shaded += k_per_wm2 * float(shade_light_wm2(weather, hour, _UPRIGHT_VIEW))
    sunlit = shaded + k_per_wm2 * float(weather.direct_wm2(hour))
    return shaded, sunlit, np.full(3, 0.97)


def excess_k(
    time_s: NDArray[np.float64],
    runs_s: Sequence[tuple[float, float]],
    goal_k: float,
    warms_s: float,
    cools_s: float,
) -> NDArray[np.float64]:
    """Return by how much something is warmer (F,) at times (F,) than without its engine.

    While the engine runs it tends to ``goal_k`` with one time constant, afterwards to 0 with another.

    Args:
        runs_s: from when to when it runs, in order.
    """
    excess = np.zeros(len(time_s))
    now_k, since_s = 0.0, -np.inf
    for start_s, stop_s in runs_s:
        at_start = now_k * np.exp(-(start_s - since_s) / cools_s)
        running = (time_s >= start_s) & (time_s < stop_s)
        excess[running] = goal_k + (at_start - goal_k) * np.exp(-(time_s[running] - start_s) / warms_s)
        now_k, since_s = goal_k + (at_start - goal_k) * np.exp(-(stop_s - start_s) / warms_s), stop_s
        after = time_s >= stop_s
        excess[after] = now_k * np.exp(-(time_s[after] - stop_s) / cools_s)
    return excess


CAR_VIEW, BOAT_VIEW = 0.7, 0.7
_CAR_HEATED = {
    # Goal, warms, cools. Bonnets of cars that have driven are 15 to 25 K warmer than before, tyres and brakes 10 to 40.
    CarPart.BONNET: (20.0, 500.0, 2400.0),
    CarPart.GLASS: (4.0, 400.0, 900.0),
    CarPart.TYRE: (12.0, 500.0, 1500.0),
    CarPart.WHEEL: (30.0, 300.0, 1500.0),
    CarPart.UNDERSIDE: (28.0, 300.0, 1800.0),
    CarPart.BODY: (1.5, 900.0, 1800.0),
}
_BOAT_HEATED = {
    BoatPart.ENGINE: (14.0, 900.0, 3000.0),
    BoatPart.EXHAUST: (45.0, 120.0, 900.0),
    BoatPart.CABIN: (2.5, 1500.0, 3000.0),
    BoatPart.DECK: (1.5, 1500.0, 3000.0),
}


def car_materials(paint: str) -> tuple[str, ...]:
    """Return the materials of a car's parts."""
    of = {
        CarPart.GLASS: "car glass",
        CarPart.TYRE: "rubber",
        CarPart.UNDERSIDE: "painted steel",
        CarPart.WHEEL: "painted steel",
    }
    return tuple(of.get(part, paint) for part in CarPart)


def boat_materials(hull: str) -> tuple[str, ...]:
    """Return the materials of a boat's parts."""
    of = {
        BoatPart.DECK: "timber",
        BoatPart.GLASS: "car glass",
        BoatPart.EXHAUST: "painted steel",
        BoatPart.ENGINE: "painted steel",
        BoatPart.GEAR: "painted steel",
    }
    return tuple(of.get(part, hull) for part in BoatPart)


def heated_k(kind: str, time_s: NDArray[np.float64], runs_s: Sequence[tuple[float, float]]) -> NDArray[np.float64]:
    """Return by how much the parts (F, P) of a car or boat are warmer than without its engine."""
    heated, parts = (_CAR_HEATED, len(CarPart)) if kind == "car" else (_BOAT_HEATED, len(BoatPart))
    total = np.zeros((len(time_s), parts))
    for part, (goal_k, warms_s, cools_s) in heated.items():
        total[:, part] = excess_k(time_s, runs_s, goal_k, warms_s, cools_s)
    return total
