"""The path of the person who is followed, through the rooms of a floor plan."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenarios.stereo_follow.floor_plan import FloorPlan
from scenarios.stereo_follow.presets import StereoFollow
from scenarios.stereo_follow.walks import STEP_M, rounded_way

_TRIES = 40
_NEAR_PASSAGE_M = 8.0
_SHARPEST_COSINE = -0.2

Leg = tuple[str, NDArray[np.float64]]
"""The room in which a leg ends, and its corners (M, 2)."""


def targets_way(
    preset: StereoFollow, plan: FloorPlan, length_m: float, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Draw the path (S, 2) from the robot's start on, longer than ``length_m``."""
    rooms = list(plan.rooms)
    room = rooms[rng.integers(len(rooms))]
    stop_m = plan.free_area(room).draw(rng)
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
        if plan.free_area(room).holds(stop_m):
            return room, np.array([here_m, stop_m])
    next_room = _neighbour(plan, room, rng)
    return next_room, plan.way(np.array([here_m, plan.free_area(next_room).draw(rng)]), rng)


def _neighbour(plan: FloorPlan, room: str, rng: np.random.Generator) -> str:
    rooms = list(plan.rooms)
    neighbours = [rooms[k] for k in (rooms.index(room) - 1, rooms.index(room) + 1) if 0 <= k < len(rooms)]
    return neighbours[rng.integers(len(neighbours))]


def _goes_on(way_m: NDArray[np.float64], corners_m: NDArray[np.float64], shortest_m: float) -> bool:
    """Return whether a leg (M, 2) is long and has no turn, at its start or later, back towards the follower."""
    corners_m = np.concatenate([way_m[-1 - int(1.0 / STEP_M) : -1][:1], corners_m])
    sides_m = np.diff(corners_m, axis=0)
    lengths_m = np.linalg.norm(sides_m, axis=1)
    along = sides_m / np.maximum(lengths_m, 1e-9)[:, None]
    is_sharp = np.einsum("nk,nk->n", along[1:], along[:-1]) <= _SHARPEST_COSINE
    return bool(lengths_m[-1] > shortest_m and not is_sharp.any())
