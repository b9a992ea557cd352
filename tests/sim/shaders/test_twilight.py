"""Light of the sun and the sky: published values, continuity, clouds."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.shaders.twilight import (
    CLOUD_TRANSMITTANCE,
    NIGHT_LX,
    SKY_LX,
    SUN_LX,
    clear_sky_lx,
    sun_and_sky_lx,
)


@pytest.mark.parametrize(
    ("elevation_deg", "expected_lx"), [(90.0, 129_000.0), (0.0, 759.0), (-6.0, 3.4), (-12.0, 0.008), (-18.0, 0.00065)]
)
def test_the_curve_has_the_published_values(elevation_deg, expected_lx):
    # Civil twilight ends at 3.4 lx, nautical at 0.008, astronomical at 0.0006 (Seidelmann 1992).
    assert clear_sky_lx(elevation_deg) == pytest.approx(expected_lx, rel=0.05)


def test_the_pieces_of_the_curve_meet():
    for edge in (20.0, 5.0, -0.8, -5.0, -12.0):
        assert clear_sky_lx(edge - 1e-6) == pytest.approx(clear_sky_lx(edge), rel=0.03)


@given(st.floats(12.0, 90.0))
def test_by_day_the_light_is_constant(elevation_deg):
    assert sun_and_sky_lx(elevation_deg) == (SUN_LX, SKY_LX)


@given(st.floats(-90.0, 11.9), st.floats(0.01, 5.0))
def test_a_lower_sun_never_brings_more_light(elevation_deg, lower_by):
    higher, lower = sun_and_sky_lx(elevation_deg), sun_and_sky_lx(elevation_deg - lower_by)
    assert lower[0] <= higher[0]
    # Below -18 degrees nothing changes; the curve's pieces meet within 3 %.
    assert lower[1] <= 1.03 * higher[1]


def test_no_sun_below_the_horizon_and_never_a_black_sky():
    sun_lx, sky_lx = sun_and_sky_lx(-90.0)
    assert sun_lx == 0.0
    assert sky_lx > NIGHT_LX


@given(st.floats(-20.0, 90.0), st.sampled_from(sorted(CLOUD_TRANSMITTANCE)))
def test_clouds_hide_the_sun_and_never_add_light(elevation_deg, cloud):
    clear, cloudy = sun_and_sky_lx(elevation_deg), sun_and_sky_lx(elevation_deg, cloud)
    level_lx = clear[0] * np.sin(np.radians(max(elevation_deg, 0.0))) + clear[1]
    if cloud != "none":
        assert cloudy[0] == 0.0
        assert 0.0 < cloudy[1] <= level_lx
