"""The target's path, and the robot that is driven by hand after him."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from scenarios.stereo_follow.floor_plan import FloorPlan
from scenarios.stereo_follow.presets import StereoFollow
from scenarios.stereo_follow.robot import Robot
from scenarios.stereo_follow.sight import is_in_sight, seen_frames
from scenarios.stereo_follow.sight_driver import SightDriver
from scenarios.stereo_follow.walks import STEP_M, at_distance, changing_pace, draw_whims, rounded_way

_TRIES = 40
_NEAR_PASSAGE_M = 8.0
_SHARPEST_COSINE = -0.2

Leg = tuple[str, NDArray[np.float64]]
"""The room in which a leg ends, and its corners (M, 2)."""


def targets_way(
    preset: StereoFollow, plan: FloorPlan, length_m: float, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Draw the path (S, 2) from the robot's start on, longer than ``length_m``."""
    rooms = plan.walked
    room = rooms[rng.integers(len(rooms))]
    stop_m = plan.draw_place(room, rng)
    if room == "corridor":
        stop_m[0] = max(stop_m[0], -_NEAR_PASSAGE_M)
    way_m = rounded_way(np.array([stop_m, stop_m]))
    while (left_m := length_m + 1.0 - STEP_M * (len(way_m) - 1)) > 0:
        for _ in range(_TRIES):
            next_room, corners_m = _leg(preset, plan, room, way_m, rng)
            is_dead_end = next_room == "corridor" and left_m > plan.corridor.x1 - plan.corridor.x0
            if not is_dead_end and _goes_on(way_m, corners_m, preset.leg_m[0]):
                break
        room = next_room
        way_m = rounded_way(np.concatenate([way_m[:-1], corners_m]))
    return way_m


def _leg(preset: StereoFollow, plan: FloorPlan, room: str, way_m: NDArray[np.float64], rng: np.random.Generator) -> Leg:
    """Draw a straight leg round a corner in the same room, or a leg into another one."""
    here_m, before_m = way_m[-1], way_m[-1 - min(int(1.0 / STEP_M), len(way_m) - 1)]
    ahead_rad = np.arctan2(*(here_m - before_m)[::-1]) if len(way_m) > 2 else rng.uniform(-np.pi, np.pi)
    for _ in range(_TRIES * (rng.random() < preset.stays)):
        direction_rad = ahead_rad + rng.choice([-1.0, 1.0]) * np.deg2rad(rng.uniform(*preset.corner_deg))
        stop_m = here_m + rng.uniform(*preset.leg_m) * np.array([np.cos(direction_rad), np.sin(direction_rad)])
        if plan.free_area(room).holds(stop_m) and plan.is_clear(here_m, stop_m):
            return room, np.array([here_m, stop_m])
    next_room = _neighbour(plan, room, rng)
    return next_room, plan.way(np.array([here_m, plan.draw_place(next_room, rng)]), rng)


def _neighbour(plan: FloorPlan, room: str, rng: np.random.Generator) -> str:
    rooms = plan.walked
    neighbours = [rooms[k] for k in (rooms.index(room) - 1, rooms.index(room) + 1) if 0 <= k < len(rooms)] or [room]
    return neighbours[rng.integers(len(neighbours))]


def _goes_on(way_m: NDArray[np.float64], corners_m: NDArray[np.float64], shortest_m: float) -> bool:
    """Return whether a leg (M, 2) is long and has no turn, at its start or later, back towards the follower."""
    corners_m = np.concatenate([way_m[-1 - int(1.0 / STEP_M) : -1][:1], corners_m])
    sides_m = np.diff(corners_m, axis=0)
    lengths_m = np.linalg.norm(sides_m, axis=1)
    along = sides_m / np.maximum(lengths_m, 1e-9)[:, None]
    is_sharp = np.einsum("nk,nk->n", along[1:], along[:-1]) <= _SHARPEST_COSINE
    return bool(lengths_m[-1] > shortest_m and not is_sharp.any())


_HEAD_STARTS_M, _SPEEDS_MPS = (1.8, 3.8), (0.6, 1.6)
_ASIDE_AT_FIRST_RAD = 0.25
NEAREST_M = 1.1
SEEN_AT_FIRST_FRAMES = 10

Drive = tuple[NDArray[np.float64], NDArray[np.float64]]
"""Places (F, 2) and headings (F,) of the robot."""


@dataclass(frozen=True, slots=True)
class Pursuit:
    """A target and the robot behind him over F frames.

    Attributes:
        way_m: (S, 2) the target's path from the robot's start. along_m: (F,) his distance along it.
        target_m: (F, 2) his places.
        robot_m, robot_heading_rad: (F, 2) and (F,) of the robot.
        drive: returns the robot's drive among other people, places (N, F, 2).
    """

    way_m: NDArray[np.float64]
    along_m: NDArray[np.float64]
    target_m: NDArray[np.float64]
    robot_m: NDArray[np.float64]
    robot_heading_rad: NDArray[np.float64]
    drive: Callable[[NDArray[np.float64]], Drive]

    @property
    def nearest_m(self) -> float:
        """Least distance of the robot from the target."""
        return float(np.linalg.norm(self.target_m - self.robot_m, axis=1).min())

    def among(self, others_m: Sequence[NDArray[np.float64]]) -> Pursuit:
        """Return the pursuit among other people, each (F, 2). It is the same until one of them hides the target."""
        robot_m, heading_rad = self.drive(np.array(others_m))
        return replace(self, robot_m=robot_m, robot_heading_rad=heading_rad)


def draw_pursuit(preset: StereoFollow, plan: FloorPlan, rng: np.random.Generator) -> Pursuit:
    """Draw the target's path and the drive after him without other people."""
    tried = []
    for _ in range(_TRIES):
        pursuit = _driven_by_sight(preset, plan, rng)
        tried.append((_too_near_m(pursuit, plan), pursuit))
        if tried[-1][0] <= 0:
            break
    return min(tried, key=lambda pair: pair[0])[1]


def _driven_by_sight(preset: StereoFollow, plan: FloorPlan, rng: np.random.Generator) -> Pursuit:
    """Draw a target that walks at changing speeds, and a driver who sees the robot's picture alone."""
    frames, rate_hz = preset.frame_count, preset.rate_hz
    pace_m = rng.uniform(*_HEAD_STARTS_M) + changing_pace(frames, rate_hz, _SPEEDS_MPS, rng, preset.pauses)
    way_m = targets_way(preset, plan, pace_m[-1], rng)
    target_m = at_distance(way_m, pace_m)
    heading_rad = _direction_rad(way_m[0], target_m[0]) + rng.uniform(-_ASIDE_AT_FIRST_RAD, _ASIDE_AT_FIRST_RAD)
    whims = draw_whims(frames, rate_hz, rng)

    def drive(others_m: NDArray[np.float64]) -> Drive:
        robot = Robot(plan, way_m[0], heading_rad, rate_hz)
        return drive_by_sight(plan, robot, SightDriver(plan, whims, rate_hz), target_m, others_m)

    return Pursuit(way_m, pace_m, target_m, *drive(np.empty((0, frames, 2))), drive=drive)


def drive_by_sight(
    plan: FloorPlan,
    robot: Robot,
    driver: SightDriver,
    target_m: NDArray[np.float64],
    others_m: NDArray[np.float64],
) -> Drive:
    """Return the drive behind the target (F, 2), which the driver sees where no other person (N, F, 2) hides it."""
    driven_m, headings_rad = [], []
    for frame, place_m in enumerate(target_m):
        driven_m.append(robot.place_m)
        headings_rad.append(robot.heading_rad)
        among_m = others_m[:, frame]
        is_seen = is_in_sight(robot.place_m, robot.heading_rad, place_m, among_m, plan.openings_m)
        robot.drive(driver.command(robot, place_m if is_seen else None, among_m))
    return np.array(driven_m), np.array(headings_rad)


def _too_near_m(pursuit: Pursuit, plan: FloorPlan) -> float:
    """Return by how much the target comes too near, infinite if it is not seen at first.

    It is infinite too where the path begins too near a wall, in a corner that it cuts: the robot could not move there.
    """
    first = slice(0, SEEN_AT_FIRST_FRAMES)
    is_seen = seen_frames(
        pursuit.robot_m[first],
        pursuit.robot_heading_rad[first],
        pursuit.target_m[first],
        np.empty((0, SEEN_AT_FIRST_FRAMES, 2)),
        plan.openings_m,
    )
    can_move = plan.is_free(pursuit.robot_m[0])
    return NEAREST_M - pursuit.nearest_m if can_move and is_seen.all() else np.inf


def _direction_rad(from_m: NDArray[np.float64], to_m: NDArray[np.float64]) -> float:
    return float(np.arctan2(to_m[1] - from_m[1], to_m[0] - from_m[0]))
