"""How a stereo camera like the Bumblebee2 reports its settings: whole numbers in the ranges of paper B, Table 1."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sim.sensors.config import SensorConfig, SensorSettings

LARGEST_WHITE_BALANCE, LARGEST_SHUTTER, LARGEST_GAIN = 1023, 707, 683
LONGEST_EXPOSURE_S = 20.85e-3
"""At the largest shutter number."""
_NEUTRAL_WHITE_BALANCE, _WHITE_BALANCE_A_FACTOR_OF_2 = 512, 256
_LARGEST_GAIN_DB = 24.0

STEREO_SENSOR = SensorConfig(
    white_balance="auto",
    longest_exposure_s=LONGEST_EXPOSURE_S,
    largest_gain=10 ** (_LARGEST_GAIN_DB / 20),
    adaptation=0.2,
    veiling_glare=0.03,
    electrons_per_nit_s=2500.0,
    full_well_e=13_000.0,
    read_noise_e=14.0,
)
"""A small CCD behind a fast lens: on a white wall the shutter is at its longest from some 200 lx downwards."""


@dataclass(frozen=True, slots=True)
class Registers:
    """Settings as the camera reports them.

    Attributes:
        red, blue: 0 to 1023, gains of these channels: 512 is 1, 256 more a factor of 2.
        shutter: 0 to 707, in proportion to the exposure time, at most 20.85 ms.
        gain: 0 to 683, in proportion to decibels, at most 24 dB.
    """

    red: int
    blue: int
    shutter: int
    gain: int


def registers(settings: SensorSettings) -> Registers:
    """Return what the camera reports of its settings.

    The paper gives the ranges and the longest exposure alone; which gain belongs to which number is a choice: even
    steps of a factor for gains, as in machine-vision cameras, and of time for the shutter.
    """
    return Registers(
        _white_balance(settings.red_gain),
        _white_balance(settings.blue_gain),
        _whole(LARGEST_SHUTTER * settings.exposure_s / LONGEST_EXPOSURE_S, LARGEST_SHUTTER),
        _whole(LARGEST_GAIN * 20 * np.log10(settings.gain) / _LARGEST_GAIN_DB, LARGEST_GAIN),
    )


def _white_balance(gain: float) -> int:
    return _whole(_NEUTRAL_WHITE_BALANCE + _WHITE_BALANCE_A_FACTOR_OF_2 * np.log2(gain), LARGEST_WHITE_BALANCE)


def _whole(value: float, largest: int) -> int:
    return min(max(round(float(value)), 0), largest)
