"""Automatic white balance: gains of red and blue that make a picture grey on average."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.sensors.config import SensorConfig

_DARKEST_NIT = 1e-9


def channel_gains(red_gain: float, blue_gain: float) -> tuple[float, float, float]:
    """Return the factors (3,) of red, green and blue, all >= 1: with less, overexposed surfaces would not be white."""
    least = min(red_gain, 1.0, blue_gain)
    return red_gain / least, 1.0 / least, blue_gain / least


def right_gains(config: SensorConfig, radiance: NDArray[np.float64]) -> tuple[float, float]:
    """Return gains of red and blue that make a mean radiance (3,) grey, ``G / R`` and ``G / B``, within the limits.

    Grey world (Buchsbaum 1980): the mean colour of a picture is taken for that of the light.
    """
    if config.white_balance == "off":
        return 1.0, 1.0
    red, green, blue = np.maximum(radiance, _DARKEST_NIT)
    return _limited(config, green / red), _limited(config, green / blue)


def next_gains(
    config: SensorConfig, red_gain: float, blue_gain: float, radiance: NDArray[np.float64]
) -> tuple[float, float]:
    """Return the gains after one step of the loop: ``log g' = (1 - adaptation) log g + adaptation log g_right``."""
    red, blue = right_gains(config, radiance)
    return red_gain * (red / red_gain) ** config.adaptation, blue_gain * (blue / blue_gain) ** config.adaptation


def _limited(config: SensorConfig, gain: float) -> float:
    return float(min(max(gain, 1.0 / config.largest_colour_gain), config.largest_colour_gain))
