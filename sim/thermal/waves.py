"""Waves of the sea as slopes on a periodic tile.

The surface is a sum of plane waves with the wave vectors of a square tile,

    h(x, y, t) = Re sum_k A_k exp(i (k . (x, y) - w_k t)),   w² = g |k|

(Tessendorf, "Simulating ocean water", 2001; deep water). ``|A_k|²`` follows the spectrum of a wind sea, k^-4 with the
cut-off of Pierson and Moskowitz (1964) below the peak and cos² around the wind's direction; swell is a narrow band of
long waves of its own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.fft import ifft2

from sim.checks import check_types, check_within

TILE_M = 48.0
CELLS = 128
LEVELS = 4
"""Of slopes: each next one has half as many cells a side, for water further away."""
_GRAVITY_MPS2 = 9.81


@dataclass(frozen=True, slots=True)
class SeaState:
    """Waves of one day.

    Attributes:
        wind_wave_m: significant height of the waves that the wind makes. wind_rad: where they run to.
        peak_m: their commonest wavelength.
        swell_m: significant height of the swell. swell_length_m: its wavelength. swell_rad: where it runs to.
        fine_slope: root mean square of the slopes of waves that are too short for the tile's cells.
    """

    wind_wave_m: float = 0.12
    wind_rad: float = 0.0
    peak_m: float = 3.0
    swell_m: float = 0.05
    swell_length_m: float = 20.0
    swell_rad: float = 0.0
    fine_slope: float = 0.05

    def __post_init__(self) -> None:
        check_types(self)
        check_within(self, "wind_wave_m swell_m", 0, 5)
        check_within(self, "peak_m", 0.8, TILE_M)
        check_within(self, "swell_length_m", 8, TILE_M)
        check_within(self, "fine_slope", 0.01, 0.4)

    @property
    def significant_m(self) -> float:
        """Significant height of all waves."""
        return float(np.hypot(self.wind_wave_m, self.swell_m))


class SeaWaves:
    """The waves of one sea.

    Attributes:
        state: their statistics.
        time_s: now.
    """

    def __init__(self, state: SeaState, rng: np.random.Generator) -> None:
        self.state, self.time_s = state, 0.0
        numbers = np.fft.fftfreq(CELLS, 1.0 / CELLS)
        kx, ky = np.meshgrid(2 * np.pi / TILE_M * numbers, 2 * np.pi / TILE_M * numbers, indexing="xy")
        k = np.hypot(kx, ky)
        # Nyquist's rows have no negative partner; the mean level is the tide's.
        usable = (k > 0) & (np.abs(kx) < kx.max()) & (np.abs(ky) < ky.max())
        variance = _wind_sea(state, np.where(usable, k, np.inf), kx, ky) + _swell(state, kx, ky)
        deviates = rng.normal(size=(2, CELLS, CELLS))
        amplitude = np.where(usable, np.sqrt(variance) * (deviates[0] + 1j * deviates[1]), 0.0)
        frequencies, self._which = np.unique(np.round(np.sqrt(_GRAVITY_MPS2 * k), 12), return_inverse=True)
        self._frequencies = frequencies
        self._components = kx, ky, np.sqrt(_GRAVITY_MPS2 * k), amplitude
        # The field sx + i sy of the two slopes: Re f has the spectrum (f(k) + f(-k)*) / 2.
        mirrored = np.conj(np.roll(amplitude[::-1, ::-1], (1, 1), (0, 1)))
        slope = 0.5 * CELLS**2 * (1j * kx - ky)
        self._forward, self._backward = (
            (slope * amplitude).astype(np.complex64),
            (slope * mirrored).astype(np.complex64),
        )

    def strongest(self, count: int) -> tuple[NDArray[np.float64], ...]:
        """Return the components of the surface with the greatest amplitudes: wave vectors' x and y, angular frequencies
        and complex amplitudes, each (count,), see the module.
        """
        kx, ky, omega, amplitude = (each.ravel() for each in self._components)
        chosen = np.argsort(-np.abs(amplitude), kind="stable")[:count]
        return kx[chosen], ky[chosen], omega[chosen], amplitude[chosen]

    def slopes(self) -> NDArray[np.float32]:
        """Return the slopes dh/dx and dh/dy (CELLS, CELLS, 2) now, rows along y; cell (i, j) is at
        ``(j, i) * TILE_M / CELLS``.
        """
        turned = self._turned().astype(np.complex64)[self._which].reshape(CELLS, CELLS)
        field = ifft2(self._forward * turned + self._backward * turned.conj(), overwrite_x=True)
        return field.view(np.float32).reshape(CELLS, CELLS, 2)

    def _turned(self) -> NDArray[np.complex128]:
        """Return ``exp(-i w t)`` of each frequency: many wave vectors have the same."""
        return np.exp(-1j * np.fmod(self._frequencies * self.time_s, 2.0 * np.pi))


def _wind_sea(
    state: SeaState, k: NDArray[np.float64], kx: NDArray[np.float64], ky: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the variance of each component's real and imaginary part; those of infinite k have none."""
    peak = 2.0 * np.pi / state.peak_m
    along = (kx * np.cos(state.wind_rad) + ky * np.sin(state.wind_rad)) / k
    spectrum = k**-4.0 * np.exp(-1.25 * (peak / k) ** 2) * np.where(along > 0, along**2, 0.0)
    return _of_height(spectrum, state.wind_wave_m)


def _swell(state: SeaState, kx: NDArray[np.float64], ky: NDArray[np.float64]) -> NDArray[np.float64]:
    """As ``_wind_sea``."""
    peak = 2.0 * np.pi / state.swell_length_m
    away = (kx - peak * np.cos(state.swell_rad)) ** 2 + (ky - peak * np.sin(state.swell_rad)) ** 2
    return _of_height(np.exp(-0.5 * away / (0.25 * peak) ** 2), state.swell_m)


def _of_height(spectrum: NDArray[np.float64], significant_m: float) -> NDArray[np.float64]:
    """Return the spectrum scaled to waves of this significant height, four standard deviations of the surface."""
    # A component with A = a + ib has the mean square (a² + b²) / 2 on the surface.
    return spectrum / spectrum.sum() * (significant_m / 4.0) ** 2
