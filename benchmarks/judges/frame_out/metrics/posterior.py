"""Calibration of a tracker's posterior: level of the smallest region that holds the truth, and NEES."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.special import chdtr

from scenarios.truth import Truth
from sim.optics import intersect_plane
from trackers.types import CameraModel, Estimate

_SMALLEST_BANDWIDTH_M = 0.1


class Calibration(NamedTuple):
    """A posterior of one frame compared with the truth.

    Attributes:
        credible_level: level in [0, 1] of the posterior's smallest (highest-density) region that holds the truth. A p
            region holds the truth if the level is at most p. The levels of a calibrated posterior are uniform.
        nees: ``e' P^-1 e`` of the error e about the posterior's mean, >= 0; mean 2 for a calibrated Gaussian in the
            plane.
    """

    credible_level: float
    nees: float


NO_POSTERIOR = Calibration(float("nan"), float("nan"))
WRONG = Calibration(1.0, float("inf"))
"""Calibration of an unusable posterior: no region holds the truth."""


def calibration(estimate: Estimate, truth: Truth, target: int, camera: CameraModel) -> Calibration:
    """Judge the posterior of one frame: particles on the ground in metres, or a Gaussian in pixels.

    Particles are projected through the true camera to half the target's height; those above the horizon keep their
    weight without a place. An estimate with neither particles nor covariance has no posterior.
    """
    if estimate.particles_px is not None:
        height_m = truth.T_world_object[target, 2, 3] + 0.5 * truth.size_m[target, 2]
        particles_m = intersect_plane(camera, truth.T_world_camera, estimate.particles_px, float(height_m))
        count = len(particles_m)
        weights = np.full(count, 1.0 / count) if estimate.weights is None else estimate.weights
        return particle_calibration(particles_m, np.asarray(weights), truth.T_world_object[target, :2, 3])
    if estimate.covariance_px is not None:
        return gaussian_calibration(estimate.position_px, estimate.covariance_px, truth.position_px[target])
    return NO_POSTERIOR


def gaussian_calibration(
    mean: NDArray[np.float64], covariance: NDArray[np.float64], truth: NDArray[np.float64]
) -> Calibration:
    """Judge N(mean (2,), covariance (2, 2)): ``nees = e' P^-1 e``, level = its chi-squared CDF with 2 degrees of
    freedom.

    Bar-Shalom, Li, Kirubarajan, Estimation with applications to tracking and navigation, 5.4.2.
    """
    error = truth - mean
    if not np.isfinite(error).all():
        return WRONG
    try:
        nees = float(error @ np.linalg.solve(covariance, error))
    except np.linalg.LinAlgError:
        return WRONG
    return Calibration(float(chdtr(2, nees)), nees) if nees >= 0 else WRONG


def particle_calibration(
    particles_m: NDArray[np.float64], weights: NDArray[np.float64], truth_m: NDArray[np.float64]
) -> Calibration:
    """Judge weighted particles (N, 2), weights summing to 1.

    Level = total weight of the particles where the posterior is at least as dense as at the truth. The density is a
    Gaussian kernel estimate with Scott's bandwidth for the effective number of particles; at a particle it is computed
    with the truth in that particle's place. So truth and particle are exchangeable, and the levels of a calibrated
    posterior are uniform for any bandwidth. (Hyndman, Computing and graphing
    highest density regions, 1996; ranks of exchangeable points as in Vovk et al., Algorithmic learning in a random
    world, 2005.)
    """
    usable = np.isfinite(particles_m).all(axis=1) & (weights > 0)
    if not usable.any() or not np.isfinite(truth_m).all():
        return WRONG
    points, masses = particles_m[usable], weights[usable]
    share = masses / masses.sum()
    mean = share @ points
    centred = points - mean
    covariance = (centred * share[:, None]).T @ centred
    effective = 1.0 / float(share @ share)
    bandwidth = effective ** (-1 / 3) * covariance + _SMALLEST_BANDWIDTH_M**2 * np.eye(2)
    whitening = np.linalg.cholesky(np.linalg.inv(bandwidth))
    density, density_at_truth = _densities(centred @ whitening, share, (truth_m - mean) @ whitening)
    level = float(masses[density >= density_at_truth].sum()) + float(weights[~usable].sum()) * (density_at_truth <= 0)
    error = truth_m - mean
    nees = float(error @ np.linalg.solve(covariance + 1e-9 * np.eye(2), error))
    return Calibration(min(level, 1.0), nees)


@njit(cache=True, fastmath=True)
def _densities(
    points: NDArray[np.float64], weights: NDArray[np.float64], query: NDArray[np.float64]
) -> tuple[NDArray[np.float64], float]:
    """Return unnormalised densities at the points (N,), each with the query in its own place, and at the query.

    ``f_i = sum_{j != i} w_j K(x_i - x_j) + w_i K(x_i - q)``; ``f(q) = sum_j w_j K(q - x_j)``;
    ``K(d) = exp(-|d|^2 / 2)``. Points are whitened by the bandwidth.
    """
    count = points.shape[0]
    density = np.zeros(count)
    at_query = 0.0
    for i in range(count):
        x, y, w = points[i, 0], points[i, 1], weights[i]
        to_query = w * np.exp(-0.5 * ((query[0] - x) ** 2 + (query[1] - y) ** 2))
        density[i] += to_query
        at_query += to_query
        for j in range(i):
            kernel = np.exp(-0.5 * ((points[j, 0] - x) ** 2 + (points[j, 1] - y) ** 2))
            density[i] += weights[j] * kernel
            density[j] += w * kernel
    return density, at_query


def coverage(credible_level: NDArray[np.float64], region: float) -> float:
    """Return the share in [0, 1] of frames (F,), at least one, whose truth lies in the posterior's ``region`` (0.95 …).

    A frame without posterior (NaN) is a miss, so that a tracker gains nothing by leaving out hard frames.
    """
    return float((credible_level <= region).mean())


def level_histogram(credible_level: NDArray[np.float64], bins: int = 20) -> NDArray[np.float64]:
    """Return (bins,): shares of frames (F,), at least one, by credible level, equal bins of [0, 1]; flat = calibrated.

    A frame without posterior (NaN) is in the last bin, like a truth outside every region.
    """
    levels = np.nan_to_num(credible_level, nan=1.0)
    return np.histogram(levels, bins=bins, range=(0.0, 1.0))[0] / len(levels)
