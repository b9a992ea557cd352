"""Temperatures of engines, clothes and the wall that the tide wets."""

from __future__ import annotations

import copy
import dataclasses

import numpy as np
import pytest

from scenarios.harbour.conditions import DAYS_BEFORE, draw_conditions
from scenarios.harbour.presets import PRESETS
from scenarios.harbour.scenery import LAMP, VENT, WALL_BANDS, WALL_FOOT_M, WALL_TOP_M
from scenarios.harbour.warmth import (
    DayWarmth,
    car_materials,
    draw_clothes,
    excess_k,
    gull_kelvins,
    heated_k,
    person_kelvins,
    wet_wall,
)
from sim.meshes.thermal_paint import CarPart, PersonPart
from sim.thermal.weather import Weather


def rng_of(seed: int) -> np.random.Generator:
    return np.random.Generator(np.random.PCG64(seed))


@pytest.fixture(scope="module")
def warmth() -> DayWarmth:
    conditions = draw_conditions(PRESETS["paper-d"], rng_of(1))
    kinds = [("granite", 0.5), *((name, 0.7) for name in car_materials("dark paint"))]
    made = DayWarmth(conditions.days[DAYS_BEFORE], kinds, 6.0, 7.0)
    made.at(6.5)
    return made


def test_engines_warm_up_and_cool_down_as_integrated_step_by_step() -> None:
    time_s = np.arange(0.0, 8000.0, 7.0)
    runs, goal, warms, cools = [(-300.0, 500.0), (2000.0, 2600.0)], 20.0, 400.0, 1500.0
    step, now, integrated = 0.5, 0.0, []
    for t in np.arange(-300.0, time_s[-1] + step, step):
        if t >= 0.0 and abs(t / 7.0 - round(t / 7.0)) < 1e-9:
            integrated.append(now)
        runs_now = any(start <= t < stop for start, stop in runs)
        now += step * ((goal - now) / warms if runs_now else -now / cools)
    np.testing.assert_allclose(excess_k(time_s, runs, goal, warms, cools), integrated[: len(time_s)], atol=0.02)
    assert not excess_k(time_s, [], goal, warms, cools).any()


def test_a_car_that_drove_in_has_a_hot_bonnet_and_cools_after_it_stopped() -> None:
    time_s = np.array([0.0, 60.0, 1800.0, 4000.0])
    heated = heated_k("car", time_s, [(-600.0, 50.0)])
    assert heated[1, CarPart.BONNET] > 12.0
    assert heated[1, CarPart.TYRE] > 6.0
    assert heated[1, CarPart.ROOF] == 0.0
    warm = heated[:, [CarPart.BONNET, CarPart.TYRE, CarPart.WHEEL, CarPart.UNDERSIDE]]
    assert (np.diff(warm[1:], axis=0) < 0).all()
    assert (warm[3] < 0.35 * warm[1]).all()


def in_rain(warmth: DayWarmth, rain_mm_h: float) -> DayWarmth:
    other = copy.copy(warmth)
    other.weather = dataclasses.replace(warmth.weather, rain_mm_h=rain_mm_h)
    return other


def test_skin_is_warmer_than_clothes_and_clothes_than_air(warmth: DayWarmth) -> None:
    air_k = float(warmth.weather.air_k(6.5))
    shaded, sunlit, _ = person_kelvins(draw_clothes(Weather(mean_air_k=285.0), rng_of(2)), warmth)
    assert shaded[PersonPart.SKIN] == shaded.max()
    assert 300.0 < shaded[PersonPart.SKIN] < 306.0
    assert air_k < shaded[PersonPart.TOP] < shaded[PersonPart.SKIN]
    assert shaded[PersonPart.BACKPACK] < shaded[PersonPart.TOP]
    assert (sunlit > shaded).all()
    clear = copy.copy(warmth)
    clear.weather = dataclasses.replace(warmth.weather, cloud=0.0)
    shaded, sunlit, _ = person_kelvins(draw_clothes(Weather(mean_air_k=285.0), rng_of(2)), clear)
    assert (sunlit > shaded + 0.5).all()
    cold, warm = (
        person_kelvins(draw_clothes(Weather(mean_air_k=air), rng_of(2)), warmth)[0][PersonPart.TOP]
        for air in (278.0, 298.0)
    )
    # In a coat one shows less.
    assert cold < warm - 0.5
    clothes = draw_clothes(warmth.weather, rng_of(2))
    dry, wet = (person_kelvins(clothes, in_rain(warmth, rain))[0] for rain in (0.0, 3.0))
    assert (wet < dry - 0.1).all()
    assert (wet > air_k).all()
    feathers = gull_kelvins(warmth)[0]
    assert air_k < feathers[1] < feathers[0] < feathers[2]


def under(warmth: DayWarmth, hour: float, **weather: float) -> DayWarmth:
    other = copy.copy(warmth)
    other.hour, other.weather = hour, Weather(**weather)
    return other


def test_people_and_gulls_take_up_the_light_that_shade_gets(warmth: DayWarmth) -> None:
    """Against the balance of their own surface without mass: what light brings, leaves by its conductances."""
    clothes, calm = draw_clothes(Weather(), rng_of(2)), {"wind_mps": 1.0, "cloud": 0.5, "swing_k": 0.0}
    noon, night = under(warmth, 12.0, **calm), under(warmth, 0.0, **calm)
    weather = noon.weather
    # Of half a sky, and of ground that throws back a fifth of all that falls on it.
    sky, sun = float(weather.diffuse_wm2(12.0)), float(weather.direct_wm2(12.0))
    light = 0.5 * sky + 0.5 * 0.2 * (sky + sun * float(weather.towards_sun(12.0)[2]))
    assert light > 100.0
    leaves = 5.7 + 3.8 + 6.0 + 1.0 / (0.155 * clothes.clo)
    (shaded, sunlit, _), (dark, moonlit, _) = (person_kelvins(clothes, each) for each in (noon, night))
    np.testing.assert_allclose(shaded - dark, clothes.absorptivity * light / leaves)
    np.testing.assert_allclose(sunlit - dark, clothes.absorptivity * (light + sun) / leaves)
    np.testing.assert_array_equal(dark, moonlit)
    (shaded, sunlit, _), (dark, moonlit, _) = (gull_kelvins(each) for each in (noon, night))
    np.testing.assert_allclose(shaded - dark, 0.3 * light / 17.8)
    np.testing.assert_allclose(sunlit - dark, 0.3 * (light + sun) / 17.8)
    np.testing.assert_array_equal(dark, moonlit)


def test_what_is_heated_from_within_is_warmer_than_air_and_lamps_only_burn_at_night(warmth: DayWarmth) -> None:
    air_k = float(warmth.weather.air_k(6.5))
    shaded, sunlit, _ = warmth.of((VENT, LAMP), 0.5)
    assert shaded[0] > air_k + 5.0
    assert shaded[1] < air_k + 2.0
    np.testing.assert_array_equal(shaded, sunlit)

    night = draw_conditions(PRESETS["hard"], rng_of(3))
    dark = DayWarmth(night.days[-1], [("granite", 0.5)], 22.0, 23.0)
    dark.at(22.5)
    assert dark.of((LAMP,), 0.5)[0][0] > float(dark.weather.air_k(22.5)) + 15.0


def test_the_wall_is_as_cold_as_the_sea_where_it_is_wet_and_dries_from_above(warmth: DayWarmth) -> None:
    conditions = draw_conditions(PRESETS["paper-d"], rng_of(1))
    dry = warmth.of(("granite",) * (WALL_BANDS + 1), 0.5)
    shaded, _, _ = wet_wall(dry, 280.0, conditions, 0.0)
    # From below: the sea's own, then drier and drier up to dry stone.
    like_dry = (shaded - 280.0) / (dry[0] - 280.0)
    level_m = float(conditions.tide.level_m(np.array(0.0)))
    middles_m = WALL_FOOT_M + (np.arange(WALL_BANDS) + 0.5) * (WALL_TOP_M - WALL_FOOT_M) / WALL_BANDS
    assert like_dry[0] == 0.0
    np.testing.assert_allclose(like_dry[1:][middles_m < level_m], 0.0, atol=1e-9)
    assert like_dry[-1] == pytest.approx(1.0)
    assert (np.diff(like_dry[1:]) >= -1e-9).all()
    highest_m = conditions.tide.level_m(-np.arange(0.0, 13 * 3600.0, 60.0)).max()
    assert (like_dry[1:][middles_m > highest_m] == 1.0).all()
    between = (middles_m > level_m + 0.1) & (middles_m < highest_m - 0.1)
    assert ((like_dry[1:][between] > 0.0) & (like_dry[1:][between] < 1.0)).all()


def test_days_differ_and_pictures_of_them_are_spread_evenly() -> None:
    conditions = draw_conditions(PRESETS["standard"], rng_of(7))
    assert conditions.hour(3600.0) == conditions.start_h + 1.0
    clouds = [day.weather.cloud for day in conditions.days]
    winds = [day.weather.wind_mps for day in conditions.days]
    assert len(conditions.days) == DAYS_BEFORE + 1
    assert min(np.ptp(clouds), np.ptp(winds) / 7.0) > 0.1
    times = conditions.background_times(400)
    assert times[0] == -3 * 86400.0
    np.testing.assert_allclose(np.diff(times), 648.0)
    assert times[-1] == pytest.approx(-648.0)
    assert [conditions.day_at(each) for each in (times[0], -86401.0, -86400.0, -1.0, 0.0, 5000.0)] == [0, 1, 2, 2, 3, 3]

    night = draw_conditions(PRESETS["hard"], rng_of(7)).days[-1]
    assert night.weather.rain_mm_h > 0.4
    assert night.waves.significant_m > conditions.days[-1].waves.significant_m


def test_the_paper_s_three_days_differ_in_sun_weather_and_tide() -> None:
    conditions = draw_conditions(PRESETS["paper-d"], rng_of(7))
    assert conditions.start_h == 6.0
    assert 152 <= conditions.days[-1].weather.day_of_year <= 181
    clear, windy, rainy, today = (day.weather for day in conditions.days)
    assert clear.cloud < 0.3 < windy.cloud < 0.8 < min(rainy.cloud, today.cloud)
    assert windy.wind_mps > 3.0 > clear.wind_mps
    assert (clear.rain_mm_h, windy.rain_mm_h, today.rain_mm_h) == (0.0, 0.0, 0.0) != rainy.rain_mm_h
    times = conditions.background_times(300)
    days = [conditions.day_at(each) for each in times.tolist()]
    assert days == sorted(days)
    assert np.bincount(days).tolist() == pytest.approx([100, 100, 100], abs=1)
    assert times[0] == -16 * 86400.0
    assert (np.diff(times) > 0.0).all()
    # At the same hours the water stands high on one day and low on the next of the three.
    level_m = conditions.tide.above_mean_m(times).reshape(3, 100)
    assert max(np.corrcoef(level_m)[[0, 1], [1, 2]]) < 0.0
