"""Encoded and linear colours, and the colour of black bodies: Planck's law through the filters of a camera."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

LUMINANCE_WEIGHTS = np.array([0.2126, 0.7152, 0.0722])
"""Share of linear R, G and B in luminance (ITU-R BT.709)."""


def srgb_to_linear(encoded: NDArray[np.floating]) -> NDArray[np.floating]:
    """Return linear values in [0, 1] of sRGB values in [0, 1] (IEC 61966-2-1)."""
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def linear_to_srgb(linear: NDArray[np.floating]) -> NDArray[np.floating]:
    """Return sRGB values in [0, 1] of linear values in [0, 1] (IEC 61966-2-1)."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 0.0031308) ** (1 / 2.4) - 0.055)


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
