"""Marginal probabilities of association between tracks that may not exist and detections that may be false.

J. Williams, R. Lau, "Approximate evaluation of marginal association probabilities with belief propagation", IEEE
Trans. Aerospace and Electronic Systems 50(4), 2014; existence: D. Musicki, R. Evans, "Joint integrated probabilistic
data association: JIPDA", same journal 40(3), 2004.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_ROUNDS = 200
_CONVERGED = 1e-7


def marginals(missed: Array, paired: Array, alone: Array) -> tuple[Array, Array]:
    """Return (tracks, detections) probabilities of each pair, and of each detection to belong to none (detections,).

    Each joint event pairs tracks and detections one to one, at most; its weight is the product of ``paired`` over its
    pairs, ``missed`` over the other tracks and ``alone`` over the other detections. Loopy belief propagation: exact for
    one track or one detection, and close to it else.

    Args:
        missed: (N,) > 0. paired: (N, M) >= 0. alone: (M,) > 0.
    """
    psi = paired / missed[:, None] / alone
    nu = np.ones_like(psi)
    for _ in range(_ROUNDS):
        product = psi * nu
        mu = psi / (1.0 + product.sum(axis=1, keepdims=True) - product)
        before, nu = nu, 1.0 / (1.0 + mu.sum(axis=0, keepdims=True) - mu)
        if np.abs(nu - before).max(initial=0.0) < _CONVERGED:
            break
    product = psi * nu
    pairs = product / (1.0 + product.sum(axis=1, keepdims=True))
    mu = psi / (1.0 + product.sum(axis=1, keepdims=True) - product)
    return pairs, 1.0 / (1.0 + mu.sum(axis=0))


def existence(prior: Array, detected: Array, pairs: Array) -> Array:
    """Return the probabilities (N,) that tracks exist after a picture.

    ``r = sum_j p_j + p_0 r (1 - P_D) / (1 - r P_D)``.

    Args:
        prior: (N,) probabilities before. detected: (N,) probabilities P_D of a detection of an existing object.
        pairs: (N, M) of ``marginals`` with ``missed = 1 - prior * detected``.
    """
    paired = pairs.sum(axis=1)
    hidden = prior * (1.0 - detected) / (1.0 - prior * detected)
    posterior: Array = paired + np.maximum(1.0 - paired, 0.0) * hidden
    return posterior
