"""Overlap of boxes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


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
