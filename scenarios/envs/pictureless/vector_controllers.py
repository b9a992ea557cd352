"""Controllers of many pictureless envs at a time, whose commands an action corrects."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from scenarios.envs.settings import FollowSettings
from scenarios.scenario import PicturelessWorld
from trackers.controllers.catalogue import Kernel, controller_entry
from trackers.protocols import Controller
from trackers.types import BODY_COMMANDS, CameraModel, Carrier, EgoPose, Estimate, Observation


class VectorController(Protocol):
    """Gives the commands of B envs."""

    def begin(self, which: NDArray[np.int64]) -> None:
        """Note that episodes begin in the envs ``which`` (K,)."""
        ...

    def command(self, states: NDArray[np.void], beliefs: NDArray[np.void], out: NDArray[np.float64]) -> None:
        """Write commands (B, 4): forward, right, climb, yaw rate."""
        ...


class VectorKernelController:
    """A controller with a kernel over beliefs."""

    def __init__(self, parameters: Any, kernel: Kernel, interval_s: float, count: int) -> None:
        self._parameters = kernel.record(parameters)
        self._memory = np.zeros(count, kernel.memory)
        self._steer, self._interval_s = kernel.steer, interval_s

    def begin(self, which: NDArray[np.int64]) -> None:
        """See ``VectorController``."""
        self._memory[which] = np.zeros(1, self._memory.dtype)

    def command(self, states: NDArray[np.void], beliefs: NDArray[np.void], out: NDArray[np.float64]) -> None:
        """See ``VectorController``."""
        self._steer(beliefs, self._parameters, self._memory, states["steps"] * self._interval_s, out)


class SeparateControllers:
    """Any other controller: one object per env, called one after another, which is slow.

    It gets posteriors as Gaussians, which is less than the particles of the rendered env.
    """

    def __init__(self, create: Callable[[], Controller], carrier: Carrier, world: PicturelessWorld, count: int) -> None:
        self._create, self._world, self._down = create, world, carrier.looks == "down"
        self._controllers = [create() for _ in range(count)]
        self._picture = np.zeros((*(2 * world.camera[:0:-1]).astype(int), 3), np.uint8)

    def begin(self, which: NDArray[np.int64]) -> None:
        """See ``VectorController``."""
        for k in which:
            self._controllers[k] = self._create()

    def command(self, states: NDArray[np.void], beliefs: NDArray[np.void], out: NDArray[np.float64]) -> None:
        """See ``VectorController``."""
        for k, controller in enumerate(self._controllers):
            given = controller.command(self.observation(states[k]), self.estimate(states[k]))
            out[k] = [getattr(given, name) for name in BODY_COMMANDS]

    def observation(self, state: Any) -> Observation:
        """Return what a controller is given of an env's state: time, camera and measured pose; the picture is black."""
        focal_px, half_width_px, half_height_px = self._world.camera
        T_world_camera = np.eye(4)
        T_world_camera[:3, :3], T_world_camera[:3, 3] = state["R_measured"], state["camera_measured_m"]
        camera = CameraModel(round(2 * half_width_px), round(2 * half_height_px), float(focal_px))
        time_s = float(state["steps"] * self._world.interval_s)
        return Observation(self._picture, time_s, camera, ego=EgoPose(T_world_camera))

    def estimate(self, state: Any) -> Estimate:
        """Return the tracker's answer in an env's state."""
        if state["known"] == 0.0:
            return Estimate(np.full(2, np.nan), in_view_probability=0.0)
        place_px = state["estimate_px"].copy()
        half_px = float(state["length_share"] * self._world.camera[1])
        spread_px = float(state["spread_m"]) * self._world.camera[0] / float(state["depth_m"])
        return Estimate(
            place_px,
            box_xyxy=np.concatenate([place_px - half_px, place_px + half_px]),
            in_view_probability=float(state["probability"]),
            covariance_px=np.eye(2) * spread_px**2 if self._down else None,
            depth_m=None if self._down else float(state["depth_m"]),
        )


def vector_controller(
    settings: FollowSettings, carrier: Carrier, world: PicturelessWorld, count: int
) -> VectorController:
    """Return the settings' controller for ``count`` envs. Raises ValueError for an unknown name or value."""
    entry, values = controller_entry(settings.controller, carrier.name), settings.controller_values
    if entry.kernel is not None:
        return VectorKernelController(entry.parameters(**values), entry.kernel, world.interval_s, count)
    return SeparateControllers(lambda: entry.create(**values), carrier, world, count)
