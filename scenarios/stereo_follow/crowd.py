"""The paths of the target, of the robot that follows it, and of other people who get in between."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, gaussian_filter1d

from scenarios.stereo_follow.floor_plan import FloorPlan
from scenarios.stereo_follow.presets import StereoFollow
from scenarios.stereo_follow.robot import HandDriver, Robot
from scenarios.stereo_follow.walks import STEP_M, Walk, at_distance, rounded_way, sideways, steady_pace, walk_of

_HEAD_START_M = 2.4
_APART_M = {"target": 0.55, "robot": 0.6, "other": 0.5}
_FOLLOWED_FROM_M, _FOLLOWED_UP_TO_M = 1.3, 5.5
_TRIES = 40
_SEEN_AT_FIRST_FRAMES, _CLEAR_SIGHT_M = 10, 0.7
_MAKES_WAY_FRAMES = 12
_CHANGES_SIDE_S, _FASTEST_WALK_MPS = 0.4, 1.9
_LEG_M = 3.5
_SHARPEST_COSINE = -0.2
_NEAR_PASSAGE_M = 8.0
_CHANGES_ROOM = 0.8


@dataclass(frozen=True, slots=True)
class Crowd:
    """Paths of people and robot over F frames.

    Attributes:
        walks: the target's first. kinds: ``target``, ``crosser``, ``oncomer`` …
        robot_m: (F, 2) and robot_heading_rad: (F,), driven by hand.
    """

    walks: tuple[Walk, ...]
    kinds: tuple[str, ...]
    robot_m: NDArray[np.float64]
    robot_heading_rad: NDArray[np.float64]


def draw_crowd(preset: StereoFollow, plan: FloorPlan, rng: np.random.Generator) -> Crowd:
    """Draw all paths. People keep the distances of a crowd to the target, to the robot and to each other."""
    way_m, along_m, driven_m, heading_rad = _followed_way(preset, plan, rng)
    target_m = at_distance(way_m, along_m)
    walks, kinds = [walk_of(target_m, preset.rate_hz)], ["target"]
    scene = _Scene(preset, plan, way_m, along_m, target_m, driven_m)
    for kind, count in (
        ("follower", preset.followers),
        ("oncomer", preset.oncomers),
        ("crosser", preset.crossers),
        ("stander", preset.standers),
        ("walker", preset.walkers),
    ):
        for _ in range(count):
            place_m = _first_that_fits(scene, walks, _DRAWN[kind], rng)
            if place_m is not None:
                walks.append(walk_of(place_m, preset.rate_hz, rng.uniform(-np.pi, np.pi)))
                kinds.append(kind)
    return Crowd(tuple(walks), tuple(kinds), driven_m, heading_rad)


@dataclass(frozen=True, slots=True)
class _Scene:
    """The paths of target and robot, around which other people's paths are drawn."""

    preset: StereoFollow
    plan: FloorPlan
    way_m: NDArray[np.float64]
    along_m: NDArray[np.float64]
    target_m: NDArray[np.float64]
    robot_m: NDArray[np.float64]


def _followed_way(
    preset: StereoFollow, plan: FloorPlan, rng: np.random.Generator
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return the target's path (S, 2), its distance along it (F,), and the robot's places (F, 2) and headings (F,).

    This is the first of some draws in which the target's distance from the robot stays in range, otherwise the draw
    that comes closest to that.
    """
    tried = []
    for _ in range(_TRIES):
        way_m, along_m = _targets_way(preset, plan, rng)
        target_m = at_distance(way_m, along_m)
        first_m = way_m[int(_HEAD_START_M / STEP_M)] - way_m[0]
        driven_m, headings = _drive(preset, plan, target_m, way_m[0], float(np.arctan2(first_m[1], first_m[0])), rng)
        distance_m = np.linalg.norm(target_m - driven_m, axis=1)
        off_m = max(_FOLLOWED_FROM_M - distance_m.min(), distance_m.max() - _FOLLOWED_UP_TO_M)
        tried.append((off_m, (way_m, along_m, driven_m, headings)))
        if off_m <= 0:
            break
    return min(tried, key=lambda pair: pair[0])[1]


def _targets_way(
    preset: StereoFollow, plan: FloorPlan, rng: np.random.Generator
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the target's path (S, 2) from the robot's start, and its distance along it on each frame (F,)."""
    pace_m = _HEAD_START_M + steady_pace(
        preset.frame_count, preset.rate_hz, rng.uniform(0.95, 1.25), rng, preset.pauses
    )
    rooms = list(plan.rooms)
    room = rooms[rng.integers(len(rooms))]
    stop_m = plan.free_area(room).draw(rng)
    if room == "corridor":
        stop_m[0] = max(stop_m[0], -_NEAR_PASSAGE_M)
    way_m = rounded_way(np.array([stop_m, stop_m]))
    while (left_m := pace_m[-1] + 1.0 - STEP_M * (len(way_m) - 1)) > 0:
        for _ in range(_TRIES):
            neighbours = [rooms[k] for k in (rooms.index(room) - 1, rooms.index(room) + 1) if 0 <= k < len(rooms)]
            next_room = neighbours[rng.integers(len(neighbours))] if rng.random() < _CHANGES_ROOM else room
            leg_m = plan.way(np.array([way_m[-1], plan.free_area(next_room).draw(rng)]), rng)
            is_dead_end = next_room == "corridor" and left_m > plan.corridor.x1 - plan.corridor.x0
            if not is_dead_end and _goes_on(way_m, leg_m):
                break
        room = next_room
        way_m = rounded_way(np.concatenate([way_m[:-1], leg_m]))
    return way_m, pace_m


def _goes_on(way_m: NDArray[np.float64], leg_m: NDArray[np.float64]) -> bool:
    """Return whether a leg (M, 2) is long and has no turn, at its start or later, back towards the follower."""
    corners_m = np.concatenate([way_m[-1 - int(1.0 / STEP_M) : -1][:1], leg_m])
    sides_m = np.diff(corners_m, axis=0)
    lengths_m = np.linalg.norm(sides_m, axis=1)
    along = sides_m / np.maximum(lengths_m, 1e-9)[:, None]
    return bool(lengths_m[-1] > _LEG_M and (np.einsum("nk,nk->n", along[1:], along[:-1]) > _SHARPEST_COSINE).all())


def _drive(
    preset: StereoFollow,
    plan: FloorPlan,
    target_m: NDArray[np.float64],
    start_m: NDArray[np.float64],
    heading_rad: float,
    rng: np.random.Generator,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return places (F, 2) and headings (F,) of the robot, driven by hand after the target."""
    robot = Robot(plan, start_m, heading_rad, preset.rate_hz)
    driver = HandDriver(plan, rng.uniform(1.3, 2.0), rng)
    driven_m, headings = [], []
    for place_m in target_m:
        driven_m.append(robot.place_m)
        headings.append(robot.heading_rad)
        robot.drive(driver.command(robot, place_m))
    return np.array(driven_m), np.array(headings)


def _first_that_fits(
    scene: _Scene,
    walks: list[Walk],
    draw: Callable[[_Scene, np.random.Generator], NDArray[np.float64] | None],
    rng: np.random.Generator,
) -> NDArray[np.float64] | None:
    """Return places (F, 2) of one more person, the first of some draws that keeps its distances; None if none does."""
    for _ in range(_TRIES):
        place_m = draw(scene, rng)
        if place_m is None or not scene.plan.is_free(place_m).all() or _hides_at_first(scene, place_m):
            continue
        keeps_off = [(scene.target_m, _APART_M["target"]), (scene.robot_m, _APART_M["robot"])]
        keeps_off += [(walk.place_m, _APART_M["other"]) for walk in walks[1:]]
        if all(np.linalg.norm(place_m - other_m, axis=1).min() > apart_m for other_m, apart_m in keeps_off):
            return place_m
    return None


def _hides_at_first(scene: _Scene, place_m: NDArray[np.float64]) -> bool:
    """Return whether a person at places (F, 2) is near the line of sight to the target on the first frames."""
    first = slice(0, _SEEN_AT_FIRST_FRAMES)
    robot_m, sight_m = scene.robot_m[first], (scene.target_m - scene.robot_m)[first]
    to_m = place_m[first] - robot_m
    share = np.clip(np.einsum("fk,fk->f", to_m, sight_m) / np.einsum("fk,fk->f", sight_m, sight_m), 0.0, 1.0)
    return bool((np.linalg.norm(to_m - share[:, None] * sight_m, axis=1) < _CLEAR_SIGHT_M).any())


def _crosser(scene: _Scene, rng: np.random.Generator) -> NDArray[np.float64] | None:
    """Cross the line from robot to target on a random frame, between two random places."""
    frame = int(rng.uniform(0.08, 0.92) * len(scene.target_m))
    sight_m = scene.target_m[frame] - scene.robot_m[frame]
    middle_m = scene.robot_m[frame] + rng.uniform(0.4, 0.75) * sight_m
    angle = np.arctan2(sight_m[1], sight_m[0]) + rng.choice([-1.0, 1.0]) * rng.uniform(np.pi / 4, 3 * np.pi / 4)
    across_m = rng.uniform(1.0, 2.5) * np.array([np.cos(angle), np.sin(angle)])
    plan = scene.plan
    if not plan.is_free(np.array([middle_m - across_m, middle_m, middle_m + across_m])).all():
        return None
    come_m, go_m = (plan.free_area(plan.room_of(middle_m)).draw(rng) for _ in range(2))
    way_m = rounded_way(np.array([come_m, middle_m - across_m, middle_m + across_m, go_m]))
    return _paced_through(way_m, middle_m, frame, rng.uniform(0.8, 1.5), scene)


def _oncomer(scene: _Scene, rng: np.random.Generator) -> NDArray[np.float64] | None:
    """Walk beside the target's path in the opposite direction; pass the target on a random frame, then the robot."""
    frame = int(rng.uniform(0.1, 0.9) * len(scene.target_m))
    met_m = scene.along_m[frame]
    offset_m = rng.choice([-1.0, 1.0]) * rng.uniform(0.6, 0.95)
    beside_m = scene.way_m + offset_m * sideways(scene.way_m)
    first = max(int((met_m - rng.uniform(5.0, 8.0)) / STEP_M), 0)
    last = min(int((met_m + rng.uniform(4.0, 8.0)) / STEP_M), len(beside_m))
    way_m = rounded_way(beside_m[first:last][::-1])
    return _paced_through(way_m, beside_m[int(met_m / STEP_M)], frame, rng.uniform(0.9, 1.4), scene)


def _follower(scene: _Scene, rng: np.random.Generator) -> NDArray[np.float64] | None:
    """Wait beside the target's path, walk close behind the target for a while with changes of side, then stop."""
    rate_hz, frames = scene.preset.rate_hz, len(scene.target_m)
    changes, change_s = rng.integers(1, 3), rng.uniform(3.0, 4.5)
    begin = int(rng.uniform(0.1, 0.8) * frames)
    end = min(begin + int(changes * change_s * rate_hz), frames - 1)
    followed = np.clip(np.arange(frames), begin, end)
    along_m = scene.along_m[followed] - rng.uniform(0.65, 1.0)
    # Nearly a square wave: the person is beside the line most of the time.
    sway = np.tanh(1.5 * np.cos(np.pi * (followed - begin) / (change_s * rate_hz)))
    beside_m = rng.choice([-1.0, 1.0]) * rng.uniform(0.65, 0.8) * sway
    index = np.clip((along_m / STEP_M).astype(int), 0, len(scene.way_m) - 1)
    line_m, left = at_distance(scene.way_m, along_m), sideways(scene.way_m)[index]
    # Through a door the person follows the target's path exactly.
    tight = ~scene.plan.is_free(line_m + 1.2 * beside_m[:, None] * left)
    room = (~binary_dilation(tight, iterations=_MAKES_WAY_FRAMES)).astype(float)
    offset_m = (room * beside_m)[:, None] * left
    place_m = line_m + gaussian_filter1d(offset_m, _CHANGES_SIDE_S * rate_hz, axis=0, mode="nearest")
    is_running = np.linalg.norm(np.diff(place_m, axis=0), axis=1).max() * rate_hz > _FASTEST_WALK_MPS
    return None if is_running else place_m


def _walker(scene: _Scene, rng: np.random.Generator) -> NDArray[np.float64] | None:
    """Walk between two random places, passing a place in the target's room on a random frame."""
    plan, rooms = scene.plan, list(scene.plan.rooms)
    frame = int(rng.uniform(0.0, 1.0) * (len(scene.target_m) - 1))
    here = plan.room_of(scene.target_m[frame])
    stops_m = [plan.free_area(rooms[rng.integers(len(rooms))]).draw(rng), plan.free_area(here).draw(rng)]
    stops_m.append(plan.free_area(rooms[rng.integers(len(rooms))]).draw(rng))
    way_m = rounded_way(plan.way(np.array(stops_m), rng))
    return _paced_through(way_m, stops_m[1], frame, rng.uniform(0.8, 1.4), scene)


def _stander(scene: _Scene, rng: np.random.Generator) -> NDArray[np.float64] | None:
    """Stand beside the target's path."""
    index = int(rng.uniform(0.1, 0.9) * scene.along_m[-1] / STEP_M)
    offset_m = rng.choice([-1.0, 1.0]) * rng.uniform(0.8, 1.8)
    place_m = scene.way_m[index] + offset_m * sideways(scene.way_m)[index]
    return np.tile(place_m, (len(scene.target_m), 1))


_DRAWN = {"crosser": _crosser, "oncomer": _oncomer, "follower": _follower, "walker": _walker, "stander": _stander}


def _paced_through(
    way_m: NDArray[np.float64], point_m: NDArray[np.float64], frame: int, speed_mps: float, scene: _Scene
) -> NDArray[np.float64]:
    """Return places (F, 2) on a path walked at a speed, at ``point_m`` on ``frame``; the person stands at its ends."""
    passed = int(np.linalg.norm(way_m - point_m, axis=1).argmin())
    frames = np.arange(len(scene.target_m), dtype=np.float64)
    return at_distance(way_m, STEP_M * passed + speed_mps * (frames - frame) / scene.preset.rate_hz)
