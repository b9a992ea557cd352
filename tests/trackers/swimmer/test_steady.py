"""Steady ways: what a slight curve explains goes on along it, all else does not."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from trackers.swimmer.method import steady_way

AHEAD = np.arange(1.0, 201.0)


def curve(t: NDArray[np.float64], speed_px: float, bend_px: float) -> NDArray[np.float64]:
    """Return places (T, 2) at constant speed along x, and off it by ``bend_px`` 100 frames from frame 0."""
    return np.stack([50.0 + speed_px * t, 80.0 + bend_px * (t / 100.0) ** 2], axis=1)


def past(speed_px: float, bend_px: float, noise_px: float, seed: int) -> NDArray[np.float64]:
    x = curve(np.arange(-99.0, 1.0), speed_px, bend_px)
    return x + noise_px * np.random.default_rng(seed).normal(size=x.shape)


def test_a_straight_way_goes_on() -> None:
    way = steady_way(past(0.15, 0.0, 0.0, 0), AHEAD, 0.1)
    np.testing.assert_allclose(way.place_px, curve(AHEAD, 0.15, 0.0), atol=1e-6)
    assert way.weight == pytest.approx(1.0)


def test_a_bend_goes_on() -> None:
    way = steady_way(past(0.15, 0.5, 0.0, 0), AHEAD, 0.1)
    error_px = np.linalg.norm(way.place_px - curve(AHEAD, 0.15, 0.5), axis=1)
    # Without the bend it would be 4.
    assert error_px[-1] == pytest.approx(0.0, abs=0.2)
    assert way.weight > 0.99


@given(st.floats(-np.pi, np.pi), st.booleans(), st.integers(0, 100))
def test_it_turns_and_mirrors_with_the_past(angle: float, mirrored: bool, seed: int) -> None:
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s], [s, c]]) @ np.diag([1.0, -1.0 if mirrored else 1.0])
    x = past(0.3, 0.8, 0.3, seed)
    first, second = steady_way(x, AHEAD, 0.3), steady_way(x @ turn.T, AHEAD, 0.3)
    np.testing.assert_allclose(second.place_px, first.place_px @ turn.T, atol=1e-6)
    np.testing.assert_allclose(second.radius_px, first.radius_px, rtol=1e-6)
    assert second.weight == pytest.approx(first.weight)


def test_with_noise_it_errs_less_than_constant_acceleration_and_its_region_holds() -> None:
    errors_px, accelerated_px, inside = [], [], []
    t = np.arange(-99.0, 1.0)
    for seed in range(200):
        x = past(0.15, 0.3, 0.3, seed)
        way = steady_way(x, AHEAD, 0.3)
        true = curve(AHEAD, 0.15, 0.3)[[49, 199]]
        errors_px.append(np.linalg.norm(way.place_px[[49, 199]] - true, axis=1))
        parabola = np.polynomial.polynomial.polyfit(t, x, 2)
        ahead = np.polynomial.polynomial.polyval(AHEAD[[49, 199]], parabola).T
        accelerated_px.append(np.linalg.norm(ahead - true, axis=1))
        inside.append(errors_px[-1] <= way.radius_px[[49, 199]])
        assert way.weight > 0.9
    assert (np.mean(errors_px, axis=0) < 0.85 * np.mean(accelerated_px, axis=0)).all()
    assert (np.mean(inside, axis=0) > 0.9).all()


def test_a_fish_that_turns_and_darts_is_not_steady() -> None:
    rng = np.random.default_rng(1)
    for _ in range(30):
        heading = np.cumsum(0.15 * rng.normal(size=100))
        steps = 3.0 * np.exp(0.5 * rng.normal(size=100))[:, None] * np.stack([np.cos(heading), np.sin(heading)], axis=1)
        assert steady_way(np.cumsum(steps, axis=0), AHEAD, 0.3).weight < 0.1
