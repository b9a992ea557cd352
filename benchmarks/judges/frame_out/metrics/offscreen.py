"""Error of the estimate while the target is outside the picture, in metres on the ground."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from benchmarks.judges.frame_out.metrics.frame_outs import FrameOut
from benchmarks.judges.frame_out.metrics.series import EstimateSeries, TruthSeries

WORST_ERROR_M = 200.0
"""Cap of every error, and the error without an answer, for NaN, and for a place above the horizon."""


def ground_error_m(truth: TruthSeries, estimate: EstimateSeries) -> NDArray[np.float64]:
    """Return (F,): ``min(|estimate - truth|, 200)`` in metres, in [0, 200]; 200 without an answer.

    The estimate is projected through the true camera to half the car's height, where its centre is. No frame is left
    out because the tracker is lost.
    """
    distance_m = np.linalg.norm(estimate.position_m - truth.ground_m[:, truth.target], axis=1)
    return np.minimum(np.nan_to_num(distance_m, nan=WORST_ERROR_M, posinf=WORST_ERROR_M), WORST_ERROR_M)


def error_by_frames_since_exit_m(error_m: NDArray[np.float64], frame_out: FrameOut) -> NDArray[np.float64]:
    """Return (length_frames,): entry k is the error k frames after the exit."""
    return error_m[frame_out.exit_frame : frame_out.exit_frame + frame_out.length_frames]
