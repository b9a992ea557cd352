"""What the robot carries: its stereo camera and its odometry; recent changes of the light before it."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scenarios.objects import SceneObjects
from scenarios.scenario import Setup
from scenarios.stage import SceneCamera, Stage
from scenarios.stereo_follow.camera import SENSOR, camera, camera_pose, draw_mount, registers
from scenarios.stereo_follow.lighting import NEW_S
from scenarios.stereo_follow.truth import LightEvent
from sim.render.pipeline import Capture, Shader, capture
from sim.sensors.automatic import metered_radiance
from sim.sensors.camera_sensor import CameraSensor
from sim.sensors.config import Picture, SensorSettings
from sim.shaders.colour import LUMINANCE_WEIGHTS, srgb_to_linear
from sim.world import World
from trackers.types import CameraSettings, EgoPose, Observation

_LINEAR = srgb_to_linear(np.arange(256) / 255.0)
_BACK_LIGHT = 3.0
"""Threshold of back light: mean luminance of the picture over that of a grey coat on the target's back."""
_COAT = 0.3
"""Reflectance of the grey coat."""
_SHADE = 0.4
"""Threshold of shade: share of the highest illuminance within the last second."""
_STEP_PX = 8


class LightEvents:
    """Detects new changes of the light; of several, the first of these counts.

    They are: a switched lamp; the target at a door, in the light of two places; the start of back light; shade, a fall
    of the light on the target below two fifths within a second. Each is new for a second.
    """

    def __init__(self, places: Sequence[str], switched: Sequence[LightEvent | None], rate_hz: float) -> None:
        """``places`` (F,) are the target's places; ``switched`` (F,) are the lamp events there, see ``LightPlan``."""
        self._places, self._switched = places, switched
        self._new_frames = int(NEW_S * rate_hz)
        self._illuminance_lx: deque[float] = deque(maxlen=self._new_frames)
        self._was_back_lit = False
        self._latest: LightEvent | None = None
        self._since = self._new_frames

    def follow(self, frame: int, picture: Picture, illuminance_lx: float) -> LightEvent | None:
        """Add a frame; return ``PeopleTruth.light_event``.

        Args:
            illuminance_lx: on the target, towards the camera.
        """
        is_back_lit = _luminance_nit(picture) > _BACK_LIGHT * _COAT * illuminance_lx / np.pi
        begins: LightEvent | None = None
        if frame > 0 and "door" in (self._places[frame], self._places[frame - 1]):
            begins = "doorway"
        elif is_back_lit and not self._was_back_lit and frame > 0:
            begins = "back light"
        elif self._illuminance_lx and illuminance_lx < _SHADE * max(self._illuminance_lx):
            begins = "shade"
        self._was_back_lit = bool(is_back_lit)
        self._illuminance_lx.append(illuminance_lx)
        self._since += 1
        switched = self._switched[frame]
        if switched is not None:
            # A lamp also causes other changes; they do not count as events, during it or after it.
            self._latest, self._since = None, self._new_frames
            self._illuminance_lx.clear()
            return switched
        if begins is not None and (begins != self._latest or self._since >= self._new_frames):
            self._latest, self._since = begins, 0
        return self._latest if self._since < self._new_frames else None


def _luminance_nit(picture: Picture) -> float:
    """Return the mean luminance of a picture; white pixels may be brighter."""
    # Luminances first: averaging three colours over both axes takes twice as long.
    level = float((_LINEAR[picture.image_rgb[::_STEP_PX, ::_STEP_PX]] @ LUMINANCE_WEIGHTS).mean())
    used = picture.settings
    return level * SENSOR.full_well_e / (SENSOR.electrons_per_nit_s * used.exposure_s * used.gain)


SCALE_ERROR, TURN_SCALE_ERROR = 0.01, 0.02
SLIP_M, TURN_SLIP_RAD = 0.002, np.deg2rad(0.08)
_STANDS = 1e-4
"""Metres and radians per frame: a robot that moves less than both does not slip."""


class Odometry:
    """Dead reckoning in the frame of the robot's start, x ahead.

    Scale errors of the wheels are constant over an episode, one for distances and one for turns. On every frame in
    which the robot moves, the wheels slip: 2 mm and 0.08 degrees, standard deviations.
    """

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        self._scales = np.array([1.0 + rng.normal(0.0, SCALE_ERROR), 1.0 + rng.normal(0.0, TURN_SCALE_ERROR)])
        self._believed = np.zeros(3)
        self._true: tuple[NDArray[np.float64], float] | None = None

    def measure(self, place_m: NDArray[np.float64], heading_rad: float) -> NDArray[np.float64]:
        """Add the robot's true pose and return the measured T_world_camera (4, 4), which is level."""
        if self._true is not None:
            before_m, before_rad = self._true
            # NumPy's product differs from a compiled sum in the last bit, so pictureless drives compute their own.
            step_m = float((place_m - before_m) @ (np.cos(before_rad), np.sin(before_rad)))
            add_up(self._believed, self._scales, step_m, float(heading_rad - before_rad), self._rng)
        self._true = (np.array(place_m), heading_rad)
        return camera_pose(self._believed[:2], float(self._believed[2]))


@njit(cache=True)
def add_up(
    believed: NDArray[np.float64],
    scales: NDArray[np.float64],
    step_m: float,
    turn_rad: float,
    rng: np.random.Generator,
) -> None:
    """Advance the believed place and heading (3,) by the wheels' measurement of a step ahead and a turn.

    Args:
        scales: (2,) measured over true distances, and measured over true turns.
    """
    slip_m, slip_rad = SLIP_M * rng.standard_normal(), TURN_SLIP_RAD * rng.standard_normal()
    moves = abs(step_m) > _STANDS or abs(turn_rad) > _STANDS
    step_m = scales[0] * step_m + (slip_m if moves else 0.0)
    turn_rad = scales[1] * turn_rad + (slip_rad if moves else 0.0)
    middle_rad = believed[2] + 0.5 * turn_rad
    believed[0] += step_m * np.cos(middle_rad)
    believed[1] += step_m * np.sin(middle_rad)
    believed[2] += turn_rad


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

    def __init__(self, setup: Setup, world: World, *, smooth: bool = False) -> None:
        """``smooth``: see ``SceneCamera``, of both pictures."""
        preset = setup.preset
        model = camera(preset.width_px, preset.height_px)
        super().__init__(setup, world, model, CameraSensor(SENSOR, setup.rng("sensor")), smooth=smooth)
        self._right_sensor = CameraSensor(SENSOR, setup.rng("right sensor"))
        self._mount = draw_mount(setup.rng("mount"))

    def take(self, shader: Shader, T_world_camera: NDArray[np.float64], frame: int, **exposing: Any) -> Capture[Any]:
        """Take both pictures of the current world; the left sensor's loops take one step. Return the left one."""
        left = super().take(shader, T_world_camera, frame, **exposing)
        used = left.picture.settings
        settings = SensorSettings(used.exposure_s, used.gain * self._mount.gain, used.red_gain, used.blue_gain)
        self.T_world_right = T_world_camera @ self._mount.T_left_right
        self.right = capture(
            self._renderer,
            shader,
            self._right_sensor,
            self.model,
            self.T_world_right,
            frame,
            settings=settings,
            smooth=self._smooth,
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

    def __init__(
        self,
        setup: Setup,
        objects: SceneObjects,
        events: LightEvents,
        *,
        has_odometry: bool = True,
        smooth: bool = False,
    ) -> None:
        self._events = events
        self._odometry = Odometry(setup.rng("odometry")) if has_odometry else None
        super().__init__(setup, objects, StereoCamera(setup, objects.world, smooth=smooth))

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
