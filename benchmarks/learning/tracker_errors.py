"""Error models of trackers, for envs without pictures: runs are recorded, errors sorted by mode, a model fitted."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy import stats

from benchmarks.contract.suite import controllers_suite
from benchmarks.run.editions import controller_edition
from benchmarks.run.episodes import editions_of, simulated
from benchmarks.run.selection import tracker_named
from scenarios import catalog
from scenarios.envs.follow_env import followed_episode
from scenarios.envs.pictureless.bank import pictureless_of
from scenarios.envs.pictureless.episode_state import LATENTS
from scenarios.envs.pictureless.error_model import (
    CONDITION_FRAMES,
    CUT,
    KNOT_FRAMES,
    LONG_LOST_FRAMES,
    LOST,
    PLAIN,
    PLAIN_SHARE,
    QUANTILE_Z,
    TRACKING,
    UNSEEN,
    UNSEEN_SHARE,
    WRONG,
    ErrorModel,
    model_path,
)
from scenarios.envs.pictureless.poses import camera_numbers
from scenarios.envs.settings import FollowSettings
from scenarios.loop import Loop
from scenarios.scenario import Scenario
from scenarios.visibility import is_in_view
from sim.checks import check
from sim.rng import generator
from trackers.atomic_file import atomic_file, write_atomic
from trackers.belief.kernel import SEEN_PROBABILITY, SIGHTING
from trackers.belief.sighting import sighting_of
from trackers.controllers.catalogue import controller_entry
from trackers.protocols import Controller
from trackers.types import CameraCommand, Carrier, Estimate, Observation

_FARTHEST_M = 300.0
_LEAST_SPREAD_M = 0.05


ANSWERS = (
    "along_m",
    "across_m",
    "spread_m",
    "densest_along",
    "densest_across",
    "densest_share",
    "probability",
    "length",
)
"""Columns of the random quantities of an answer, in the order of the latents."""


def errors_in(run: NDArray[np.void], carrier: Carrier, wrong_from_m: float) -> pd.DataFrame:
    """Return the modes and errors in a run (T,) of dtype ``RUN``, a line for each frame after the first.

    Its columns ``condition``, ``condition_frames``, ``mode`` and ``unsure_frames`` are those of ``ErrorModel``;
    ``known`` and ``in_picture`` are whether there is an estimate, and whether it is in the picture. Of the estimate,
    NaN without one, are ``along_m`` and ``across_m``, its error along and across the axis, ``spread_m`` and
    ``densest_share`` of the posterior, ``densest_along`` and ``densest_across`` over the spread, the ``probability``
    of being in view, and the ``length`` of the box over the target's length at that place.

    Args:
        wrong_from_m: see ``TrackerRuns``.
    """
    run = run[1:]
    sighting = run["sighting"]
    error_m, depth_m = _errors(run, carrier)
    known = (sighting["known"] > 0) & np.isfinite(error_m).all(axis=1)
    far = np.linalg.norm(error_m, axis=1)
    sure = known & (sighting["in_view_probability"] >= SEEN_PROBABILITY)
    mode = np.where(sure, np.where(far < wrong_from_m, TRACKING, WRONG), LOST)
    visible = run["visible_fraction"] * ~run["out"]
    condition = np.where(visible >= PLAIN_SHARE, PLAIN, np.where(visible < UNSEEN_SHARE, UNSEEN, CUT))
    axis_rad = _axes(run, carrier, mode)
    longest_m = np.maximum(run["size_m"][:, 0], run["size_m"][:, 2])
    unit_share = 0.5 * run["camera"][:, 0] * longest_m / np.maximum(depth_m, 1e-3) / run["camera"][:, 1]
    offset_m = np.column_stack([sighting["densest_x_m"] - sighting["x_m"], sighting["densest_y_m"] - sighting["y_m"]])
    # The measured frame differs from the true one by a shift and a fraction of a degree: directions are equal.
    densest = _turned(offset_m, axis_rad) / np.maximum(sighting["spread_m"], _LEAST_SPREAD_M)[:, None]
    if carrier.looks == "ahead":
        densest = np.zeros_like(densest)
    answers = (
        np.clip(error_m if carrier.looks == "around" else _turned(error_m, axis_rad), -_FARTHEST_M, _FARTHEST_M),
        sighting["spread_m"],
        densest,
        sighting["densest_share"],
        sighting["in_view_probability"],
        sighting["length_share"] / unit_share,
    )
    answered = pd.DataFrame(np.column_stack(answers), columns=ANSWERS)
    answered.loc[~known] = np.nan
    inside = (np.abs(np.column_stack([sighting["picture_x"], sighting["picture_y"]])) < 1.0).all(axis=1)
    return answered.assign(
        condition=condition,
        condition_frames=_frames_since(np.r_[True, condition[1:] != condition[:-1]]),
        mode=mode,
        unsure_frames=_frames_since(np.r_[True, mode == TRACKING])[1:],
        known=known,
        in_picture=known & inside,
    )


def _errors(run: NDArray[np.void], carrier: Carrier) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the errors of the tracker's places (T, 2), see ``ErrorModel``, NaN without one, and their depths (T,)."""
    R, camera_m = run["T_world_camera"][:, :, :3], run["T_world_camera"][:, :, 3]
    focal_px, half_px = run["camera"][:, :1], run["camera"][:, 1:]
    tangents = (run["estimate_px"] - half_px) / focal_px
    middle_m = run["place_m"] + [0.0, 0.0, 0.5] * run["size_m"]
    if carrier.looks == "around":
        right_m, down_m, depth_m = np.einsum("tij,ti->jt", R, middle_m - camera_m)
        return depth_m[:, None] * tangents - np.column_stack([right_m, down_m]), depth_m
    rays = np.einsum("tij,tj->ti", R, np.column_stack([tangents, np.ones(len(run))]))
    if carrier.looks == "down":
        drop_m = camera_m[:, 2] - middle_m[:, 2]
        depth_m = drop_m / np.maximum(-rays[:, 2], drop_m / _FARTHEST_M)
    else:
        sighting = run["sighting"]
        c, s = np.cos(sighting["heading_rad"]), np.sin(sighting["heading_rad"])
        # The measured camera is level: distance ahead is depth.
        depth_m = c * (sighting["x_m"] - sighting["carrier_x_m"]) + s * (sighting["y_m"] - sighting["carrier_y_m"])
    return camera_m[:, :2] + depth_m[:, None] * rays[:, :2] - middle_m[:, :2], depth_m


def _axes(run: NDArray[np.void], carrier: Carrier, mode: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the axis (T,) of each frame: that of the latest frame on which the target was tracked."""
    if carrier.looks == "around":
        return np.zeros(len(run))
    axis_rad = run["heading_rad"]
    if carrier.looks == "ahead":
        sight_m = (run["place_m"] - run["T_world_camera"][:, :, 3])[:, :2]
        axis_rad = np.arctan2(sight_m[:, 1], sight_m[:, 0])
    tracked = np.maximum.accumulate(np.where(mode == TRACKING, np.arange(len(run)), 0))
    return np.asarray(axis_rad[tracked])


def _turned(vectors_m: NDArray[np.float64], axis_rad: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return vectors (T, 2) along and across axes (T,)."""
    c, s = np.cos(axis_rad), np.sin(axis_rad)
    return np.column_stack([c * vectors_m[:, 0] + s * vectors_m[:, 1], c * vectors_m[:, 1] - s * vectors_m[:, 0]])


def _frames_since(marked: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return the number of frames since the latest mark of each; the first frame has one."""
    places = np.arange(len(marked))
    return places - np.maximum.accumulate(np.where(marked, places, 0))


_FEWEST = 25
"""Least number of frames of a distribution; fewer are pooled with the next ones."""
_SMOOTHING = 2.0
_PROBABILITIES = stats.norm.cdf(QUANTILE_Z)
_LONGEST_KEPT = 0.995


def fit(tracker: str, scenario: str, runs: Sequence[NDArray[np.void]], made: Mapping[str, Any]) -> ErrorModel:
    """Return the error model of a tracker from runs (T,) of dtype ``RUN`` each; frame 0, which is given, is left out.

    Args:
        made: provenance stored in the model.

    Raises:
        ValueError: without runs.
    """
    check("runs", len(runs) > 0, "at least one", "none")
    settings, carrier = pictureless_of(scenario).runs, catalog.scenario(scenario).carrier
    every = pd.concat(
        [errors_in(run, carrier, settings.wrong_from_m) for run in runs], keys=range(len(runs)), names=["run", "frame"]
    )
    knots = np.array(KNOT_FRAMES)
    nearest = np.searchsorted(0.5 * (knots[1:] + knots[:-1]), every["unsure_frames"])
    # The index of each frame's distribution: its condition while tracking, else the nearest knot.
    every["slot"] = np.where(every["mode"] == TRACKING, every["condition"], nearest)
    return ErrorModel(
        tracker=tracker,
        scenario=scenario,
        made=dict(made),
        rates=_rates(every),
        kept=_kept(every),
        error_m=np.stack([_by_knot(every, column) for column in ("along_m", "across_m")]),
        spread_m=_by_knot(every, "spread_m"),
        densest_share=_by_knot(every, "densest_share"),
        densest_offset=np.stack([_by_mode(every, column) for column in ("densest_along", "densest_across")]),
        probability=_probabilities(every),
        length=_by_mode(every, "length"),
        known_share=_known_shares(every),
        looked_again=_looked_again(every, settings.jump_m),
    )


def _rates(every: pd.DataFrame) -> NDArray[np.float64]:
    # Mode and age are of the frame before; the condition is of this frame.
    before = every.groupby("run")[["mode", "unsure_frames"]].shift().dropna().astype(int)
    now = every.loc[before.index]
    row = np.searchsorted(CONDITION_FRAMES, now["condition_frames"], side="right") - 1
    is_long = (before["unsure_frames"] > LONG_LOST_FRAMES).to_numpy(int)
    counts = np.zeros((3, len(CONDITION_FRAMES), 2, 3, 3))
    np.add.at(counts, (now["condition"].array, row, is_long, before["mode"].array, now["mode"].array), 1.0)
    overall = _shares(counts.sum(axis=(0, 1, 2)) + np.eye(3))
    by_condition = _shares(counts.sum(axis=(1, 2)) + _SMOOTHING * overall)
    return _shares(counts + _SMOOTHING * by_condition[:, None, None])


def _shares(counts: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(counts / counts.sum(axis=-1, keepdims=True))


def _by_knot(every: pd.DataFrame, column: str) -> NDArray[np.float64]:
    """Return quantiles (M, K, Q) of a column by mode and slot."""
    known = every[every[column].notna()]
    out = np.zeros((3, len(KNOT_FRAMES), len(QUANTILE_Z)))
    for mode, slot in np.ndindex(out.shape[:2]):
        own = known[known["mode"] == mode]
        # Too few values are pooled with those of ever more neighbours.
        apart = (own["slot"] - slot).abs()
        pools = (own[apart <= reach] for reach in range(len(KNOT_FRAMES)))
        chosen = next((pool for pool in pools if len(pool) >= _FEWEST), own)
        out[mode, slot] = _quantiles(known[known["mode"] == TRACKING] if chosen.empty else chosen, column, 0.0)
    return out


def _by_mode(every: pd.DataFrame, column: str) -> NDArray[np.float64]:
    """Return quantiles (M, Q) of a column by mode."""
    known = every[every[column].notna()]
    own = [known[known["mode"] == mode] for mode in range(3)]
    return np.stack([_quantiles(each if len(each) >= _FEWEST else known, column, 0.0) for each in own])


def _probabilities(every: pd.DataFrame) -> NDArray[np.float64]:
    known = every[every["probability"].notna()]
    out = np.zeros((3, 2, len(QUANTILE_Z)))
    for mode, inside in np.ndindex(out.shape[:2]):
        own = known[known["mode"] == mode]
        chosen = own[own["in_picture"] == inside]
        typical = 0.25 if mode == LOST else 0.75
        out[mode, inside] = _quantiles(chosen if len(chosen) >= _FEWEST else own, "probability", typical)
    return out


def _quantiles(chosen: pd.DataFrame, column: str, without: float) -> NDArray[np.float64]:
    """Return quantiles (Q,) of a column; ``without`` any line that number."""
    return np.quantile(chosen[column] if len(chosen) else [without], _PROBABILITIES)


def _known_shares(every: pd.DataFrame) -> NDArray[np.float64]:
    lost = every[every["mode"] == LOST].groupby("slot")["known"].mean()
    out = np.ones((3, len(KNOT_FRAMES)))
    out[LOST] = lost.reindex(range(len(KNOT_FRAMES))).ffill().fillna(1.0)
    return out


def _kept(every: pd.DataFrame) -> NDArray[np.float64]:
    """Return the correlations (M, 8) of neighbouring frames' normal scores."""
    alike = every.groupby(["mode", "slot"])[[*ANSWERS]]
    count = alike.transform("count")
    scores = ((alike.rank() - 0.5) / count).where(count >= 3).apply(stats.norm.ppf)
    kept = np.zeros((3, LATENTS))
    for mode in range(3):
        now = scores.where(every["mode"] == mode)
        before = now.groupby("run").shift()
        kept[mode] = [now[each].corr(before[each], min_periods=_FEWEST) for each in ANSWERS]
    kept = np.nan_to_num(kept)
    # Too few frames on a wrong target: use the correlation of a lost one.
    kept[WRONG] = np.where(kept[WRONG] == 0.0, kept[LOST], kept[WRONG])
    return np.clip(kept, 0.0, _LONGEST_KEPT)


def _looked_again(every: pd.DataFrame, jump_m: float) -> float:
    """Return the rate of jumps of a lost target's estimate when its place is in the picture in vain."""
    steps_m = every.groupby("run")[["along_m", "across_m"]].diff()
    vain = (every["mode"] == LOST) & (every["condition"] == UNSEEN) & every["in_picture"]
    vain &= every.index.get_level_values("frame") > 0
    jumps = np.hypot(steps_m["along_m"], steps_m["across_m"])[vain] > jump_m
    return float(jumps.mean()) if len(jumps) else 0.0


RUN = np.dtype(
    [
        # Of the camera that the tracker watches, with focal length, half width and half height in pixels.
        ("T_world_camera", "f8", (3, 4)),
        ("camera", "f8", (3,)),
        # Of the target's underside.
        ("place_m", "f8", (3,)),
        ("heading_rad", "f8"),
        ("size_m", "f8", (3,)),
        # NaN without an estimate.
        ("estimate_px", "f8", (2,)),
        ("visible_fraction", "f8"),
        # In the steered camera's picture; out of the watched one's.
        ("in_view", "?"),
        ("out", "?"),
        ("sighting", SIGHTING),
    ],
    align=True,
)
"""One frame."""
DISTURBED = "disturbed:"
_CALM_S, _DISTURBED_S = (2.0, 5.0), (1.0, 3.0)


class Disturbed:
    """Another controller, interrupted by random commands for a while, so that the target is lost."""

    def __init__(self, carrier: Carrier, controller: Controller, rng: np.random.Generator) -> None:
        self._carrier, self._controller, self._rng = carrier, controller, rng
        self._until_s = 0.0
        self._away: CameraCommand | None = None

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the controller's command, or the random one."""
        own = self._controller.command(observation, estimate)
        if observation.time_s >= self._until_s:
            calm = self._away is not None or self._until_s == 0.0
            self._until_s = observation.time_s + self._rng.uniform(*(_CALM_S if calm else _DISTURBED_S))
            away = {axis.name: axis.limit * float(self._rng.uniform(-1.0, 1.0)) for axis in self._carrier.axes}
            self._away = None if calm else CameraCommand(**away)
        return own if self._away is None else self._away


def run_of(settings: FollowSettings, seed: int, controller: str) -> NDArray[np.void]:
    """Run one episode; return its frames (T,) of dtype ``RUN``.

    Args:
        controller: name, with prefix ``DISTURBED`` for random interruptions.
    """
    followed = catalog.scenario(settings.scenario)
    carrier = followed.carrier
    name = controller.removeprefix(DISTURBED)
    own: Controller = controller_entry(name, carrier.name).create()
    if name != controller:
        own = Disturbed(carrier, own, generator(seed, "disturbance"))
    loop = followed_episode(settings, seed)
    frames = [_frame(followed, loop) for _ in loop.frames(own)]
    loop.episode.close()
    return np.concatenate(frames)


def write_runs(
    settings: FollowSettings,
    seeds: range,
    controllers: list[str],
    folder: Path,
    report: Callable[[int, int], None] = lambda done, of: None,
) -> list[Path]:
    """Write a run of every seed, the controllers in turn, to ``folder``; runs of the same editions are reused.

    ``report`` is called with (runs done, all).
    """
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for k, seed in enumerate(seeds):
        report(k, len(seeds))
        controller = controllers[k % len(controllers)]
        path = folder / f"{settings.scenario}-{settings.preset_name}-{seed}-{_file_name(settings, controller)}.npy"
        if not path.exists():
            run = run_of(settings, seed, controller)
            with atomic_file(path) as file:
                np.save(file, run, allow_pickle=False)
        paths.append(path)
    report(len(seeds), len(seeds))
    return paths


def read_run(path: Path) -> NDArray[np.void]:
    """Return the frames (T,) that ``write_runs`` wrote. Raises ValueError for another file."""
    run: NDArray[np.void] = np.load(path, allow_pickle=False)
    check("path", run.dtype == RUN, "a run written by write_runs", path)
    return run


def _file_name(settings: FollowSettings, controller: str) -> str:
    """Return a run's name: the controller, and a digest of all settings and editions."""
    carrier = catalog.scenario(settings.scenario).carrier
    steering = controller_entry(controller.removeprefix(DISTURBED), carrier.name)
    tracker = tracker_named(str(settings.tracker))
    episode = simulated(settings.scenario, settings.preset_name, 0)
    made = editions_of(controllers_suite(), episode, tracker) | controller_edition(steering)
    digest = hashlib.sha256(f"{settings!r}/{made!r}/{RUN}".encode()).hexdigest()[:10]
    return f"{controller.replace(':', '-')}-{digest}"


def _frame(followed: Scenario, loop: Loop) -> NDArray[np.void]:
    truth, estimate = loop.frame.truth, loop.estimate
    (judged, camera), target = loop.frame.judged, truth.index_of(followed.target)
    # As if the tracker's camera were the steered one.
    observation = replace(loop.frame.observation, steered=None)
    row = np.zeros(1, RUN)
    values: dict[str, Any] = {
        "T_world_camera": truth.T_world_camera[:3],
        "camera": camera_numbers(observation.camera),
        "place_m": truth.T_world_object[target, :3, 3],
        "heading_rad": np.arctan2(truth.T_world_object[target, 1, 0], truth.T_world_object[target, 0, 0]),
        "size_m": truth.size_m[target],
        "estimate_px": estimate.position_px,
        "visible_fraction": truth.visible_fraction[target],
        "in_view": is_in_view(judged, target, camera, followed.widest_view_m),
        "out": truth.state[target] == "out",
        "sighting": sighting_of(followed.carrier.looks, observation, estimate),
    }
    for name, value in values.items():
        row[name][0] = value
    return row


def make_error_model(settings: FollowSettings, seeds: range, folder: Path, report: Callable[[int, int], None]) -> Path:
    """Run one episode with pictures for each seed, fit the model to these runs, put it at its place in the package.

    Args:
        seeds: of development episodes. folder: where runs are kept; runs of the same editions are reused.
        report: called with (episodes done, all).

    Returns:
        The model's file.
    """
    controllers = list(pictureless_of(settings.scenario).runs.controllers)
    model = model_of(settings, write_runs(settings, seeds, controllers, folder, report))
    path = model_path(model.scenario, model.tracker)
    write_atomic(path, model.to_json())
    return path


def model_of(settings: FollowSettings, paths: Sequence[Path]) -> ErrorModel:
    """Return the model fitted to runs of ``write_runs`` with these settings."""
    runs = [read_run(path) for path in paths]
    made = {
        "by": "benchmarks.learning.tracker_errors",
        "preset": settings.preset_name,
        "frames": sum(len(run) - 1 for run in runs),
        "runs": [path.stem.removeprefix(f"{settings.scenario}-") for path in paths],
    }
    return fit(settings.tracker, settings.scenario, runs, made)
