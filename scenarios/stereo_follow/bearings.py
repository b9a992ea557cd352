"""What a driver by hand works with: bearings, sightings, and the first corner of a way."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, hypot, pi

import numpy as np
from numpy.typing import NDArray

from scenarios.stereo_follow.floor_plan import FloorPlan
from scenarios.stereo_follow.robot import Robot, is_straight_way

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
        return goal_m
    gap = plan.openings[here if there > here else here - 1]
    middle_m = 0.5 * (gap.y0 + gap.y1)
    ends_m = np.array([[gap.x0 - _APPROACH_M, middle_m], [gap.x1 + _APPROACH_M, middle_m]])
    near_m, far_m = ends_m if there > here else ends_m[::-1]
    return far_m if is_straight_way(from_m, far_m, free_m) else near_m
