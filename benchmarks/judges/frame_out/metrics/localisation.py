"""How near an estimate is to a car: overlap of boxes, metres on the ground, pixels of the picture."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from benchmarks.judges.frame_out.metrics.series import EstimateSeries, TruthSeries
from trackers.kernels.boxes import box_iou

ON_CAR_IOU = 0.5
WORST_ERROR_M = 200.0
"""Cap of every error, and the error without an answer, for NaN, and for a place above the horizon."""
PRECISION_PX = 20.0
"""Largest centre error of a precise frame."""
CENTRE_ERRORS_PX = np.arange(51.0)
"""Centre errors at which precision is drawn."""
THRESHOLDS = np.linspace(0.0, 1.0, 21)
"""Overlaps at which success is counted."""


def on_object(truth: TruthSeries, estimate: EstimateSeries) -> NDArray[np.bool_]:
    """Return (F, N): the estimate is on object n in frame k.

    On it: IoU with its amodal box at least 0.5, or centre within half of its length on the ground (``|estimate -
    truth| <= length / 2`` in metres, both at half its height). The same inside and outside the picture.
    """
    iou = box_iou(estimate.box_xyxy[:, None], truth.box_xyxy)
    return (iou >= ON_CAR_IOU) | (_distance_m(truth, estimate) <= 0.5 * truth.object_size_m[:, 0])


def on_other(truth: TruthSeries, estimate: EstimateSeries) -> NDArray[np.int64]:
    """Return (F,): index of another object that the estimate is on while it is not on the target; -1 = none.

    Where several others qualify, the one nearest on the ground.
    """
    on = on_object(truth, estimate)
    candidates = on & ~on[:, [truth.target]]
    distance_m = np.nan_to_num(_distance_m(truth, estimate), nan=1e9)
    nearest = np.argmin(np.where(candidates, distance_m, np.inf), axis=1)
    return np.where(candidates.any(axis=1), nearest, -1)


def ground_error_m(truth: TruthSeries, estimate: EstimateSeries) -> NDArray[np.float64]:
    """Return (F,): ``min(|estimate - truth|, 200)`` in metres, in [0, 200]; 200 without an answer.

    The estimate is projected through the true camera to half the car's height, where its centre is. No frame is left
    out because the tracker is lost.
    """
    return _capped(_distance_m(truth, estimate)[:, truth.target], WORST_ERROR_M)


def centre_error_px(truth: TruthSeries, estimate: EstimateSeries) -> NDArray[np.float64]:
    """Return ``|estimate - truth|`` (F,) in pixels, at most the picture's diagonal, also for NaN.

    Wu, Lim, Yang, Online object tracking: a benchmark, CVPR 2013 (there without a cap). ``precision_20_px`` is the
    share of frames on which it is at most 20 px (ibid.).
    """
    error_px = np.linalg.norm(estimate.position_px - truth.position_px[:, truth.target], axis=1)
    return _capped(error_px, float(np.hypot(*truth.size_px)))


def success_curve(iou: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (21,): share of frames with IoU above each of ``THRESHOLDS``, in [0, 1] (OTB, see ``centre_error_px``).

    The area under it is the mean of its values, as the benchmark computes it.
    """
    return (iou[None] > THRESHOLDS[:, None]).mean(axis=1)


def precision_plot(error_px: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (51,): share of frames with a centre error of at most each of ``CENTRE_ERRORS_PX``, in [0, 1] (OTB, see
    ``centre_error_px``); its value at 20 px is ``precision_20_px``.
    """
    return (error_px[None] <= CENTRE_ERRORS_PX[:, None]).mean(axis=1)


def _distance_m(truth: TruthSeries, estimate: EstimateSeries) -> NDArray[np.float64]:
    """Return (F, N), NaN without an answer."""
    return np.linalg.norm(estimate.position_m[:, None] - truth.ground_m, axis=-1)


def _capped(error: NDArray[np.float64], worst: float) -> NDArray[np.float64]:
    return np.minimum(np.nan_to_num(error, nan=worst, posinf=worst), worst)
