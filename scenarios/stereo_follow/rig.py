"""The pair of cameras on the robot; both take their pictures with the left camera's settings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenarios.camera_rig import SingleCamera
from scenarios.scenario import RendererName
from scenarios.stereo_follow.camera import SENSOR, camera_model, draw_mount, registers
from sim.optics import PinholeCamera
from sim.render.pipeline import Capture, Shader, capture
from sim.rng import generator
from sim.sensors.automatic import metered_radiance
from sim.sensors.camera_sensor import CameraSensor
from sim.sensors.config import SensorSettings
from sim.world import World
from trackers.types import CameraSettings, EgoPose, Observation


@dataclass(frozen=True, slots=True)
class StereoPair:
    """Both pictures of an instant, and the right camera's true pose, T_world_right (4, 4)."""

    left: Capture
    right: Capture
    T_world_right: NDArray[np.float64]


class StereoRig(SingleCamera):
    """Two cameras with their sensors; the seed determines the mount. The left picture is the watched one.

    Attributes:
        camera: the model of both.
    """

    _sensor: CameraSensor

    def __init__(self, world: World, camera: PinholeCamera, renderer: RendererName, seed: int) -> None:
        self._left_sensor = CameraSensor(SENSOR, generator(seed, "sensor"))
        super().__init__(world, camera, renderer, self._left_sensor)
        self._right_sensor = CameraSensor(SENSOR, generator(seed, "right sensor"))
        self._mount = draw_mount(generator(seed, "mount"))

    def take_pair(self, shader: Shader, T_world_left: NDArray[np.float64], frame: int) -> StereoPair:
        """Take both pictures of the current world; the left sensor's loops take one step.

        Args:
            frame: index, >= 0; it determines the noise.
        """
        left = self.take(shader, T_world_left, frame)
        used = left.picture.settings
        settings = SensorSettings(used.exposure_s, used.gain * self._mount.gain, used.red_gain, used.blue_gain)
        T_world_right = T_world_left @ self._mount.T_left_right
        right = capture(
            self._renderer, shader, self._right_sensor, self.camera, T_world_right, frame, settings=settings
        )
        return StereoPair(left, right, T_world_right)

    def observation(self, pair: StereoPair, time_s: float, ego: EgoPose | None, *, is_lost: bool) -> Observation:
        """Return a pair as an observation; without its right picture if that is lost."""
        used = pair.left.picture.settings
        return Observation(
            image_rgb=pair.left.picture.image_rgb,
            time_s=time_s,
            camera=camera_model(self.camera),
            settings=CameraSettings(used.exposure_s, used.gain, registers(used)),
            ego=ego,
            right_rgb=None if is_lost else pair.right.picture.image_rgb,
        )

    def settle(self, shader: Shader, T_world_left: NDArray[np.float64], steps: int) -> None:
        """Let the left sensor's loops take some steps in the current light, without a picture."""
        gbuffer = self._renderer.gbuffer(self.camera, T_world_left)
        metered = metered_radiance(shader.shade(gbuffer, self.camera, T_world_left))
        for _ in range(steps):
            self._left_sensor.step(metered)

    def hold(self, *, exposure: bool, white_balance: bool) -> None:
        """Hold exposure or white balance from now on, see ``CameraSensor.hold``."""
        self._left_sensor.hold(exposure=exposure, white_balance=white_balance)
