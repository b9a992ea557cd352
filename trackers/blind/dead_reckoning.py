"""Where a target seen from above is, by its state at the exit and by how the camera has moved and turned since."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.blind.protocol import TargetState
from trackers.registry import register
from trackers.types import CameraModel, Estimate, Observation

_NO_INSTRUMENTS = np.diag([1.0, -1.0, -1.0, 1.0])
"""Pose of a camera that looks straight down: what is assumed of one that does not measure its pose."""
_NEAREST_M = 0.05
"""Points nearer to the camera's plane, or behind it, are projected as if they were so far before it."""


@dataclass(frozen=True)
class CarriedParameters:
    """Setting of ``blind_carried``; the others have other values.

    Attributes:
        with_camera: share of the camera's displacement that is added to the target's place.
        drives_on: share of the target's velocity at the exit that it keeps.
        turns: share of the camera's turn by which that velocity turns.
    """

    with_camera: float = 1.0
    drives_on: float = 0.0
    turns: float = 0.0


@dataclass(frozen=True)
class StraightParameters(CarriedParameters):
    """Setting of ``blind_straight``, see ``CarriedParameters``."""

    with_camera: float = 0.0
    drives_on: float = 1.0
    turns: float = 0.0


@dataclass(frozen=True)
class TurningParameters(CarriedParameters):
    """Setting of ``blind_turning``, see ``CarriedParameters``."""

    with_camera: float = 0.0
    drives_on: float = 1.0
    turns: float = 1.0


@register("blind_carried", role="blind", summary="the place at the exit, carried along with the camera's displacement")
class Carried:
    """Place p of the target, velocity v at the exit, camera's place c and its turn since the exit a, on the ground:

    ``p' = p + with_camera (c' - c) + drives_on dt R(turns a') v``. It says nothing until it is told its target's state.
    """

    Parameters = CarriedParameters

    def __init__(self, parameters: CarriedParameters, rng: np.random.Generator) -> None:
        self._parameters = parameters
        self._place_m: NDArray[np.float64] | None = None

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """See ``Tracker``. The box is not used: ``told`` says more."""

    def told(self, observation: Observation, state: TargetState) -> None:
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


@register("blind_straight", role="blind", summary="drives straight on from the exit with its true velocity there")
class Straight(Carried):
    """See ``Carried``."""

    Parameters = StraightParameters


@register("blind_turning", role="blind", summary="drives on from the exit, and turns as the camera turns")
class Turning(Carried):
    """See ``Carried``."""

    Parameters = TurningParameters


@dataclass(frozen=True)
class BelowParameters:
    """``blind_below`` has nothing to set."""


@register("blind_below", role="blind", summary="the place straight below the camera")
class Below:
    """The same answer whatever it is told."""

    Parameters = BelowParameters

    def __init__(self, parameters: BelowParameters, rng: np.random.Generator) -> None:
        pass

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """See ``Tracker``."""

    def told(self, observation: Observation, state: TargetState) -> None:
        """See ``BlindTracker``."""

    def update(self, observation: Observation) -> Estimate:
        """See ``Tracker``."""
        pose = _pose_of(observation)
        # Every point of the plumb line is seen at the same pixel.
        return Estimate(_pixel_of(pose[:3, 3] - np.array([0.0, 0.0, 1.0]), pose, observation.camera))


def _pose_of(observation: Observation) -> NDArray[np.float64]:
    return _NO_INSTRUMENTS if observation.ego is None else observation.ego.T_world_camera


def _turn_rad(before: NDArray[np.float64], after: NDArray[np.float64]) -> float:
    """Return the turn about the vertical that comes nearest to the rotation from one pose (4, 4) to the other."""
    R = after[:3, :3] @ before[:3, :3].T
    return float(np.arctan2(R[1, 0] - R[0, 1], R[0, 0] + R[1, 1]))


def _pixel_of(point_m: NDArray[np.float64], pose: NDArray[np.float64], camera: CameraModel) -> NDArray[np.float64]:
    in_camera_m = (point_m - pose[:3, 3]) @ pose[:3, :3]
    middle_px = 0.5 * np.array([camera.width_px, camera.height_px])
    return middle_px + camera.focal_px * in_camera_m[:2] / max(in_camera_m[2], _NEAREST_M)
