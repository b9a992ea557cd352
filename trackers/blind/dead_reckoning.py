"""Dead reckoning of a target seen from above: its state at the exit, and how the camera has moved and turned since."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.protocols import TargetState
from trackers.registry import NoParameters, register, tunable
from trackers.types import CameraModel, Estimate, Observation

_NO_INSTRUMENTS = np.diag([1.0, -1.0, -1.0, 1.0])
"""Pose of a camera that looks straight down, assumed where no pose is measured."""
_NEAREST_M = 0.05
"""Least depth of a projected point; points nearer to the camera's plane or behind it count as at this depth."""


@dataclass(frozen=True)
class CarriedParameters:
    """Settings of ``blind_carried``; the variants below change the defaults.

    Attributes:
        with_camera: share of the camera's displacement that is added to the target's position.
        drives_on: share of its velocity at the exit that the target keeps.
        turns: share of the camera's turn by which that velocity turns.
    """

    with_camera: float = 1.0
    drives_on: float = 0.0
    turns: float = 0.0


@dataclass(frozen=True)
class StraightParameters(CarriedParameters):
    """Settings of ``blind_straight``, see ``CarriedParameters``."""

    with_camera: float = 0.0
    drives_on: float = 1.0
    turns: float = 0.0


@dataclass(frozen=True)
class TurningParameters(CarriedParameters):
    """Settings of ``blind_turning``, see ``CarriedParameters``."""

    with_camera: float = 0.0
    drives_on: float = 1.0
    turns: float = 1.0


@register("blind_carried", role="blind", summary="the position at the exit, moved by the camera's displacement")
class Carried:
    """Moves the target's position p over the ground, without pictures.

    ``p' = p + with_camera (c' - c) + drives_on dt R(turns a') v``, with the velocity v at the exit, the camera's
    position c and its turn a since the exit. The estimate is NaN until ``set_state`` is called.
    """

    Parameters = CarriedParameters

    def __init__(self, parameters: CarriedParameters, rng: np.random.Generator) -> None:
        self._parameters = parameters
        self._place_m: NDArray[np.float64] | None = None

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """See ``Tracker``. The box is not used: ``set_state`` gives the state."""

    def set_state(self, observation: Observation, state: TargetState) -> None:
        """See ``BlindTracker``."""
        pose = _pose_of(observation)
        self._place_m = pose[:3, :3] @ state.place_m + pose[:3, 3]
        self._velocity_mps = pose[:3, :3] @ state.velocity_mps
        self._exit_pose, self._pose, self._time_s = pose, pose, observation.time_s

    def update(self, observation: Observation) -> Estimate:
        """See ``Tracker``."""
        if self._place_m is None:
            return Estimate(np.full(2, np.nan))
        p, pose = self._parameters, _pose_of(observation)
        turn = p.turns * _turn_rad(self._exit_pose, pose)
        R = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        driven_m = p.drives_on * (observation.time_s - self._time_s) * R @ self._velocity_mps[:2]
        carried_m = p.with_camera * (pose[:2, 3] - self._pose[:2, 3])
        self._place_m = self._place_m + np.append(carried_m + driven_m, 0.0)
        self._pose, self._time_s = pose, observation.time_s
        return Estimate(_pixel_of(self._place_m, pose, observation.camera))


@register("blind_straight", role="blind", summary="constant velocity from the exit on, the true one there")
class Straight(Carried):
    """See ``Carried``."""

    Parameters = StraightParameters


@register("blind_turning", role="blind", summary="constant speed from the exit on, turning as the camera turns")
class Turning(Carried):
    """See ``Carried``."""

    Parameters = TurningParameters


@register("blind_below", role="blind", summary="the point straight below the camera")
class Below:
    """Returns the pixel straight below the camera."""

    Parameters = NoParameters

    def __init__(self, parameters: NoParameters, rng: np.random.Generator) -> None:
        pass

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """See ``Tracker``."""

    def set_state(self, observation: Observation, state: TargetState) -> None:
        """See ``BlindTracker``."""

    def update(self, observation: Observation) -> Estimate:
        """See ``Tracker``."""
        pose = _pose_of(observation)
        # All points of the plumb line project to the same pixel.
        return Estimate(_pixel_of(pose[:3, 3] - np.array([0.0, 0.0, 1.0]), pose, observation.camera))


def _pose_of(observation: Observation) -> NDArray[np.float64]:
    return _NO_INSTRUMENTS if observation.ego is None else observation.ego.T_world_camera


def _turn_rad(before: NDArray[np.float64], after: NDArray[np.float64]) -> float:
    """Return the turn about the vertical nearest to the rotation from one pose (4, 4) to the other."""
    R = after[:3, :3] @ before[:3, :3].T
    return float(np.arctan2(R[1, 0] - R[0, 1], R[0, 0] + R[1, 1]))


def _pixel_of(point_m: NDArray[np.float64], pose: NDArray[np.float64], camera: CameraModel) -> NDArray[np.float64]:
    in_camera_m = (point_m - pose[:3, 3]) @ pose[:3, :3]
    middle_px = 0.5 * np.array([camera.width_px, camera.height_px])
    return middle_px + camera.focal_px * in_camera_m[:2] / max(in_camera_m[2], _NEAREST_M)


@dataclass(frozen=True)
class AheadParameters:
    """Setting of ``blind_ahead``.

    Attributes:
        ahead_m: distance of the target along the camera's axis.
    """

    ahead_m: float = tunable(2.0, 1.0, 6.0)


@register(
    "blind_ahead", role="blind", summary="always the same distance straight ahead of the camera", suites=("stereo",)
)
class StraightAhead:
    """Returns the same position and distance on every frame."""

    Parameters = AheadParameters

    def __init__(self, parameters: AheadParameters, rng: np.random.Generator) -> None:
        self._ahead_m = parameters.ahead_m

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """See ``Tracker``."""

    def set_state(self, observation: Observation, state: TargetState) -> None:
        """See ``BlindTracker``."""

    def update(self, observation: Observation) -> Estimate:
        """See ``Tracker``."""
        camera = observation.camera
        return Estimate(0.5 * np.array([camera.width_px, camera.height_px]), depth_m=self._ahead_m)
