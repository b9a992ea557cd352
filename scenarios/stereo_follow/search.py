"""Search by a driver who has lost the target: where it may have gone, where it was last, around, in the next room."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenarios.stereo_follow.bearings import Sighting, first_corner, seen_from
from scenarios.stereo_follow.floor_plan import FloorPlan
from scenarios.stereo_follow.robot import Robot, is_straight_way
from scenarios.stereo_follow.whims import Whims

_IMAGINES_S = 2.5
_ARRIVED_M, _LOOKS_THERE_RAD, _LOOKS_THERE_S = 0.7, 0.25, 1.5
_SWEEP_RAD_S, _ASIDE_RAD, _ALL_AROUND_RAD = 1.3, 1.0, 2.0 * np.pi
_NEAR_OPENING_M = 1.5


class Search:
    """The driver's search since he lost the target. It knows the latest sighting, and nothing of the target after it.

    He imagines for two and a half seconds that the target walks on, with errors, and drives there; if nobody is there
    he looks all around, and then goes to look around in the next room.
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
        """Return whether he has reached a place, or has looked at it from within its room, and nobody is there.

        To an opening he goes before he believes that.
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
