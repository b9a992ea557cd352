"""Reflection of water in the thermal band against published values and Fresnel's equations in another form."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.thermal.radiance import EXTINCTION_INDEX, REFRACTIVE_INDEX, WAVELENGTH_M, reflectance, spectral_reflectance


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
