"""Free-response receiver operating characteristic: share found against false alarms an hour, over all thresholds.

Confidences are compared with a fixed grid of thresholds, the same for all trackers and episodes, so that episodes add
up and are resampled together. ``counts`` (..., 2 K) hold for K thresholds, the lowest first, the share found, then the
false alarms an hour. Neither has to fall with the threshold: a higher one may break one long alarm into several.

The order of two trackers may turn with the range of the area. So areas are named by their ranges: over 0.1 to 10 alarms
an hour, which somebody on watch can bear, and over 1 to 100. The share found at one alarm an hour, where both meet on a
log axis, stands before them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_HIGHEST_LOG_ODDS, _STEPS = 14.0, 200
THRESHOLDS = np.concatenate(
    [[0.0], 1.0 / (1.0 + np.exp(-np.linspace(-_HIGHEST_LOG_ODDS, _HIGHEST_LOG_ODDS, _STEPS + 1))), [1.0]]
)
"""Confidences 0, 1 and between them equal steps of 0.14 in their log odds."""


def reached(levels: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (K,) how many ``levels`` (N,) reach each threshold; NaN reaches none."""
    return np.asarray((np.asarray(levels)[:, None] >= THRESHOLDS).sum(axis=0), dtype=float)


def found_at(counts: NDArray[np.float64], alarms_per_hour: float | NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the largest share (...) found at any threshold with at most so many alarms, one number or (..., 1); 0
    where all have more.
    """
    share, alarms = _split(counts)
    return np.asarray(np.where(alarms <= alarms_per_hour, share, 0.0).max(axis=-1))


def area(counts: NDArray[np.float64], low: float, high: float) -> NDArray[np.float64]:
    """Return the mean (...) of ``found_at`` over the logarithm of the alarms from ``low`` > 0 to ``high`` an hour."""
    share, alarms = _split(counts)
    order = alarms.argsort(axis=-1)
    best = np.maximum.accumulate(np.take_along_axis(share, order, -1), axis=-1)
    starts = np.log(np.clip(np.take_along_axis(alarms, order, -1), low, high))
    ends = np.concatenate([starts[..., 1:], np.full_like(starts[..., :1], np.log(high))], axis=-1)
    return np.asarray((best * (ends - starts)).sum(axis=-1) / np.log(high / low))


def _split(counts: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return shares and alarms (..., K); a share below 0, or of nothing to find, NaN, counts as 0."""
    share, alarms = np.split(counts, 2, axis=-1)
    return np.maximum(np.nan_to_num(share), 0.0), alarms
