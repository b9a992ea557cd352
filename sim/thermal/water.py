"""How water reflects and emits in the thermal band: Fresnel's equations with the indices of Hale and Querry."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

WAVELENGTH_M = 1e-6 * np.arange(8.0, 14.5)
REFRACTIVE_INDEX = np.array([1.291, 1.262, 1.218, 1.153, 1.111, 1.146, 1.210])
EXTINCTION_INDEX = np.array([0.0343, 0.0399, 0.0508, 0.0968, 0.199, 0.305, 0.370])
"""At ``WAVELENGTH_M``, 25 °C: Hale and Querry, "Optical constants of water in the 200 nm to 200 µm wavelength region",
Applied Optics 12 (1973)."""

# Half an interval at the ends; a black body of 288 K is nearly as bright at all wavelengths of the band.
_WEIGHTS = np.array([0.5, 1, 1, 1, 1, 1, 0.5]) / 6.0


def reflectance(cosine: ArrayLike) -> NDArray[np.float64]:
    """Return the share of unpolarised light in the band that a smooth water surface reflects.

    With the complex index m: ``r_s = (c - q) / (c + q)``, ``r_p = (m² c - q) / (m² c + q)``, ``q² = m² - 1 + c²``; the
    share is the mean of ``|r_s|²`` and ``|r_p|²``.

    Args:
        cosine: (...) of the angle of incidence, in [0, 1].
    """
    return np.asarray(spectral_reflectance(cosine) @ _WEIGHTS)


def spectral_reflectance(cosine: ArrayLike) -> NDArray[np.float64]:
    """Return ``reflectance`` at each of ``WAVELENGTH_M`` (..., 7)."""
    c = np.asarray(cosine, dtype=float)[..., None]
    square = (REFRACTIVE_INDEX + 1j * EXTINCTION_INDEX) ** 2
    q = np.sqrt(square - 1.0 + c**2)
    r_s, r_p = (c - q) / (c + q), (square * c - q) / (square * c + q)
    return 0.5 * (np.abs(r_s) ** 2 + np.abs(r_p) ** 2)
