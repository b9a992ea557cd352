"""An uncooled thermal camera: from radiance in its band to counts and to the 8 bits that it shows.

Noise and pattern depend on the frame alone, whatever was taken before it; the gain control has a memory.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.optics import Camera, CameraMotion
from sim.render.compilation import announce_compilation
from sim.sensors.gain_control import BIN_COUNTS, apply_tone, bin_at, histogram, right_tone
from sim.sensors.noise import frame_keys
from sim.sensors.thermal_config import ThermalConfig, ThermalPicture, ThermalSettings
from sim.sensors.thermal_noise import LARGEST_COUNT, Bolometers, count_picture, fill_deviates
from sim.thermal.radiance import apparent_temperature_k, band_radiance, band_slope

REFERENCE_K = 300.0
RANGE_K = (233.0, 423.0)
"""Black bodies of count 0 and of the largest count: the usual range of high gain."""
STEP_GREY = 6.0
"""The gain control has stepped if it changes the grey level of a picture's pixels by more than this on average."""

_LOWEST, _HIGHEST = (float(band_radiance(kelvin)) for kelvin in RANGE_K)
PER_RADIANCE = LARGEST_COUNT / (_HIGHEST - _LOWEST)
_PER_K = float(band_slope(REFERENCE_K))
_GAIN, _DRIFT, _COLUMNS, _LEVEL, _RESIDUE = range(5)
"""Patterns of a sensor, by number; residues of later corrections follow."""


class ThermalSensor:
    """A ``Sensor`` of one band, see ``sim.render.pipeline``. Its gain control is settled at the first picture."""

    def __init__(self, config: ThermalConfig, rng: np.random.Generator) -> None:
        """Draw the keys of all noise to come, and the time of the first correction, from ``rng``."""
        self.config = config
        self._noise_key, self._pattern_key = (int(key) for key in rng.integers(1 << 63, size=2))
        self._phase = float(rng.uniform())
        self._warming = float(rng.choice([-1.0, 1.0]))
        self._patterns: dict[tuple[int, int, int], tuple[NDArray[np.float32], ...]] = {}
        self._tone: NDArray[np.float32] | None = None
        self._latest: ThermalPicture | None = None
        self._frame = self._adapted_at = -1
        announce_compilation(count_picture)

    def expose(
        self,
        radiance: NDArray[np.float32],
        camera: Camera,
        frame: int,
        motion: CameraMotion | None = None,
    ) -> ThermalPicture:
        """Take the picture of a frame from its radiance (H, 1, W) in W/(m² sr), see ``Sensor``.

        Frames may be left out: the gain control then settles for longer.
        """
        is_next, self._frame = frame == self._frame + 1, frame
        if self._latest is not None and is_next and self._is_closed(frame):
            held = self._latest
            settings = ThermalSettings(held.settings.gain, held.settings.tone, is_held=True)
            return ThermalPicture(held.image_rgb, held.counts, radiance[:, 0], settings)
        counts = self._counts(radiance[:, 0], frame)
        settings = self._adapted(counts, frame)
        self._latest = _toned(radiance, counts, settings)
        return self._latest

    def develop(
        self,
        radiance: NDArray[np.float32],
        camera: Camera,
        frame: int,
        settings: ThermalSettings,
        motion: CameraMotion | None = None,
    ) -> ThermalPicture:
        """Take a picture with given settings; the gain control stays as it is. Arguments as for ``expose``."""
        return _toned(radiance, self._counts(radiance[:, 0], frame), settings)

    def _corrections(self, frame: int) -> float:
        """Return how many intervals between corrections have passed; the first one began before the first frame."""
        return frame / (self.config.rate_hz * self.config.shutter_every_s) + self._phase

    def _is_closed(self, frame: int) -> bool:
        """Return whether the shutter is closed."""
        return self._corrections(frame) % 1.0 < self.config.shutter_s / self.config.shutter_every_s

    def _counts(self, radiance: NDArray[np.float32], frame: int) -> NDArray[np.uint16]:
        c = self.config
        passed = self._corrections(frame)
        gain, drift, offset = self._pattern(int(np.floor(passed)), *radiance.shape)
        pixels = Bolometers(
            gain,
            offset,
            drift,
            np.float32(passed % 1.0),
            np.float32(c.netd_k * _PER_K),
            np.float32(0.5 * c.blur_px**2),
            np.float32(_LOWEST),
            np.float32(PER_RADIANCE),
        )
        width = radiance.shape[1]
        counts = np.empty(radiance.shape, np.uint16)
        hashes, lines = np.empty(width, np.uint32), np.empty((2, width + 2), np.float32)
        count_picture(radiance, pixels, frame_keys(self._noise_key, frame), hashes, lines, counts)
        return counts

    def _pattern(self, correction: int, height: int, width: int) -> tuple[NDArray[np.float32], ...]:
        """Return gain, drift and offset (H, W) between a correction and the next."""
        key = correction, height, width
        if key not in self._patterns:
            # The larger view's pattern is kept beside the picture's.
            self._patterns = dict([*self._patterns.items()][-1:])
            c = self.config
            gain = c.gain_spread * self._deviates(_GAIN, height, width)
            columns = self._deviates(_COLUMNS, 1, width)
            drift = c.drift_k * (np.sqrt(0.75) * self._deviates(_DRIFT, height, width) + 0.5 * columns)
            drift += self._warming * c.bowl_k * _bowl(height, width)
            residue = c.fixed_pattern_k * self._deviates(_RESIDUE + correction, height, width)
            residue += c.level_k * self._deviates(_LEVEL, 1, correction + 1)[0, correction]
            self._patterns[key] = tuple(
                np.asarray(each, np.float32) for each in (gain, _PER_K * drift, _PER_K * residue)
            )
        return self._patterns[key]

    def _deviates(self, number: int, height: int, width: int) -> NDArray[np.float32]:
        """Return the values (H, W) of one of the sensor's patterns, of N(0, 1)."""
        deviates = np.empty((height, width), np.float32)
        fill_deviates(frame_keys(self._pattern_key, number), np.empty(width, np.uint32), deviates)
        return deviates

    def _right_tone(self, found: NDArray[np.int64]) -> NDArray[np.float32]:
        c = self.config
        largest = c.largest_gain * BIN_COUNTS / (PER_RADIANCE * _PER_K)
        return right_tone(found, c.plateau, c.linear, largest)

    def _adapted(self, counts: NDArray[np.uint16], frame: int) -> ThermalSettings:
        """Let the gain control take its step and return the settings that follow."""
        found = histogram(counts)
        right = self._right_tone(found)
        has_stepped = False
        if self._tone is None:
            self._tone = right
        else:
            passed_s = max(frame - self._adapted_at, 1) / self.config.rate_hz
            change = np.float32(1.0 - np.exp(-passed_s / self.config.settling_s)) * (right - self._tone)
            corrected = int(self._corrections(frame)) != int(self._corrections(self._adapted_at))
            has_stepped = corrected or float(np.abs(change) @ found / found.sum()) > STEP_GREY
            self._tone = self._tone + change
        self._adapted_at = frame
        return ThermalSettings(_gain(self._tone, found), self._tone, has_stepped=has_stepped)


def _toned(radiance: NDArray[np.float32], counts: NDArray[np.uint16], settings: ThermalSettings) -> ThermalPicture:
    grey = np.empty(counts.shape, np.uint8)
    apply_tone(counts, np.round(settings.tone).astype(np.uint8), grey)
    return ThermalPicture(np.broadcast_to(grey[..., None], (*grey.shape, 3)), counts, radiance[:, 0], settings)


def _gain(tone: NDArray[np.float32], found: NDArray[np.int64]) -> float:
    """Return the grey levels per kelvin over the middle half of a histogram."""
    low = bin_at(found, 0.25)
    high = max(bin_at(found, 0.75), low + 1)
    low_k, high_k = apparent_temperature_k(_LOWEST + np.array([low, high]) * BIN_COUNTS / PER_RADIANCE)
    return float((tone[high] - tone[low]) / (high_k - low_k))


def _bowl(height: int, width: int) -> NDArray[np.float64]:
    """Return how far each pixel (H, W) is on the way from the middle (-1/3) to the corners (2/3), squared."""
    rows, columns = ((np.arange(side) + 0.5) / (0.5 * side) - 1.0 for side in (height, width))
    away: NDArray[np.float64] = 0.5 * (rows[:, None] ** 2 + columns**2) - 1.0 / 3.0
    return away
