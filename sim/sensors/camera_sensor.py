"""The camera's sensor: radiance in, picture and the settings in use out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.optics import PinholeCamera
from sim.render.compilation import announce_compilation
from sim.sensors.config import Picture, SensorConfig, SensorSettings
from sim.sensors.exposure import luminance_of, metered_radiance, next_exposure, right_exposure
from sim.sensors.lens import distort, veil
from sim.sensors.motion_blur import blur_by_motion
from sim.sensors.noise import Development, develop_rows, frame_keys, response
from sim.sensors.white_balance import channel_gains, next_gains, right_gains


class CameraSensor:
    """A sensor with its loops of exposure and white balance. Before the first picture it has been on for a while: both
    are right.
    """

    def __init__(self, config: SensorConfig, rng: np.random.Generator) -> None:
        """Draw the key of all noise to come from ``rng``."""
        self.config = config
        self._key = int(rng.integers(1 << 63))
        self._settings: SensorSettings | None = None
        self._film = np.empty((0, 3, 0), np.float32)
        self._exposure_held = self._white_balance_held = False

    def hold(self, *, exposure: bool, white_balance: bool) -> None:
        """Let exposure (time and gain) or white balance stay as they are from now on, or follow the light again."""
        self._exposure_held, self._white_balance_held = exposure, white_balance

    def expose(
        self,
        radiance: NDArray[np.float32],
        camera: PinholeCamera,
        frame: int,
        *,
        motion: NDArray[np.float64] | None = None,
        interval_s: float = 1.0,
    ) -> Picture:
        """Take the picture of a frame, then let the loops take one step.

        Args:
            radiance: (H, 3, W) float32, cd/m².
            camera: its lens distorts the picture.
            frame: index, >= 0; with the pixel it determines the noise.
            motion: homography (3, 3) from this picture's pixels to the next one's, or None for a camera at
                rest.
            interval_s: time between the two.
        """
        metered = metered_radiance(radiance)
        settings = self.settings_for(metered)
        picture = self.develop(radiance, camera, frame, settings, motion=motion, interval_s=interval_s)
        self.step(metered)
        return picture

    @property
    def settings(self) -> SensorSettings | None:
        """Settings of the picture now to be taken; None before the first."""
        return self._settings

    def settings_for(self, metered: NDArray[np.float64]) -> SensorSettings:
        """Return the settings of the picture now to be taken; its mean radiance (3,) matters only for the first."""
        if self._settings is None:
            gains = right_gains(self.config, metered)
            exposure = right_exposure(self.config, channel_gains(*gains)[1] * luminance_of(metered))
            self._settings = SensorSettings(*exposure, *gains)
        return self._settings

    def step(self, metered: NDArray[np.float64]) -> None:
        """Let the loops take one step from a picture of this mean radiance (3,)."""
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
        *,
        motion: NDArray[np.float64] | None = None,
        interval_s: float = 1.0,
    ) -> Picture:
        """Take a picture with given settings; changes nothing. Arguments as for ``expose``."""
        if motion is not None:
            radiance = blur_by_motion(radiance, motion, settings.exposure_s / interval_s)
        radiance = distort(radiance, camera)
        announce_compilation(develop_rows)
        image_rgb = np.empty((radiance.shape[0], radiance.shape[2], 3), np.uint8)
        development = self.development(metered_radiance(radiance), settings, frame, image_rgb)
        develop_rows(radiance, np.arange(radiance.shape[0]), development)
        return Picture(image_rgb, settings)

    def development(
        self, metered: NDArray[np.float64], settings: SensorSettings, frame: int, image_rgb: NDArray[np.uint8]
    ) -> Development:
        """Return what becomes of the radiance of a frame's picture (H, W, 3), of mean radiance ``metered`` (3,)."""
        share = self.config.veiling_glare
        return Development(
            np.float32(share),
            veil(metered, share),
            response(self.config, settings),
            frame_keys(self._key, frame),
            image_rgb,
        )

    def film(self, rows: int, width: int) -> NDArray[np.float32]:
        """Return room for a radiance (rows, 3, width): the same every time, as fresh memory costs a millisecond."""
        if self._film.shape != (rows, 3, width):
            self._film = np.empty((rows, 3, width), np.float32)
        return self._film
