"""How well a camera that follows a tracker's estimate keeps the car in its picture."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from benchmarks.scores.recovery import Recovery
from benchmarks.suites.frame_out.metrics.series import TruthSeries


def time_in_view(truth: TruthSeries) -> float:
    """Return the share in [0, 1] of frames on which the target's centre is inside the picture, hidden or
    not.
    """
    return float(np.mean(truth.in_picture))


def losses_per_minute(recoveries: Sequence[Recovery | None], frame_count: int, rate_hz: float) -> float:
    """Return how often a minute a frame-out ended with the car not recovered, never back in full included, >=
    0.
    """
    lost = sum(recovery is not None and not recovery.recovered for recovery in recoveries)
    return 60.0 * lost * rate_hz / frame_count
