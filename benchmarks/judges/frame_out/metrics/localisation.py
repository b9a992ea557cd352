"""Tests whether an estimate is on a car: overlap in the picture, distance on the ground."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from benchmarks.judges.frame_out.metrics.series import EstimateSeries, TruthSeries

ON_CAR_IOU = 0.5


def box_iou(first_xyxy: NDArray[np.float64], second_xyxy: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the intersection over union of boxes (..., 4), which broadcast: area(A n B) / area(A u B), in [0, 1].

    0 where either box has no area or holds NaN.
    """
    low = np.maximum(first_xyxy[..., :2], second_xyxy[..., :2])
    high = np.minimum(first_xyxy[..., 2:], second_xyxy[..., 2:])
    with np.errstate(invalid="ignore", divide="ignore"):
        shared = np.prod(np.clip(high - low, 0.0, None), axis=-1)
        areas = [np.prod(np.clip(box[..., 2:] - box[..., :2], 0.0, None), axis=-1) for box in (first_xyxy, second_xyxy)]
        iou = shared / (areas[0] + areas[1] - shared)
    return np.where((areas[0] > 0) & (areas[1] > 0), np.nan_to_num(iou, nan=0.0), 0.0)


def on_object(truth: TruthSeries, estimate: EstimateSeries) -> NDArray[np.bool_]:
    """Return (F, N): the estimate is on object n in frame k.

    On it: IoU with its amodal box at least 0.5, or centre within half of its length on the ground (``|estimate -
    truth| <= length / 2`` in metres, both at half its height). The same inside and outside the picture.
    """
    iou = box_iou(estimate.box_xyxy[:, None], truth.box_xyxy)
    distance_m = np.linalg.norm(estimate.position_m[:, None] - truth.ground_m, axis=-1)
    with np.errstate(invalid="ignore"):
        return (iou >= ON_CAR_IOU) | (distance_m <= 0.5 * truth.object_size_m[:, 0])


def on_target(truth: TruthSeries, estimate: EstimateSeries) -> NDArray[np.bool_]:
    """Return (F,): the estimate is on the target, see ``on_object``."""
    return on_object(truth, estimate)[:, truth.target]


def on_other(truth: TruthSeries, estimate: EstimateSeries) -> NDArray[np.int64]:
    """Return (F,): index of another object that the estimate is on while it is not on the target; -1 = none.

    Where several others qualify, the one nearest on the ground.
    """
    on = on_object(truth, estimate)
    distance_m = np.linalg.norm(estimate.position_m[:, None] - truth.ground_m, axis=-1)
    candidates = on & ~on[:, [truth.target]]
    nearest = np.argmin(np.where(candidates, np.nan_to_num(distance_m, nan=1e9), np.inf), axis=1)
    return np.where(candidates.any(axis=1), nearest, -1)
