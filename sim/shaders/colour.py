"""Conversion between encoded and linear colours."""

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
