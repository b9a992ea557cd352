"""The background of the whole picture: a low-rank model, and what each pixel has lately shown beyond it.

N. Oliver, B. Rosario, A. Pentland, "A Bayesian computer vision system for modeling human interactions", IEEE TPAMI
22(8), 2000 (eigenbackground), with coefficients fitted robustly, since intruders are outliers (M. Black, A. Jepson,
"EigenTracking", IJCV 26(1), 1998).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numba import njit
from numpy.typing import NDArray

Picture = NDArray[np.float32]

_FITTED_PX = 6_000
_ROUNDS = 4
_OUTLIER = 2.5
"""Deviations beyond which a pixel counts less (Huber's psi; 98.7 % of a normal distribution lie within)."""
_FOLDS = 3


@dataclass(frozen=True, eq=False)
class LowRank:
    """``picture = mean + coefficients @ basis``, pixels in rows.

    Attributes:
        mean: (N,) counts.
        basis: (K, N) counts; the first two rows are a constant and the mean itself: offset and gain of the camera.
        prior: (K,) inverse variances of the coefficients; 0 for those two, which are free.
        spread: (N,) root mean square of what the model leaves, counts: pictures are explained by other days' bases.
    """

    mean: Picture
    basis: Picture
    prior: NDArray[np.float64]
    spread: Picture

    def coefficients(self, picture: Picture, start: NDArray[np.float64] | None) -> NDArray[np.float64]:
        """Return the robust coefficients (K,) of a picture (N,), beginning from ``start`` if given.

        Minimises ``sum_n rho((picture_n - mean_n - c basis_n) / spread_n) + 1/2 sum_k prior_k c_k^2`` with Huber's rho
        over every n-th pixel, by iteratively reweighted least squares.
        """
        basis, weight, step = self._fitted
        target = (picture[::step] - self.mean[::step]).astype(np.float64)
        c: NDArray[np.float64] = np.zeros(len(basis)) if start is None else start
        for round_ in range(_ROUNDS + 2 * (start is None)):
            deviation = np.abs(target - c @ basis) * weight
            scale = max(1.0, 1.4826 * float(np.median(deviation))) if round_ == 0 or start is None else 1.0
            w = weight**2 * np.minimum(1.0, _OUTLIER * scale / np.maximum(deviation, 1e-9))
            weighted = basis * w
            c = np.asarray(np.linalg.solve(weighted @ basis.T + np.diag(self.prior + 1e-9), weighted @ target))
        return c

    @property
    def deviations(self) -> NDArray[np.float64]:
        """Standard deviations of the coefficients of the scene's components, the last rows of ``basis``."""
        scene: NDArray[np.float64] = self.prior[self.prior > 0.0]
        return 1.0 / np.sqrt(scene)

    @cached_property
    def _fitted(self) -> tuple[NDArray[np.float64], NDArray[np.float64], int]:
        """Basis and weights of every n-th pixel, which the fit reads, and n."""
        step = max(1, len(self.mean) // _FITTED_PX)
        return self.basis[:, ::step].astype(np.float64), 1.0 / self.spread[::step].astype(np.float64), step

    def explained(self, coefficients: NDArray[np.float64]) -> Picture:
        """Return the picture (N,) of coefficients (K,)."""
        return self.mean + coefficients.astype(np.float32) @ self.basis


def learn(pictures: Picture, components: int, noise: Picture) -> LowRank:
    """Learn from pictures (T, N), T >= 1.

    Args:
        pictures: counts, in order of time.
        components: of the scene, beside the camera's offset and gain; 0 = none.
        noise: (N,) counts, > 0: pixels are weighted by it, or waves would take all components.
    """
    mean = pictures.mean(axis=0)
    camera = np.stack([np.ones_like(mean), mean - mean.mean()])
    if float(np.abs(camera[1]).max()) < 1e-3:
        camera = camera[:1]
    rest = (pictures - mean) / noise
    span = np.linalg.qr((camera / noise).T)[0].T.astype(np.float32)
    rest -= (rest @ span.T) @ span
    gram = (rest @ rest.T).astype(np.float64)
    basis, variance = _principal(rest, gram, np.arange(len(rest)), components)
    prior = np.concatenate([np.zeros(len(camera)), 1.0 / np.maximum(variance, 1e-6)])
    spread = np.maximum(noise * _left_over(rest, gram, components), noise)
    return LowRank(mean, np.concatenate([camera, basis * noise]), prior, spread)


def _principal(rest: Picture, gram: NDArray[np.float64], rows: NDArray[np.intp], k: int) -> tuple[Picture, NDArray]:
    """Return k orthonormal rows (k, N) that explain ``rest[rows]`` best, and the variance along each (k,)."""
    k = min(k, len(rows) - 1)
    values, vectors = np.linalg.eigh(gram[np.ix_(rows, rows)])
    order = np.argsort(values)[::-1][:k]
    order = order[values[order] > 1e-6 * max(float(values.max()), 1e-9)]
    found = (vectors[:, order] / np.sqrt(values[order])).T.astype(np.float32) @ rest[rows]
    return found, values[order] / len(rows)


def _left_over(rest: Picture, gram: NDArray[np.float64], k: int) -> Picture:
    """Return the root mean square (N,) of what bases of other days leave of each third of the pictures."""
    folds = np.array_split(np.arange(len(rest)), min(_FOLDS, len(rest)))
    total = np.zeros(rest.shape[1])
    for fold in folds:
        others = np.setdiff1d(np.arange(len(rest)), fold) if len(folds) > 1 else fold
        basis, _ = _principal(rest, gram, others, k)
        left = rest[fold] - (rest[fold] @ basis.T) @ basis
        total += np.einsum("tn,tn->n", left, left)
    return np.sqrt(total / len(rest)).astype(np.float32)


_MEMORY_OUTLIER = 3.0
"""Deviations from which a picture counts less."""
_UNCOVERED = 30.0
"""Deviations by which a place may have changed while a car stood on it: sun and rain did not reach it."""


@njit(cache=True)
def _predict(left: Picture, slow: Picture, doubt: Picture, noise: Picture, deviation: Picture) -> None:
    """``deviation = (left - slow) / sqrt(P + noise)`` per pixel (N,), ``P = doubt``; variances in counts squared."""
    for n in range(left.size):
        deviation[n] = (left[n] - slow[n]) / math.sqrt(doubt[n] + noise[n])


@njit(cache=True)
def _learn(
    left: Picture,
    claimed: NDArray[np.uint8],
    slow: Picture,
    doubt: Picture,
    noise: Picture,
    first: Picture,
    drift: float,
    rate: float,
    outlier: float,
) -> None:
    """Kalman filter of each pixel's slow residual (a random walk), with a running estimate of its noise.

    ``P = max(min(P + drift^2 v, P0), P)`` (it grows no further than at first); ``e = left - slow``; ``S = P + v``;
    ``K = P / S`` times Huber's weight of ``e / sqrt(S)``; ``slow += K e``; ``P *= 1 - K``;
    ``v += rate v (min(e^2 / S, outlier^2) - 1)``. Claimed pixels keep their residual.
    """
    for n in range(left.size):
        v = noise[n]
        if claimed[n]:
            continue
        p = max(min(doubt[n] + drift * drift * v, first[n]), doubt[n])
        e = left[n] - slow[n]
        s = p + v
        square = e * e / s
        weight = 1.0 if square < outlier * outlier else outlier / math.sqrt(square)
        gain = p / s * weight
        slow[n] += gain * e
        noise[n] = v * (1.0 + rate * (min(square, outlier * outlier) - 1.0))
        doubt[n] = p * (1.0 - gain)


class PixelMemory:
    """Slow residual, doubt and noise of all pixels.

    Attributes:
        slow: (N,) counts beyond the low-rank background.
        noise: (N,) variance from one picture to the next, counts squared.
    """

    def __init__(self, first: Picture, noise: Picture, *, remembered_frames: float, noise_frames: float) -> None:
        """Begin with no residual.

        Args:
            first: (N,) variance of the residual before anything is known, counts squared.
            noise: (N,) variance of the noise, counts squared, > 0.
            remembered_frames: time constant of the residual. noise_frames: of the noise.
        """
        self.slow, self.doubt = np.zeros_like(noise), first.copy()
        self.noise, self._floor = noise.copy(), float(np.percentile(noise, 1)) * 0.5
        self._first = first
        self._drift, self._rate = 1.0 / remembered_frames, 1.0 / noise_frames
        self._deviation = np.empty_like(noise)

    def deviation(self, left: Picture) -> Picture:
        """Return how many standard deviations (N,) a picture less its low-rank background is off."""
        _predict(left, self.slow, self.doubt, self.noise, self._deviation)
        return self._deviation

    def doubtful(self) -> Picture:
        """Return the share (N,) of the doubt about the slow residual in the variance of a picture."""
        share: Picture = self.doubt / (self.doubt + self.noise)
        return share

    def uncover(self, pixels: NDArray[np.intp]) -> None:
        """Take what the next picture shows on ``pixels`` (M,) for the background, if no object claims it."""
        self.doubt[pixels] = _UNCOVERED**2 * self.noise[pixels]

    def learn(self, left: Picture, claimed: NDArray[np.uint8]) -> None:
        """Take in a picture less its low-rank background (N,), where no object claims the pixel."""
        _learn(left, claimed, self.slow, self.doubt, self.noise, self._first, self._drift, self._rate, _MEMORY_OUTLIER)
        np.maximum(self.noise, self._floor, out=self.noise)
