"""Weather, tide and waves of an episode and of the days before it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenarios.harbour.presets import DayBefore, Harbour, Range
from scenarios.harbour.sea import Tide, draw_tide
from sim.thermal.waves import SeaState
from sim.thermal.weather import Weather, draw_weather

DAYS_BEFORE = 3
_LATITUDE_DEG, _X_BEARING_DEG = 35.0, 200.0
"""The camera looks to the south-south-west: in the morning the sun shines on the quay from behind, from the left."""
_CALMER = 0.6
"""Behind moles waves have this share of the height that the wind makes in as short a fetch outside."""


@dataclass(frozen=True, slots=True)
class Day:
    """One day's weather and its waves."""

    weather: Weather
    waves: SeaState


@dataclass(frozen=True, slots=True)
class Conditions:
    """An episode's conditions.

    Attributes:
        start_h: solar time of the first picture. episode_h: how long the episode lasts.
        days: of the days before, the earliest first, and of the episode's own (DAYS_BEFORE + 1,).
        days_ago: (DAYS_BEFORE + 1,) how many days before the episode's own each of them is.
        tide: of all days.
    """

    start_h: float
    episode_h: float
    days: tuple[Day, ...]
    days_ago: tuple[int, ...]
    tide: Tide

    def hour(self, time_s: float) -> float:
        """Return the solar time at a time, beyond 0 to 24 before and after the episode's own day."""
        return self.start_h + time_s / 3600.0

    def day_at(self, time_s: float) -> int:
        """Return the index of the day in ``days``; its own lasts from the episode's first frame on."""
        since = np.floor(time_s / 86400.0)
        return max(k for k, ago in enumerate(self.days_ago) if k == 0 or -ago <= since)

    def background_times(self, count: int) -> NDArray[np.float64]:
        """Return the ascending times (count,) of pictures spread evenly over the days before."""
        time_s = -DAYS_BEFORE * 86400.0 * (1.0 - np.arange(count) / max(count, 1))
        since = np.floor(time_s / 86400.0).astype(int)
        return time_s - 86400.0 * (np.array(self.days_ago)[since + DAYS_BEFORE] + since)


def draw_conditions(preset: Harbour, rng: np.random.Generator) -> Conditions:
    """Draw an episode's conditions."""
    start_h = float(rng.uniform(*preset.start_h))
    day_of_year = int(rng.integers(preset.day_of_year[0], preset.day_of_year[1] + 1))
    alike = preset.cloud_before, preset.wind_before_mps, (0.0, 0.0), preset.swell_before_m
    days = preset.days_before or [DayBefore(ago, *alike) for ago in range(DAYS_BEFORE, 0, -1)]
    before = [_day(day_of_year - k.days_ago, k.cloud, k.wind_mps, k.rain_mm_h, k.swell_m, rng) for k in days]
    today = _day(day_of_year, preset.cloud, preset.wind_mps, preset.rain_mm_h, preset.swell_m, rng)
    ago = (*(each.days_ago for each in days), 0)
    return Conditions(start_h, preset.frame_count / preset.rate_hz / 3600.0, (*before, today), ago, draw_tide(rng))


def _day(
    day_of_year: int,
    cloud: Range,
    wind_mps: Range,
    rain_mm_h: Range,
    swell_m: Range,
    rng: np.random.Generator,
) -> Day:
    weather = draw_weather(
        rng,
        day_of_year=(day_of_year - 1) % 365 + 1,
        latitude_deg=_LATITUDE_DEG,
        x_bearing_deg=_X_BEARING_DEG,
        cloud=cloud,
        wind_mps=wind_mps,
        rain_mm_h=rain_mm_h,
    )
    wind = weather.wind_mps
    waves = SeaState(
        # A fetch of 300 m: 0.0016 sqrt(fetch / g) wind (Hasselmann et al. 1973, JONSWAP).
        wind_wave_m=float(_CALMER * 0.0016 * np.sqrt(300.0 / 9.81) * wind),
        wind_rad=weather.wind_rad,
        peak_m=float(np.clip(0.35 * wind, 0.9, 6.0)),
        swell_m=float(rng.uniform(*swell_m)),
        swell_length_m=float(rng.uniform(14.0, 30.0)),
        swell_rad=float(rng.normal(0.0, 0.5)),
        # Cox and Munk (1954): 0.003 + 0.00512 wind is the variance of all slopes; less in shelter.
        fine_slope=float(np.clip(0.6 * np.sqrt(0.003 + 0.00512 * wind), 0.02, 0.2)),
    )
    return Day(weather, waves)
