"""The camera on the robot: a stereo camera like the Bumblebee2, which reports its settings with every picture.

It reports integers in the ranges of paper B, Table 1. The paper gives only the ranges and the longest exposure. The
mapping is our choice: gains are logarithmic, as in machine-vision cameras, and the shutter is linear in time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from sim.optics import look_down_pose
from sim.sensors.config import SensorConfig, SensorSettings
from trackers.types import CameraModel, CameraRegisters

CAMERA_HEIGHT_M = 1.2
BASELINE_M = 0.12
"""Distance from the left camera to the right one."""
_MISALIGNED_RAD = np.deg2rad(0.03)
_GAIN_DIFFERENCE = 0.015
HALF_VIEW_RAD = float(np.deg2rad(33.0))
"""Half of the horizontal field of view."""
LONGEST_EXPOSURE_S = 20.85e-3
"""Exposure time at the largest shutter number."""
_LARGEST_WHITE_BALANCE, _LARGEST_SHUTTER, _LARGEST_GAIN = 1023, 707, 683
_NEUTRAL_WHITE_BALANCE = 512
_LARGEST_COLOUR_GAIN, _LARGEST_GAIN_DB = 4.0, 24.0

SENSOR = SensorConfig(
    white_balance="auto",
    longest_exposure_s=LONGEST_EXPOSURE_S,
    largest_gain=10 ** (_LARGEST_GAIN_DB / 20),
    largest_colour_gain=_LARGEST_COLOUR_GAIN,
    adaptation=0.2,
    veiling_glare=0.03,
    electrons_per_nit_s=1500.0,
    full_well_e=13_000.0,
    read_noise_e=14.0,
)
"""A small CCD behind a fast lens: on a white wall the exposure is at its longest below about 200 lx."""


def camera(width_px: int, height_px: int) -> CameraModel:
    """Return the stereo camera, with a horizontal field of view of 66 degrees, for a picture size."""
    return CameraModel.from_field_of_view(width_px, height_px, 2.0 * HALF_VIEW_RAD, baseline_m=BASELINE_M)


def registers(settings: SensorSettings) -> CameraRegisters:
    """Return settings as the camera reports them.

    ``red`` and ``blue`` are 512 at a gain of 1, 0 at 1/4 and 1023 at 4; ``shutter`` is proportional to the exposure
    time, ``gain`` to the gain in decibels, at most 24.
    """
    return CameraRegisters(
        _white_balance(settings.red_gain),
        _white_balance(settings.blue_gain),
        _whole(_LARGEST_SHUTTER * settings.exposure_s / LONGEST_EXPOSURE_S, _LARGEST_SHUTTER),
        _whole(_LARGEST_GAIN * 20 * np.log10(settings.gain) / _LARGEST_GAIN_DB, _LARGEST_GAIN),
    )


def _white_balance(gain: float) -> int:
    share = np.log2(gain) / np.log2(_LARGEST_COLOUR_GAIN)
    return _whole(_NEUTRAL_WHITE_BALANCE * (1 + share), _LARGEST_WHITE_BALANCE)


def _whole(value: float, largest: int) -> int:
    return min(max(round(float(value)), 0), largest)


def camera_pose(
    place_m: NDArray[np.float64], heading_rad: float, nod_rad: float = 0.0, roll_rad: float = 0.0
) -> NDArray[np.float64]:
    """Return T_world_camera (4, 4) of the camera on a robot at a place (2,), looking along its heading.

    It is level, except for the small angles ``nod_rad`` (nose up) and ``roll_rad`` (right side down).
    """
    return look_down_pose(np.append(place_m, CAMERA_HEIGHT_M), heading_rad, 0.5 * np.pi + nod_rad, roll_rad)


@dataclass(frozen=True, slots=True)
class StereoMount:
    """The right camera's pose and gain relative to the left one, with the remaining errors of calibration.

    Attributes:
        T_left_right: (4, 4), camera frames.
        gain: of its sensor over that of the left one at the same settings.
    """

    T_left_right: NDArray[np.float64]
    gain: float


def draw_mount(rng: np.random.Generator) -> StereoMount:
    """Draw a mount: turned about each axis by hundredths of a degree (a quarter of a pixel), gain off by about 1 %."""
    T_left_right = np.eye(4)
    T_left_right[:3, :3] = Rotation.from_rotvec(rng.normal(0.0, _MISALIGNED_RAD, 3)).as_matrix()
    T_left_right[0, 3] = BASELINE_M
    return StereoMount(T_left_right, float(np.exp(rng.normal(0.0, _GAIN_DIFFERENCE))))
