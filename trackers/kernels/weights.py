"""Arithmetic of particle weights."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True)
def normalise_log_weights(log_weights: NDArray[np.float64]) -> tuple[NDArray[np.float64], float, bool]:
    """Turn log-weights l_i into weights that sum to one, without overflow.

    ``m = max l_i;  w_i = exp(l_i - m) / sum_j exp(l_j - m);  log-likelihood = m + log(sum_j exp(l_j - m) / N)``.

    Args:
        log_weights: (N,); -inf and NaN count as zero weight, finite otherwise.

    Returns:
        weights (N,); the log-likelihood; and True if no weight was above zero: then all are 1 / N and the
        log-likelihood is -inf.
    """
    count = log_weights.size
    largest = -np.inf
    for value in log_weights:
        if value > largest:
            largest = value
    if largest == -np.inf:
        return np.full(count, 1.0 / count), -np.inf, True
    weights = np.empty(count)
    total = 0.0
    for i in range(count):
        value = log_weights[i]
        weights[i] = 0.0 if np.isnan(value) else np.exp(value - largest)
        total += weights[i]
    for i in range(count):
        weights[i] /= total
    return weights, largest + np.log(total / count), False


def circular_mean(angles_rad: NDArray[np.float64], weights: NDArray[np.float64]) -> float:
    """Return the direction of ``sum w_i (cos a_i, sin a_i)`` in (-pi, pi]; angles and weights are (N,)."""
    return float(np.arctan2(weights @ np.sin(angles_rad), weights @ np.cos(angles_rad)))
