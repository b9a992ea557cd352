"""Centre error and success of the OTB benchmark, on the frames that show the whole target."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

THRESHOLDS = np.linspace(0.0, 1.0, 21)
"""Overlaps at which success is counted."""
PRECISION_PX = 20.0
"""Largest centre error of a precise frame."""


def centre_error_px(
    position_px: NDArray[np.float64], truth_px: NDArray[np.float64], size_px: tuple[int, int]
) -> NDArray[np.float64]:
    """Return ``|estimate - truth|`` (F,) in pixels, at most the picture's diagonal, also for NaN.

    Wu, Lim, Yang, Online object tracking: a benchmark, CVPR 2013 (there without a cap).
    """
    worst = float(np.hypot(*size_px))
    error = np.linalg.norm(position_px - truth_px, axis=1)
    return np.minimum(np.nan_to_num(error, nan=worst, posinf=worst), worst)


def precision_20_px(error_px: NDArray[np.float64]) -> float:
    """Return the share of frames with a centre error of at most 20 px, in [0, 1] (ibid.); NaN without frames."""
    return float((error_px <= PRECISION_PX).mean()) if len(error_px) else float("nan")


def success_curve(iou: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (21,): share of frames with IoU above each of ``THRESHOLDS``, in [0, 1] (ibid.); NaN without frames."""
    if len(iou) == 0:
        return np.full(len(THRESHOLDS), np.nan)
    return (iou[None] > THRESHOLDS[:, None]).mean(axis=1)


def success_auc(curve: NDArray[np.float64]) -> float:
    """Return the area under a success curve: the mean of its 21 values, as the benchmark computes it."""
    return float(curve.mean())
