"""The thermal shader of the harbour at any time of the episode and of the days before."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from scenarios.harbour.clutter import Clutter
from scenarios.harbour.conditions import DAYS_BEFORE, Conditions
from scenarios.harbour.crew import Crews
from scenarios.harbour.intruders import Intruders
from scenarios.harbour.scenery import Surface
from scenarios.harbour.warmth import DayWarmth, gull_kelvins, wet_wall
from sim.shaders.thermal.sea import Sea
from sim.shaders.thermal.shader import ThermalShader
from sim.thermal.waves import SeaWaves
from sim.world import Body, World

_SHADOW_REACH_M = 75.0
_STEP_S = 30.0
"""Interval between updates of the temperatures. Parts that an engine heats are updated on every frame; others change by
less than the noise of a pixel within the interval, so that static bodies need not be drawn again."""
_AIR_STEP_H = 1.0 / 6.0
"""Air and sky change in steps of this length."""
_SUN_STEP_H = 1.0 / 6.0
_REMEMBERED = np.array([0.45, 0.3, 0.25])
"""Shares of the sun's latest positions, ``_SUN_STEP_H`` apart, in what sunlight has warmed."""


class Thermals:
    """Sets temperatures, sun, air and waves of a shader by the time.

    Attributes:
        shader: of the world.
    """

    def __init__(
        self,
        world: World,
        conditions: Conditions,
        scenery: list[Surface],
        clutter: Clutter,
        intruders: Intruders,
        rate_hz: float,
        waves: Sequence[SeaWaves],
        crews: Crews | None = None,
    ) -> None:
        """``waves``: of the days of ``conditions``."""
        self._crews = crews
        self._conditions, self._clutter, self._intruders = conditions, clutter, intruders
        self._rate_hz = rate_hz
        walls = [each for each in scenery if each.body.name == "wall"]
        self._wall, self._walls = walls[0], [each.body for each in walls]
        self._alike: dict[tuple[tuple[str, ...], float], list[Body]] = {}
        others = (each for each in scenery if each.body.name != "wall")
        for surface in (*others, *clutter.surfaces):
            self._alike.setdefault((surface.materials, surface.sky_view), []).append(surface.body)
        self._kinds = {(name, each.sky_view) for each in (*scenery, *clutter.surfaces) for name in each.materials}
        self._kinds |= intruders.warmth_kinds()
        self.shader = ThermalShader(world, _SHADOW_REACH_M)
        self._seas = [
            Sea(clutter.sea, each, day.weather.sea_k) for day, each in zip(conditions.days, waves, strict=True)
        ]
        self._warmth: dict[int, DayWarmth] = {}
        self._shown: tuple[int, frozenset[int]] | None = None

    def show_frame(self, frame: int) -> None:
        """Set all to a frame of the episode; temperatures are those of the latest ``_STEP_S``, and the heat of engines
        that of the frame.
        """
        every = max(round(_STEP_S * self._rate_hz), 1)
        step = frame // every * every
        here = frozenset(np.flatnonzero(self._intruders.presence[frame]).tolist())
        self._seas[DAYS_BEFORE].waves.time_s = frame / self._rate_hz
        is_new = (step, here) != self._shown
        if self._shown is None or self._shown[0] != step:
            self._set_world(step / self._rate_hz, DAYS_BEFORE)
        for k in sorted(here):
            if is_new or self._intruders.is_heated(k):
                bodies, kelvins = self._intruders.kelvins(frame, k, self._warmth[DAYS_BEFORE])
                self.shader.set_parts(bodies, *kelvins)
        self._shown = step, here

    def show_earlier(self, time_s: float) -> None:
        """Set all to a time on the days before."""
        day = self._conditions.day_at(time_s)
        self._seas[day].waves.time_s = time_s
        self._set_world(time_s, day)
        self._shown = None

    def _set_world(self, time_s: float, day: int) -> None:
        self.shader.sea = self._seas[day]
        hour = self._conditions.hour(time_s)
        warmth = self._of_day(day)
        warmth.at(hour)
        set_parts = self.shader.set_parts
        for (materials, sky_view), bodies in self._alike.items():
            set_parts(bodies, *warmth.of(materials, sky_view))
        dry = warmth.of(self._wall.materials, self._wall.sky_view)
        set_parts(self._walls, *wet_wall(dry, warmth.weather.sea_k, self._conditions, time_s))
        set_parts(self._clutter.gulls, *gull_kelvins(warmth))
        for bodies, kelvins in [] if self._crews is None else self._crews.kelvins(warmth):
            set_parts(bodies, *kelvins)
        self.shader.set_air(warmth.weather.air(round(hour / _AIR_STEP_H) * _AIR_STEP_H))
        self.shader.set_sun(*_suns(warmth, hour))

    def _of_day(self, day: int) -> DayWarmth:
        if day not in self._warmth:
            first_h = self._conditions.start_h - 24.0 * self._conditions.days_ago[day]
            last_h = first_h + (24.0 if day < DAYS_BEFORE else self._conditions.episode_h)
            self._warmth[day] = DayWarmth(self._conditions.days[day], self._kinds, first_h, last_h)
        return self._warmth[day]


def _suns(warmth: DayWarmth, hour: float) -> tuple[list[NDArray[np.float64]], list[float]]:
    """Return the positions that surfaces remember, on a grid of times, with weights that pass on smoothly."""
    place = hour / _SUN_STEP_H
    first = int(np.floor(place))
    share = place - first
    weights = (1.0 - share) * np.concatenate([[0.0], _REMEMBERED]) + share * np.concatenate([_REMEMBERED, [0.0]])
    towards = [warmth.weather.towards_sun((first + 1 - k) * _SUN_STEP_H) for k in range(len(weights))]
    up = [(each, float(weight)) for each, weight in zip(towards, weights, strict=True) if each[2] > 0.02]
    return [each for each, _ in up], [weight for _, weight in up]
