"""Which tracklet continues which: the best set of links, and a probability for each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

IMPOSSIBLE = 1e6


@dataclass(frozen=True, slots=True)
class Match:
    """Row ``tail`` continues as column ``start``, with a probability against all alternatives."""

    tail: int
    start: int
    probability: float


def best_links(costs: NDArray[np.float64]) -> list[Match]:
    """Return the set of links with the least sum of costs, each tail and start at most once.

    Args:
        costs: (N, M) negative log-odds of each link against none; a link with a cost >= 0 is never in the set.

    The probability of a link is a softmax over the set and those without the link that differ from it by one step: its
    tail and its start are linked to others that are free, or not at all, or two links are exchanged. So two fish that
    go into a blob and come out of it are decided together.
    """
    gains = np.minimum(costs, 0.0)
    if not gains.any():
        return []
    rows, columns = linear_sum_assignment(gains)
    chosen = gains[rows, columns] < 0
    rows, columns = rows[chosen], columns[chosen]
    own = gains[rows, columns]
    exchanged = gains[np.ix_(rows, columns)] + gains[np.ix_(rows, columns)].T - own[:, None] - own[None, :]
    np.fill_diagonal(exchanged, np.inf)
    free_columns = np.setdiff1d(np.arange(costs.shape[1]), columns)
    free_rows = np.setdiff1d(np.arange(costs.shape[0]), rows)
    worth = np.where(gains < 0, -gains, -np.inf)
    left = _log_sum(worth[np.ix_(rows, free_columns)]) + _log_sum(worth[np.ix_(free_rows, columns)].T) + own
    # No alternative is better than the best set, so no exponent overflows.
    alternatives = np.exp(left) + np.exp(-np.maximum(exchanged, 0.0)).sum(axis=1)
    return [
        Match(int(row), int(column), float(probability))
        for row, column, probability in zip(rows, columns, 1.0 / (1.0 + alternatives), strict=True)
    ]


def _log_sum(worth: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return for each row the logarithm of the sum of one, for no link, and of the exponentials of all its links."""
    none = np.zeros((len(worth), 1))
    return np.logaddexp.reduce(np.concatenate([none, worth], axis=1), axis=1)  # type: ignore[no-any-return]
