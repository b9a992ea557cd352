"""The automatic exposure: what settings bring a picture to mid grey."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.sensors.config import SensorConfig, SensorSettings
from sim.shaders.colour import LUMINANCE_WEIGHTS

METER_STEP_PX = 8
"""The light meter looks at every eighth pixel of every eighth row."""


def metered_luminance(radiance: NDArray[np.float32]) -> float:
    """Return the mean luminance in cd/m² of a radiance picture (H, 3, W)."""
    seen = radiance[::METER_STEP_PX, :, ::METER_STEP_PX]
    return luminance_of(seen.mean(axis=(0, 2), dtype=float))


def luminance_of(radiance: NDArray[np.float64]) -> float:
    """Return the luminance in cd/m² of one radiance (3,)."""
    return float(LUMINANCE_WEIGHTS @ radiance)


def right_settings(config: SensorConfig, luminance_nit: float) -> SensorSettings:
    """Return the settings that bring a mean luminance to mid grey: exposure first, then gain.

    ``mid_grey = luminance * electrons_per_nit_s * exposure * gain / full_well_e``, within the limits.
    """
    if config.mode == "fixed":
        return SensorSettings(config.fixed_exposure_s, config.fixed_gain)
    wanted_s = config.mid_grey * config.full_well_e / (config.electrons_per_nit_s * max(luminance_nit, 1e-9))
    return _split(config, wanted_s)


def next_settings(config: SensorConfig, now: SensorSettings, luminance_nit: float) -> SensorSettings:
    """Return the settings after one step of the loop.

    With the product p of exposure and gain: ``log p' = (1 - adaptation) log p + adaptation log p_right``.
    """
    if config.mode == "fixed":
        return now
    right = right_settings(config, luminance_nit)
    product = now.exposure_s * now.gain
    return _split(config, product * (right.exposure_s * right.gain / product) ** config.adaptation)


def _split(config: SensorConfig, product_s: float) -> SensorSettings:
    exposure_s = min(max(product_s, config.shortest_exposure_s), config.longest_exposure_s)
    return SensorSettings(exposure_s, min(max(product_s / exposure_s, 1.0), config.largest_gain))
