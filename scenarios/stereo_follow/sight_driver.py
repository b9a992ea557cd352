"""A driver by hand who knows of the target only what the robot's camera shows him."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

from scenarios.stereo_follow.bearings import Sighting, first_corner, seen_from
from scenarios.stereo_follow.floor_plan import FloorPlan
from scenarios.stereo_follow.robot import FASTEST_MPS, Robot
from scenarios.stereo_follow.search import Search
from scenarios.stereo_follow.whims import Whims
from trackers.types import CameraCommand

_WAITS_M = 1.6
"""Nearer to the target the driver always looks, and keeps it in the middle of the picture."""
_TOO_NEAR_M, _BACKS_OFF_MPS = 1.1, 0.5
_LOOKS_AWAY_FROM_M = 3.0
_TURN_GAIN, _FASTEST_TURN_RAD_S, _DONE_TURNING_RAD = 2.5, 1.3, 0.04
_CATCHES_UP_M = 1.0
"""Farther behind than this he drives as fast as the robot can."""
_STEADY_TOLERANCE_RAD = 0.06
_VELOCITY_S = 0.4
_LANE_M, _PASSES_M, _SLOWS_M, _STEERS_M, _STOPS_M = 0.6, 0.85, 1.7, 1.1, 0.7


class SightDriver:
    """A human driver who looks at the picture, with a delay, and drives in bursts.

    He leaves the target at some bearing and distance until it walks off, and looks away at times. A target that he
    does not see he searches, see ``Search``. He steers around people before the robot.
    """

    def __init__(self, plan: FloorPlan, whims: Whims, rate_hz: float) -> None:
        self._free_m, self._whims, self._interval_s = plan.free_m, whims, 1.0 / rate_hz
        self._plan = plan
        self._pictures: deque[NDArray[np.float64] | None] = deque(maxlen=whims.reaction_frames + 1)
        self._latest: Sighting | None = None
        self._search: Search | None = None
        self._frame = -1
        self._goes = self._turns = False
        self._forward_mps = 0.0

    def command(
        self, robot: Robot, target_m: NDArray[np.float64] | None, others_m: NDArray[np.float64]
    ) -> CameraCommand:
        """Return the command for the next frame.

        Args:
            target_m: (2,) the target's place if the picture shows it, otherwise None.
            others_m: (N, 2) places of other people; those close before the robot count.
        """
        self._frame += 1
        self._pictures.append(None if target_m is None else self._judged(robot, target_m))
        turn_rad_s = 0.0
        if not self._looks_away(robot):
            self._take_in(self._pictures[0])
            self._forward_mps, turn_rad_s = self._wanted(robot)
        return self._steadied(*self._past_people(robot, others_m, self._forward_mps, turn_rad_s))

    def _judged(self, robot: Robot, target_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the place (2,) where he believes that he sees the target."""
        distance_m, bearing_rad = seen_from(robot, target_m)
        distance_m *= 1.0 + self._whims.range_error[self._frame]
        direction_rad = robot.heading_rad + bearing_rad + self._whims.bearing_error_rad[self._frame]
        return robot.place_m + distance_m * np.array([np.cos(direction_rad), np.sin(direction_rad)])

    def _looks_away(self, robot: Robot) -> bool:
        if self._latest is None or self._search is not None or self._whims.attends[self._frame]:
            return False
        return seen_from(robot, self._latest.place_m)[0] > _LOOKS_AWAY_FROM_M

    def _take_in(self, place_m: NDArray[np.float64] | None) -> None:
        """Take in a sighting, or its absence."""
        if place_m is None:
            if self._search is None and self._latest is not None:
                self._search = Search(self._plan, self._whims, self._latest, 1.0 / self._interval_s)
            return
        velocity_mps = np.zeros(2)
        if self._latest is not None:
            passed_s = (self._frame - self._latest.frame) * self._interval_s
            fresh = 1.0 - np.exp(-passed_s / _VELOCITY_S)
            velocity_mps = (1.0 - fresh) * self._latest.velocity_mps
            velocity_mps += fresh * (place_m - self._latest.place_m) / passed_s
        self._latest, self._search = Sighting(place_m, velocity_mps, self._frame), None

    def _wanted(self, robot: Robot) -> tuple[float, float]:
        """Return speed and turn rate that he wants."""
        if self._latest is None:
            return 0.0, 0.0
        if self._search is None:
            return self._follow(robot, self._latest.place_m)
        goal_m, sweep_rad_s = self._search.goal(robot, self._frame)
        if goal_m is None:
            return 0.0, sweep_rad_s
        _, bearing_rad = seen_from(robot, goal_m)
        fast_mps = self._whims.burst_mps[self._frame] * max(np.cos(bearing_rad), 0.0)
        return fast_mps, self._turn(bearing_rad, _STEADY_TOLERANCE_RAD)

    def _follow(self, robot: Robot, place_m: NDArray[np.float64]) -> tuple[float, float]:
        frame, whims = self._frame, self._whims
        distance_m, _ = seen_from(robot, place_m)
        corner_m = first_corner(self._plan, robot.place_m, place_m, self._free_m)
        _, bearing_rad = seen_from(robot, corner_m)
        if corner_m is place_m:
            play = min(max((distance_m - 1.0) / (_WAITS_M - 1.0), 0.0), 1.0)
            turn_rad_s = self._turn(
                bearing_rad - play * whims.aim_rad[frame], _STEADY_TOLERANCE_RAD + play * whims.tolerance_rad[frame]
            )
        else:
            turn_rad_s = self._turn(bearing_rad, _STEADY_TOLERANCE_RAD)
        if distance_m < _TOO_NEAR_M:
            return -_BACKS_OFF_MPS, turn_rad_s
        behind_m = distance_m - whims.distance_m[frame]
        self._goes = behind_m > (0.0 if self._goes else whims.slack_m[frame])
        fast_mps = FASTEST_MPS if behind_m > _CATCHES_UP_M else whims.burst_mps[frame]
        return (fast_mps * max(np.cos(bearing_rad), 0.0) if self._goes else 0.0), turn_rad_s

    def _turn(self, error_rad: float, tolerance_rad: float) -> float:
        """Return the turn rate: none until the error exceeds the tolerance, then until it is gone."""
        self._turns = abs(error_rad) > (_DONE_TURNING_RAD if self._turns else tolerance_rad)
        rate_rad_s = min(max(_TURN_GAIN * error_rad, -_FASTEST_TURN_RAD_S), _FASTEST_TURN_RAD_S)
        return rate_rad_s if self._turns else 0.0

    def _past_people(
        self, robot: Robot, others_m: NDArray[np.float64], forward_mps: float, turn_rad_s: float
    ) -> tuple[float, float]:
        """Return speed and turn rate behind the nearest person (N, 2) before the robot: slower, at last past him."""
        for distance_m, bearing_rad in sorted(seen_from(robot, other_m) for other_m in others_m):
            ahead_m, left_m = distance_m * np.cos(bearing_rad), distance_m * np.sin(bearing_rad)
            if forward_mps > 0.0 and 0.0 < ahead_m < _SLOWS_M and abs(left_m) < _LANE_M:
                slower = min(max((distance_m - _STOPS_M) / (_SLOWS_M - _STOPS_M), 0.0), 1.0)
                if distance_m < _STEERS_M:
                    aside_m = left_m - np.copysign(_PASSES_M, left_m)
                    turn_rad_s = self._turn(float(np.arctan2(aside_m, ahead_m)), _STEADY_TOLERANCE_RAD)
                return slower * forward_mps, turn_rad_s
        return forward_mps, turn_rad_s

    def _steadied(self, forward_mps: float, turn_rad_s: float) -> CameraCommand:
        """Return the command of an unsteady hand; who lets go is steady."""
        frame, whims = self._frame, self._whims
        return CameraCommand(
            forward_mps=float(forward_mps + (whims.unsteady_mps[frame] if forward_mps else 0.0)),
            yaw_rate_rad_s=float(turn_rad_s + (whims.unsteady_rad_s[frame] if turn_rad_s or forward_mps else 0.0)),
        )
