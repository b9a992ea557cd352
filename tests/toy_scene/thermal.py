"""A thermal camera in small: every body has a temperature, the sensor counts it, a gain control makes 8 bits of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sim.gbuffer import GBuffer
from sim.sensors.config import SensorSettings
from trackers.types import CameraModel

GROUND_K, BODY_K, SKY_K = 285.0, 303.0, 250.0
_COUNTS_PER_K, _COLDEST_K, _NOISE_COUNTS = 40.0, 200.0, 2.0
_LARGEST_COUNT = (1 << 14) - 1
_INTEGRATION_S = 0.01


class Warmth:
    """Shader: the radiance of a surface is its temperature, one band, whatever the light."""

    def __init__(self, temperature_k: NDArray[np.float64]) -> None:
        self._temperature_k = np.append(temperature_k, SKY_K).astype(np.float32)

    def shade(self, gbuffer: GBuffer, camera: CameraModel, T_world_camera: NDArray[np.float64]) -> NDArray[np.float32]:
        """Return (H, 1, W) float32, kelvin."""
        return self._temperature_k[gbuffer.instance_id][:, None, :]


@dataclass(frozen=True, slots=True)
class ThermalPicture:
    """What the sensor gives: counts (H, W) uint16 of 14 bits, the same as grey in three channels, settings in use."""

    image_rgb: NDArray[np.uint8]
    counts: NDArray[np.uint16]
    settings: SensorSettings


class ThermalSensor:
    """Counts, noise, and a gain control that spreads each picture's counts over 8 bits."""

    settings = None

    def __init__(self, rng: np.random.Generator) -> None:
        self._key = int(rng.integers(1 << 31))
        self._low = 0.0

    def expose(self, radiance: NDArray[np.float32], camera: CameraModel, frame: int, **exposing: Any) -> ThermalPicture:
        """Take the picture of a frame."""
        self._low, high = np.percentile(self._counts(radiance, frame), (0.5, 99.5))
        gain = 255.0 / max(float(high - self._low), 1.0)
        return self.develop(radiance, camera, frame, SensorSettings(_INTEGRATION_S, gain))

    def develop(
        self,
        radiance: NDArray[np.float32],
        camera: CameraModel,
        frame: int,
        settings: SensorSettings,
        **exposing: Any,
    ) -> ThermalPicture:
        """Take a picture with a gain that is given, and the level of the latest exposure."""
        counts = self._counts(radiance, frame)
        grey = np.clip((counts - self._low) * settings.gain, 0, 255).astype(np.uint8)
        return ThermalPicture(np.repeat(grey[..., None], 3, axis=2), counts, settings)

    def _counts(self, radiance: NDArray[np.float32], frame: int) -> NDArray[np.uint16]:
        noise = np.random.default_rng([self._key, frame]).normal(0.0, _NOISE_COUNTS, radiance[:, 0].shape)
        counts = np.round(_COUNTS_PER_K * (radiance[:, 0] - _COLDEST_K) + noise)
        return np.clip(counts, 0, _LARGEST_COUNT).astype(np.uint16)
