"""The robot that carries the camera, and the hand that drives it after the target where no tracker does."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenarios.stereo_follow.floor_plan import FloorPlan
from trackers.types import CameraCommand, Carrier, CommandAxis

FASTEST_MPS, FASTEST_TURN_RAD_S = 1.6, 1.6
ACCELERATION_MPS2, TURN_ACCELERATION_RAD_S2 = 1.5, 4.0
ROBOT = Carrier(
    "robot",
    (
        CommandAxis("forward_mps", FASTEST_MPS, ACCELERATION_MPS2),
        CommandAxis("yaw_rate_rad_s", FASTEST_TURN_RAD_S, TURN_ACCELERATION_RAD_S2),
    ),
    "ahead",
)
"""Its motors set the same limits."""
_TURN_GAIN, _SPEED_GAIN = 2.2, 1.1
_REACTION_FRAMES = 4
_TRAIL_FRAMES, _TRAIL_STEP_FRAMES = 75, 5
_ALONG_LINE = np.linspace(0.0, 1.0, 20)


class Robot:
    """A robot on two driven wheels: it goes ahead or back and turns, with limits, and stops at walls.

    Attributes:
        place_m: (2,). heading_rad: counter-clockwise from world x.
    """

    def __init__(self, plan: FloorPlan, place_m: NDArray[np.float64], heading_rad: float, rate_hz: float) -> None:
        self._plan = plan
        self._interval_s = 1.0 / rate_hz
        self._speed_mps = self._turn_rad_s = 0.0
        self.place_m = np.array(place_m, dtype=float)
        self.heading_rad = float(heading_rad)

    def drive(self, command: CameraCommand) -> None:
        """Obey a command for one frame: ``forward_mps`` and ``yaw_rate_rad_s``, as far as it can, nothing else."""
        dt = self._interval_s
        wanted_mps = float(np.clip(command.forward_mps, -FASTEST_MPS, FASTEST_MPS))
        wanted_rad_s = float(np.clip(command.yaw_rate_rad_s, -FASTEST_TURN_RAD_S, FASTEST_TURN_RAD_S))
        self._speed_mps += _limited(wanted_mps - self._speed_mps, ACCELERATION_MPS2 * dt)
        self._turn_rad_s += _limited(wanted_rad_s - self._turn_rad_s, TURN_ACCELERATION_RAD_S2 * dt)
        middle_rad = self.heading_rad + 0.5 * self._turn_rad_s * dt
        self.heading_rad += self._turn_rad_s * dt
        step_m = self._speed_mps * dt * np.array([np.cos(middle_rad), np.sin(middle_rad)])
        # At a wall it slides along.
        for part_m in (step_m, np.array([step_m[0], 0.0]), np.array([0.0, step_m[1]])):
            if self._plan.is_free(self.place_m + part_m):
                self.place_m = self.place_m + part_m
                return
        self._speed_mps = 0.0


class HandDriver:
    """A person who drives the robot after the target by what he sees of it, a quarter of a second late.

    He turns towards it in proportion to its bearing and keeps a distance, both with the unsteadiness of a hand. Where a
    wall is between he steers for where it went.
    """

    def __init__(self, plan: FloorPlan, distance_m: float, rng: np.random.Generator) -> None:
        self._plan = plan
        self._distance_m = distance_m
        self._rng = rng
        self._seen: list[NDArray[np.float64]] = []
        self._unsteady = np.zeros(2)

    def command(self, robot: Robot, target_m: NDArray[np.float64]) -> CameraCommand:
        """Return the command for the next frame, the target being at (2,)."""
        self._seen.append(np.array(target_m, dtype=float))
        seen_m = self._seen[max(len(self._seen) - 1 - _REACTION_FRAMES, 0)]
        ahead_m = self._steered_for(robot.place_m) - robot.place_m
        bearing_rad = np.arctan2(ahead_m[1], ahead_m[0]) - robot.heading_rad
        bearing_rad = (bearing_rad + np.pi) % (2 * np.pi) - np.pi
        distance_m = float(np.hypot(*(seen_m - robot.place_m)))
        self._unsteady = 0.95 * self._unsteady + self._rng.normal(0.0, (0.02, 0.03))
        wanted_mps = _SPEED_GAIN * (distance_m - self._distance_m) * max(np.cos(bearing_rad), 0.0)
        return CameraCommand(
            forward_mps=float(np.clip(wanted_mps + self._unsteady[0], 0.0, FASTEST_MPS)),
            yaw_rate_rad_s=float(_TURN_GAIN * bearing_rad + self._unsteady[1]),
        )

    def _steered_for(self, place_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the latest place (2,) seen of the target to which one can go straight."""
        latest = max(len(self._seen) - 1 - _REACTION_FRAMES, 0)
        trail_m = np.array(self._seen[max(latest - _TRAIL_FRAMES, 0) : latest + 1][::-_TRAIL_STEP_FRAMES])
        lines_m = place_m + _ALONG_LINE[:, None, None] * (trail_m - place_m)
        is_straight = self._plan.is_free(lines_m).all(axis=0)
        return trail_m[is_straight.argmax()]


def _limited(change: float, most: float) -> float:
    return min(max(change, -most), most)
