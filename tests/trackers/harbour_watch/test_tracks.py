"""Association and existence beside the sum over all joint events."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from trackers.harbour_watch.tracks import existence, marginals


def brute_force(prior, detected, likelihood, alone):
    """Return the existence (N,), pairs (N, M) and alone (M,) by summing over every joint event.

    Each track exists or not, is missed or has one detection; ``likelihood`` (N, M) includes the density of its score.
    """
    n, m = likelihood.shape
    total, there, pairs, free = 0.0, np.zeros(n), np.zeros((n, m)), np.zeros(m)
    for choice in product(range(-2, m), repeat=n):  # -2: does not exist, -1: exists and is missed
        taken = [j for j in choice if j >= 0]
        if len(set(taken)) < len(taken):
            continue
        weight = 1.0
        for i, j in enumerate(choice):
            if j == -2:
                weight *= 1.0 - prior[i]
            elif j == -1:
                weight *= prior[i] * (1.0 - detected[i])
            else:
                weight *= prior[i] * detected[i] * likelihood[i, j]
        weight *= np.prod([alone[j] for j in range(m) if j not in taken])
        total += weight
        for i, j in enumerate(choice):
            there[i] += weight * (j > -2)
            if j >= 0:
                pairs[i, j] += weight
        for j in range(m):
            free[j] += weight * (j not in taken)
    return there / total, pairs / total, free / total


def ours(prior, detected, likelihood, alone):
    pairs, free = marginals(1.0 - prior * detected, (prior * detected)[:, None] * likelihood, alone)
    return existence(prior, detected, pairs), pairs, free


@pytest.mark.parametrize(("tracks", "detections"), [(1, 1), (1, 3), (3, 1), (0, 2), (2, 0)])
def test_one_track_or_one_detection_is_exact(tracks, detections):
    rng = np.random.default_rng(tracks * 10 + detections)
    prior, detected = rng.uniform(0.05, 0.95, (2, tracks))
    likelihood, alone = rng.exponential(3.0, (tracks, detections)), rng.uniform(0.5, 2.0, detections)
    for found, wanted in zip(
        ours(prior, detected, likelihood, alone), brute_force(prior, detected, likelihood, alone), strict=True
    ):
        np.testing.assert_allclose(found, wanted, atol=1e-6)


@pytest.mark.parametrize("seed", range(6))
def test_several_are_close_to_the_sum_over_all_events(seed):
    rng = np.random.default_rng(seed)
    prior, detected = rng.uniform(0.1, 0.9, (2, 3))
    likelihood, alone = rng.exponential(1.0, (3, 3)) ** 3, np.ones(3)
    for found, wanted in zip(
        ours(prior, detected, likelihood, alone), brute_force(prior, detected, likelihood, alone), strict=True
    ):
        np.testing.assert_allclose(found, wanted, atol=0.08)


def test_a_track_that_is_never_seen_fades():
    prior = np.array([0.9])
    for _ in range(5):
        faded = existence(prior, np.array([0.8]), np.zeros((1, 0)))
        assert faded < prior
        prior = faded
    assert prior < 0.01
