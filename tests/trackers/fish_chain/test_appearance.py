"""The model of looks against a library's Gaussians, and on drawn descriptors."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import multivariate_normal

from trackers.fish_chain.linking import Appearance

FEATURES = 6


def pieces(
    rng: np.random.Generator, fish: NDArray[np.float64], noise: float, chunks: int = 12
) -> list[NDArray[np.float64]]:
    return [each + rng.normal(0, noise, (chunks, len(each))) for each in fish]


def test_ratios_are_those_of_the_two_gaussians(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("trackers.fish_chain.linking._MOST", np.inf)
    rng = np.random.default_rng(1)
    model = Appearance()
    model.learn(pieces(rng, rng.normal(0, 2, (40, FEATURES)), 0.7))
    assert model._axes is not None
    within = np.linalg.inv(model._axes @ model._axes.T)
    between = within @ model._axes @ np.diag(model._spread) @ model._axes.T @ within
    first, second = rng.normal(0, 1, (5, FEATURES)), rng.normal(0, 1, (2, FEATURES))
    noises = [0.3 + 0.7 / len(each) for each in (first, second)]
    a, b = (between + noise * within for noise in noises)
    means = [each.mean(axis=0) - model._mean for each in (first, second)]
    same = multivariate_normal(np.zeros(2 * FEATURES), np.block([[a, between], [between, b]])).logpdf(
        np.concatenate(means)
    )
    different = multivariate_normal(np.zeros(FEATURES), a).logpdf(means[0])
    different += multivariate_normal(np.zeros(FEATURES), b).logpdf(means[1])
    assert model.log_ratios([first], [second])[0, 0] == pytest.approx(same - different, abs=1e-6)


def test_fish_that_differ_are_told_apart_and_those_alike_are_not() -> None:
    rng = np.random.default_rng(2)
    for spread, surely in ((2.0, True), (0.0, False)):
        fish = rng.normal(0, spread, (30, FEATURES))
        model = Appearance()
        model.learn(pieces(rng, fish, 0.7))
        ratios = model.log_ratios(pieces(rng, fish, 0.7), pieces(rng, fish, 0.7))
        others = ratios[~np.eye(30, dtype=bool)]
        if surely:
            assert np.diag(ratios).min() > 0
            assert np.quantile(others, 0.9) < 0
        else:
            assert np.abs(ratios).max() < 1.5


def test_nothing_is_known_before_it_is_learnt() -> None:
    looks = [np.ones((3, FEATURES))]
    model = Appearance()
    assert (model.log_ratios(looks, looks) == 0).all()
    model.learn(looks)
    assert (model.log_ratios(looks, looks) == 0).all()
    assert model.log_ratios([], looks).shape == (0, 1)
