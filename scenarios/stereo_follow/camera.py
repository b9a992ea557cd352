"""The camera on the robot."""

from __future__ import annotations

import numpy as np

from sim.optics import PinholeCamera
from sim.sensors.config import SensorSettings
from sim.sensors.registers import registers
from trackers.types import CameraRegisters

CAMERA_HEIGHT_M = 1.2


def camera(width_px: int, height_px: int) -> PinholeCamera:
    """Return the camera with a lens of 66 degrees, at a size of its picture."""
    return PinholeCamera.from_field_of_view(width_px, height_px, float(np.deg2rad(66.0)))


def reported(settings: SensorSettings) -> CameraRegisters:
    """Return settings as a tracker is told them."""
    known = registers(settings)
    return CameraRegisters(known.red, known.blue, known.shutter, known.gain)
