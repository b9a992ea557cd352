"""Stages before the robot's stereo camera, both pictures of which are taken with the left one's settings."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.objects import Objects
from scenarios.scenario import Setup
from scenarios.stage import SceneCamera, Stage
from scenarios.stereo_follow.camera import SENSOR, camera, draw_mount, registers
from scenarios.stereo_follow.light_events import LightEvents
from scenarios.stereo_follow.odometry import Odometry
from sim.render.pipeline import Capture, Shader, capture
from sim.sensors.camera_sensor import CameraSensor
from sim.sensors.config import SensorSettings
from sim.sensors.exposure import metered_radiance
from sim.world import World
from trackers.types import CameraSettings, EgoPose, Observation


class StereoCamera(SceneCamera):
    """Two cameras with their sensors; the seed determines the mount. The left picture is the watched one.

    Attributes:
        right: the latest right picture. T_world_right: (4, 4), the right camera's true pose then.
        right_is_lost: whether observations are without the right picture.
    """

    right_is_lost = False

    _sensor: CameraSensor
    right: Capture[Any]
    T_world_right: NDArray[np.float64]

    def __init__(self, setup: Setup, world: World) -> None:
        preset = setup.preset
        model = camera(preset.width_px, preset.height_px)
        super().__init__(setup, world, model, CameraSensor(SENSOR, setup.rng("sensor")))
        self._right_sensor = CameraSensor(SENSOR, setup.rng("right sensor"))
        self._mount = draw_mount(setup.rng("mount"))

    def take(self, shader: Shader, T_world_camera: NDArray[np.float64], frame: int, **exposing: Any) -> Capture[Any]:
        """Take both pictures of the current world; the left sensor's loops take one step. Return the left one."""
        left = super().take(shader, T_world_camera, frame, **exposing)
        used = left.picture.settings
        settings = SensorSettings(used.exposure_s, used.gain * self._mount.gain, used.red_gain, used.blue_gain)
        self.T_world_right = T_world_camera @ self._mount.T_left_right
        self.right = capture(
            self._renderer, shader, self._right_sensor, self.model, self.T_world_right, frame, settings=settings
        )
        return left

    def observation(self, picture: Any, time_s: float, ego: EgoPose | None = None, **others: Any) -> Observation:
        """See ``SceneCamera``; with the right picture."""
        used = picture.settings
        settings = CameraSettings(used.exposure_s, used.gain, registers(used))
        right_rgb = None if self.right_is_lost else self.right.picture.image_rgb
        return super().observation(picture, time_s, ego, settings=settings, right_rgb=right_rgb, **others)

    def settle(self, shader: Shader, T_world_left: NDArray[np.float64], steps: int) -> None:
        """Let the left sensor's loops take some steps in the current light, without a picture."""
        gbuffer = self._renderer.gbuffer(self.model, T_world_left)
        metered = metered_radiance(shader.shade(gbuffer, self.model, T_world_left))
        for _ in range(steps):
            self._sensor.step(metered)

    def hold(self, *, exposure: bool, white_balance: bool) -> None:
        """Hold exposure or white balance from now on, see ``CameraSensor.hold``."""
        self._sensor.hold(exposure=exposure, white_balance=white_balance)


class StereoStage(Stage):
    """A stage before the robot's stereo camera.

    Attributes:
        _robot_place: place (2,) and heading of the robot now, for odometry; set by ``_move_to``.
    """

    _camera: StereoCamera
    _robot_place: tuple[NDArray[np.float64], float]

    def __init__(self, setup: Setup, objects: Objects, events: LightEvents, *, has_odometry: bool = True) -> None:
        self._events = events
        self._odometry = Odometry(setup.rng("odometry")) if has_odometry else None
        super().__init__(setup, objects, StereoCamera(setup, objects.world))

    def _ego(self) -> EgoPose | None:
        return None if self._odometry is None else EgoPose(self._odometry.measure(*self._robot_place))

    def _pair_truth(self, capture: Capture[Any], place: str, illuminance_lx: NDArray[np.float64]) -> dict[str, Any]:
        """Return the fields of ``StereoTruth``, by name; arguments as there."""
        right = self._camera.right
        self._objects.merge(right.instance_id)
        return {
            "T_world_right": self._camera.T_world_right,
            "right_instance_map": right.instance_id,
            "right_depth_m": right.depth_m,
            "illuminance_lx": illuminance_lx,
            "place": place,
            "light_event": self._events.follow(self._frame, capture.picture, float(illuminance_lx[self._target])),
            "registers": registers(capture.picture.settings),
        }
