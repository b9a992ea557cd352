"""Long-term tracking precision, recall and F-score of VOT-LT."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

THRESHOLDS = np.linspace(0.0, 1.0, 21)
"""Confidences from which a tracker's boxes count as predictions."""


def precision_recall_curves(
    iou: NDArray[np.float64], confidence: NDArray[np.float64], visible: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return precision (21,) and recall (21,) at ``THRESHOLDS``, each in [0, 1].

    ``Pr(t) = 1/N_p sum_{k: c_k >= t} iou_k`` over the N_p frames with a prediction, ``Re(t) = 1/N_g sum_{k visible,
    c_k >= t} iou_k`` over the N_g frames on which the target is visible; iou_k is 0 where it is not. Pr is 1
    without predictions. Lukezic et al., Now you see me: evaluating performance in long-term visual tracking, 2018,
    eqs. 1-2.

    Args:
        iou: (F,) with the amodal box. confidence: (F,) in [0, 1]; 0 where the tracker's position is outside the
            picture or missing, which is no prediction and costs no precision.
        visible: (F,) the target is wholly or partly visible.
    """
    overlap = np.where(visible, iou, 0.0)
    # A confidence of 0 is no prediction at any threshold.
    predicted = (confidence[None] >= THRESHOLDS[:, None]) & (confidence[None] > 0)
    total = predicted @ overlap
    count = predicted.sum(axis=1)
    precision = np.where(count > 0, total / np.maximum(count, 1), 1.0)
    recall = total / visible.sum() if visible.any() else np.full(len(THRESHOLDS), np.nan)
    return precision, recall


def best_f_score(precision: NDArray[np.float64], recall: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the index (...) of the threshold with the greatest ``F = 2 Pr Re / (Pr + Re)`` (ibid., eq. 3).

    Args:
        precision, recall: (..., 21), means over sequences.
    """
    return np.argmax(f_score(precision, recall), axis=-1)


def f_score(precision: NDArray[np.float64], recall: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return ``2 Pr Re / (Pr + Re)``, in [0, 1]; 0 where both are 0."""
    total = precision + recall
    return np.where(total > 0, 2 * precision * recall / np.where(total > 0, total, 1.0), 0.0)
