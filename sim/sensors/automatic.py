"""Automatic exposure and white balance: settings that bring a picture to mid grey on average."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.sensors.config import SensorConfig
from sim.shaders.colour import LUMINANCE_WEIGHTS

METER_STEP_PX = 8
"""The light meter looks at every eighth pixel of every eighth row."""


def metered_radiance(radiance: NDArray[np.float32], row_step: int = METER_STEP_PX) -> NDArray[np.float64]:
    """Return the mean (3,) in cd/m² of each channel of a radiance picture (H, 3, W).

    Args:
        row_step: 1 if ``radiance`` has only the metered rows.
    """
    seen = radiance[::row_step, :, ::METER_STEP_PX]
    mean: NDArray[np.float64] = seen.mean(axis=(0, 2), dtype=float)
    return mean


def luminance_of(radiance: NDArray[np.float64]) -> float:
    """Return the luminance in cd/m² of one radiance (3,)."""
    return float(LUMINANCE_WEIGHTS @ radiance)


def right_exposure(config: SensorConfig, luminance_nit: float) -> tuple[float, float]:
    """Return exposure time and gain that bring a mean luminance to mid grey: exposure first, then gain.

    ``mid_grey = luminance * electrons_per_nit_s * exposure * gain / full_well_e``, within the limits.
    """
    wanted_s = config.mid_grey * config.full_well_e / (config.electrons_per_nit_s * max(luminance_nit, 1e-9))
    return _split(config, wanted_s)


def next_exposure(config: SensorConfig, exposure_s: float, gain: float, luminance_nit: float) -> tuple[float, float]:
    """Return exposure time and gain after one step of the loop.

    With the product p of the two: ``log p' = (1 - adaptation) log p + adaptation log p_right``.
    """
    right_s, right_gain = right_exposure(config, luminance_nit)
    product = exposure_s * gain
    return _split(config, product * (right_s * right_gain / product) ** config.adaptation)


def _split(config: SensorConfig, product_s: float) -> tuple[float, float]:
    exposure_s = min(max(product_s, config.shortest_exposure_s), config.longest_exposure_s)
    return exposure_s, min(max(product_s / exposure_s, 1.0), config.largest_gain)


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
    red, green, blue = (max(channel, _DARKEST_NIT) for channel in radiance.tolist())
    return _limited(config, green / red), _limited(config, green / blue)


def next_gains(
    config: SensorConfig, red_gain: float, blue_gain: float, radiance: NDArray[np.float64]
) -> tuple[float, float]:
    """Return the gains after one step of the loop: ``log g' = (1 - adaptation) log g + adaptation log g_right``."""
    red, blue = right_gains(config, radiance)
    return red_gain * (red / red_gain) ** config.adaptation, blue_gain * (blue / blue_gain) ** config.adaptation


def _limited(config: SensorConfig, gain: float) -> float:
    return float(min(max(gain, 1.0 / config.largest_colour_gain), config.largest_colour_gain))
