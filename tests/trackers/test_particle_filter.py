"""The particle filter against the exact Kalman filter, and in degenerate cases."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from trackers.particle_filter import ParticleFilter


class LinearGaussian:
    """x' = 0.9 x + N(0, 0.5²), y = x + N(0, 0.7²), x_0 ~ N(0, 1)."""

    decay, process, noise = 0.9, 0.5, 0.7

    def sample_initial(self, count: int, rng: np.random.Generator) -> NDArray[np.float64]:
        return rng.normal(size=(count, 1))

    def predict(self, states: NDArray[np.float64], observed: float, rng: np.random.Generator) -> NDArray[np.float64]:
        return self.decay * states + rng.normal(0.0, self.process, states.shape)

    def log_weights(self, states: NDArray[np.float64], observed: float) -> NDArray[np.float64]:
        return -0.5 * ((observed - states[:, 0]) / self.noise) ** 2 - np.log(self.noise * np.sqrt(2 * np.pi))


class Blind(LinearGaussian):
    """Every state is impossible."""

    def log_weights(self, states: NDArray[np.float64], observed: float) -> NDArray[np.float64]:
        return np.full(len(states), -np.inf)


def test_agrees_with_the_exact_kalman_filter() -> None:
    model, rng = LinearGaussian(), np.random.default_rng(0)
    particle_filter = ParticleFilter[float](model, 20_000, rng)
    mean, variance, exact_likelihood, likelihood = 0.0, 1.0, 0.0, 0.0
    for observed in rng.normal(0.0, 1.3, 25):
        mean, variance = model.decay * mean, model.decay**2 * variance + model.process**2
        innovation = variance + model.noise**2
        exact_likelihood += -0.5 * ((observed - mean) ** 2 / innovation + np.log(2 * np.pi * innovation))
        gain = variance / innovation
        mean, variance = mean + gain * (observed - mean), (1 - gain) * variance
        posterior = particle_filter.step(observed)
        likelihood += posterior.log_likelihood
        estimate = posterior.weights @ posterior.states[:, 0]
        spread = posterior.weights @ (posterior.states[:, 0] - estimate) ** 2
        # 20,000 particles: the mean's own standard deviation is about 0.005.
        assert estimate == pytest.approx(mean, abs=0.025)
        assert spread == pytest.approx(variance, rel=0.06)
    assert likelihood == pytest.approx(exact_likelihood, abs=0.2)


def test_all_zero_weights_keep_the_prediction() -> None:
    particle_filter = ParticleFilter[float](Blind(), 50, np.random.default_rng(1))
    posterior = particle_filter.step(0.0)
    assert posterior.starved
    assert posterior.log_likelihood == -np.inf
    np.testing.assert_array_equal(posterior.weights, np.full(50, 0.02))
    np.testing.assert_array_equal(particle_filter.states, posterior.states)


def test_one_particle_is_enough() -> None:
    particle_filter = ParticleFilter[float](LinearGaussian(), 1, np.random.default_rng(2))
    for observed in (0.0, 50.0, -50.0):
        posterior = particle_filter.step(observed)
        assert posterior.weights.tolist() == [1.0]
        np.testing.assert_array_equal(particle_filter.states, posterior.states)


def test_the_same_generator_gives_the_same_particles() -> None:
    first, second = (ParticleFilter[float](LinearGaussian(), 100, np.random.default_rng(3)) for _ in range(2))
    for observed in (0.1, -0.4, 1.0):
        first.step(observed)
        second.step(observed)
    np.testing.assert_array_equal(first.states, second.states)


def test_no_particles_are_refused() -> None:
    with pytest.raises(ValueError, match="particles: expected a whole number >= 1, got 0"):
        ParticleFilter[float](LinearGaussian(), 0, np.random.default_rng(0))
