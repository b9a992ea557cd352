"""Radiance in the band: black bodies, and water beside its constants."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.constants import Boltzmann, Planck, speed_of_light
from scipy.integrate import quad

from sim.thermal.radiance import (
    COLDEST_K,
    EXTINCTION_INDEX,
    HOTTEST_K,
    REFRACTIVE_INDEX,
    WAVELENGTH_M,
    apparent_temperature_k,
    band_radiance,
    band_slope,
    reflectance,
    spectral_reflectance,
)


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


def _by_angles(degrees: float, index: complex) -> float:
    """Fresnel's equations with the complex angle of refraction by Snell's law."""
    incident = np.radians(degrees)
    refracted = np.arcsin(np.sin(incident) / index)
    r_s = -np.sin(incident - refracted) / np.sin(incident + refracted)
    r_p = np.tan(incident - refracted) / np.tan(incident + refracted)
    return 0.5 * (abs(r_s) ** 2 + abs(r_p) ** 2)


@given(st.floats(1.0, 89.0))
def test_reflectances_are_fresnels(degrees):
    found = spectral_reflectance(np.cos(np.radians(degrees)))
    for k, index in enumerate(REFRACTIVE_INDEX + 1j * EXTINCTION_INDEX):
        assert found[k] == pytest.approx(_by_angles(degrees, index), rel=1e-9)


@pytest.mark.parametrize(("degrees", "emissivity"), [(0.0, 0.99), (60.0, 0.96), (70.0, 0.90), (80.0, 0.70)])
def test_smooth_water_emits_as_published_at_10_um(degrees, emissivity):
    # To the two digits that models of a sea without wind agree on (Masuda et al. 1988; Wu and Smith 1997).
    at = list(np.round(1e6 * WAVELENGTH_M)).index(10)
    found = 1.0 - spectral_reflectance(np.cos(np.radians(degrees)))[at]
    assert found == pytest.approx(emissivity, abs=0.006)


def test_the_band_is_near_its_middle_and_grazing_light_is_all_reflected():
    for cosine in (0.1, 0.3, 1.0):
        spectral = spectral_reflectance(cosine)
        assert spectral.min() < reflectance(cosine) < spectral.max()
    assert float(reflectance(0.0)) == pytest.approx(1.0)
