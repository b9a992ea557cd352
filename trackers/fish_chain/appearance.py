"""How likely two pieces of track show the same fish by their looks: a two-covariance model, learnt from the tracklets.

A look is ``x = μ + b + w``: b ~ N(0, B) differs between fish, w ~ N(0, W) between chunks of frames of one fish. The
log-likelihood ratio of *same fish* against *two fish* follows in closed form (Brümmer & de Villiers, The speaker
partitioning problem, Odyssey 2010); it tends to 0 for fish that look alike.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

_LEAST_PIECES, _LEAST_CHUNKS = 4, 3
_PRIOR_CHUNKS = 20.0
_LASTING = 0.3
"""Share of W that does not average out over chunks: light, depth and posture change slowly."""
_MOST = 3.0
"""A single feature speaks no stronger for or against a link; real looks have heavier tails than Gaussians."""


class Appearance:
    """The model; ratios are 0 until enough tracklets are known."""

    def __init__(self) -> None:
        self._axes: NDArray[np.float64] | None = None

    def learn(self, pieces: Sequence[NDArray[np.float64]]) -> None:
        """Learn from the looks (C, D) of tracklets, each of one fish."""
        long = [looks for looks in pieces if len(looks) >= _LEAST_CHUNKS]
        if len(long) < _LEAST_PIECES:
            return
        means = np.array([looks.mean(axis=0) for looks in long])
        counts = np.array([len(looks) for looks in long], dtype=float)
        centred = np.concatenate([looks - mean for looks, mean in zip(long, means, strict=True)])
        freedom = counts.sum() - len(long)
        all_variance = np.var(np.concatenate(long), axis=0) + 1e-9
        prior = _PRIOR_CHUNKS * np.diag(all_variance)
        within = (centred.T @ centred + prior) / (freedom + _PRIOR_CHUNKS)
        mean = np.average(means, axis=0, weights=np.sqrt(counts))
        # Axes on which W = I and the means of pieces scatter by diag(scatter).
        scatter, axes = eigh(np.cov(means.T, aweights=np.sqrt(counts)), within)
        noise = float(np.mean(_noise(counts)))
        # Means of one and the same fish would scatter by up to so much (Marchenko & Pastur, 1967).
        edge = noise * (1 + np.sqrt(len(mean) / len(long))) ** 2
        kept = scatter > edge
        self._mean, self._spread, self._axes = mean, scatter[kept] - noise, axes[:, kept]

    def log_ratios(
        self, first: Sequence[NDArray[np.float64]], second: Sequence[NDArray[np.float64]]
    ) -> NDArray[np.float64]:
        """Return the log-likelihood ratios (N, M), same against different, of N pieces' looks (C, D) with M others'.

        0 for pieces without looks (C = 0).
        """
        if self._axes is None or not len(first) or not len(second):
            return np.zeros((len(first), len(second)))
        x, u = self._projected(first)
        y, v = self._projected(second)
        seen = np.logical_and.outer(*([len(looks) > 0 for looks in pieces] for pieces in (first, second)))
        x, u, y, v = x[:, None], u[:, None, None], y[None], v[None, :, None]
        spread = self._spread
        same_xx, same_yy = spread + u, spread + v
        determinant = same_xx * same_yy - spread**2
        same = (x**2 * same_yy - 2 * spread * x * y + y**2 * same_xx) / determinant + np.log(determinant)
        different = x**2 / same_xx + y**2 / same_yy + np.log(same_xx * same_yy)
        ratios = np.clip(0.5 * (different - same), -_MOST, _MOST)
        return np.where(seen, ratios.sum(axis=-1), 0.0)

    def _projected(self, pieces: Sequence[NDArray[np.float64]]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        assert self._axes is not None
        means = np.array([looks.mean(axis=0) if len(looks) else self._mean for looks in pieces])
        counts = np.array([max(len(looks), 1) for looks in pieces], dtype=float)
        return (means - self._mean) @ self._axes, _noise(counts)


def _noise(counts: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the variance of the mean of so many chunks, as a share of W."""
    return _LASTING + (1 - _LASTING) / counts
