"""The rippled surface: dispersion, slopes, statistics."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim.water_surface import RippledSurface, Ripples, angular_frequency, draw_waves


def _surface(seed=3, **ripples):
    waves = draw_waves(Ripples(**ripples), 0.12, np.random.default_rng(seed))
    return RippledSurface(waves, (-0.3, -0.21), (0.3, 0.21), 0.12, 0.12)


def test_the_slowest_ripple_is_that_of_clean_water():
    # Lamb's figures for clean water: 23.1 cm/s at 1.7 cm.
    number_per_m = 2 * np.pi / np.linspace(0.005, 0.1, 2000)
    speed_mps = angular_frequency(number_per_m, 10.0) / number_per_m
    assert speed_mps.min() == pytest.approx(0.231, abs=0.001)
    assert 2 * np.pi / number_per_m[speed_mps.argmin()] == pytest.approx(0.0171, abs=0.0004)


def test_long_waves_in_shallow_water_run_at_the_root_of_depth_times_gravity():
    assert angular_frequency(np.array([0.05]), 0.12)[0] / 0.05 == pytest.approx(np.sqrt(9.81 * 0.12), rel=1e-4)


@settings(deadline=None)
@given(st.floats(-0.3, 0.3), st.floats(-0.21, 0.21), st.floats(0, 60))
def test_slopes_are_those_of_the_height(x, y, time_s):
    surface, step = _surface(), 1e-6
    surface.time_s = time_s
    around = np.array([(x, y), (x + step, y), (x - step, y), (x, y + step), (x, y - step)])
    height, slope_x, slope_y = surface.height_and_slope(around).T
    assert (height[1] - height[2]) / (2 * step) == pytest.approx(slope_x[0], abs=1e-6)
    assert (height[3] - height[4]) / (2 * step) == pytest.approx(slope_y[0], abs=1e-6)


@pytest.mark.parametrize("time_s", [0.0, 7.3, 600.0])
def test_the_grid_is_the_surface(time_s):
    surface = _surface(slope_rms=0.05)
    surface.time_s = time_s
    grid = surface.grid()
    rows, columns = np.mgrid[: grid.values.shape[1] : 9, : grid.values.shape[2] : 9]
    places = grid.first_m + grid.step_m * np.column_stack([columns.ravel(), rows.ravel()])
    exact = surface.height_and_slope(places).T.reshape(3, *rows.shape)
    np.testing.assert_allclose(grid.values[:, ::9, ::9], exact, atol=2e-5)
    assert (grid.first_m < surface.low_m).all()
    last = grid.first_m + grid.step_m * (np.array(grid.values.shape[:0:-1]) - 1)
    assert (last > surface.high_m).all()


def test_slopes_have_the_configured_size_and_no_direction():
    # Of many surfaces: one alone has few waves.
    slopes = np.concatenate([_surface(seed, slope_rms=0.04).grid().values[1:].reshape(2, -1) for seed in range(40)], 1)
    assert np.sqrt((slopes.astype(float) ** 2).sum(axis=0).mean()) == pytest.approx(0.04, rel=0.03)
    assert (slopes[0] ** 2).mean() == pytest.approx((slopes[1] ** 2).mean(), rel=0.2)


def test_a_flat_surface_is_flat():
    assert not _surface(slope_rms=0.0).grid().values.any()


def test_the_same_waves_again():
    np.testing.assert_array_equal(_surface(5).grid().values, _surface(5).grid().values)
    assert (_surface(5).waves.vector_per_m != _surface(6).waves.vector_per_m).all()


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"slope_rms": 0.5}, "slope_rms: expected a number in"),
        ({"wavelengths_m": (0.2, 0.1)}, "wavelengths_m: expected two numbers in ascending order"),
        ({"waves": 0}, "waves: expected a number in"),
    ],
)
def test_impossible_ripples_are_named(wrong, message):
    with pytest.raises(ValueError, match=message):
        Ripples(**wrong)


def test_impossible_water_is_named():
    waves = draw_waves(Ripples(), 0.1, np.random.default_rng(0))
    with pytest.raises(ValueError, match="high_m: expected more than low_m"):
        RippledSurface(waves, (0.0, 0.0), (1.0, 0.0), 0.1, 0.1)
    with pytest.raises(ValueError, match="depth_m: expected a length"):
        RippledSurface(waves, (0.0, 0.0), (1.0, 1.0), 0.1, 0.0)
    with pytest.raises(ValueError, match="refractive_index: expected a number > 1"):
        RippledSurface(waves, (0.0, 0.0), (1.0, 1.0), 0.1, 0.1, 0.9)
