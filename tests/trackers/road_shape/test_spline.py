"""The spline against SciPy's."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from trackers.road_shape.road_model import evaluate_spline, fit_cubic_spline


@settings(deadline=None)
@given(st.integers(3, 9), st.integers(0, 10_000))
def test_is_scipys_with_the_same_end_curvatures(count: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    knots = np.cumsum(rng.uniform(5, 30, count)) - 40
    values = rng.uniform(-50, 50, count)
    pieces = fit_cubic_spline(knots, values)
    ends = tuple((2, float(curvature)) for curvature in (2 * pieces[0, 1], 2 * pieces[-1, 1]))
    reference = CubicSpline(knots, values, bc_type=ends)
    at = np.linspace(knots[0] - 30, knots[-1] + 30, 80)
    got, slopes = evaluate_spline(knots, pieces, at)
    scale = np.abs(reference(at)).max() + 1
    np.testing.assert_allclose(got, reference(at), atol=1e-9 * scale)
    np.testing.assert_allclose(slopes, reference(at, 1), atol=1e-9 * scale)
    # The ends are parabolas, so the curvature goes on unchanged outside.
    assert abs(pieces[0, 0]) < 1e-12
    assert abs(pieces[-1, 0]) < 1e-12


def test_a_parabola_is_met_exactly_and_goes_on_outside() -> None:
    knots = np.array([-20.0, 0.0, 7.0, 30.0])
    pieces = fit_cubic_spline(knots, 3 + 0.5 * knots + 0.01 * knots**2)
    at = np.array([-100.0, -3.0, 90.0])
    values, slopes = evaluate_spline(knots, pieces, at)
    np.testing.assert_allclose(values, 3 + 0.5 * at + 0.01 * at**2)
    np.testing.assert_allclose(slopes, 0.5 + 0.02 * at)


def test_two_points_are_a_straight_line() -> None:
    knots = np.array([0.0, 4.0])
    values, slopes = evaluate_spline(knots, fit_cubic_spline(knots, np.array([1.0, 3.0])), np.array([-2.0, 2.0, 10.0]))
    np.testing.assert_allclose(values, [0.0, 2.0, 6.0])
    np.testing.assert_allclose(slopes, 0.5)
