"""What the robot's drive tells about a hidden target: absences made on purpose, and a regressor for them.

A ring of people closes around the target for some seconds, so that he is hidden from everywhere. No pictures.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenarios.stereo_follow.floor_plan import draw_floor_plan
from scenarios.stereo_follow.presets import StereoFollow
from scenarios.stereo_follow.pursuit import Pursuit, draw_pursuit
from scenarios.stereo_follow.sight import seen_frames
from sim.rng import generator

RINGED = (slice(70, 115), slice(150, 195), slice(230, 275))
"""Frames on which the ring is closed."""
_RING_M, _RING_PEOPLE, _FAR_AWAY_M = 0.3, 12, 1e6
_LAGS = (0, 4, 10)
_STEP_FRAMES = 3
_GATES_S = (0.4, 1.5)
_PENALTIES = (1e-4, 1e-3, 1e-2, 1e-1, 1.0)


@dataclass(frozen=True)
class Absences:
    """N frames on which the target is not seen; places in the frame of the robot when it was last seen.

    Attributes:
        episode: (N,) its number. after_s: (N,) time since.
        known: (N, K) where the target and the robot were and how they moved, to the last sighting.
        driven: (N, D) where the robot is now and was some frames ago, and how far it had turned.
        moved_m: (N, 2) of the target since.
    """

    episode: NDArray[np.int64]
    after_s: NDArray[np.float64]
    known: NDArray[np.float64]
    driven: NDArray[np.float64]
    moved_m: NDArray[np.float64]

    def of(self, chosen: NDArray[np.bool_]) -> Absences:
        """Return some of the frames."""
        return Absences(*(values[chosen] for values in vars(self).values()))


def ring_around(target_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return places (12, F, 2) of people who stand around a target (F, 2) on some frames, otherwise far away."""
    angles = np.linspace(0.0, 2.0 * np.pi, _RING_PEOPLE, endpoint=False)
    ring_m = _RING_M * np.column_stack([np.cos(angles), np.sin(angles)])
    others_m = np.full((_RING_PEOPLE, *target_m.shape), _FAR_AWAY_M)
    for frames in RINGED:
        others_m[:, frames] = target_m[frames] + ring_m[:, None]
    return others_m


def absences(preset: StereoFollow, seeds: range) -> Absences:
    """Return the absences of episodes in which the ring closes three times."""
    rows = []
    for seed in seeds:
        plan = draw_floor_plan(generator(seed, "floor plan"))
        pursuit = draw_pursuit(preset, plan, generator(seed, "crowd"))
        others_m = ring_around(pursuit.target_m)
        pursuit = pursuit.among(others_m)
        seen = seen_frames(pursuit.robot_m, pursuit.robot_heading_rad, pursuit.target_m, others_m, plan.openings_m)
        rows += [(seed, *row) for row in _rows(pursuit, seen, preset.rate_hz)]
    episode, after_s, known, driven, moved_m = (np.array(column) for column in zip(*rows, strict=True))
    return Absences(episode, after_s, known, driven, moved_m)


def gain(development: Absences, held_out: Absences, rng: np.random.Generator) -> tuple[float, float, float]:
    """Return by which share the drive lessens the mean error on held-out episodes, and its 95 % interval over them."""
    errors_m = [_errors_m(development, held_out, with_drive=with_drive) for with_drive in (False, True)]
    episodes = np.unique(held_out.episode)
    sums_m = np.array([[error_m[held_out.episode == k].sum() for k in episodes] for error_m in errors_m])
    drawn = sums_m[:, rng.integers(len(episodes), size=(1000, len(episodes)))].sum(axis=2)
    low, high = np.percentile(1.0 - drawn[1] / drawn[0], [2.5, 97.5])
    return float(1.0 - sums_m[1].sum() / sums_m[0].sum()), float(low), float(high)


def _rows(pursuit: Pursuit, seen: NDArray[np.bool_], rate_hz: float) -> list[tuple[object, ...]]:
    """Return time, known, driven and moved of every third frame without the target, from half a second on."""
    target_m, robot_m, heading_rad = pursuit.target_m, pursuit.robot_m, pursuit.robot_heading_rad
    rows: list[tuple[object, ...]] = []
    for frame in np.flatnonzero(~seen)[::_STEP_FRAMES]:
        last = int(np.flatnonzero(seen[:frame])[-1])
        if last < 15 or frame - last < 8:
            continue
        cosine, sine = np.cos(heading_rad[last]), np.sin(heading_rad[last])
        to_robot = np.array([[cosine, -sine], [sine, cosine]])
        at_m, walked_m = (target_m[last] - robot_m[last]) @ to_robot, target_m[last] - target_m[[last - 3, last - 15]]
        rolled_m, turned_rad = (robot_m[last] - robot_m[last - 3]) @ to_robot, heading_rad[last] - heading_rad[last - 3]
        known = np.concatenate([at_m, *(walked_m @ to_robot), rolled_m, [turned_rad]])
        lagged = [max(frame - lag, last) for lag in _LAGS]
        since_m, since_rad = (robot_m[lagged] - robot_m[last]) @ to_robot, heading_rad[lagged] - heading_rad[last]
        driven = np.column_stack([since_m, np.cos(since_rad) - 1.0, np.sin(since_rad)]).ravel()
        rows.append(((frame - last) / rate_hz, known, driven, (target_m[frame] - target_m[last]) @ to_robot))
    return rows


def _errors_m(development: Absences, held_out: Absences, *, with_drive: bool) -> NDArray[np.float64]:
    """Return the errors (N,) of a ridge regression; its penalty is chosen by cross-validation over episodes."""
    inputs, wanted_m = _inputs(development, with_drive), development.moved_m
    scale = np.sqrt((inputs**2).mean(axis=0)) + 1e-9
    inputs, fold = inputs / scale, development.episode % 4

    def fit(rows: NDArray[np.bool_], penalty: float) -> NDArray[np.float64]:
        a = inputs[rows]
        return np.linalg.solve(a.T @ a + penalty * len(a) * np.eye(a.shape[1]), a.T @ wanted_m[rows])

    def left_out_m(penalty: float) -> float:
        misses_m = [inputs[fold == k] @ fit(fold != k, penalty) - wanted_m[fold == k] for k in range(4)]
        return float(np.linalg.norm(np.concatenate(misses_m), axis=1).mean())

    weights = fit(np.ones(len(inputs), dtype=np.bool_), min(_PENALTIES, key=left_out_m))
    return np.linalg.norm(_inputs(held_out, with_drive) / scale @ weights - held_out.moved_m, axis=1)


def _inputs(rows: Absences, with_drive: bool) -> NDArray[np.float64]:
    """Return the inputs (N, I): what is known, each also fading with the time since and growing with it."""
    after_s = rows.after_s[:, None]
    facts = np.column_stack([np.ones(len(after_s)), rows.known, *([rows.driven] if with_drive else [])])
    return np.concatenate([facts, facts * after_s, *(facts * np.exp(-after_s / gate_s) for gate_s in _GATES_S)], axis=1)
