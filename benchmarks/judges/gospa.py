"""GOSPA, the generalised optimal sub-pattern assignment metric of targets and tracks on one frame."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment


def gospa(distance: NDArray[np.float64], cutoff: float, order: float = 1.0) -> float:
    """Return GOSPA with alpha = 2 (Rahmathullah, Garcia-Fernandez and Svensson 2017), in the unit of the distances.

    ``(sum over pairs of d^p + c^p / 2 (missed + false))^(1/p)``, the least over all one-to-one pairings of targets and
    tracks nearer than c. Tests hold it to recorded results of Stone Soup, which is not installed.

    Args:
        distance: (n, m) from each target to each track.
        cutoff: c > 0. order: p >= 1.
    """
    worth = np.maximum(cutoff**order - distance**order, 0.0)
    rows, columns = linear_sum_assignment(-worth)
    alone = 0.5 * cutoff**order * sum(distance.shape)
    return float(max(alone - worth[rows, columns].sum(), 0.0) ** (1.0 / order))
