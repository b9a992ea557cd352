"""Colour of black bodies: Planck's law through the filters of a colour camera."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.shaders.colour import LUMINANCE_WEIGHTS

WHITE_K = 6504.0
"""Temperature of the white for which surface colours are given (D65)."""
_SECOND_RADIATION_CONSTANT_M_K = 1.438777e-2
_WAVELENGTH_M = 1e-9 * np.arange(390.0, 701.0, 2.0)
_PEAK_M = 1e-9 * np.array([600.0, 540.0, 460.0])
_WIDTH_M = 1e-9 * np.array([35.0, 38.0, 28.0])
_FILTERS = np.exp(-0.5 * ((_WAVELENGTH_M - _PEAK_M[:, None]) / _WIDTH_M[:, None]) ** 2)
"""(3, W) sensitivities of R, G and B: bell curves with the centres and widths of common colour sensors."""


def black_body_rgb(temperature_k: float) -> NDArray[np.float64]:
    """Return the linear R, G, B (3,) of luminance 1 of a black body's light; (1, 1, 1) at 6504 K.

    Each channel adds up ``M(wavelength, T) ~ wavelength^-5 / (exp(c2 / (wavelength T)) - 1)`` (Planck 1901) under its
    filter, divided by the same at 6504 K. The filters are a camera's: with the standard observer's, red-hot light would
    have negative blue.

    Raises:
        ValueError: for a temperature outside 1,000 to 40,000 K.
    """
    if not 1000.0 <= temperature_k <= 40_000.0:
        raise ValueError(f"temperature_k: expected 1000 to 40000 K, got {temperature_k}")
    rgb = _seen(temperature_k) / _seen(WHITE_K)
    return rgb / float(rgb @ LUMINANCE_WEIGHTS)


def _seen(temperature_k: float) -> NDArray[np.float64]:
    exitance = _WAVELENGTH_M**-5 / np.expm1(_SECOND_RADIATION_CONSTANT_M_K / (_WAVELENGTH_M * temperature_k))
    seen: NDArray[np.float64] = _FILTERS @ exitance
    return seen
