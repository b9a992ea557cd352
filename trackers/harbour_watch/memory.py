"""What each pixel has lately shown beyond the low-rank background: a slow residual and the noise about it."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Picture = NDArray[np.float32]

_OUTLIER = 3.0
"""Deviations from which a picture counts less."""
_UNCOVERED = 30.0
"""Deviations by which a place may have changed while a car stood on it: sun and rain did not reach it."""


@njit(cache=True)
def _predict(
    left: Picture,
    slow: Picture,
    doubt: Picture,
    noise: Picture,
    deviation: Picture,
) -> None:
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
        _learn(
            left,
            claimed,
            self.slow,
            self.doubt,
            self.noise,
            self._first,
            self._drift,
            self._rate,
            _OUTLIER,
        )
        np.maximum(self.noise, self._floor, out=self.noise)
