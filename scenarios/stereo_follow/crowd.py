"""The paths of the target, of the robot that follows it, and of other people who get in between."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, gaussian_filter1d

from scenarios.stereo_follow.floor_plan import FloorPlan
from scenarios.stereo_follow.presets import StereoFollow
from scenarios.stereo_follow.pursuit import NEAREST_M, SEEN_AT_FIRST_FRAMES, Pursuit, draw_pursuit
from scenarios.stereo_follow.walks import STEP_M, Walk, at_distance, rounded_way, sideways, walk_of

KINDS = ("target", "follower", "oncomer", "crosser", "stander", "walker")
"""Parts that people play."""
_APART_M = {"target": 0.55, "robot": 0.6, "other": 0.5}
_TRIES = 40
_CLEAR_SIGHT_M = 0.7
_MAKES_WAY_FRAMES = 12
_CHANGES_SIDE_S, _FASTEST_WALK_MPS = 0.4, 1.9


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
    """Draw all paths. People keep the distances of a crowd to the target, to the robot and to each other.

    Each person is drawn around the drive among those before him; then the robot is driven again among all of them.
    """
    scene = _Scene(preset, plan, draw_pursuit(preset, plan, rng))
    kinds = ["target"]
    walks = [walk_of(scene.target_m, preset.rate_hz)]
    for kind, count in (
        ("follower", preset.followers),
        ("oncomer", preset.oncomers),
        ("crosser", preset.crossers),
        ("stander", preset.standers),
        ("walker", preset.walkers),
    ):
        for _ in range(count):
            with_him = _first_that_fits(scene, _DRAWN[kind], rng)
            if with_him is not None:
                scene = with_him
                walks.append(walk_of(scene.others_m[-1], preset.rate_hz, rng.uniform(-np.pi, np.pi)))
                kinds.append(kind)
    return Crowd(tuple(walks), tuple(kinds), scene.robot_m, scene.pursuit.robot_heading_rad)


@dataclass(frozen=True, slots=True)
class _Scene:
    """Target, robot and the others so far (F, 2) each, around which another person's path is drawn."""

    preset: StereoFollow
    plan: FloorPlan
    pursuit: Pursuit
    others_m: tuple[NDArray[np.float64], ...] = ()

    @property
    def way_m(self) -> NDArray[np.float64]:
        return self.pursuit.way_m

    @property
    def along_m(self) -> NDArray[np.float64]:
        return self.pursuit.along_m

    @property
    def target_m(self) -> NDArray[np.float64]:
        return self.pursuit.target_m

    @property
    def robot_m(self) -> NDArray[np.float64]:
        return self.pursuit.robot_m

    def with_person(self, place_m: NDArray[np.float64]) -> _Scene:
        """Return the scene with another person (F, 2), whom the driver sees."""
        others_m = (*self.others_m, place_m)
        return replace(self, others_m=others_m, pursuit=self.pursuit.among(others_m))


def _first_that_fits(
    scene: _Scene,
    draw: Callable[[_Scene, np.random.Generator], NDArray[np.float64] | None],
    rng: np.random.Generator,
) -> _Scene | None:
    """Return the scene with one more person, the first of some draws that keeps its distances; None if none does."""
    for _ in range(_TRIES):
        place_m = draw(scene, rng)
        if place_m is None or not scene.plan.is_free(place_m).all() or _hides_at_first(scene, place_m):
            continue
        if not _keeps_off(scene, place_m):
            continue
        with_him = scene.with_person(place_m)
        if with_him.pursuit.nearest_m < min(scene.pursuit.nearest_m, NEAREST_M):
            continue
        if all(_is_apart(with_him.robot_m, other_m, _APART_M["robot"]) for other_m in with_him.others_m):
            return with_him
    return None


def _keeps_off(scene: _Scene, place_m: NDArray[np.float64]) -> bool:
    """Return whether a person at places (F, 2) keeps the distances of a crowd."""
    near = [(scene.target_m, _APART_M["target"]), (scene.robot_m, _APART_M["robot"])]
    near += [(other_m, _APART_M["other"]) for other_m in scene.others_m]
    return all(_is_apart(place_m, other_m, apart_m) for other_m, apart_m in near)


def _is_apart(place_m: NDArray[np.float64], other_m: NDArray[np.float64], apart_m: float) -> bool:
    return bool(np.linalg.norm(place_m - other_m, axis=1).min() > apart_m)


def _hides_at_first(scene: _Scene, place_m: NDArray[np.float64]) -> bool:
    """Return whether a person at places (F, 2) is near the line of sight to the target on the first frames."""
    first = slice(0, SEEN_AT_FIRST_FRAMES)
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
    come_m, go_m = (plan.draw_place(plan.room_of(middle_m), rng) for _ in range(2))
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
    plan, rooms = scene.plan, scene.plan.walked
    frame = int(rng.uniform(0.0, 1.0) * (len(scene.target_m) - 1))
    here = plan.room_of(scene.target_m[frame])
    stops_m = [plan.draw_place(rooms[rng.integers(len(rooms))], rng), plan.draw_place(here, rng)]
    stops_m.append(plan.draw_place(rooms[rng.integers(len(rooms))], rng))
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
