"""The scale of a target: a correlation filter over its size.

Source: Danelljan, Häger, Khan, Felsberg, Discriminative scale space tracking, TPAMI 2017, section 4: pictures of the
target, cut out at several sizes, are one signal over the size with many channels; the filter that answers it with a
Gaussian around the true size is a quotient of spectra.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from trackers.correlation_filter.features import CELL, gradients
from trackers.correlation_filter.patch import patch_around

_SIZES, _STEP = 17, 1.03
"""Number of sizes, and the ratio of one to the next."""
_LEAST_SAMPLES, _MOST_SAMPLES = 256, 512
"""Of the target at one size."""
_SIGMA = 0.75
"""Of the wanted answer, in steps of size."""
_REGULARISATION = 0.01
_RATE = 0.025


class ScaleFilter:
    """Finds by how much a target has grown."""

    def __init__(self, size_px: NDArray[np.float64]) -> None:
        """``size_px``: (2,) width and height of the target at the scale 1."""
        area = float(size_px.prod())
        step_px = np.sqrt(area / np.clip(area, _LEAST_SAMPLES, _MOST_SAMPLES))
        columns, rows = (CELL * max(round(side / (CELL * step_px)), 2) for side in size_px.tolist())
        self._shape = (rows, columns)
        self._step_px = size_px / (columns, rows)
        steps = fft.ifftshift(np.arange(_SIZES) - _SIZES // 2)
        self._factors = _STEP**steps
        self._wanted = fft.rfft(np.exp(-0.5 * (steps / _SIGMA) ** 2))
        self._window = np.cos(np.pi * steps / (_SIZES + 1)) ** 2
        self._numerator: NDArray[np.complex128] | None = None
        self._denominator = np.empty(0)

    def best(self, image_rgb: NDArray[np.uint8], centre_px: NDArray[np.float64], scale: float) -> float:
        """Return the scale of the target around a point (2,), which is looked for near ``scale``."""
        spectra = self._spectra(image_rgb, centre_px, scale)
        assert self._numerator is not None
        answer = (self._numerator.conj() * spectra).sum(0) / (self._denominator + _REGULARISATION)
        response = fft.fftshift(fft.irfft(answer, _SIZES))
        best = int(np.argmax(response))
        if response[best] <= 0.0:
            return scale
        step = float(best - _SIZES // 2)
        if 0 < best < _SIZES - 1:
            low, middle, high = response[best - 1 : best + 2]
            curve = low - 2.0 * middle + high
            step += 0.5 * (low - high) / curve if curve < 0 else 0.0
        return float(scale * _STEP**step)

    def learn(self, image_rgb: NDArray[np.uint8], centre_px: NDArray[np.float64], scale: float) -> None:
        """Learn how the target around a point (2,) looks at its scale and at others."""
        spectra = self._spectra(image_rgb, centre_px, scale)
        numerator, denominator = self._wanted.conj() * spectra, (np.abs(spectra) ** 2).sum(0)
        if self._numerator is None:
            self._numerator, self._denominator = numerator, denominator
        self._numerator = self._numerator + _RATE * (numerator - self._numerator)
        self._denominator = self._denominator + _RATE * (denominator - self._denominator)

    def _spectra(
        self, image_rgb: NDArray[np.uint8], centre_px: NDArray[np.float64], scale: float
    ) -> NDArray[np.complex128]:
        sizes = (
            gradients(patch_around(image_rgb, centre_px, self._step_px * (scale * factor), self._shape)).ravel()
            for factor in self._factors
        )
        spectra: NDArray[np.complex128] = fft.rfft(np.stack(list(sizes), axis=-1) * self._window)
        return spectra
