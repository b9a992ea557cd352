"""Cubic splines (paper A, equations 3.1 and 3.2)."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


def fit_cubic_spline(knots: NDArray[np.float64], values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the pieces ``S_i(y) = a_i (y - y_i)^3 + b_i (y - y_i)^2 + c_i (y - y_i) + d_i`` through n >= 2 points.

    With M_i = S''(y_i), h_i = y_{i+1} - y_i and slopes s_i = (d_{i+1} - d_i) / h_i:
    ``h_{i-1} M_{i-1} + 2 (h_{i-1} + h_i) M_i + h_i M_{i+1} = 6 (s_i - s_{i-1})`` inside and, at the ends,
    ``M_0 = M_1, M_{n-1} = M_{n-2}``;
    ``a_i = (M_{i+1} - M_i) / (6 h_i), b_i = M_i / 2, c_i = s_i - h_i (2 M_i + M_{i+1}) / 6``.

    The end conditions are a reading: the first and last piece are parabolas, so the extrapolation keeps the curvature
    of the ends. (A natural spline's curvature changes its sign there.)

    Args:
        knots: (n,) y_i, strictly increasing.
        values: (n,) d_i.

    Returns:
        (n - 1, 4) rows a, b, c, d.
    """
    n = knots.size
    h = knots[1:] - knots[:-1]
    s = (values[1:] - values[:-1]) / h
    M: NDArray[np.floating] = np.zeros(n)
    if n >= 3:
        system = np.zeros((n, n))
        right = np.zeros(n)
        system[0, 0], system[0, 1] = 1.0, -1.0
        system[n - 1, n - 1], system[n - 1, n - 2] = 1.0, -1.0
        for i in range(1, n - 1):
            system[i, i - 1], system[i, i], system[i, i + 1] = h[i - 1], 2.0 * (h[i - 1] + h[i]), h[i]
            right[i] = 6.0 * (s[i] - s[i - 1])
        M = np.linalg.solve(system, right)
    pieces = np.empty((n - 1, 4))
    pieces[:, 0] = (M[1:] - M[:-1]) / (6.0 * h)
    pieces[:, 1] = 0.5 * M[:-1]
    pieces[:, 2] = s - h * (2.0 * M[:-1] + M[1:]) / 6.0
    pieces[:, 3] = values[:-1]
    return pieces


@njit(cache=True)
def evaluate_spline(
    knots: NDArray[np.float64], pieces: NDArray[np.float64], at: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return S(y) and S'(y), both (N,), at positions (N,); beyond the ends the first or last piece is extrapolated.

    Args:
        knots: (n,); pieces: (n - 1, 4), from ``fit_cubic_spline``.
    """
    values = np.empty(at.size)
    slopes = np.empty(at.size)
    for k in range(at.size):
        i = min(max(np.searchsorted(knots, at[k], side="right") - 1, 0), len(pieces) - 1)
        a, b, c, d = pieces[i]
        y = at[k] - knots[i]
        values[k] = ((a * y + b) * y + c) * y + d
        slopes[k] = (3.0 * a * y + 2.0 * b) * y + c
    return values, slopes
