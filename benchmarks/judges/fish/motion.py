"""How fish swim, in numbers that a simulated and a measured table of tracks can be compared by.

Nothing but positions goes in, so that truth, detections and files of real tracks give the same numbers. Steps between
unmeasured frames count nowhere.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import inf

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import Score
from benchmarks.contract.metric import OWN, Mean, Metric, Quantity

ANY = "any"
LAGS = (5, 50, 100, 200)
VELOCITY_FRAMES = 5
"""Velocities are means over so many frames, so that the noise of single positions does not count as turning."""
_TURN_FRAMES = 5
_STRIDE_FRAMES = 25

Array = NDArray[np.float64]


def motion_scores(position_px: Array, body_px: float | None) -> Iterator[Score]:
    """Yield ``motion_NAME_LINE`` of the places (T, N, 2) of all fish, NaN where they were not measured.

    Over L frames: ``motion_turn_L``, median change of direction, degrees; ``motion_heading_L``, mean cosine of that;
    ``motion_velocity_L`` and ``motion_speed_L``, autocorrelation of the velocity, and of the speed about its mean;
    ``motion_straightness_L``, mean of the way as the crow flies over the way swum. Over all frames:
    ``motion_step_p5_any``, ``p50`` and ``p95``, percentiles of the length of a step, px a frame;
    ``motion_wall_p50_any``, median of the distance to the nearest side of the box of all positions, px; and
    ``motion_meetings_any``, the share of time that two fish are nearer than half of ``body_px``, the length of a body,
    where that is known; unmeasured frames between measured ones are filled in straight for it, since trackers lose fish
    just then. What no track is long enough for is left out.
    """
    for name, value in _statistics(position_px, body_px).items():
        if np.isfinite(value):
            yield Score(f"motion_{name}", float(value))


def _statistics(position_px: Array, body_px: float | None) -> dict[str, float]:
    """Return the statistics by name; NaN where no track is long enough."""
    step_px = np.linalg.norm(np.diff(position_px, axis=0), axis=2)
    velocity_px = (position_px[VELOCITY_FRAMES:] - position_px[:-VELOCITY_FRAMES]) / VELOCITY_FRAMES
    heading = np.arctan2(velocity_px[..., 1], velocity_px[..., 0])
    turn = np.abs((heading[_TURN_FRAMES:] - heading[:-_TURN_FRAMES] + np.pi) % (2.0 * np.pi) - np.pi)
    speed_px = np.linalg.norm(velocity_px, axis=2)
    ahead = velocity_px / np.where(speed_px > 0.0, speed_px, np.nan)[..., None]
    about_mean = (speed_px - _mean(speed_px))[..., None]
    places = position_px.reshape(-1, 2)
    low, high = np.nanmin(places, axis=0), np.nanmax(places, axis=0)
    return {
        f"turn_{_TURN_FRAMES}": np.rad2deg(_percentile(turn, 50)),
        **{f"heading_{lag}": _mean(_products(ahead, lag)) for lag in LAGS},
        **{f"velocity_{lag}": _autocorrelation(velocity_px, lag, speed_px**2) for lag in LAGS},
        **{f"speed_{lag}": _autocorrelation(about_mean, lag, about_mean**2) for lag in LAGS},
        **{f"straightness_{lag}": _straightness(position_px, step_px, lag) for lag in LAGS[1:]},
        **{f"step_p{percent}_{ANY}": _percentile(step_px, percent) for percent in (5, 50, 95)},
        f"wall_p50_{ANY}": _percentile(np.minimum(places - low, high - places).min(axis=1), 50),
        f"meetings_{ANY}": np.nan if body_px is None else _share_of_meetings(position_px, 0.5 * body_px),
    }


def _products(values: Array, lag: int) -> Array:
    """Return the scalar products (T - lag, N) of vectors (T, N, K) with those ``lag`` frames later."""
    return np.asarray((values[lag:] * values[:-lag]).sum(axis=2))


def _autocorrelation(values: Array, lag: int, squares: Array) -> float:
    mean_square = _mean(squares)
    return _mean(_products(values, lag)) / mean_square if mean_square > 0.0 else np.nan


def _straightness(position_px: Array, step_px: Array, count: int) -> float:
    """Return the mean over all windows of ``count`` steps without an unmeasured frame, ``_STRIDE_FRAMES`` apart."""
    firsts = np.arange(0, len(step_px) - count + 1, _STRIDE_FRAMES)
    swum_px = np.array([step_px[first : first + count].sum(axis=0) for first in firsts])
    apart_px = np.linalg.norm(position_px[firsts + count] - position_px[firsts], axis=2)
    moved = swum_px > 0.0
    return _mean(apart_px[moved] / swum_px[moved]) if len(firsts) else np.nan


def _share_of_meetings(position_px: Array, near_px: float) -> float:
    frames, count, _ = position_px.shape
    if count < 2:
        return np.nan
    # Every process imports the suites, and few judge fish.
    import pandas as pd

    filled = pd.DataFrame(position_px.reshape(frames, -1)).interpolate(limit_area="inside").to_numpy()
    filled = filled.reshape(position_px.shape)
    first, second = np.triu_indices(count, 1)
    apart_px = np.linalg.norm(filled[:, first] - filled[:, second], axis=2)
    return float((apart_px < near_px).sum() / max(np.isfinite(apart_px).sum(), 1))


def _percentile(values: Array, percent: float) -> float:
    known = values[np.isfinite(values)]
    return float(np.percentile(known, percent)) if known.size else np.nan


def _mean(values: Array) -> float:
    known = values[np.isfinite(values)]
    return float(known.mean()) if known.size else np.nan


def _metric(name: str, summary: str, unit: str, low: float, high: float) -> Metric:
    true_places = "the true places of all fish, the same for all trackers"
    quantity = Quantity(f"motion_{name}", low, high, true_places, OWN, (motion_scores,))
    return Metric(quantity.name, summary, unit, "higher", Mean(quantity))


MOTION = (
    _metric("turn", "median change of direction", "degrees", 0, 180),
    _metric("heading", "mean cosine of the change of direction", "1", -1, 1),
    _metric("velocity", "autocorrelation of the velocity", "1", -1, 1),
    _metric("speed", "autocorrelation of the speed about its mean", "1", -1, 1),
    _metric("straightness", "way as the crow flies over the way swum", "fraction", 0, 1),
    _metric("step_p5", "step of a frame, 5th percentile", "px", 0, inf),
    _metric("step_p50", "step of a frame, median", "px", 0, inf),
    _metric("step_p95", "step of a frame, 95th percentile", "px", 0, inf),
    _metric("wall_p50", "distance to the nearest wall, median", "px", 0, inf),
    _metric("meetings", "share of time that two fish are nearer than half a body", "fraction", 0, 1),
)
"""Metrics of the rows of one line, without its suffix."""
