"""Koschmieder's law: against NumPy, and its limits."""

from __future__ import annotations

import numpy as np
import pytest

from sim.shaders.atmosphere import Air, extinction_of_fog, extinction_of_rain, transmittance_row, veil_row

WIDTH, HEIGHT, FOCAL_PX = 64, 48, 60.0


def air(beta_per_m: float) -> Air:
    ray = np.array([1.0 / FOCAL_PX, 0.5 * WIDTH, 0.5 * HEIGHT], np.float32)
    return Air(np.float32(beta_per_m), np.full(3, 10.0, np.float32), ray)


@pytest.mark.parametrize("beta_per_m", [0.0, 1e-4, 0.013, 0.065])
@pytest.mark.parametrize("row", [0, 24, 47])
def test_what_comes_through_is_the_exponential_of_the_distance(beta_per_m, row):
    depth_m = np.geomspace(0.5, 150.0, WIDTH).astype(np.float32)
    left = np.empty(WIDTH, np.float32)
    transmittance_row(air(beta_per_m), row, depth_m, left)
    x, y = (np.arange(WIDTH) + 0.5 - 0.5 * WIDTH) / FOCAL_PX, (row + 0.5 - 0.5 * HEIGHT) / FOCAL_PX
    distance_m = depth_m * np.sqrt(1.0 + x**2 + y**2)
    np.testing.assert_allclose(left, np.exp(-np.minimum(beta_per_m * distance_m, 12.0)), rtol=1e-4, atol=1e-6)


def test_at_the_visibility_a_fiftieth_of_the_contrast_is_left():
    assert np.exp(-extinction_of_fog(200.0) * 200.0) == pytest.approx(0.02, rel=1e-3)
    assert extinction_of_fog(np.inf) == 0.0
    assert extinction_of_rain(0.0) == 0.0


def test_the_veil_goes_from_the_surface_to_the_air():
    left, radiance = np.array([1.0, 0.5, 0.0], np.float32), np.array([4.0, 4.0, 4.0], np.float32)
    veil_row(left, np.float32(10.0), radiance)
    np.testing.assert_allclose(radiance, [4.0, 7.0, 10.0])
