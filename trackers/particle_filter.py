"""The particle filter of all methods in this package: a generic loop over a given model (paper A, section 2)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from trackers.kernels.particles import normalise_log_weights, systematic_indices

Observed = TypeVar("Observed", contravariant=True)
_Observed = TypeVar("_Observed")


class ParticleModel(Protocol[Observed]):
    """Prior, motion model and likelihood of a filter. ``observed`` holds the model's inputs of one frame."""

    def sample_initial(self, count: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """Draw ``count`` states (N, D) from the prior at the first frame."""
        ...

    def predict(self, states: NDArray[np.float64], observed: Observed, rng: np.random.Generator) -> NDArray[np.float64]:
        """Draw the next states (N, D): x_k ~ p(x_k | x_{k-1}). Must not change ``states``."""
        ...

    def log_weights(self, states: NDArray[np.float64], observed: Observed) -> NDArray[np.float64]:
        """Return log p(y_k | x_k) up to a constant (N,); -inf and NaN mean impossible."""
        ...


@dataclass(frozen=True)
class Posterior:
    """Weighted particles of one frame, before resampling.

    Attributes:
        states: (N, D).
        weights: (N,), sum 1.
        log_likelihood: log of the mean of exp(log-weight): the evidence of this frame, up to the model's constant.
        starved: True if every weight was zero; the weights are then equal, which keeps the prediction.
    """

    states: NDArray[np.float64]
    weights: NDArray[np.float64]
    log_likelihood: float
    starved: bool


class ParticleFilter(Generic[_Observed]):
    """Bootstrap filter: predict, weight, normalise and resample in proportion to weight at every frame.

    Attributes:
        states: (N, D) equally weighted particles after the last resampling.
    """

    def __init__(self, model: ParticleModel[_Observed], count: int, rng: np.random.Generator) -> None:
        """Draw ``count`` >= 1 particles from the model's prior.

        Raises:
            ValueError: if ``count`` is not positive.
        """
        if count < 1:
            raise ValueError(f"particles: expected a whole number >= 1, got {count}")
        self._model = model
        self._rng = rng
        self.states = model.sample_initial(count, rng)

    def step(self, observed: _Observed) -> Posterior:
        """Update with one frame and return its weighted particles."""
        states = self._model.predict(self.states, observed, self._rng)
        weights, log_likelihood, starved = normalise_log_weights(self._model.log_weights(states, observed))
        self.states = states[systematic_indices(weights, self._rng.random())]
        return Posterior(states, weights, log_likelihood, starved)
