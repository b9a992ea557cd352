"""How the fish swim: rows of an episode or of a block of real tracks."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import Score
from benchmarks.contract.metric import OWN, Mean, Metric, Quantity
from benchmarks.judges.fish.motion_statistics import motion_statistics

ANY = "any"
LAGS = ("5", "50", "100", "200")
_LAGGED = ("turn", "heading", "velocity", "speed", "straightness")
_PLAIN = {
    "step_p5": "speed p5",
    "step_p50": "speed p50",
    "step_p95": "speed p95",
    "wall_p50": "wall p50",
    "meetings": "pairs nearer than half a body",
}
"""Name of a row → statistic."""


def motion_scores(position_px: NDArray[np.float64], body_px: float | None) -> Iterator[Score]:
    """Yield ``motion_NAME_LINE`` of the places (T, N, 2) of all fish, see ``motion_statistics``.

    ``motion_turn_L``, ``heading``, ``velocity``, ``speed`` and ``straightness`` over L frames. Over all frames:
    ``motion_step_p5_any``, ``p50`` and ``p95`` of the length of a step, ``motion_wall_p50_any``, and
    ``motion_meetings_any``, the share of time that two fish are nearer than half a body, where its length is known.
    """
    found = motion_statistics(position_px, body_px or 1.0)
    for name in _LAGGED:
        for lag in LAGS:
            yield from _score(f"motion_{name}_{lag}", found.get(f"{name} {lag}", np.nan))
    for name, statistic in _PLAIN.items():
        if name != "meetings" or body_px is not None:
            yield from _score(f"motion_{name}_{ANY}", found[statistic])


def _score(name: str, value: float) -> Iterator[Score]:
    if np.isfinite(value):
        yield Score(name, float(value))


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
