"""How fish move, in numbers that a simulated and a measured table of tracks can be compared by.

Nothing but positions goes in, so that truth, detections and files of real tracks give the same numbers. Steps between
unmeasured frames count nowhere.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.checks import check

TURN_FRAMES = 5
LAGS = (5, 50, 100, 200)
STRAIGHT_FRAMES = (50, 100, 200)
SPEED_PERCENTILES = (5, 50, 95)
VELOCITY_FRAMES = 5
"""Velocities are means over so many frames, so that the noise of single positions does not count as turning."""
_STRIDE_FRAMES = 25

Array = NDArray[np.float64]


def motion_statistics(position_px: Array, body_px: float) -> dict[str, float]:
    """Return the statistics of tracks by name; NaN where no track is long enough.

    ``speed p50``: percentile of the length of a step, px a frame. ``turn 5``: median change of heading over 5 frames,
    degrees. ``heading 50``: mean cosine of that over 50 frames.
    ``velocity 50`` and ``speed 50``: autocorrelation of the velocity, and of the speed about its mean.
    ``straightness 50``: mean of the way as the crow flies over the way swum in 50 frames. ``wall p50``: median of
    the distance to the nearest side of the box of all positions, px. ``pairs nearer than half a body``: share of time;
    unmeasured frames between measured ones are filled in straight for it, since trackers lose fish just then.

    Args:
        position_px: (T, N, 2), NaN where not measured.
        body_px: length of the fish.
    """
    shape = np.shape(position_px)
    check("position_px", len(shape) == 3 and shape[2] == 2 and shape[1] > 0, "shape (T, N, 2)", shape)
    check("body_px", body_px > 0, "a length > 0 px", body_px)
    step_px = np.linalg.norm(np.diff(position_px, axis=0), axis=2)
    found = {f"speed p{p}": _percentile(step_px, p) for p in SPEED_PERCENTILES}
    velocity_px = (position_px[VELOCITY_FRAMES:] - position_px[:-VELOCITY_FRAMES]) / VELOCITY_FRAMES
    found[f"turn {TURN_FRAMES}"] = _turning_deg(velocity_px)
    found |= _autocorrelations(velocity_px)
    for count in STRAIGHT_FRAMES:
        found[f"straightness {count}"] = _straightness(position_px, step_px, count)
    found["wall p50"] = _percentile(_wall_distance(position_px), 50)
    found["pairs nearer than half a body"] = _share_of_meetings(position_px, 0.5 * body_px)
    return found


def _turning_deg(velocity_px: Array) -> float:
    heading = np.arctan2(velocity_px[..., 1], velocity_px[..., 0])
    turn = np.abs((heading[TURN_FRAMES:] - heading[:-TURN_FRAMES] + np.pi) % (2.0 * np.pi) - np.pi)
    return float(np.rad2deg(_percentile(turn, 50)))


def _autocorrelations(velocity_px: Array) -> dict[str, float]:
    speed_px = np.linalg.norm(velocity_px, axis=2)
    ahead = velocity_px / np.where(speed_px > 0.0, speed_px, np.nan)[..., None]
    about_mean = speed_px - _mean(speed_px)
    found = {}
    for lag in LAGS:
        found[f"heading {lag}"] = _mean((ahead[lag:] * ahead[:-lag]).sum(axis=2))
        found[f"velocity {lag}"] = _ratio((velocity_px[lag:] * velocity_px[:-lag]).sum(axis=2), speed_px**2)
        found[f"speed {lag}"] = _ratio(about_mean[lag:] * about_mean[:-lag], about_mean**2)
    return found


def _straightness(position_px: Array, step_px: Array, count: int) -> float:
    """Return the mean over all windows of ``count`` steps without an unmeasured frame, ``_STRIDE_FRAMES`` apart."""
    firsts = np.arange(0, len(step_px) - count + 1, _STRIDE_FRAMES)
    swum_px = np.array([step_px[first : first + count].sum(axis=0) for first in firsts])
    apart_px = np.linalg.norm(position_px[firsts + count] - position_px[firsts], axis=2)
    moved = swum_px > 0.0
    return _mean(apart_px[moved] / swum_px[moved]) if len(firsts) else np.nan


def _wall_distance(position_px: Array) -> Array:
    flat = position_px.reshape(-1, 2)
    low, high = np.nanmin(flat, axis=0), np.nanmax(flat, axis=0)
    distance_px: Array = np.minimum(flat - low, high - flat).min(axis=1)
    return distance_px


def _share_of_meetings(position_px: Array, near_px: float) -> float:
    count = position_px.shape[1]
    if count < 2:
        return np.nan
    filled = np.stack([_filled(position_px[:, n]) for n in range(count)], axis=1)
    first, second = np.triu_indices(count, 1)
    apart_px = np.linalg.norm(filled[:, first] - filled[:, second], axis=2)
    return float((apart_px < near_px).sum() / max(np.isfinite(apart_px).sum(), 1))


def _filled(track_px: Array) -> Array:
    """Return a track (T, 2) with straight lines over unmeasured frames, but before the first and after the last."""
    frames = np.arange(len(track_px))
    known = np.isfinite(track_px[:, 0])
    if not known.any():
        return track_px
    columns = [np.interp(frames, frames[known], track_px[known, k], np.nan, np.nan) for k in range(2)]
    return np.column_stack(columns)


def _percentile(values: Array, percent: float) -> float:
    known = values[np.isfinite(values)]
    return float(np.percentile(known, percent)) if known.size else np.nan


def _mean(values: Array) -> float:
    known = values[np.isfinite(values)]
    return float(known.mean()) if known.size else np.nan


def _ratio(products: Array, squares: Array) -> float:
    mean_square = _mean(squares)
    return _mean(products) / mean_square if mean_square > 0.0 else np.nan
