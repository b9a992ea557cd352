"""Weather of one day at one place: sun, air, wind, clouds and rain as functions of the hour."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sim.checks import check_types, check_within
from sim.thermal.radiance import Air, air_mass

STEFAN_BOLTZMANN = 5.670374e-8
_SOLAR_CONSTANT_WM2 = 1361.0
_WARMEST_HOUR = 15.0


@dataclass(frozen=True, slots=True)
class Weather:
    """A day's weather. Hours are solar time; those of the next day go on beyond 24, those of the day before are < 0.

    Attributes:
        latitude_deg: of the place, north is positive.
        x_bearing_deg: compass bearing of the world's x axis, clockwise from north.
        day_of_year: 1 to 366.
        mean_air_k: mean of the day. swing_k: from the coldest hour to the warmest.
        vapour_hpa: pressure of water vapour.
        cloud: share of the sky that is covered, 0 to 1.
        wind_mps: at 10 m height. wind_rad: where it blows to, from the world's x axis towards y.
        rain_mm_h: 0 for none.
        sea_k: temperature of the sea's surface.
    """

    latitude_deg: float = 36.0
    x_bearing_deg: float = 0.0
    day_of_year: int = 100
    mean_air_k: float = 286.0
    swing_k: float = 7.0
    vapour_hpa: float = 9.0
    cloud: float = 0.2
    wind_mps: float = 3.0
    wind_rad: float = 0.0
    rain_mm_h: float = 0.0
    sea_k: float = 285.0

    def __post_init__(self) -> None:
        check_types(self)
        check_within(self, "latitude_deg", -66, 66)
        check_within(self, "day_of_year", 1, 366)
        check_within(self, "mean_air_k sea_k", 250, 320)
        check_within(self, "swing_k", 0, 30)
        check_within(self, "vapour_hpa", 0.5, 45)
        check_within(self, "cloud", 0, 1)
        check_within(self, "wind_mps", 0, 40)
        check_within(self, "rain_mm_h", 0, 100)

    def air_k(self, hour: ArrayLike) -> NDArray[np.float64]:
        """Return the temperature of the air (...)."""
        phase = 2.0 * np.pi * (np.asarray(hour, dtype=float) - _WARMEST_HOUR) / 24.0
        return np.asarray(self.mean_air_k + 0.5 * self.swing_k * np.cos(phase))

    def towards_sun(self, hour: ArrayLike) -> NDArray[np.float64]:
        """Return unit vectors (..., 3) towards the sun in the world frame; z < 0 at night.

        Declination by Cooper (1969), position by spherical trigonometry.
        """
        declination = np.radians(23.45) * np.sin(2.0 * np.pi * (284 + self.day_of_year) / 365.0)
        turn = 2.0 * np.pi * (np.asarray(hour, dtype=float) - 12.0) / 24.0
        latitude = np.radians(self.latitude_deg)
        east = -np.cos(declination) * np.sin(turn)
        north = np.cos(latitude) * np.sin(declination) - np.sin(latitude) * np.cos(declination) * np.cos(turn)
        up = np.sin(latitude) * np.sin(declination) + np.cos(latitude) * np.cos(declination) * np.cos(turn)
        bearing = np.radians(self.x_bearing_deg)
        x = east * np.sin(bearing) + north * np.cos(bearing)
        y = north * np.sin(bearing) - east * np.cos(bearing)
        return np.stack([x, y, up], axis=-1)

    def direct_wm2(self, hour: ArrayLike) -> NDArray[np.float64]:
        """Return the sun's irradiance (...) of a surface that faces it, through gaps between clouds.

        Clear sky: ``1361 * 0.7 ** (air mass ** 0.678)`` (Meinel and Meinel 1976).
        """
        sine = self.towards_sun(hour)[..., 2]
        clear = _SOLAR_CONSTANT_WM2 * 0.7 ** (air_mass(sine) ** 0.678)
        return np.where(sine > 0.0, (1.0 - self.cloud) * clear, 0.0)

    def diffuse_wm2(self, hour: ArrayLike) -> NDArray[np.float64]:
        """Return the irradiance (...) of level ground by sky and clouds.

        A tenth of the clear sun's is scattered by air; clouds lower the total to ``1 - 0.75 N^3.4`` of a clear day's
        (Kasten and Czeplak 1980).
        """
        sine = np.maximum(self.towards_sun(hour)[..., 2], 0.0)
        clear_direct = _SOLAR_CONSTANT_WM2 * 0.7 ** (air_mass(sine) ** 0.678) * sine
        total = 1.1 * clear_direct * (1.0 - 0.75 * self.cloud**3.4)
        return np.maximum(total - (1.0 - self.cloud) * clear_direct, 0.0)

    def sky_wm2(self, hour: ArrayLike) -> NDArray[np.float64]:
        """Return the long-wave irradiance (...) of level ground by the whole sky.

        Emissivity of the clear sky by Idso (1981), ``0.70 + 5.95e-5 e exp(1500 / T)``; clouds fill the rest (Crawford
        and Duchon 1999).
        """
        kelvin = self.air_k(hour)
        clear = np.minimum(0.70 + 5.95e-5 * self.vapour_hpa * np.exp(1500.0 / kelvin), 1.0)
        return np.asarray((clear + (1.0 - clear) * self.cloud) * STEFAN_BOLTZMANN * kelvin**4)

    def air(self, hour: float) -> Air:
        """Return air and sky in the camera's band.

        Emissivity overhead by Idso (1981), ``0.24 + 2.98e-8 e² exp(3000 / T)``. Clouds have the air's temperature at
        1 km. Attenuation is that of the water vapour's continuum, 0.02/km for each hPa beside 0.05/km of haze, and of
        rain by ITU-R P.1814, ``1.58 R^0.63`` dB/km.
        """
        kelvin = float(self.air_k(hour))
        rain_per_km = 1.58 * self.rain_mm_h**0.63 * np.log(10.0) / 10.0
        return Air(
            temperature_k=kelvin,
            attenuation_per_m=float(1e-3 * (0.05 + 0.02 * self.vapour_hpa + rain_per_km)),
            zenith_emissivity=float(min(0.24 + 2.98e-8 * self.vapour_hpa**2 * np.exp(3000.0 / kelvin), 1.0)),
            cloud=self.cloud,
            cloud_k=kelvin - 6.5,
        )


def draw_weather(
    rng: np.random.Generator,
    *,
    day_of_year: int,
    latitude_deg: float,
    x_bearing_deg: float,
    cloud: tuple[float, float] = (0.0, 1.0),
    wind_mps: tuple[float, float] = (0.5, 8.0),
    rain_mm_h: tuple[float, float] = (0.0, 0.0),
) -> Weather:
    """Return a day's weather; pairs are ranges of a uniform draw.

    Cloudy days have a smaller swing and moister air. The mean follows the season of a temperate coast, the sea a month
    and a half later.
    """
    season, sea_season = (np.cos(2.0 * np.pi * (day_of_year - late) / 365.0) for late in (205, 240))
    north = np.sign(latitude_deg)
    covered = float(rng.uniform(*cloud))
    mean_k = 286.0 + north * 9.0 * season + rng.normal(0.0, 2.0)
    saturated_hpa = 6.11 * np.exp(17.6 * (mean_k - 273.15) / (mean_k - 30.0))
    humidity = np.clip(0.6 + 0.25 * covered + rng.normal(0.0, 0.05), 0.3, 0.98)
    return Weather(
        latitude_deg=latitude_deg,
        x_bearing_deg=x_bearing_deg,
        day_of_year=day_of_year,
        mean_air_k=float(mean_k),
        swing_k=float((10.0 - 7.0 * covered) * rng.uniform(0.8, 1.2)),
        vapour_hpa=float(np.clip(humidity * saturated_hpa, 0.5, 45.0)),
        cloud=covered,
        wind_mps=float(rng.uniform(*wind_mps)),
        wind_rad=float(rng.uniform(-np.pi, np.pi)),
        rain_mm_h=float(rng.uniform(*rain_mm_h)),
        sea_k=float(287.0 + north * 6.0 * sea_season + rng.normal(0.0, 1.0)),
    )
