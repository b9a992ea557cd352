"""Sun, air and sky of a day against the almanac and limits that physics sets."""

from __future__ import annotations

import numpy as np
import pytest

from sim.thermal.radiance import Air, air_mass, band_radiance, sky_radiance
from sim.thermal.weather import STEFAN_BOLTZMANN, Weather, draw_weather


@pytest.mark.parametrize(("day", "elevation_deg"), [(172, 90 - 36 + 23.45), (355, 90 - 36 - 23.45), (81, 90 - 36)])
def test_the_sun_at_noon_stands_as_high_as_the_almanac_says(day, elevation_deg):
    towards = Weather(latitude_deg=36.0, day_of_year=day).towards_sun(12.0)
    assert np.degrees(np.arcsin(towards[2])) == pytest.approx(elevation_deg, abs=0.5)
    np.testing.assert_allclose(np.linalg.norm(towards), 1.0)


def test_the_sun_rises_in_the_east_and_stands_in_the_south():
    # A camera that looks to the south has the east on its left.
    south = Weather(x_bearing_deg=180.0, day_of_year=81)
    assert south.towards_sun(12.0)[0] > 0.5
    assert abs(south.towards_sun(12.0)[1]) < 1e-9
    assert south.towards_sun(7.0)[1] > 0.9
    assert south.towards_sun(17.0)[1] < -0.9
    east = Weather(x_bearing_deg=90.0, day_of_year=81)
    assert east.towards_sun(7.0)[0] > 0.9


def test_at_the_equinox_day_and_night_are_equal():
    hours = np.linspace(0.0, 24.0, 2881)
    up = Weather(day_of_year=81).towards_sun(hours)[:, 2] > 0
    assert up.mean() == pytest.approx(0.5, abs=0.005)
    assert Weather().direct_wm2(0.0) == 0.0
    assert Weather().diffuse_wm2(0.0) == pytest.approx(0.0)


def test_a_clear_noon_has_the_sun_of_textbooks_and_clouds_take_it():
    clear, covered = Weather(cloud=0.0, day_of_year=172), Weather(cloud=1.0, day_of_year=172)
    assert 850 < float(clear.direct_wm2(12.0)) < 1000
    assert float(covered.direct_wm2(12.0)) == 0.0
    # Kasten and Czeplak: a quarter of the light passes a closed cover.
    level = float(clear.direct_wm2(12.0)) * float(clear.towards_sun(12.0)[2]) + float(clear.diffuse_wm2(12.0))
    assert float(covered.diffuse_wm2(12.0)) == pytest.approx(0.25 * level)


def test_the_sky_in_long_wave_is_colder_than_the_air_when_clear():
    clear, covered = Weather(cloud=0.0), Weather(cloud=1.0)
    black = STEFAN_BOLTZMANN * float(clear.air_k(6.0)) ** 4
    assert 0.7 * black < float(clear.sky_wm2(6.0)) < 0.9 * black
    assert float(covered.sky_wm2(6.0)) == pytest.approx(black)


def test_the_clear_sky_is_coldest_overhead_and_as_warm_as_the_air_at_the_horizon():
    air = Air(temperature_k=290.0, zenith_emissivity=0.3)
    radiance = sky_radiance(air, np.linspace(0.0, 1.0, 40))
    assert (np.diff(radiance) < 0).all()
    assert radiance[-1] == pytest.approx(0.3 * band_radiance(290.0), rel=2e-3)
    assert radiance[0] == pytest.approx(float(band_radiance(290.0)), rel=1e-4)
    covered = sky_radiance(Air(cloud=1.0, cloud_k=280.0), np.array([0.1, 0.9]))
    np.testing.assert_allclose(covered, band_radiance(280.0))


def test_air_mass_is_that_of_the_tables():
    # Kasten and Young (1989), table: 30, 10 and 0 degrees.
    np.testing.assert_allclose(
        air_mass(np.sin(np.radians([90.0, 30.0, 10.0, 0.0]))), [1, 1.994, 5.585, 37.92], rtol=2e-3
    )


def test_rain_and_vapour_make_the_air_dim():
    dry, moist, wet = (Weather(vapour_hpa=v, rain_mm_h=r).air(9.0) for v, r in ((5.0, 0.0), (20.0, 0.0), (20.0, 8.0)))
    assert 1e-4 < dry.attenuation_per_m < moist.attenuation_per_m < wet.attenuation_per_m < 3e-3
    assert dry.zenith_emissivity < moist.zenith_emissivity
    # ITU-R P.1814: 8 mm/h cost 5.9 dB/km.
    assert wet.attenuation_per_m - moist.attenuation_per_m == pytest.approx(1e-3 * 5.86 / 4.343, rel=0.01)


def test_days_are_drawn_from_the_generator_alone():
    first, again = (
        draw_weather(np.random.default_rng(4), day_of_year=100, latitude_deg=36, x_bearing_deg=90) for _ in "ab"
    )
    assert first == again
    rng = np.random.default_rng(5)
    days = [draw_weather(rng, day_of_year=200, latitude_deg=36, x_bearing_deg=90) for _ in range(200)]
    summer = np.mean([day.mean_air_k for day in days])
    assert summer == pytest.approx(295.0, abs=1.0)
    # The further covered, the less the day swings.
    assert np.corrcoef([day.cloud for day in days], [day.swing_k for day in days])[0, 1] < -0.8


@pytest.mark.parametrize(("name", "value"), [("cloud", 1.2), ("latitude_deg", 80.0), ("wind_mps", -1.0)])
def test_impossible_weather_is_refused(name, value):
    with pytest.raises(ValueError, match=f"^{name}: expected a number in"):
        Weather(**{name: value})
