"""Fit of a tracker's error model to runs of the rendered env, by counting.

Modes follow from estimates and truth (``tracker_errors``); rates of modes are counted frame pairs, smoothed towards
those of the same condition at any age; distributions are sample quantiles; the frame-to-frame correlation of a latent
number is that of the normal scores of neighbouring frames in the same mode.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from benchmarks.learning.tracker_errors import TrackerErrors, errors_in
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
    KNOT_FRAMES,
    LONG_LOST_FRAMES,
    LOST,
    QUANTILE_Z,
    TRACKING,
    UNSEEN,
    WRONG,
    ErrorModel,
)
from sim.checks import check

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
