"""Detection of a half-hidden person at the expected place, where the points are too few for a candidate."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

_REACH_M, _LOW_M, _HIGH_M = 0.35, 0.35, 1.95
_STEPS = 3
_LEAST_POINTS = 60


def points_of_body(
    points_m: NDArray[np.float32], expected_m: NDArray[np.float64], taken: Sequence[NDArray[np.int64]]
) -> NDArray[np.int64] | None:
    """Return indices (N,) of the points (H, W, 3) around a place (2,) in the robot's frame; None if below 60.

    Three steps of mean shift with a radius of 0.35 m.

    Args:
        taken: indices of points that belong to other people.
    """
    flat = points_m.reshape(-1, 3)
    with np.errstate(invalid="ignore"):
        near = np.flatnonzero(
            (np.abs(flat[:, 0] - expected_m[0]) < 2 * _REACH_M)
            & (np.abs(flat[:, 1] - expected_m[1]) < 2 * _REACH_M)
            & (flat[:, 2] > _LOW_M)
            & (flat[:, 2] < _HIGH_M)
        )
    if taken:
        near = np.setdiff1d(near, np.concatenate(taken), assume_unique=True)
    middle_m, own = np.asarray(expected_m, dtype=float), near
    for _ in range(_STEPS):
        own = near[np.hypot(*(flat[near, :2] - middle_m).T) < _REACH_M]
        if len(own) < _LEAST_POINTS:
            return None
        middle_m = flat[own, :2].mean(axis=0).astype(float)
    return own
