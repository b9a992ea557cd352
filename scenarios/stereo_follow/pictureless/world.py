"""Robots in buildings, without pictures."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenarios.command_link import LinkLimits
from scenarios.envs.pictureless.kernel_world import KernelWorld
from scenarios.envs.pictureless.poses import camera_numbers
from scenarios.stereo_follow.camera import camera
from scenarios.stereo_follow.pictureless.drive_kernel import DRIVE_STATE
from scenarios.stereo_follow.pictureless.stereo_kernel import Drives, begin_drives, drive_on
from scenarios.stereo_follow.presets import StereoFollow


class StereoWorld(KernelWorld):
    """See ``KernelWorld``."""

    state_dtype = DRIVE_STATE
    begin_kernel, move_kernel = staticmethod(begin_drives), staticmethod(drive_on)

    def __init__(
        self, preset: StereoFollow, arrays: dict[str, NDArray[np.float64]], link: LinkLimits, errors: NDArray[np.void]
    ) -> None:
        numbers = camera_numbers(camera(preset.width_px, preset.height_px))
        super().__init__(Drives(**arrays, errors=errors, camera=numbers, interval_s=1.0 / preset.rate_hz), link)
