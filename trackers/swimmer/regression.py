"""Regression of places: the weights that minimise the mean distance, and the spread about them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

RIDGE = 0.03
"""Weight of the prior as a share of each feature's mean square, with any number of samples."""
SCARCE = 150.0
"""The prior weighs double with so many independent samples."""
_FEW = 5.0
"""So many independent samples weigh as much as the prior in single numbers: its share, and the spread."""
_NEAREST = 0.003
"""Distances below this many units count as this much, so that no sample has unbounded weight."""
_ROUNDS = 6
_QUANTILE = 0.95


@dataclass(frozen=True, eq=False)
class Regression:
    """Predicts a step (2,) from features, and how far off it may be.

    Attributes:
        weights: (D,) of the features of either axis.
        spread: (S,) weights >= 0 of the scales: the radius that holds 95 % of the errors is ``spread @ scales``.
    """

    weights: NDArray[np.float64]
    spread: NDArray[np.float64]

    def step(self, features: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the steps (M, 2) for features (M, 2, D)."""
        return features @ self.weights

    def radius(self, scales: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the radii (M,) of the circles that hold the end with 95 % probability, for scales (M, S)."""
        return scales @ self.spread


@dataclass(frozen=True, eq=False)
class Samples:
    """M observed steps.

    Attributes:
        features: (M, 2, D). step: (M, 2), in units. scales: (M, S) >= 0.
        weight: (M,) > 0, at most 1.
        fold: (M,) bool, which of two parts of the time a sample is from.
        independent: number of samples that do not overlap.
        added: number of the last features, which may be unknown (all zero): the others are fitted without them.
    """

    features: NDArray[np.float64]
    step: NDArray[np.float64]
    scales: NDArray[np.float64]
    weight: NDArray[np.float64]
    fold: NDArray[np.bool_]
    independent: float
    added: int = 0

    def part(self, kept: NDArray[np.bool_]) -> Samples:
        """Return the samples that are ``kept`` (M,)."""
        return Samples(
            self.features[kept],
            self.step[kept],
            self.scales[kept],
            self.weight[kept],
            self.fold[kept],
            self.independent * float(kept.mean()),
            self.added,
        )


def fitted(samples: Samples, prior: Regression) -> Regression:
    """Return the regression that the samples and a prior give.

    The weights w minimise ``sum q |step - F w|`` plus a ridge about the prior's, by iteratively reweighted least
    squares (Weiszfeld 1937): the error that counts is the mean distance. The prior's weights are first taken times the
    share in [0, 1] that suits the samples best. The spread is the prior's times the factor
    that makes 95 % of the errors lie inside, each predicted from the other half of the time.
    """
    held = prior.weights * _held(samples, prior.weights)
    weights = _weights(samples, held)
    ratios, counts = [], []
    for fold in (False, True):
        tested = samples.fold == fold
        if tested.any() and not tested.all():
            trained = _weights(samples.part(~tested), held)
            part = samples.part(tested)
            ratios.append(_length(part.step - part.features @ trained) / prior.radius(part.scales))
            counts.append(part.weight)
    if not ratios:
        return Regression(weights, prior.spread)
    factor = _weighted_quantile(np.concatenate(ratios), np.concatenate(counts))
    return Regression(weights, prior.spread * factor ** _trust(samples))


def _held(samples: Samples, prior: NDArray[np.float64]) -> float:
    """Return the share of the prior's steps that gives the least error, nearer to 1 the fewer samples there are."""
    shares, step = np.linspace(0.0, 1.0, 11), samples.features @ prior
    errors = [samples.weight @ _length(samples.step - share * step) for share in shares]
    return 1.0 + _trust(samples) * (float(shares[int(np.argmin(errors))]) - 1.0)


def _trust(samples: Samples) -> float:
    return samples.independent / (samples.independent + _FEW)


def first_fit(samples: Samples) -> Regression:
    """Return the regression of samples alone; the radii are fitted to the errors and scaled to hold 95 % of them."""
    weights = _weights(samples, np.zeros(samples.features.shape[-1]), RIDGE / 30)
    error = _length(samples.step - samples.features @ weights)
    # Relative errors count, or the swift would decide alone.
    size = np.maximum(error, _NEAREST) + samples.scales.mean(axis=1)
    spread, _ = nnls(samples.scales / size[:, None], error / size)
    spread += 1e-3 * spread.max()
    return Regression(weights, spread * _weighted_quantile(error / (samples.scales @ spread), samples.weight))


def _weights(samples: Samples, prior: NDArray[np.float64], ridge: float | None = None) -> NDArray[np.float64]:
    """Return weights of the features before ``samples.added``, and those of the added ones for what is then left."""
    if ridge is None:
        ridge = RIDGE * (1.0 + SCARCE / samples.independent)
    base = samples.features.shape[-1] - samples.added
    F, rest = np.split(samples.features, [base], axis=-1)
    first = _nearest(F, samples.step, samples.weight, prior[:base], ridge)
    if not rest.any():
        return np.concatenate([first, prior[base:]])
    return np.concatenate([first, _nearest(rest, samples.step - F @ first, samples.weight, prior[base:], ridge)])


def _nearest(
    F: NDArray[np.float64],
    step: NDArray[np.float64],
    weight: NDArray[np.float64],
    prior: NDArray[np.float64],
    ridge: float,
) -> NDArray[np.float64]:
    """Return the w that minimises the weighted sum of ``|step - F w|`` and the ridge."""
    flat, off, w = F.reshape(-1, F.shape[-1]), (step - F @ prior).ravel(), prior
    for _ in range(_ROUNDS):
        q = weight / np.maximum(_length(step - F @ w), _NEAREST)
        rooted = np.repeat(np.sqrt(q), 2)
        weighted = flat * rooted[:, None]
        # A product with its own transpose takes half the time.
        gram = weighted.T @ weighted
        penalty = ridge * np.maximum(np.diag(gram), 1e-9 * q.sum())
        w = prior + np.linalg.solve(gram + np.diag(penalty), weighted.T @ (rooted * off))
    return w


def _length(vector: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.linalg.norm(vector, axis=-1)


def _weighted_quantile(values: NDArray[np.float64], weights: NDArray[np.float64]) -> float:
    order = np.argsort(values)
    below = np.cumsum(weights[order]) / weights.sum()
    return float(values[order[min(int(np.searchsorted(below, _QUANTILE)), len(values) - 1)]])
