"""A simulated human driver, whose only information about the target is the picture of the robot's camera."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from math import atan2, hypot, pi

import numpy as np
from numpy.typing import NDArray

from scenarios.stereo_follow.floor_plan import FloorPlan
from scenarios.stereo_follow.robot import FASTEST_MPS, Robot, is_straight_way
from scenarios.stereo_follow.walks import Whims
from trackers.types import CameraCommand

_APPROACH_M = 0.9


@dataclass(frozen=True, slots=True)
class Sighting:
    """A sighting of the target that a driver took in.

    Attributes:
        place_m: (2,), as he judged it. velocity_mps: (2,), averaged over earlier sightings.
        frame: on which he took it in.
    """

    place_m: NDArray[np.float64]
    velocity_mps: NDArray[np.float64]
    frame: int


def seen_from(robot: Robot, place_m: NDArray[np.float64]) -> tuple[float, float]:
    """Return distance and bearing of a place (2,) from a robot; to the left is positive."""
    east_m, north_m = place_m[0] - robot.place_m[0], place_m[1] - robot.place_m[1]
    bearing_rad = atan2(north_m, east_m) - robot.heading_rad
    return hypot(east_m, north_m), (bearing_rad + pi) % (2.0 * pi) - pi


def first_corner(
    plan: FloorPlan, from_m: NDArray[np.float64], goal_m: NDArray[np.float64], free_m: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return where to drive first on the way to a goal (2,): the goal itself, or a place before or behind an opening.

    Args:
        free_m: ``plan.free_m``.
    """
    rooms = list(plan.rooms)
    here, there = rooms.index(plan.room_of(from_m)), rooms.index(plan.room_of(goal_m))
    if here == there or is_straight_way(from_m, goal_m, free_m):
        return plan.around(from_m, goal_m)[0]
    gap = plan.openings[here if there > here else here - 1]
    middle_m = 0.5 * (gap.y0 + gap.y1)
    ends_m = np.array([[gap.x0 - _APPROACH_M, middle_m], [gap.x1 + _APPROACH_M, middle_m]])
    near_m, far_m = ends_m if there > here else ends_m[::-1]
    return far_m if is_straight_way(from_m, far_m, free_m) else near_m


_IMAGINES_S = 2.5
_ARRIVED_M, _LOOKS_THERE_RAD, _LOOKS_THERE_S = 0.7, 0.25, 1.5
_SWEEP_RAD_S, _ASIDE_RAD, _ALL_AROUND_RAD = 1.3, 1.0, 2.0 * np.pi
_NEAR_OPENING_M = 1.5


class Search:
    """The driver's search for a lost target, from its latest sighting alone.

    For two and a half seconds the driver extrapolates the target's motion, with errors, and drives there. If the place
    is empty, the robot turns all around, and then does so in the next room.
    """

    def __init__(self, plan: FloorPlan, whims: Whims, latest: Sighting, rate_hz: float) -> None:
        self._plan, self._whims, self._latest, self._interval_s = plan, whims, latest, 1.0 / rate_hz
        self._free_m = plan.free_m
        self._to_m: NDArray[np.float64] | None = None
        self._looked_s = self._swept_rad = 0.0
        self._side = 0.0

    def goal(self, robot: Robot, frame: int) -> tuple[NDArray[np.float64] | None, float]:
        """Return the place (2,) to drive to and 0, or None and the turn rate with which he looks around."""
        if self._side != 0.0:
            self._swept_rad += _SWEEP_RAD_S * self._interval_s
            if self._swept_rad < _ASIDE_RAD:
                return None, self._side * _SWEEP_RAD_S
            if self._swept_rad < 2.0 * _ASIDE_RAD + _ALL_AROUND_RAD:
                return None, -self._side * _SWEEP_RAD_S
            self._to_m, self._side, self._swept_rad = self._in_next_room(robot), 0.0, 0.0
        goal_m = self._imagined_m(frame) if self._to_m is None else self._to_m
        if self._is_deserted(robot, goal_m):
            self._side = self._side_of(robot)
        return first_corner(self._plan, robot.place_m, goal_m, self._free_m), 0.0

    def _imagined_m(self, frame: int) -> NDArray[np.float64]:
        """Return where the target may be (2,); not beyond a wall."""
        latest, lost = self._latest, self._latest.frame
        passed_s = min((frame - lost) * self._interval_s, _IMAGINES_S)
        turn_rad = self._whims.carry_rad[lost]
        cosine, sine = np.cos(turn_rad), np.sin(turn_rad)
        walked_m = passed_s * self._whims.carry[lost] * latest.velocity_mps
        there_m = latest.place_m + np.array([[cosine, -sine], [sine, cosine]]) @ walked_m
        return there_m if is_straight_way(latest.place_m, there_m, self._free_m) else latest.place_m

    def _is_deserted(self, robot: Robot, goal_m: NDArray[np.float64]) -> bool:
        """Return whether a place is reached, or was looked at from within its room, and is empty.

        A place at an opening has to be reached.
        """
        distance_m, bearing_rad = seen_from(robot, goal_m)
        is_open = self._plan.room_of(robot.place_m) == self._plan.room_of(goal_m) and not any(
            gap.shrunk(-_NEAR_OPENING_M).holds(goal_m) for gap in self._plan.openings
        )
        self._looked_s += self._interval_s * (is_open and abs(bearing_rad) < _LOOKS_THERE_RAD)
        return distance_m < _ARRIVED_M or self._looked_s > _LOOKS_THERE_S

    def _side_of(self, robot: Robot) -> float:
        """Return the side to which the target walked when it was lost: 1.0 left, -1.0 right."""
        ahead = np.array([np.cos(robot.heading_rad), np.sin(robot.heading_rad)])
        east_mps, north_mps = self._latest.velocity_mps
        return 1.0 if ahead[0] * north_mps - ahead[1] * east_mps > 0.0 else -1.0

    def _in_next_room(self, robot: Robot) -> NDArray[np.float64]:
        """Return a place (2,) behind the opening towards which the target walked."""
        self._looked_s = 0.0
        east = np.sign(self._latest.velocity_mps[0])
        room = self._plan.room_of(robot.place_m)
        gap = {"corridor": self._plan.passage, "yard": self._plan.door}.get(
            room, self._plan.door if east > 0 else self._plan.passage
        )
        behind_m = gap.x1 + 1.5 if robot.place_m[0] < gap.x0 else gap.x0 - 1.5
        return np.array([behind_m, 0.5 * (gap.y0 + gap.y1)])


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
        """Return the judged place (2,) of the target in the picture."""
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
        """Return the intended speed and turn rate."""
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
        """Return the command with the errors of an unsteady hand; none while the robot stands."""
        frame, whims = self._frame, self._whims
        return CameraCommand(
            forward_mps=float(forward_mps + (whims.unsteady_mps[frame] if forward_mps else 0.0)),
            yaw_rate_rad_s=float(turn_rad_s + (whims.unsteady_rad_s[frame] if turn_rad_s or forward_mps else 0.0)),
        )
