"""Change of the light by the camera's reported settings, as register values (paper B, sections 2.2 and 4)."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

from trackers.kernels.histogram import bhattacharyya
from trackers.types import CameraRegisters, Observation

LARGEST_WHITE_BALANCE = 1023
"""Of R and B."""
LARGEST_SHUTTER_STEP, LARGEST_GAIN_STEP = 177, 342
"""S_max and G_max."""
_SHUTTER_STEP, _GAIN_STEP = 4, 2
_TREND_SHUTTER_WEIGHT, _TREND_GAIN_WEIGHT, _TREND_FRAMES = 10.0, 10.0, 10
_COLOUR_WEIGHT, _SHUTTER_WEIGHT, _GAIN_WEIGHT = 0.4, 6.0, 0.9


def shutter_and_gain(registers: CameraRegisters) -> tuple[int, int]:
    """Return S in 0 to 177 and G in 0 to 342: shutter and gain in steps of 4 and 2, their standard deviations at
    constant light (section 2.3), to the nearest step.
    """
    return int(registers.shutter / _SHUTTER_STEP + 0.5), int(registers.gain / _GAIN_STEP + 0.5)


def white_balance_change(now: CameraRegisters, then: CameraRegisters) -> int:
    """Return ``|R - R'| + |B - B'|`` in register values."""
    return abs(now.red - then.red) + abs(now.blue - then.blue)


def colour_change(white_balance_change: float, unit: float) -> float:
    """Return ``P_c = 0.4 (|R - R'| + |B - B'|) / unit``, at most 1 (equation 9; its unit: ``StereoColourParameters``).

    Args:
        white_balance_change, unit: register values.
    """
    return min(_COLOUR_WEIGHT * white_balance_change / unit, 1.0)


def brightness_change(now: CameraRegisters, then: CameraRegisters) -> float:
    """Return ``P_l = 6.0 |S - S'| / S_max + 0.9 |G - G'| / G_max`` in [0, 1] (equation 10)."""
    (shutter, gain), (shutter_then, gain_then) = shutter_and_gain(now), shutter_and_gain(then)
    by_shutter = _SHUTTER_WEIGHT * abs(shutter - shutter_then) / LARGEST_SHUTTER_STEP
    return min(by_shutter + _GAIN_WEIGHT * abs(gain - gain_then) / LARGEST_GAIN_STEP, 1.0)


def dissimilarity(histogram: NDArray[np.float64], template: NDArray[np.float64]) -> float:
    """Return ``R_color = sqrt(1 - sum_h sum_s sqrt(H_in H_t))`` in [0, 1] of two histograms of sum 1 (equation 1)."""
    return float(np.sqrt(max(0.0, 1.0 - bhattacharyya(histogram, template))))


class LightTrend:
    """D_l: suitability of the light for learning colour, by the trend of the camera's exposure (section 2.3).

    ``h = k_S S / S_max + k_G G / G_max``, ``k_S = k_G = 10`` (equation 4); g_h is the slope of the least-squares line
    through h of the last 10 frames, per frame; ``D_l = g_h S_max / S`` where S is below its largest, else
    ``g_h G_max / G`` (equation 5). A shutter or gain of 0 counts as one step; with a single frame the slope is 0.
    """

    def __init__(self) -> None:
        self._steps: deque[tuple[int, int]] = deque(maxlen=_TREND_FRAMES)

    def update(self, now: CameraRegisters) -> float:
        """Return D_l after the settings of the next frame."""
        shutter, gain = shutter_and_gain(now)
        self._steps.append((shutter, gain))
        # Integers, so that constant settings have a slope of exactly 0: its sign matters.
        twice_centred = 2 * np.arange(len(self._steps)) - (len(self._steps) - 1)
        shutter_slope, gain_slope = (
            2 * (twice_centred @ np.array(self._steps)) / max(int(twice_centred @ twice_centred), 1)
        )
        slope = (
            _TREND_SHUTTER_WEIGHT * shutter_slope / LARGEST_SHUTTER_STEP
            + _TREND_GAIN_WEIGHT * gain_slope / LARGEST_GAIN_STEP
        )
        if shutter < LARGEST_SHUTTER_STEP:
            return float(slope * LARGEST_SHUTTER_STEP / max(shutter, 1))
        return float(slope * LARGEST_GAIN_STEP / max(gain, 1))


_REGISTER_LIMITS = {"red": 1023, "blue": 1023, "shutter": 707, "gain": 683}


def camera_registers(observation: Observation, before: CameraRegisters | None = None) -> CameraRegisters:
    """Return the camera's register values; if it reports none, those ``before``.

    Raises:
        ValueError: if there are neither, or a value is out of range.
    """
    registers = (observation.settings.registers if observation.settings else None) or before
    if registers is None:
        raise ValueError("settings.registers: expected the camera's automatic settings as register values, got None")
    for name, largest in _REGISTER_LIMITS.items():
        value = getattr(registers, name)
        if not 0 <= value <= largest:
            raise ValueError(f"settings.registers.{name}: expected 0 to {largest}, got {value}")
    return registers
