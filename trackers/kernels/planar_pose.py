"""Homographies of points, and the sums of one Gauss-Newton step of their robust fit."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True)
def apply_homography(H: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return ``(h_1 . p, h_2 . p) / (h_3 . p)`` (N, 2), p = (x, y, 1), of points (N, 2); NaN where h_3 . p <= 0."""
    result = np.empty((points.shape[0], 2))
    for i in range(points.shape[0]):
        x, y = points[i, 0], points[i, 1]
        w = H[2, 0] * x + H[2, 1] * y + H[2, 2]
        if w > 1e-9:
            result[i, 0] = (H[0, 0] * x + H[0, 1] * y + H[0, 2]) / w
            result[i, 1] = (H[1, 0] * x + H[1, 1] * y + H[1, 2]) / w
        else:
            result[i] = np.nan
    return result


@njit(cache=True)
def robust_normal_equations(
    H: NDArray[np.float64],
    H_derivatives: NDArray[np.float64],
    points: NDArray[np.float64],
    pixels: NDArray[np.float64],
    scale_px: float,
) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """Sum the weighted normal equations of ``pixels ~ H points`` for the parameters of H.

    ``r_i = z_i - pi(H p_i)``, ``J_i = d pi(H p_i) / d parameters``, Geman-McClure weight
    ``w_i = (1 + |r_i|^2 / s^2)^-2``:  ``A = sum w J^T J / s^2``,  ``b = sum w J^T r / s^2``.

    Args:
        H: (3, 3) plane to pixels.
        H_derivatives: (P, 3, 3) of H by each parameter.
        points, pixels: (N, 2) each; rows with NaN are left out.
        scale_px: s, residual at which a point has lost three quarters of its weight.

    Returns:
        A (P, P), b (P,) and the sum of weights.
    """
    count = H_derivatives.shape[0]
    A = np.zeros((count, count))
    b = np.zeros(count)
    total = 0.0
    j_u = np.empty(count)
    j_v = np.empty(count)
    inverse_variance = 1.0 / (scale_px * scale_px)
    for i in range(points.shape[0]):
        x, y = points[i, 0], points[i, 1]
        w = H[2, 0] * x + H[2, 1] * y + H[2, 2]
        if not w > 1e-9:
            continue
        u = (H[0, 0] * x + H[0, 1] * y + H[0, 2]) / w
        v = (H[1, 0] * x + H[1, 1] * y + H[1, 2]) / w
        r_u = pixels[i, 0] - u
        r_v = pixels[i, 1] - v
        square = (r_u * r_u + r_v * r_v) * inverse_variance
        if not square < 1e6:
            continue
        weight = 1.0 / ((1.0 + square) * (1.0 + square))
        total += weight
        for p in range(count):
            D = H_derivatives[p]
            d_w = D[2, 0] * x + D[2, 1] * y + D[2, 2]
            j_u[p] = (D[0, 0] * x + D[0, 1] * y + D[0, 2] - u * d_w) / w
            j_v[p] = (D[1, 0] * x + D[1, 1] * y + D[1, 2] - v * d_w) / w
        for p in range(count):
            b[p] += weight * inverse_variance * (j_u[p] * r_u + j_v[p] * r_v)
            for q in range(count):
                A[p, q] += weight * inverse_variance * (j_u[p] * j_u[q] + j_v[p] * j_v[q])
    return A, b, total
