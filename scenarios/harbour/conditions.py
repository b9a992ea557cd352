"""Weather, tide and waves of an episode and of the days before it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenarios.harbour.layout import MEAN_SEA_M
from scenarios.harbour.presets import DayBefore, Harbour, Range
from sim.thermal.waves import SeaState, SeaWaves
from sim.thermal.weather import Weather, draw_weather

_HOUR_S = 3600.0
_PERIODS_H = np.array([12.4206, 12.0, 23.9345, 25.8193])
"""Of the constituents M2, S2, K1 and O1 (Pugh and Woodworth, "Sea-Level Science", 2014, table 4.1)."""
_AMPLITUDES_M = np.array([0.62, 0.17, 0.07, 0.05])
"""Of a coast with a range of 1 to 1.6 m: the semi-diurnal ones are the larger."""


@dataclass(frozen=True, slots=True)
class Tide:
    """Four constituents with phases (4,) at time 0."""

    phases_rad: NDArray[np.float64]

    def above_mean_m(self, time_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the level (...) over the mean at times (...), within 0.91 m."""
        turns = np.asarray(time_s)[..., None] / (_PERIODS_H * _HOUR_S)
        return (_AMPLITUDES_M * np.cos(2.0 * np.pi * turns + self.phases_rad)).sum(axis=-1)

    def level_m(self, time_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the height (...) of the sea over the quay's surface, negative."""
        return MEAN_SEA_M + self.above_mean_m(time_s)


LOWEST_M = MEAN_SEA_M - float(_AMPLITUDES_M.sum())
"""Of all tides."""


def draw_tide(rng: np.random.Generator) -> Tide:
    """Draw a tide that turns neither at the start nor within two hours, so that it moves while the episode lasts."""
    phases = rng.uniform(0.0, 2.0 * np.pi, 4)
    # A quarter of a period from a turn is where the level moves fastest.
    phases[0] = rng.choice([0.5, 1.5]) * np.pi + rng.uniform(-0.7, 0.2)
    return Tide(phases)


def sway(
    time_s: NDArray[np.float64], periods_s: tuple[float, float], rng: np.random.Generator, waves: int = 4
) -> NDArray[np.float64]:
    """Return a smooth random motion (...) of unit standard deviation with periods within a range, at times (...)."""
    period = np.exp(rng.uniform(np.log(periods_s[0]), np.log(periods_s[1]), waves))
    phase = rng.uniform(0.0, 2.0 * np.pi, waves)
    return np.cos(2.0 * np.pi * np.asarray(time_s)[..., None] / period + phase).sum(axis=-1) / np.sqrt(0.5 * waves)


def float_poses(
    place_m: NDArray[np.float64],
    heading_rad: NDArray[np.float64],
    roll_rad: NDArray[np.float64],
    pitch_rad: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return poses (..., 4, 4), x ahead and y left, at places (..., 3): turned about z, then y, then x."""
    cz, sz, cy, sy = np.cos(heading_rad), np.sin(heading_rad), np.cos(pitch_rad), np.sin(pitch_rad)
    cx, sx = np.cos(roll_rad), np.sin(roll_rad)
    T = np.zeros((*np.shape(heading_rad), 4, 4))
    T[..., 0, 0], T[..., 0, 1], T[..., 0, 2] = cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx
    T[..., 1, 0], T[..., 1, 1], T[..., 1, 2] = sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx
    T[..., 2, 0], T[..., 2, 1], T[..., 2, 2] = -sy, cy * sx, cy * cx
    T[..., :3, 3] = place_m
    T[..., 3, 3] = 1.0
    return T


@dataclass(frozen=True, slots=True)
class Rocking:
    """How a boat moves on waves: heave (...), roll (...), pitch (...)."""

    heave_m: NDArray[np.float64]
    roll_rad: NDArray[np.float64]
    pitch_rad: NDArray[np.float64]


def rocking(
    time_s: NDArray[np.float64], wave_height_m: NDArray[np.float64], length_m: float, rng: np.random.Generator
) -> Rocking:
    """Return the motion at times (...) in waves of a significant height (...).

    A significant height is four standard deviations of the surface. A short boat follows the surface, a long one
    averages it; it rolls at its own period of some seconds.
    """
    follows = 1.0 / (1.0 + (length_m / 14.0) ** 2)
    surface = 0.25 * np.asarray(wave_height_m) * follows
    return Rocking(
        surface * sway(time_s, (2.5, 6.0), rng),
        1.1 * surface / (0.15 * length_m) * sway(time_s, (2.4, 3.8), rng),
        0.8 * surface / (0.3 * length_m) * sway(time_s, (2.5, 6.0), rng),
    )


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


def draw_waves(conditions: Conditions, rng: np.random.Generator) -> list[SeaWaves]:
    """Draw the waves of each day."""
    keys = rng.integers(2**31, size=len(conditions.days))
    days = zip(conditions.days, keys, strict=True)
    return [SeaWaves(day.waves, np.random.default_rng(int(key))) for day, key in days]


def draw_conditions(preset: Harbour, rng: np.random.Generator) -> Conditions:
    """Draw an episode's conditions."""
    start_h = float(rng.uniform(*preset.start_h))
    day_of_year = int(rng.integers(preset.day_of_year[0], preset.day_of_year[1] + 1))
    alike = preset.cloud_before, preset.wind_before_mps, (0.0, 0.0), preset.swell_before_m
    days = preset.days_before or [DayBefore(ago, *alike) for ago in range(DAYS_BEFORE, 0, -1)]
    long = (14.0, 30.0)
    if preset.swell_period_s is not None:
        # Of waves in deep water.
        low, high = (9.81 * period_s**2 / (2.0 * np.pi) for period_s in preset.swell_period_s)
        long = (low, high)
    before = [_day(day_of_year - k.days_ago, k.cloud, k.wind_mps, k.rain_mm_h, k.swell_m, long, rng) for k in days]
    today = _day(day_of_year, preset.cloud, preset.wind_mps, preset.rain_mm_h, preset.swell_m, long, rng)
    ago = (*(each.days_ago for each in days), 0)
    return Conditions(start_h, preset.frame_count / preset.rate_hz / 3600.0, (*before, today), ago, draw_tide(rng))


def _day(
    day_of_year: int,
    cloud: Range,
    wind_mps: Range,
    rain_mm_h: Range,
    swell_m: Range,
    swell_length_m: Range,
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
        swell_length_m=float(rng.uniform(*swell_length_m)),
        swell_rad=float(rng.normal(0.0, 0.5)),
        # Cox and Munk (1954): 0.003 + 0.00512 wind is the variance of all slopes; less in shelter.
        fine_slope=float(np.clip(0.6 * np.sqrt(0.003 + 0.00512 * wind), 0.02, 0.2)),
    )
    return Day(weather, waves)
