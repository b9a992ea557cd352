"""Systematic resampling: unbiased, with the least variance, and never of zero weights."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from trackers.kernels.particles import circular_mean, normalise_log_weights, systematic_indices

WEIGHTS = hnp.arrays(np.float64, st.integers(1, 60), elements=st.one_of(st.just(0.0), st.floats(1e-12, 1e12))).filter(
    lambda weights: weights.sum() > 0
)


def test_counts_have_the_mean_and_variance_of_systematic_resampling() -> None:
    weights = np.array([0.03, 0.0, 0.37, 0.12, 0.28, 0.2])
    rng = np.random.default_rng(0)
    counts = np.array([np.bincount(systematic_indices(weights, u), minlength=6) for u in rng.random(20_000)])
    expected = 6 * weights
    part = expected - np.floor(expected)
    np.testing.assert_allclose(counts.mean(axis=0), expected, atol=0.015)
    np.testing.assert_allclose(counts.var(axis=0), part * (1 - part), atol=0.015)


@settings(deadline=None)
@given(WEIGHTS, st.floats(0, 1, exclude_max=True))
def test_each_is_taken_its_share_rounded(weights: np.ndarray, offset: float) -> None:
    ancestors = systematic_indices(weights, offset)
    assert len(ancestors) == len(weights)
    assert (np.diff(ancestors) >= 0).all()
    share = weights / weights.sum() * len(weights)
    counts = np.bincount(ancestors, minlength=len(weights))
    assert (np.abs(counts - share) < 1 + 1e-6).all()
    assert (weights[ancestors] > 0).all()


@settings(deadline=None)
@given(hnp.arrays(np.float64, st.integers(1, 40), elements=st.floats(-1e4, 1e4)))
def test_log_weights_are_normalised_as_logsumexp_does(log_weights: np.ndarray) -> None:
    weights, log_likelihood, starved = normalise_log_weights(log_weights)
    reference = np.logaddexp.reduce(log_weights)
    assert not starved
    np.testing.assert_allclose(weights, np.exp(log_weights - reference), rtol=1e-9, atol=1e-300)
    np.testing.assert_allclose(log_likelihood, reference - np.log(len(log_weights)), rtol=1e-9, atol=1e-9)


def test_impossible_weights_count_nothing() -> None:
    weights, _, starved = normalise_log_weights(np.array([np.nan, -np.inf, 3.0, 3.0]))
    assert weights.tolist() == [0.0, 0.0, 0.5, 0.5]
    assert not starved
    weights, _, starved = normalise_log_weights(np.array([np.nan, -np.inf]))
    assert weights.tolist() == [0.5, 0.5]
    assert starved


def test_circular_mean_goes_the_short_way_round() -> None:
    angles = np.array([np.pi - 0.1, -np.pi + 0.1])
    assert abs(abs(circular_mean(angles, np.array([0.5, 0.5]))) - np.pi) < 1e-12
