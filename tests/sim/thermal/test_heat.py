"""Temperatures of surfaces against an independent solver, a sum of energy, and states without change."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from sim.thermal.heat import MATERIALS, STEP_H, Balance, Material, Surface, course, wet_bulb_k, worn_k
from sim.thermal.weather import STEFAN_BOLTZMANN, Weather

DAY = Weather(cloud=0.2, wind_mps=3.0, swing_k=9.0)
KINDS = [Surface(MATERIALS["asphalt"]), Surface(MATERIALS["brick"], 0.5), Surface(MATERIALS["roof felt"])]
KINDS += [Surface(MATERIALS["painted steel"], 0.5), Surface(MATERIALS["glass"], 0.5)]


def _inflow_wm2(weather: Weather, surface: Surface, kelvin: float, hour: float, *, is_sunny: bool) -> float:
    """The module's equation, written anew term by term."""
    m, view, air_k = surface.material, surface.sky_view, float(weather.air_k(hour))
    direct, diffuse = float(weather.direct_wm2(hour)), float(weather.diffuse_wm2(hour))
    sine = max(float(weather.towards_sun(hour)[2]), 0.0)
    sun = m.absorptivity * (is_sunny * direct + view * diffuse + (1 - view) * 0.2 * (direct * sine + diffuse))
    around = view * float(weather.sky_wm2(hour)) + (1 - view) * STEFAN_BOLTZMANN * air_k**4
    long_wave = m.emissivity * (around - STEFAN_BOLTZMANN * kelvin**4)
    wind = (5.7 + 3.8 * weather.wind_mps) * (air_k - kelvin)
    wet = min(8.0 * weather.rain_mm_h, 40.0) * (wet_bulb_k(air_k, weather.vapour_hpa) - kelvin)
    behind = {"mean": weather.mean_air_k, "air": air_k, "room": 293.0}[m.behind]
    return sun + long_wave + wind + wet + m.coupling_w_m2k * (behind - kelvin)


@pytest.mark.heavy
@pytest.mark.parametrize("rain_mm_h", [0.0, 2.0])
@pytest.mark.parametrize("surface", KINDS)
def test_courses_are_those_of_an_independent_solver(surface, rain_mm_h):
    weather = Weather(cloud=0.2, wind_mps=3.0, swing_k=9.0, rain_mm_h=rain_mm_h)
    found = course([surface], weather, 5.0, 20.0)
    for is_sunny, kelvin in ((False, found.shaded_k), (True, found.sunlit_k)):
        solved = solve_ivp(
            lambda hour, k, sunny=is_sunny: [
                3600.0 / surface.material.capacity_j_m2k * _inflow_wm2(weather, surface, k[0], hour, is_sunny=sunny)
            ],
            (-19.0, 20.0),
            [weather.mean_air_k],
            method="LSODA",
            t_eval=[6.0, 9.0, 13.0, 19.0],
            max_step=0.25,
            rtol=1e-6,
        )
        for hour, wanted in zip(solved.t, solved.y[0], strict=True):
            assert found.at(hour)[int(is_sunny)][0] == pytest.approx(wanted, abs=0.15)
        assert kelvin.shape == (len(found.hours), 1)


def test_heat_that_flows_in_warms_what_it_flows_into():
    hours = 6.0 + STEP_H * np.arange(400)
    balance, kelvin = Balance(KINDS, DAY, hours), np.full((2, len(KINDS)), 285.0)
    capacity = np.array([each.material.capacity_j_m2k for each in KINDS])
    gained, before = np.zeros_like(kelvin), kelvin
    for k in range(1, len(hours)):
        kelvin = balance.after(kelvin, k, 3600.0 * STEP_H)
        gained += balance.inflow_wm2(kelvin, k) * 3600.0 * STEP_H
    # Implicit steps take the inflow at their end; linearising T⁴ leaves a remainder.
    np.testing.assert_allclose(gained, capacity * (kelvin - before), rtol=2e-3, atol=200.0)


@given(st.floats(0.0, 1.0), st.floats(0.0, 12.0), st.floats(0.0, 1.0))
@settings(max_examples=15, deadline=None)
def test_sun_warms_more_than_shade_and_nothing_runs_away(cloud, wind_mps, view):
    weather = Weather(cloud=cloud, wind_mps=wind_mps)
    found = course([Surface(MATERIALS[name], view) for name in ("asphalt", "white paint")], weather, 6.0, 16.0)
    assert (found.sunlit_k >= found.shaded_k - 1e-9).all()
    assert (found.shaded_k > weather.mean_air_k - 25).all()
    assert (found.sunlit_k < weather.mean_air_k + 75).all()


def test_on_a_clear_calm_night_thin_roofs_are_colder_than_the_air_and_walls_between():
    night = Weather(cloud=0.0, wind_mps=0.5)
    found = course([Surface(MATERIALS["roof sheet"], view) for view in (1.0, 0.5)], night, 2.0, 3.0)
    roof, wall = found.shaded_k[0]
    assert roof < float(night.air_k(2.0)) - 3.0
    assert roof < wall < float(night.air_k(2.0))


def test_where_a_course_starts_makes_no_difference():
    early, late = course(KINDS, DAY, 0.0, 14.0), course(KINDS, DAY, 9.0, 14.0)
    np.testing.assert_allclose(early.at(13.0), late.at(13.0), atol=0.02)
    for hour in (9.0, 14.0):
        late.at(hour)
    with pytest.raises(ValueError, match=r"^hour: expected a number in \[9, "):
        late.at(8.9)
    with pytest.raises(ValueError, match=r"^last_hour: expected a number > first_hour = 9, got 9"):
        course(KINDS, DAY, 9.0, 9.0)


def test_clothes_pass_on_what_the_skin_gives():
    outside = [worn_k(DAY, 6.0, clo) for clo in (0.05, 0.6, 1.5)]
    air_k = float(DAY.air_k(6.0))
    assert 306.0 > outside[0] > outside[1] > outside[2] > air_k - 3.0
    kelvin, around = outside[1], 0.5 * (float(DAY.sky_wm2(6.0)) + STEFAN_BOLTZMANN * air_k**4)
    given_off = (5.7 + 3.8 * 3.0) * (kelvin - air_k) + 0.95 * (STEFAN_BOLTZMANN * kelvin**4 - around)
    assert (306.0 - kelvin) / (0.155 * 0.6) == pytest.approx(given_off, rel=1e-9)


def test_the_wet_bulb_is_that_of_the_paper():
    # Stull (2011): 13.7 °C at 20 °C and 50 %.
    saturated_hpa = 6.11 * np.exp(17.6 * 20.0 / 263.0)
    assert wet_bulb_k(293.15, 0.5 * saturated_hpa) == pytest.approx(273.15 + 13.7, abs=0.1)


def test_materials_are_within_what_there_is():
    with pytest.raises(ValueError, match=r"^emissivity: expected a number in \[0, 1\], got 1.2"):
        Material(1.2, 0.5, 1e4, 1.0)
    with pytest.raises(ValueError, match=r"^sky_view: expected a number in \[0, 1\], got -1"):
        Surface(MATERIALS["brick"], -1.0)
