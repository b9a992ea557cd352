"""Error models of trackers, for envs without pictures: runs are recorded, errors are told apart, a model is fitted."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from benchmarks.contract.suite import controllers_suite
from benchmarks.run.editions import controller_edition
from benchmarks.run.episodes import editions_of, simulated
from benchmarks.run.selection import tracker_named
from scenarios import catalog
from scenarios.envs.pictureless.bank import pictureless_of
from scenarios.envs.pictureless.episode_state import (
    ACROSS,
    ALONG,
    DENSEST_ACROSS,
    DENSEST_ALONG,
    DENSEST_SHARE,
    LATENTS,
    LENGTH,
    PROBABILITY,
    SPREAD,
)
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
from scenarios.envs.settings import FollowSettings
from scenarios.envs.watched_episode import watched_episode
from scenarios.in_view import is_in_view
from scenarios.loop import Loop
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
_OFF_BORDER = 0.05


@dataclass(frozen=True, eq=False)
class TrackerErrors:
    """Modes and errors on N frames.

    Attributes:
        condition, condition_frames, mode, unsure_frames: see ``ErrorModel``.
        known, in_picture: whether there is an estimate, and whether it is in the picture.
        error_m: (N, 2) of the place, along and across the axis; NaN without an estimate.
        spread_m, share: (N, 1) of the posterior. densest_offset: (N, 2) over the spread.
        probability: (N,). length: (N, 1) of the box over the target's length at that place.
    """

    condition: NDArray[np.int64]
    condition_frames: NDArray[np.int64]
    mode: NDArray[np.int64]
    unsure_frames: NDArray[np.int64]
    known: NDArray[np.bool_]
    in_picture: NDArray[np.bool_]
    error_m: NDArray[np.float64]
    spread_m: NDArray[np.float64]
    share: NDArray[np.float64]
    densest_offset: NDArray[np.float64]
    probability: NDArray[np.float64]
    length: NDArray[np.float64]

    @staticmethod
    def joined(parts: Sequence[TrackerErrors]) -> TrackerErrors:
        """Return the frames of all parts, concatenated."""
        names = [field.name for field in dataclasses.fields(TrackerErrors)]
        return TrackerErrors(**{name: np.concatenate([getattr(part, name) for part in parts]) for name in names})


def errors_in(run: NDArray[np.void], carrier: Carrier, wrong_from_m: float) -> TrackerErrors:
    """Return the errors in a run (T,) of dtype ``RUN`` after its first frame (T - 1 frames).

    Args:
        wrong_from_m: see ``TrackerRuns``.
    """
    run = run[1:]
    sighting = run["sighting"]
    focal_px, half_px = _camera(run, carrier)
    place_m, depth_m = _places(run, carrier, focal_px, half_px)
    known = (sighting["known"] > 0) & np.isfinite(place_m).all(axis=1)
    error_m = place_m - run["place_m"]
    far = np.linalg.norm(error_m, axis=1)
    sure = known & (sighting["in_view_probability"] >= SEEN_PROBABILITY)
    mode = np.where(sure, np.where(far < wrong_from_m, TRACKING, WRONG), LOST)
    visible = run["visible_fraction"] * ~run["out"]
    condition = np.where(visible >= PLAIN_SHARE, PLAIN, np.where(visible < UNSEEN_SHARE, UNSEEN, CUT))
    unsure = _since(mode != TRACKING)
    axis_rad = _axes(run, carrier, mode)
    longest_m = np.maximum(run["size_m"][:, 0], run["size_m"][:, 2])
    unit_share = 0.5 * focal_px * longest_m / np.maximum(depth_m, 1e-3) / half_px[0]
    offset_m = np.column_stack([sighting["densest_x_m"] - sighting["x_m"], sighting["densest_y_m"] - sighting["y_m"]])
    nothing = ~known[:, None]
    spread_m = sighting["spread_m"][:, None]
    # The measured frame differs from the true one by a shift and a fraction of a degree: directions are equal.
    densest = _turned(offset_m, axis_rad) / np.maximum(spread_m, _LEAST_SPREAD_M)
    if carrier.looks == "ahead":
        densest = np.zeros_like(densest)
    return TrackerErrors(
        condition=condition,
        condition_frames=_run_lengths(condition),
        mode=mode,
        unsure_frames=unsure,
        known=known,
        in_picture=known & (np.abs(np.column_stack([sighting["picture_x"], sighting["picture_y"]])) < 1.0).all(axis=1),
        error_m=np.where(nothing, np.nan, np.clip(_turned(error_m, axis_rad), -_FARTHEST_M, _FARTHEST_M)),
        spread_m=np.where(nothing, np.nan, spread_m),
        share=np.where(nothing, np.nan, sighting["densest_share"][:, None]),
        densest_offset=np.where(nothing, np.nan, densest),
        probability=np.where(known, sighting["in_view_probability"], np.nan),
        length=np.where(nothing, np.nan, (sighting["length_share"] / unit_share)[:, None]),
    )


def _camera(run: NDArray[np.void], carrier: Carrier) -> tuple[float, NDArray[np.float64]]:
    """Return focal length and half the picture's size (2,), pixels, from sightings."""
    sighting = run["sighting"]
    # From the picture's corner, in halves of its width and height; near the border the quotient is undefined.
    shares = 1.0 + np.column_stack([sighting["picture_x"], sighting["picture_y"]])
    known = np.flatnonzero((sighting["known"] > 0) & (np.abs(shares) > _OFF_BORDER).all(axis=1))
    check("run", len(known) > 0, "one with estimates of the tracker", "none")
    half_px = np.median(run["estimate_px"][known] / shares[known], axis=0)
    first = known[0]
    reach_m = sighting["height_m"][first] if carrier.looks == "down" else 1.0
    return float(half_px[0] * reach_m / sighting["half_right_m"][first]), half_px


def _places(
    run: NDArray[np.void], carrier: Carrier, focal_px: float, half_px: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the tracker's places in the true world (T, 2) and their depths (T,); NaN without one."""
    R, camera_m = run["T_world_camera"][:, :, :3], run["T_world_camera"][:, :, 3]
    tangents = (run["estimate_px"] - half_px) / focal_px
    rays = np.einsum("tij,tj->ti", R, np.column_stack([tangents, np.ones(len(run))]))
    if carrier.looks == "down":
        drop_m = camera_m[:, 2] - 0.5 * run["size_m"][:, 2]
        depth_m = drop_m / np.maximum(-rays[:, 2], drop_m / _FARTHEST_M)
    else:
        sighting = run["sighting"]
        c, s = np.cos(sighting["heading_rad"]), np.sin(sighting["heading_rad"])
        # The measured camera is level: distance ahead is depth.
        depth_m = c * (sighting["x_m"] - sighting["carrier_x_m"]) + s * (sighting["y_m"] - sighting["carrier_y_m"])
    return camera_m[:, :2] + depth_m[:, None] * rays[:, :2], depth_m


def _axes(run: NDArray[np.void], carrier: Carrier, mode: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the axis (T,) of each frame: that of the latest frame on which the target was tracked."""
    axis_rad = run["heading_rad"]
    if carrier.looks == "ahead":
        sight_m = run["place_m"] - run["T_world_camera"][:, :2, 3]
        axis_rad = np.arctan2(sight_m[:, 1], sight_m[:, 0])
    tracked = np.maximum.accumulate(np.where(mode == TRACKING, np.arange(len(run)), 0))
    return np.asarray(axis_rad[tracked])


def _turned(vectors_m: NDArray[np.float64], axis_rad: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return vectors (T, 2) along and across axes (T,)."""
    c, s = np.cos(axis_rad), np.sin(axis_rad)
    return np.column_stack([c * vectors_m[:, 0] + s * vectors_m[:, 1], c * vectors_m[:, 1] - s * vectors_m[:, 0]])


def _since(flags: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return the number of frames since a flag was set, 0 where it is not."""
    places = np.arange(1, len(flags) + 1)
    return places - np.maximum.accumulate(np.where(flags, 0, places))


def _run_lengths(values: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the number of frames since each value changed, 0 on the first."""
    places = np.arange(len(values))
    return places - np.maximum.accumulate(np.where(np.r_[True, values[1:] != values[:-1]], places, 0))


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
    parts = [errors_in(run, carrier, settings.wrong_from_m) for run in runs]
    every = TrackerErrors.joined(parts)
    error, spread, share = _by_knot(every, every.error_m), _by_knot(every, every.spread_m), _by_knot(every, every.share)
    return ErrorModel(
        tracker=tracker,
        scenario=scenario,
        made=dict(made),
        rates=_rates(parts),
        kept=_kept(parts),
        error_m=np.moveaxis(error, -1, 0),
        spread_m=spread[..., 0],
        densest_share=share[..., 0],
        densest_offset=np.moveaxis(_by_mode(every, every.densest_offset), -1, 0),
        probability=_probabilities(every),
        length=_by_mode(every, every.length)[..., 0],
        known_share=_known_shares(every),
        looked_again=_looked_again(parts, settings.jump_m),
    )


def _rates(parts: Sequence[TrackerErrors]) -> NDArray[np.float64]:
    counts = np.zeros((3, len(CONDITION_FRAMES), 2, 3, 3))
    for run in parts:
        row = np.searchsorted(CONDITION_FRAMES, run.condition_frames, side="right") - 1
        is_long = (run.unsure_frames > LONG_LOST_FRAMES).astype(int)
        # Mode and age are of the frame before; the condition is of this frame.
        np.add.at(counts, (run.condition[1:], row[1:], is_long[:-1], run.mode[:-1], run.mode[1:]), 1.0)
    overall = counts.sum(axis=(0, 1, 2)) + np.eye(3)
    overall /= overall.sum(axis=-1, keepdims=True)
    by_condition = counts.sum(axis=(1, 2)) + _SMOOTHING * overall
    by_condition /= by_condition.sum(axis=-1, keepdims=True)
    rates = counts + _SMOOTHING * by_condition[:, None, None]
    return np.asarray(rates / rates.sum(axis=-1, keepdims=True))


def _slots(errors: TrackerErrors) -> NDArray[np.int64]:
    """Return the distribution's index (N,) of each frame: its condition while tracking, else the nearest knot."""
    knots = np.array(KNOT_FRAMES)
    nearest = np.searchsorted(0.5 * (knots[1:] + knots[:-1]), errors.unsure_frames)
    return np.where(errors.mode == TRACKING, errors.condition, nearest)


def _by_knot(errors: TrackerErrors, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return quantiles (M, K, Q, V) of values (N, V) by mode and slot."""
    slots, knots = _slots(errors), len(KNOT_FRAMES)
    known = np.isfinite(values).all(axis=1)
    out = np.zeros((3, knots, len(QUANTILE_Z), values.shape[1]))
    for mode in range(3):
        own = known & (errors.mode == mode)
        for slot in range(knots):
            # Too few values are pooled with those of ever more neighbours.
            for reach in range(knots + 1):
                chosen = values[own & (np.abs(slots - slot) <= reach)]
                if len(chosen) >= _FEWEST:
                    break
            else:
                chosen = values[own] if own.any() else values[known & (errors.mode == TRACKING)]
            out[mode, slot] = np.quantile(chosen, _PROBABILITIES, axis=0) if len(chosen) else 0.0
    return out


def _by_mode(errors: TrackerErrors, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return quantiles (M, Q, V) of values (N, V) by mode."""
    known = np.isfinite(values).all(axis=1)
    out = np.zeros((3, len(QUANTILE_Z), values.shape[1]))
    for mode in range(3):
        own = known & (errors.mode == mode)
        chosen = values[own] if own.sum() >= _FEWEST else values[known]
        out[mode] = np.quantile(chosen, _PROBABILITIES, axis=0)
    return out


def _probabilities(errors: TrackerErrors) -> NDArray[np.float64]:
    out = np.zeros((3, 2, len(QUANTILE_Z)))
    known = np.isfinite(errors.probability)
    for mode in range(3):
        own = known & (errors.mode == mode)
        for inside in range(2):
            chosen = errors.probability[own & (errors.in_picture == inside)]
            chosen = chosen if len(chosen) >= _FEWEST else errors.probability[own]
            typical = 0.25 if mode == LOST else 0.75
            out[mode, inside] = np.quantile(chosen, _PROBABILITIES) if len(chosen) else typical
    return out


def _known_shares(errors: TrackerErrors) -> NDArray[np.float64]:
    slots = _slots(errors)
    out = np.ones((3, len(KNOT_FRAMES)))
    for slot in range(len(KNOT_FRAMES)):
        own = (errors.mode == LOST) & (slots == slot)
        if own.sum() > 0:
            out[LOST, slot] = errors.known[own].mean()
        elif slot > 0:
            out[LOST, slot] = out[LOST, slot - 1]
    return out


def _kept(parts: Sequence[TrackerErrors]) -> NDArray[np.float64]:
    """Return the correlations (M, 8) of neighbouring frames' normal scores."""
    every = TrackerErrors.joined(parts)
    # Runs are concatenated: the last frame of one is no neighbour of the first of the next.
    follows = np.concatenate([np.r_[False, np.ones(len(run.mode) - 1, bool)] for run in parts])[1:]
    columns = {
        ALONG: every.error_m[:, 0],
        ACROSS: every.error_m[:, 1],
        SPREAD: every.spread_m[:, 0],
        DENSEST_ALONG: every.densest_offset[:, 0],
        DENSEST_ACROSS: every.densest_offset[:, 1],
        DENSEST_SHARE: every.share[:, 0],
        PROBABILITY: every.probability,
        LENGTH: every.length[:, 0],
    }
    slots, kept = _slots(every), np.zeros((3, LATENTS))
    for latent, values in columns.items():
        for mode in range(3):
            scores = np.full(len(values), np.nan)
            for slot in range(len(KNOT_FRAMES)):
                own = (every.mode == mode) & (slots == slot) & np.isfinite(values)
                if own.sum() >= 3:
                    scores[own] = stats.norm.ppf((stats.rankdata(values[own]) - 0.5) / own.sum())
            both = follows & np.isfinite(scores[1:]) & np.isfinite(scores[:-1])
            if both.sum() >= _FEWEST and np.std(scores[1:][both]) > 0 and np.std(scores[:-1][both]) > 0:
                kept[mode, latent] = np.corrcoef(scores[1:][both], scores[:-1][both])[0, 1]
    # Too few frames on a wrong target: use the correlation of a lost one.
    kept[WRONG] = np.where(kept[WRONG] == 0.0, kept[LOST], kept[WRONG])
    return np.clip(kept, 0.0, _LONGEST_KEPT)


def _looked_again(parts: Sequence[TrackerErrors], jump_m: float) -> float:
    """Return the rate of jumps of a lost target's estimate when its place is in the picture in vain."""
    jumps, frames = 0, 0
    for run in parts:
        vain = (run.mode == LOST) & (run.condition == UNSEEN) & run.in_picture
        step_m = np.linalg.norm(np.diff(run.error_m, axis=0), axis=1)
        frames += int(vain[1:].sum())
        jumps += int((step_m[vain[1:]] > jump_m).sum())
    return jumps / max(frames, 1)


_LATER = ("depth_m", "axis_depth_m")
"""Fields of a sighting that no run holds, so that runs recorded before stay readable."""
RECORDED = [name for name in SIGHTING.names or () if name not in _LATER]
"""Fields of a sighting that a run holds."""
RUN = np.dtype(
    [
        ("T_world_camera", "f8", (3, 4)),
        ("place_m", "f8", (2,)),
        ("heading_rad", "f8"),
        ("size_m", "f8", (3,)),
        # Of the target's centre, and the estimate; NaN behind the camera, and without an estimate.
        ("position_px", "f8", (2,)),
        ("estimate_px", "f8", (2,)),
        ("visible_fraction", "f8"),
        ("in_view", "?"),
        ("out", "?"),
        ("sighting", np.dtype([(name, SIGHTING[name]) for name in RECORDED], align=True)),
        # As obeyed: forward, right, climb, yaw rate.
        ("command", "f8", (4,)),
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
    carrier = catalog.scenario(settings.scenario).carrier
    name = controller.removeprefix(DISTURBED)
    own: Controller = controller_entry(name, carrier.name).create()
    if name != controller:
        own = Disturbed(carrier, own, generator(seed, "disturbance"))
    loop = watched_episode(settings, seed)
    target = catalog.scenario(settings.scenario).target
    frames = [_frame(carrier, target, loop) for _ in loop.frames(own)]
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
    digest = hashlib.sha256(f"{settings!r}/{made!r}".encode()).hexdigest()[:10]
    return f"{controller.replace(':', '-')}-{digest}"


def _frame(carrier: Carrier, target_name: str, loop: Loop) -> NDArray[np.void]:
    (truth, camera), estimate = loop.frame.judged, loop.estimate
    target, obeyed = truth.index_of(target_name), loop.obeyed or CameraCommand()
    row = np.zeros(1, RUN)
    values: dict[str, Any] = {
        "T_world_camera": truth.T_world_camera[:3],
        "place_m": truth.T_world_object[target, :2, 3],
        "heading_rad": np.arctan2(truth.T_world_object[target, 1, 0], truth.T_world_object[target, 0, 0]),
        "size_m": truth.size_m[target],
        "position_px": truth.position_px[target],
        "estimate_px": estimate.position_px,
        "visible_fraction": truth.visible_fraction[target],
        "in_view": is_in_view(truth, target, camera),
        "out": truth.state[target] == "out",
        "sighting": sighting_of(carrier.looks, loop.frame.observation, estimate)[RECORDED],
        "command": [obeyed.forward_mps, obeyed.right_mps, obeyed.climb_mps, obeyed.yaw_rate_rad_s],
    }
    for name, value in values.items():
        row[name][0] = value
    return row


def make_error_model(
    settings: FollowSettings, seeds: range, folder: Path, report: Callable[[int, int], None]
) -> ErrorModel:
    """Run one episode with pictures for each seed and return the model fitted to these runs.

    Args:
        seeds: of development episodes. folder: where runs are kept; runs of the same editions are reused.
        report: called with (episodes done, all).
    """
    controllers = list(pictureless_of(settings.scenario).runs.controllers)
    return model_of(settings, write_runs(settings, seeds, controllers, folder, report))


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


def save_error_model(model: ErrorModel) -> Path:
    """Write a model to its place in the package; return its file."""
    path = model_path(model.scenario, model.tracker)
    write_atomic(path, model.to_json())
    return path
