"""Robots in buildings, without pictures."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.command_link import LinkLimits
from scenarios.envs.pictureless.poses import camera_numbers
from scenarios.stereo_follow.camera import camera
from scenarios.stereo_follow.pictureless.drive_kernel import DRIVE_LIFE
from scenarios.stereo_follow.pictureless.stereo_kernel import begin_drives, drive_on
from scenarios.stereo_follow.presets import StereoFollow

_ARRAYS = ("target_m", "target_rad", "size_m", "others_m", "free_m", "openings_m", "path_m", "yaw_rad", "onsets")


class StereoWorld:
    """See ``scenarios.scenario.World``."""

    life = DRIVE_LIFE

    def __init__(
        self, preset: StereoFollow, arrays: dict[str, NDArray[np.float64]], link: LinkLimits, errors: NDArray[np.void]
    ) -> None:
        self.interval_s = 1.0 / preset.rate_hz
        self.camera = camera_numbers(camera(preset.width_px, preset.height_px))
        bank = tuple(arrays[name] for name in _ARRAYS)
        self._fixed = (bank, errors, self.camera, self.interval_s)
        self._link = link

    def begin(self, lives: Any, which: Any, episodes: Any, at_frame_outs: bool, sightings: Any, rng: Any) -> None:
        """See ``World``."""
        begin_drives(lives, which, episodes, at_frame_outs, *self._fixed, sightings, rng)

    def move(self, lives: Any, wanted: Any, waiting: Any, sightings: Any, rng: Any) -> None:
        """See ``World``."""
        link = self._link
        drive_on(lives, wanted, link.limits, link.steps, waiting, link.noise, *self._fixed, sightings, rng)
