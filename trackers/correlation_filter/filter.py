"""A discriminative correlation filter: how a target looks, apart from what is around it, and where it is in a picture.

The filter f has weights on the target's cells alone, and answers the features x of a region around the target with a
Gaussian y over its displacement: ``min_f |f * x - y|² + mu |f - f_before|²``, f = 0 outside the target.

* Henriques, Caseiro, Martins, Batista, High-speed tracking with kernelized correlation filters, TPAMI 2015: all
  displacements of one region are the training samples, in the frequency domain.
* Kiani Galoogahi, Fagg, Lucey, Learning background-aware correlation filters for visual tracking, ICCV 2017: f = 0
  outside the target, by the alternating direction method of multipliers.
* Li, Tian, Zuo, Zhang, Yang, Learning spatial-temporal regularized correlation filters for visual tracking, CVPR 2018:
  the second term, which holds the filter where the target is hidden, and the closed form of one sample.
* Danelljan, Bhat, Khan, Felsberg, ECO: efficient convolution operators for tracking, CVPR 2017: the peak between cells
  by Newton's method on the response's Fourier series.
* Bertinetto et al., Staple, CVPR 2016 (see ``colour``): the response is mixed with how likely the colours of a box are
  those of the target, which holds where the target changes its form.
* Danelljan et al., TPAMI 2017 (see ``scale``): the target's size.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy import fft

from trackers.correlation_filter.colour import ColourModel, colour_bins
from trackers.correlation_filter.features import CELL, cell_features
from trackers.correlation_filter.patch import patch_around
from trackers.correlation_filter.scale import ScaleFilter
from trackers.kernels.boxes import box_centre, box_size

_CELLS = 48
"""Cells a side of the region."""
_REGION = 4.5
"""Side of the region, in roots of the target's area."""
_LEAST_REGION = 1.3
"""Side of the region of a long target, in its longer sides."""
_SIGMA = 0.0625
"""Of the Gaussian y, in roots of the target's area."""
_HOLD = 0.25
"""mu, in mean energies of the region."""
_PENALTY, _PENALTY_GROWTH = 0.025, 10.0
"""Of a weight outside the target, in the same unit, and its growth from one iteration to the next."""
_ITERATIONS, _FIRST_ITERATIONS = 2, 4
_COLOUR = 0.25
"""Share of colours in the response."""
_COLOUR_RATE = 0.04
_COLOUR_CORE = 0.8
"""Sides of the part of the box whose colours are the target's."""
_PEAK_CELLS = 3
"""Half the side of the part of the response that belongs to its peak."""
_NEWTON_STEPS, _NEWTON_ENDS = 4, 1e-3


@dataclass(frozen=True, eq=False)
class Match:
    """Where a target is most likely in a region.

    Attributes:
        position_px: (2,) middle of the target.
        scale: its size relative to that of the first box.
        peak: the filter's response there: about 1 where it looks as it was learnt, towards 0 where it is hidden.
        sharpness: the peak above the mean of the response around it, in standard deviations of that (peak-to-sidelobe
            ratio: Bolme et al., Visual object tracking using adaptive correlation filters, CVPR 2010).
    """

    position_px: NDArray[np.float64]
    scale: float
    peak: float
    sharpness: float


class CorrelationFilter:
    """How a target looks, learnt from a box in a picture and from the boxes of later ones.

    The caller keeps where the target is. Equal calls give equal answers.
    """

    def __init__(self, image_rgb: NDArray[np.uint8], box_xyxy: NDArray[np.float64]) -> None:
        """Learn the target in a box (4,) of a picture (H, W, 3); the box may reach beyond the picture.

        Raises:
            ValueError: for a box that is none, see ``box_size``.
        """
        self.size_px = box_size(box_xyxy)
        region_px = max(_REGION * float(np.sqrt(self.size_px.prod())), _LEAST_REGION * float(self.size_px.max()))
        self._step_px = region_px / (CELL * _CELLS)
        self._box_samples = self.size_px / self._step_px
        offsets = np.arange(_CELLS) - _CELLS // 2
        sigma = _SIGMA * float(np.sqrt(self._box_samples.prod())) / CELL
        bell = np.exp(-0.5 * (fft.ifftshift(offsets) / sigma) ** 2)
        self._wanted = fft.rfft2(np.outer(bell, bell).astype(np.float32))
        across, down = (np.abs(offsets + 0.5) <= max(0.5 * side / CELL, 1.0) for side in self._box_samples)
        self._on_target = np.outer(down, across).astype(np.float32)
        hann = np.cos(np.pi * (offsets + 0.5) / (_CELLS + 1)).astype(np.float32) ** 2
        self._window = np.outer(hann, hann)
        self._core = np.flatnonzero(self._inside(_COLOUR_CORE * self._box_samples))
        beyond = self._box_samples + self._box_samples.mean()
        self._around = np.flatnonzero(self._inside(beyond) & ~self._inside(self._box_samples))
        self._colours = ColourModel()
        self._sizes = ScaleFilter(self.size_px)
        self._weights: NDArray[np.float32] | None = None
        self._weight_spectra: NDArray[np.complex64] = np.empty(0, np.complex64)
        self.update(image_rgb, box_xyxy)

    def locate(
        self, image_rgb: NDArray[np.uint8], around_px: NDArray[np.float64], scale: float = 1.0, search: float = 1.0
    ) -> Match:
        """Look for the target in a picture (H, W, 3).

        Args:
            around_px: (2,) where it is expected.
            scale: size at which it is expected, relative to that of the first box.
            search: side of the region in which it is looked for, >= 1. At 1 the region is that in which the target is
                learnt, 4.5 roots of its area, and places near its middle are more likely. In a larger one all places
                are equally likely, and the time grows as its square.
        """
        cells = 2 * round(0.5 * search * _CELLS)
        samples = CELL * cells
        patch = patch_around(image_rgb, around_px, np.full(2, self._step_px * scale), (samples, samples))
        features = cell_features(patch)
        if cells == _CELLS:
            features *= self._window
        spectrum = (self._spectra(cells).conj() * fft.rfft2(features)).sum(0)
        response = fft.fftshift(fft.irfft2(spectrum, (cells, cells)))
        mixed = (1.0 - _COLOUR) * response + _COLOUR * self._colour_response(patch, cells)
        top = divmod(int(np.argmax(mixed)), cells)
        row, column = _peak(mixed, top)
        cell_px = self._step_px * scale * CELL
        position_px = around_px + cell_px * (np.array([column, row]) - cells // 2)
        best_scale = self._sizes.best(image_rgb, position_px, scale)
        return Match(position_px, best_scale, float(response[top]), _sharpness(response, top))

    def update(self, image_rgb: NDArray[np.uint8], box_xyxy: NDArray[np.float64]) -> None:
        """Learn how the target looks in a box (4,) of a picture (H, W, 3).

        The box's sides have the ratio of the first box: its area tells the scale.

        Raises:
            ValueError: for a box that is none, see ``box_size``.
        """
        centre_px = box_centre(box_xyxy)
        scale = float(np.sqrt(box_size(box_xyxy).prod() / self.size_px.prod()))
        samples = CELL * _CELLS
        patch = patch_around(image_rgb, centre_px, np.full(2, self._step_px * scale), (samples, samples))
        bins = colour_bins(patch).ravel()
        self._colours.learn(bins[self._core], bins[self._around], 1.0 if self._weights is None else _COLOUR_RATE)
        self._learn(fft.rfft2(cell_features(patch) * self._window))
        self._sizes.learn(image_rgb, centre_px, scale)

    def _learn(self, spectra: NDArray[np.complex64]) -> None:
        """Learn the weights on features of these spectra (CHANNELS, n, n // 2 + 1)."""
        first = self._weights is None
        energies = (spectra.real**2 + spectra.imag**2).sum(0)
        energy = np.float32(max(float(energies.mean()), 1e-6))
        hold = np.float32(0.0 if first else _HOLD) * energy
        penalty = np.float32(_PENALTY) * energy
        before = np.zeros_like(spectra) if first else self._weight_spectra
        wanted = spectra * self._wanted.conj() + hold * before
        confined, dual = before, np.zeros_like(spectra)
        for _ in range(_FIRST_ITERATIONS if first else _ITERATIONS):
            free = _free_optimum(spectra, energies, wanted, confined, dual, hold, penalty)
            self._weights = fft.irfft2(free, (_CELLS, _CELLS)) * self._on_target
            confined = fft.rfft2(self._weights)
            dual = free - confined
            penalty *= np.float32(_PENALTY_GROWTH)
        self._weight_spectra = confined

    def _spectra(self, cells: int) -> NDArray[np.complex64]:
        """Return the spectra of the weights in the middle of a region of so many cells a side."""
        assert self._weights is not None
        margin = (cells - _CELLS) // 2
        if margin == 0:
            return self._weight_spectra
        spectra: NDArray[np.complex64] = fft.rfft2(np.pad(self._weights, ((0, 0), (margin, margin), (margin, margin))))
        return spectra

    def _colour_response(self, patch_rgb: NDArray[np.uint8], cells: int) -> NDArray[np.float32]:
        """Return how likely the colours of a box around each place are the target's (cells, cells), 0 to 1."""
        likelihood = self._colours.likelihood(colour_bins(patch_rgb))
        box = [2 * int(0.5 * side) + 1 for side in self._box_samples]
        mean = cv2.boxFilter(likelihood, cv2.CV_32F, box, borderType=cv2.BORDER_REPLICATE)
        # Places lie at corners of cells.
        corners = np.array([[CELL, 0, -0.5], [0, CELL, -0.5]])
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        at = cv2.warpAffine(mean, corners, (cells, cells), flags=flags, borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(at, np.float32)

    def _inside(self, box_samples: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return which samples of the region lie in a box of so many (2,) in its middle, at least one a side."""
        offsets = np.abs(np.arange(CELL * _CELLS) + 0.5 - 0.5 * CELL * _CELLS)
        across, down = (offsets <= max(0.5 * side, 0.5) for side in box_samples)
        return np.outer(down, across)


@njit(cache=True, fastmath=True)
def _free_optimum(spectra, energies, wanted, confined, dual, hold, penalty):  # type: ignore[no-untyped-def]
    """Return the weights that are best for each frequency, not confined to the target, plus ``dual``.

    By the Sherman-Morrison formula, since each frequency has one sample.
    """
    channels, rows, columns = spectra.shape
    along = np.zeros((rows, columns), np.complex64)
    free = np.empty_like(spectra)
    for c in range(channels):
        for i in range(rows):
            for j in range(columns):
                pull = wanted[c, i, j] + penalty * (confined[c, i, j] - dual[c, i, j])
                free[c, i, j] = pull
                along[i, j] += np.conj(spectra[c, i, j]) * pull
    for i in range(rows):
        for j in range(columns):
            along[i, j] /= hold + penalty + energies[i, j]
    share = np.float32(1) / (hold + penalty)
    for c in range(channels):
        for i in range(rows):
            for j in range(columns):
                free[c, i, j] = (free[c, i, j] - spectra[c, i, j] * along[i, j]) * share + dual[c, i, j]
    return free


def _peak(response: NDArray[np.float32], top: tuple[int, int]) -> tuple[float, float]:
    """Return row and column of the highest point of the Fourier series through a response (n, n), n even.

    Newton's method from the highest value, at ``top``; if it leaves its neighbourhood, that place is returned.
    """
    size = len(response)
    series = fft.fft2(response.astype(float)) / size**2
    # The highest frequency is left out: its phase is not known.
    series[size // 2], series[:, size // 2] = 0.0, 0.0
    waves = 2j * np.pi * fft.fftfreq(size)
    place = np.array(top, float)
    for _ in range(_NEWTON_STEPS):
        down, across = np.exp(waves * place[0]), np.exp(waves * place[1])
        middle, slope, bend = (series @ (across * waves**order) for order in range(3))
        gradient = np.array([(down * waves) @ middle, down @ slope]).real
        mixed = ((down * waves) @ slope).real
        hessian = np.array([[((down * waves**2) @ middle).real, mixed], [mixed, (down @ bend).real]])
        if not (hessian[0, 0] < 0 and np.linalg.det(hessian) > 0):
            return top
        step = np.linalg.solve(hessian, gradient)
        place -= step
        if np.abs(place - top).max() > 1.0:
            return top
        if np.abs(step).max() < _NEWTON_ENDS:
            break
    return float(place[0]), float(place[1])


def _sharpness(response: NDArray[np.float32], top: tuple[int, int]) -> float:
    """Return the peak-to-sidelobe ratio of a response (n, n) with its peak at ``top``."""
    beside = np.ones(response.shape, bool)
    beside[tuple(slice(max(place - _PEAK_CELLS, 0), place + _PEAK_CELLS + 1) for place in top)] = False
    others = response[beside]
    return float((response[top] - others.mean()) / max(float(others.std()), 1e-6))
