"""The camera's sensor, from radiance to the picture and its settings."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.optics import CameraMotion, PinholeCamera
from sim.render.compilation import announce_compilation
from sim.render.row_stages import RowStage
from sim.sensors.automatic import (
    METER_STEP_PX,
    channel_gains,
    luminance_of,
    metered_radiance,
    next_exposure,
    next_gains,
    right_exposure,
    right_gains,
)
from sim.sensors.config import Picture, SensorConfig, SensorSettings
from sim.sensors.motion_blur import blur_by_motion, needs_blur
from sim.sensors.noise import Development, develop_row, develop_rows, frame_keys, new_develop_scratch, response, veil


class CameraSensor:
    """A sensor with loops of exposure and white balance, both settled at the first picture.

    A ``RowSensor``, see ``sim.render.pipeline``.
    """

    developing = RowStage(develop_row, new_develop_scratch)
    metered_row_step = METER_STEP_PX

    def __init__(self, config: SensorConfig, rng: np.random.Generator) -> None:
        """Draw the key of all noise to come from ``rng``."""
        self.config = config
        self._key = int(rng.integers(1 << 63))
        self._settings: SensorSettings | None = None
        self._film = np.empty((0, 3, 0), np.float32)
        self._exposure_held = self._white_balance_held = False

    def hold(self, *, exposure: bool, white_balance: bool) -> None:
        """Hold exposure (time and gain) or white balance from now on, or let them follow the light again."""
        self._exposure_held, self._white_balance_held = exposure, white_balance

    def expose(
        self, radiance: NDArray[np.float32], camera: PinholeCamera, frame: int, motion: CameraMotion | None = None
    ) -> Picture:
        """Take the picture of a frame from its radiance (H, 3, W) in cd/m², see ``Sensor``."""
        metered = metered_radiance(radiance)
        settings = self.settings_for(metered)
        picture = self.develop(radiance, camera, frame, settings, motion)
        self.step(metered)
        return picture

    @property
    def settings(self) -> SensorSettings | None:
        """Settings of the next picture; None before the first."""
        return self._settings

    def settings_for(self, metered: NDArray[np.float64]) -> SensorSettings:
        """Return the settings of the next picture; its mean radiance (3,) determines those of the first."""
        if self._settings is None:
            gains = right_gains(self.config, metered)
            exposure = right_exposure(self.config, channel_gains(*gains)[1] * luminance_of(metered))
            self._settings = SensorSettings(*exposure, *gains)
        return self._settings

    def step(self, metered: NDArray[np.float64]) -> None:
        """Advance the loops by one step, with a picture of this mean radiance (3,)."""
        now = self.settings_for(metered)
        exposure, gains = (now.exposure_s, now.gain), (now.red_gain, now.blue_gain)
        if not self._exposure_held:
            exposure = next_exposure(self.config, *exposure, channel_gains(*gains)[1] * luminance_of(metered))
        if not self._white_balance_held:
            gains = next_gains(self.config, *gains, metered)
        self._settings = SensorSettings(*exposure, *gains)

    def develop(
        self,
        radiance: NDArray[np.float32],
        camera: PinholeCamera,
        frame: int,
        settings: SensorSettings,
        motion: CameraMotion | None = None,
    ) -> Picture:
        """Take a picture with given settings; the loops stay as they are. Arguments as for ``expose``."""
        if motion is not None:
            radiance = blur_by_motion(radiance, motion.homography, settings.exposure_s / motion.interval_s)
        rows = np.arange(len(radiance))
        return self._develop_rows(radiance, rows, len(rows), metered_radiance(radiance), settings, frame)[0]

    def needs_whole(self, camera: PinholeCamera, settings: SensorSettings | None, motion: CameraMotion | None) -> bool:
        """Return whether it is the first picture, or motion brings light from one pixel to others."""
        settings = self._settings if settings is None else settings
        if settings is None:
            return True
        if motion is None:
            return False
        share = settings.exposure_s / motion.interval_s
        return needs_blur(camera.width_px, camera.height_px, motion.homography, share)

    def develop_first(
        self,
        radiance: NDArray[np.float32],
        rows: NDArray[np.int64],
        camera: PinholeCamera,
        frame: int,
        settings: SensorSettings | None,
    ) -> tuple[Picture, Development]:
        """Begin a picture by its metered rows, see ``RowSensor``."""
        metered = metered_radiance(radiance, row_step=1)
        used = self.settings_for(metered) if settings is None else settings
        begun = self._develop_rows(radiance, rows, camera.height_px, metered, used, frame)
        if settings is None:
            self.step(metered)
        return begun

    def _develop_rows(
        self,
        radiance: NDArray[np.float32],
        rows: NDArray[np.int64],
        height: int,
        metered: NDArray[np.float64],
        settings: SensorSettings,
        frame: int,
    ) -> tuple[Picture, Development]:
        """Return a picture with these rows developed, and the input for the others; its mean radiance is (3,)."""
        share, image_rgb = self.config.veiling_glare, np.empty((height, radiance.shape[2], 3), np.uint8)
        answer, keys = response(self.config, settings), frame_keys(self._key, frame)
        development = Development(np.float32(share), veil(metered, share), answer, keys, image_rgb)
        announce_compilation(develop_rows)
        develop_rows(radiance, rows, development)
        return Picture(image_rgb, settings), development

    def film(self, rows: int, width: int) -> NDArray[np.float32]:
        """Return scratch for a radiance (rows, 3, width), allocated once: fresh memory costs a millisecond."""
        if self._film.shape != (rows, 3, width):
            self._film = np.empty((rows, 3, width), np.float32)
        return self._film
