"""The colour of glowing things against Planck's law in narrow bands and the book's colours of lamps."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.shaders.colour import LUMINANCE_WEIGHTS, WHITE_K, black_body_rgb


def _planck(wavelength_m: float, temperature_k: float) -> float:
    """Spectral exitance from h, c and k, up to a factor."""
    h, c, k = 6.62607015e-34, 299_792_458.0, 1.380649e-23
    return 1.0 / (wavelength_m**5 * (np.exp(h * c / (wavelength_m * k * temperature_k)) - 1.0))


def test_white_is_white():
    np.testing.assert_allclose(black_body_rgb(WHITE_K), [1.0, 1.0, 1.0], rtol=1e-12)


@given(st.floats(1000.0, 40_000.0))
def test_luminance_is_one_and_no_channel_is_dark(temperature_k):
    rgb = black_body_rgb(temperature_k)
    assert rgb @ LUMINANCE_WEIGHTS == pytest.approx(1.0)
    assert (rgb > 0).all()


@given(st.floats(1000.0, 39_000.0))
def test_hotter_is_bluer(temperature_k):
    cooler, hotter = black_body_rgb(temperature_k), black_body_rgb(temperature_k * 1.02)
    assert hotter[0] / hotter[1] < cooler[0] / cooler[1]
    assert hotter[2] / hotter[1] > cooler[2] / cooler[1]


@pytest.mark.parametrize("temperature_k", [2400.0, 2856.0, 4000.0, 10_000.0])
def test_ratios_are_those_of_plancks_law_at_the_filters_middles(temperature_k):
    ratios = [_planck(at, temperature_k) / _planck(at, WHITE_K) for at in (600e-9, 540e-9, 460e-9)]
    expected = np.array(ratios) / ratios[1]
    rgb = black_body_rgb(temperature_k)
    # Bands of some 80 nm see a little of what lies beside.
    np.testing.assert_allclose(rgb / rgb[1], expected, rtol=0.05)


@pytest.mark.parametrize("temperature_k", [999.0, 40_001.0, float("nan")])
def test_impossible_temperatures_are_named(temperature_k):
    with pytest.raises(ValueError, match=r"temperature_k: expected 1000 to 40000 K, got"):
        black_body_rgb(temperature_k)
