"""Radiance in the thermal band against Planck's law summed by SciPy, and water against published values."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.constants import Boltzmann, Planck, speed_of_light
from scipy.integrate import quad

from sim.thermal.radiance import COLDEST_K, HOTTEST_K, apparent_temperature_k, band_radiance, band_slope


def _planck(wavelength_m: float, kelvin: float) -> float:
    photon = Planck * speed_of_light / (wavelength_m * Boltzmann * kelvin)
    return 2 * Planck * speed_of_light**2 / wavelength_m**5 / np.expm1(photon)


@pytest.mark.parametrize("kelvin", [COLDEST_K, 180.0, 233.0, 273.15, 300.0, 423.0, HOTTEST_K])
def test_the_band_is_plancks_law_summed(kelvin):
    summed, _ = quad(_planck, 8e-6, 14e-6, args=(kelvin,), epsabs=0, epsrel=1e-11)
    assert float(band_radiance(kelvin)) == pytest.approx(summed, rel=1e-9)


@given(st.floats(COLDEST_K + 1, HOTTEST_K - 1))
def test_the_slope_is_that_of_the_radiance(kelvin):
    rise = band_radiance(kelvin + 0.05) - band_radiance(kelvin - 0.05)
    assert float(band_slope(kelvin)) == pytest.approx(float(rise) / 0.1, rel=1e-5)


@given(st.floats(200.0, HOTTEST_K))
@settings(deadline=None)
def test_apparent_temperature_is_the_inverse(kelvin):
    assert float(apparent_temperature_k(band_radiance(kelvin))) == pytest.approx(kelvin, abs=1e-3)


@pytest.mark.parametrize("kelvin", [119.0, 801.0, float("nan")])
def test_temperatures_out_of_range_are_refused(kelvin):
    with pytest.raises(ValueError, match=r"temperature_k: expected numbers in \[120, 800\], got"):
        band_radiance(kelvin)
