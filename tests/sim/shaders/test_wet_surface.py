"""Wet surfaces: never brighter than dry ones, energy kept, Fresnel's limits."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.shaders.wet_surface import (
    FILM_REFLECTANCE,
    HEAD_ON,
    THROWN_BACK,
    WATER_INDEX,
    mirrored_share,
    wet_reflectance,
)

SHARES = st.floats(0.0, 1.0, width=32)


@given(SHARES, SHARES)
def test_a_wet_surface_reflects_no_more_than_the_dry_one(rho, wetness):
    wet = wet_reflectance(np.float32(rho), np.float32(wetness))
    assert -1e-6 <= wet <= rho + 1e-6


@given(SHARES)
def test_a_dry_surface_stays_as_it_is(rho):
    assert wet_reflectance(np.float32(rho), np.float32(0.0)) == np.float32(rho)


@given(st.floats(0.0, 0.999))
def test_light_is_absorbed_as_lekner_and_dorf_say(rho):
    # Of their equation: absorbed share A = (1 - R) a / (1 - p (1 - a)), a = 1 - rho; all else comes back.
    absorbed = (1.0 - FILM_REFLECTANCE) * (1.0 - rho) / (1.0 - THROWN_BACK * rho)
    wet = wet_reflectance(np.float32(rho), np.float32(1.0))
    assert FILM_REFLECTANCE + wet == pytest.approx(1.0 - absorbed, abs=1e-4)


def test_water_mirrors_two_percent_head_on_and_all_at_grazing_angles():
    assert pytest.approx(0.02, abs=5e-4) == HEAD_ON
    assert mirrored_share(np.float32(1.0)) == pytest.approx(HEAD_ON)
    assert mirrored_share(np.float32(0.0)) == pytest.approx(1.0)


@given(st.floats(0.35, 1.0))
def test_schlick_is_near_fresnel(cosine):
    sine = np.sqrt(1.0 - cosine**2) / WATER_INDEX
    inner = np.sqrt(1.0 - sine**2)
    parallel = (WATER_INDEX * cosine - inner) / (WATER_INDEX * cosine + inner)
    across = (cosine - WATER_INDEX * inner) / (cosine + WATER_INDEX * inner)
    assert mirrored_share(np.float32(cosine)) == pytest.approx(0.5 * (parallel**2 + across**2), abs=0.03)


def test_the_share_thrown_back_is_that_of_the_refractive_index():
    assert pytest.approx(0.474, abs=2e-3) == THROWN_BACK
