"""Heights of a sea, from the slopes that it shows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.thermal.waves import CELLS, TILE_M, SeaWaves


def heights_m(waves: SeaWaves, places_m: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return height (N,) and slope (N, 2) at places (N, 2): a direct sum of the waves whose slopes there are now.

    A plane wave ``a exp(i k . x)`` has the slopes ``i k a``: of any field of slopes, the part along k is of a surface.
    """
    slopes = waves.slopes().astype(float)
    spectrum = np.fft.fft2(slopes, axes=(0, 1)) / CELLS**2
    numbers = 2.0 * np.pi / TILE_M * np.fft.fftfreq(CELLS, 1.0 / CELLS)
    vectors = np.stack(np.meshgrid(numbers, numbers, indexing="xy"), axis=-1)
    amplitudes = -1j * (vectors * spectrum).sum(axis=-1) / np.maximum((vectors**2).sum(axis=-1), 1e-9)
    strong = np.abs(amplitudes) > 1e-8
    amplitude, vector = amplitudes[strong], vectors[strong]
    wave = amplitude * np.exp(1j * (np.asarray(places_m, dtype=float) @ vector.T))
    return wave.sum(axis=-1).real, ((1j * wave) @ vector).real
