"""Temperatures of surfaces over a day by their heat balance, and of things that are heated from within.

Emissivities in 8 to 14 µm are those of the ECOSTRESS library (Meerdink et al. 2019) and of common tables of thermal
cameras; solar absorptivities are of ASHRAE's and Duffie and Beckman's tables. The layer that follows the day's cycle
has the areal heat capacity ``density * specific heat * thickness``, with the thickness of the sheet, or for thick
bodies the depth to which the day's wave reaches. ``coupling`` is the conductance to what lies behind that layer, which
keeps the day's mean temperature (``behind`` = ``mean``) or that of the air (``air``), or of a heated room (``room``).

A surface of areal heat capacity C under the sky share v (the rest of what it sees is ground):

    C dT/dt = a (S + v D + (1 - v) 0.2 (S z + D)) + e (v L + (1 - v) s T_air⁴ - s T⁴)
              + h (T_air - T) + w (T_wet - T) + k (T_behind - T)

S is the sun's irradiance of a surface that faces it, 0 in shade, and z the sine of its elevation; D and L are the sky's
in sunlight and long wave; ``h = 5.7 + 3.8 wind`` W/(m² K) (McAdams 1954). In rain w = 8 W/(m² K)
for each mm/h, at most 40, draws the surface to the wet-bulb temperature. The equation is integrated by Euler's implicit
method, linearised in T⁴, from a day before on.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sim.checks import check, check_types, check_within
from sim.thermal.weather import STEFAN_BOLTZMANN, Weather


@dataclass(frozen=True, slots=True)
class Material:
    """A surface layer.

    Attributes:
        emissivity: in 8 to 14 µm, 0 to 1.
        absorptivity: of sunlight, 0 to 1.
        capacity_j_m2k: heat that warms a square metre by 1 K.
        coupling_w_m2k: conductance to what lies behind.
        behind: what that is.
    """

    emissivity: float
    absorptivity: float
    capacity_j_m2k: float
    coupling_w_m2k: float
    behind: Literal["mean", "air", "room"] = "mean"

    def __post_init__(self) -> None:
        check_types(self)
        check_within(self, "emissivity absorptivity", 0, 1)
        check_within(self, "capacity_j_m2k", 0, above=True)
        check_within(self, "coupling_w_m2k", 0)


def _sheet(kg_m3: float, j_kgk: float, thickness_m: float) -> float:
    return kg_m3 * j_kgk * thickness_m


MATERIALS: dict[str, Material] = {
    "concrete": Material(0.94, 0.65, _sheet(2300, 880, 0.08), 9.0),
    "asphalt": Material(0.95, 0.90, _sheet(2240, 920, 0.07), 8.0),
    "gravel": Material(0.93, 0.70, _sheet(1600, 840, 0.05), 4.0),
    "grass": Material(0.97, 0.75, _sheet(300, 3000, 0.02), 3.0),
    "brick": Material(0.93, 0.65, _sheet(1800, 840, 0.07), 4.0),
    "granite": Material(0.92, 0.60, _sheet(2650, 790, 0.10), 12.0),
    "timber": Material(0.91, 0.60, _sheet(550, 1700, 0.025), 2.0, "air"),
    "painted steel": Material(0.93, 0.50, _sheet(7850, 490, 0.003), 5.0, "air"),
    "dark paint": Material(0.94, 0.90, _sheet(7850, 490, 0.0012), 4.0, "air"),
    "white paint": Material(0.92, 0.25, _sheet(7850, 490, 0.0012), 4.0, "air"),
    "bare metal": Material(0.25, 0.40, _sheet(2700, 900, 0.002), 5.0, "air"),
    "roof sheet": Material(0.88, 0.60, _sheet(7850, 490, 0.0007), 1.2, "air"),
    "roof felt": Material(0.93, 0.90, _sheet(1100, 1400, 0.012), 0.6, "room"),
    "fibreglass": Material(0.92, 0.30, _sheet(1700, 1000, 0.008), 3.0, "air"),
    "glass": Material(0.84, 0.15, _sheet(2500, 840, 0.004), 5.5, "room"),
    "car glass": Material(0.84, 0.40, _sheet(2500, 840, 0.004), 5.0, "air"),
    "rubber": Material(0.94, 0.92, _sheet(1100, 1900, 0.012), 2.0, "air"),
    "rope": Material(0.92, 0.60, _sheet(600, 1400, 0.015), 6.0, "air"),
    "canvas": Material(0.92, 0.55, _sheet(500, 1400, 0.001), 3.0, "air"),
    "feathers": Material(0.97, 0.50, _sheet(100, 1500, 0.01), 1.5, "air"),
}
"""By name."""


STEP_H = 1.0 / 30.0
ROOM_K = 293.0
_SPIN_UP_H = 24.0
_GROUND_ALBEDO = 0.2
_CLO_M2K_W = 0.155


@dataclass(frozen=True, slots=True)
class Surface:
    """A surface whose temperature is wanted.

    Attributes:
        material: what it is made of.
        sky_view: share of its half-space that is sky: 1 for ground and roofs, 0.5 for walls, 0 for undersides.
    """

    material: Material
    sky_view: float = 1.0

    def __post_init__(self) -> None:
        check_within(self, "sky_view", 0, 1)


@dataclass(frozen=True, eq=False)
class Course:
    """Temperatures of N surfaces over T hours.

    Attributes:
        hours: (T,), evenly spaced.
        shaded_k: (T, N), never in the sun.
        sunlit_k: (T, N), always facing the sun while it is up.
        emissivity: (N,).
    """

    hours: NDArray[np.float64]
    shaded_k: NDArray[np.float64]
    sunlit_k: NDArray[np.float64]
    emissivity: NDArray[np.float64]

    def at(self, hour: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return ``shaded_k`` and ``sunlit_k`` (N,) at an hour, interpolated.

        Raises:
            ValueError: for an hour outside the course.
        """
        first, last = float(self.hours[0]), float(self.hours[-1])
        check("hour", first <= hour <= last, f"a number in [{first:g}, {last:g}]", hour)
        place = (hour - first) / (self.hours[1] - first)
        k = min(int(place), len(self.hours) - 2)
        share = place - k
        shaded, sunlit = ((1.0 - share) * each[k] + share * each[k + 1] for each in (self.shaded_k, self.sunlit_k))
        return shaded, sunlit


def course(surfaces: Sequence[Surface], weather: Weather, first_hour: float, last_hour: float) -> Course:
    """Return the temperatures of surfaces from ``first_hour`` to ``last_hour``, under the same weather day after day.

    Raises:
        ValueError: if the hours are not in ascending order.
    """
    check("last_hour", last_hour > first_hour, f"a number > first_hour = {first_hour:g}", last_hour)
    before = round(_SPIN_UP_H / STEP_H)
    steps = before + int((last_hour - first_hour) / STEP_H) + 2
    hours = np.asarray(first_hour + STEP_H * (np.arange(steps) - before), dtype=np.float64)
    balance = Balance(surfaces, weather, hours)
    kelvin = np.empty((len(hours), 2, len(surfaces)))
    kelvin[0] = weather.mean_air_k
    for k in range(len(hours) - 1):
        kelvin[k + 1] = balance.after(kelvin[k], k + 1, 3600.0 * STEP_H)
    return Course(hours[before:], kelvin[before:, 0], kelvin[before:, 1], balance.emissivity)


class Balance:
    """The heat balance of N surfaces at H hours, in the shade (row 0) and facing the sun (row 1).

    Attributes:
        emissivity: (N,).
    """

    def __init__(self, surfaces: Sequence[Surface], weather: Weather, hours: NDArray[np.float64]) -> None:
        w, made_of = weather, [each.material for each in surfaces]
        self.emissivity = np.array([each.emissivity for each in made_of])
        absorptivity = np.array([each.absorptivity for each in made_of])
        self._capacity = np.array([each.capacity_j_m2k for each in made_of])
        coupling = np.array([each.coupling_w_m2k for each in made_of])
        view = np.array([each.sky_view for each in surfaces])
        # Columns are hours from here on.
        air_k, direct = (each(hours)[:, None] for each in (w.air_k, w.direct_wm2))
        light = shade_light_wm2(w, hours[:, None], view)
        sunlight = np.stack([light, light + direct], axis=1)
        long_wave = view * w.sky_wm2(hours)[:, None] + (1.0 - view) * STEFAN_BOLTZMANN * air_k**4
        convection = 5.7 + 3.8 * w.wind_mps
        wetting = min(8.0 * w.rain_mm_h, 40.0)
        wet_k = np.array([[wet_bulb_k(float(each), w.vapour_hpa)] for each in air_k[:, 0]])
        behind_k = {"mean": np.full_like(air_k, w.mean_air_k), "air": air_k, "room": np.full_like(air_k, ROOM_K)}
        behind = np.concatenate([behind_k[each.behind] for each in made_of], axis=1)
        inflow = self.emissivity * long_wave + convection * air_k + wetting * wet_k + coupling * behind
        self._inflow = absorptivity * sunlight + inflow[:, None]
        self._conductance = convection + wetting + coupling

    def inflow_wm2(self, kelvin: NDArray[np.float64], k: int) -> NDArray[np.float64]:
        """Return the heat (2, N) that surfaces of these temperatures (2, N) take up at the k-th hour, W/m²."""
        own = self.emissivity * STEFAN_BOLTZMANN * kelvin**4
        return np.asarray(self._inflow[k] - self._conductance * kelvin - own)

    def after(self, kelvin: NDArray[np.float64], k: int, step_s: float) -> NDArray[np.float64]:
        """Return the temperatures (2, N) a step later, at the k-th hour: Euler's implicit step, linearised."""
        stiffness = self._conductance + 4.0 * self.emissivity * STEFAN_BOLTZMANN * kelvin**3
        return np.asarray(kelvin + self.inflow_wm2(kelvin, k) / (self._capacity / step_s + stiffness))


def shade_light_wm2(weather: Weather, hour: ArrayLike, sky_view: ArrayLike) -> NDArray[np.float64]:
    """Return the sunlight (...) that falls from the sky and from lit ground on a surface in the shade.

    ``v D + (1 - v) 0.2 (S z + D)``, see above.

    Args:
        hour, sky_view: (...), of shapes that go together.
    """
    view, diffuse = np.asarray(sky_view), weather.diffuse_wm2(hour)
    level = weather.direct_wm2(hour) * np.maximum(weather.towards_sun(hour)[..., 2], 0.0) + diffuse
    return np.asarray(view * diffuse + (1.0 - view) * _GROUND_ALBEDO * level)


def wet_bulb_k(air_k: float, vapour_hpa: float) -> float:
    """Return the wet-bulb temperature of air by Stull (2011), who gives it for 5 to 99 % of humidity, within 1 K."""
    celsius = air_k - 273.15
    saturated_hpa = 6.11 * np.exp(17.6 * celsius / (celsius + 243.0))
    percent = float(np.clip(100.0 * vapour_hpa / saturated_hpa, 5.0, 99.0))
    return 273.15 + float(
        celsius * np.arctan(0.151977 * np.sqrt(percent + 8.313659))
        + np.arctan(celsius + percent)
        - np.arctan(percent - 1.676331)
        + 0.00391838 * percent**1.5 * np.arctan(0.023101 * percent)
        - 4.686035
    )


def worn_k(weather: Weather, hour: float, insulation_clo: float, *, skin_k: float = 306.0) -> float:
    """Return the temperature of the outside of clothes, in the shade: what passes through them, they give off.

    ``(T_skin - T) / R = h (T - T_air) + 0.95 s (T⁴ - T_around⁴)``, with 0.155 m² K/W for each clo (ISO 9920) and half
    of what is around being sky.

    Args:
        insulation_clo: 0.05 for skin itself, 0.6 for light clothes, 1 to 1.5 for a coat.
        skin_k: of covered skin.
    """
    check("insulation_clo", insulation_clo > 0, "a number > 0", insulation_clo)
    air_k = float(weather.air_k(hour))
    resistance = _CLO_M2K_W * insulation_clo
    convection = 5.7 + 3.8 * weather.wind_mps
    around = 0.5 * float(weather.sky_wm2(hour)) + 0.5 * STEFAN_BOLTZMANN * air_k**4
    kelvin = 0.5 * (skin_k + air_k)
    for _ in range(8):  # Newton's method doubles the digits each time.
        excess = (skin_k - kelvin) / resistance - convection * (kelvin - air_k)
        excess += 0.95 * (around - STEFAN_BOLTZMANN * kelvin**4)
        kelvin += excess / (1.0 / resistance + convection + 4.0 * 0.95 * STEFAN_BOLTZMANN * kelvin**3)
    return kelvin
