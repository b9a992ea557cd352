"""Weighted particles: normalisation, resampling, weights from detections, and point estimates."""

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
    sines, cosines = _sines_and_cosines(angles_rad)
    return float(np.arctan2(weights @ sines, weights @ cosines))


@njit(cache=True)
def _sines_and_cosines(angles_rad: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    sines, cosines = np.empty(len(angles_rad)), np.empty(len(angles_rad))
    for n in range(len(angles_rad)):
        sines[n], cosines[n] = np.sin(angles_rad[n]), np.cos(angles_rad[n])
    return sines, cosines


@njit(cache=True)
def systematic_indices(weights: NDArray[np.float64], offset: float) -> NDArray[np.int64]:
    """Return the ancestors of N equally weighted particles: systematic resampling with one uniform number.

    ``a_i = min{j : w_0 + ... + w_j > W (i + u) / N}``, W the sum of the weights. Particle j is taken floor(N w_j / W)
    or ceil(N w_j / W) times, on average N w_j / W times, and never where w_j = 0.

    Args:
        weights: (N,) non-negative, finite, not all zero; need not sum to one.
        offset: u in [0, 1).

    Returns:
        (N,) indices, ascending.

    Source: Kitagawa 1996, "Monte Carlo filter and smoother"; paper A draws with replacement, of which this is the
    version with the least variance.
    """
    count = weights.size
    total = weights.sum()
    last = count - 1
    while last > 0 and weights[last] == 0.0:
        last -= 1
    ancestors = np.empty(count, np.int64)
    j = 0
    cumulative = weights[0]
    for i in range(count):
        threshold = total * (i + offset) / count
        while cumulative <= threshold and j < last:
            j += 1
            cumulative += weights[j]
        ancestors[i] = j
    return ancestors


_AXIS_WRONG = 0.1
"""Probability that a candidate's measured axis is wrong."""


@njit(cache=True)
def detection_log_weights(
    positions_m: NDArray[np.float64],
    headings_rad: NDArray[np.float64],
    detectable: NDArray[np.float64],
    miss_counts: bool,
    candidates_m: NDArray[np.float64],
    axes_rad: NDArray[np.float64],
    log_ratios: NDArray[np.float64],
    deviations_m: NDArray[np.float64],
    axis_deviation_rad: float,
) -> NDArray[np.float64]:
    """Return the log-likelihood (N,) of a picture's candidates for each particle.

    ``w_i = (1 - p_i) + p_i max_j exp(l_j - |z_j - x_i|^2 / 2 s_j^2) (0.1 + 0.9 k exp(-sin^2(a_j - h_i) / 2 t^2))``,
    ``k = sqrt(pi / 2) / t``: the target is either missed or one of the candidates, and one measured axis in ten is
    wrong. A particle in full view far from all candidates gets ``1 - p_i`` (negative information), one outside the
    picture gets 1.

    Args:
        positions_m (N, 2), headings_rad (N,): particles.
        detectable: (N,) p_i, probability that a target at the particle is detected.
        miss_counts: False replaces ``1 - p_i`` by 1: a miss has no weight.
        candidates_m (J, 2), axes_rad (J,), log_ratios (J,): z, a (up to half a turn; NaN = unknown)
            and ``l = log p(detection | target) / p(detection | anything else)``.
        deviations_m (J,), axis_deviation_rad: s and t.
    """
    result = np.empty(positions_m.shape[0])
    # Relative to a uniform density of axes, 1 / pi.
    sharpness = max(1.0, np.sqrt(0.5 * np.pi) / axis_deviation_rad)
    for i in range(positions_m.shape[0]):
        best = -50.0
        for j in range(candidates_m.shape[0]):
            d_x = candidates_m[j, 0] - positions_m[i, 0]
            d_y = candidates_m[j, 1] - positions_m[i, 1]
            value = log_ratios[j] - 0.5 * (d_x * d_x + d_y * d_y) / (deviations_m[j] * deviations_m[j])
            if not np.isnan(axes_rad[j]):
                sine = np.sin(axes_rad[j] - headings_rad[i])
                aligned = np.exp(-0.5 * sine * sine / (axis_deviation_rad * axis_deviation_rad))
                value += np.log(_AXIS_WRONG + (1.0 - _AXIS_WRONG) * sharpness * aligned)
            best = max(best, value)
        missed = 1.0 - detectable[i] if miss_counts else 1.0
        result[i] = np.log(missed + detectable[i] * np.exp(best))
    return result


@njit(cache=True)
def geometric_median(points: NDArray[np.float64], weights: NDArray[np.float64], steps: int) -> NDArray[np.float64]:
    """Return the point m that minimises ``sum w_i |x_i - m|`` over points (N, 2): the estimate with the
    least expected error.

    Weiszfeld's iteration from the mean, ``m <- sum (w_i / d_i) x_i / sum (w_i / d_i)`` with ``d_i =
    sqrt(|x_i - m|^2 + eps)``.
    """
    m_x, m_y, total = 0.0, 0.0, 0.0
    for i in range(points.shape[0]):
        m_x += weights[i] * points[i, 0]
        m_y += weights[i] * points[i, 1]
        total += weights[i]
    m_x, m_y = m_x / total, m_y / total
    for _ in range(steps):
        sum_x, sum_y, total = 0.0, 0.0, 0.0
        for i in range(points.shape[0]):
            d_x, d_y = points[i, 0] - m_x, points[i, 1] - m_y
            pull = weights[i] / np.sqrt(d_x * d_x + d_y * d_y + 1e-4)
            sum_x += pull * points[i, 0]
            sum_y += pull * points[i, 1]
            total += pull
        m_x, m_y = sum_x / total, sum_y / total
    return np.array([m_x, m_y])


def spacing(points: NDArray[np.float64]) -> float:
    """Return the mean spacing ``sqrt(2 pi sqrt(det cov) / N)`` of points (N, 2), 0 of fewer than two.

    It is added in quadrature to the detection's error: where particles are sparse, the nearest one is further from the
    target.
    """
    if len(points) < 2:
        return 0.0
    determinant = float(np.linalg.det(np.cov(points.T)))
    return float(np.sqrt(2.0 * np.pi * np.sqrt(max(determinant, 0.0)) / len(points)))
