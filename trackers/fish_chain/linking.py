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

    The probability of a link is a softmax over the set and every set that differs from it at this link by the least:
    the link left out, its tail or its start linked to one that is free, or two links exchanged. So two fish that go
    into a blob and come out of it are decided together.
    """
    gains = np.minimum(costs, 0.0)
    if not gains.any():
        return []
    rows, columns = linear_sum_assignment(gains)
    chosen = gains[rows, columns] < 0
    rows, columns = rows[chosen], columns[chosen]
    own = gains[rows, columns]
    exchanged = gains[np.ix_(rows, columns)] + gains[np.ix_(rows, columns)].T - own[:, None] - own[None, :]
    np.fill_diagonal(exchanged, -own)
    free_columns = np.setdiff1d(np.arange(costs.shape[1]), columns)
    free_rows = np.setdiff1d(np.arange(costs.shape[0]), rows)
    elsewhere = np.where(gains < 0, gains, np.inf)
    others = np.concatenate(
        [
            exchanged,
            elsewhere[np.ix_(rows, free_columns)] - own[:, None],
            elsewhere[np.ix_(free_rows, columns)].T - own[:, None],
        ],
        axis=1,
    )
    # No alternative is better than the best set, so no exponent overflows.
    probabilities = 1.0 / (1.0 + np.exp(-np.maximum(others, 0.0)).sum(axis=1))
    return [Match(int(r), int(c), float(p)) for r, c, p in zip(rows, columns, probabilities, strict=True)]
