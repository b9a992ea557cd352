"""Masks of one target against its pixels in the picture: region similarity J and contour accuracy F, as DAVIS has them.

*J* of a frame is the intersection over union of the two masks. *F* is the harmonic mean of precision and recall of the
contours: a point of one contour is right if one of the other lies within 0.008 of the picture's diagonal. Perazzi et
al., A benchmark dataset and evaluation methodology for video object segmentation, CVPR 2016; tolerance, recall (share
of frames above a half) and decay (mean of the first quarter of the frames minus that of the last) as in the evaluation
of DAVIS 2017.

All frames after the first count that show at least one pixel of the target, of truth with pixels. One without an answer
or without a mask is an empty mask there, 0. While no pixel is seen nothing counts: ``in_view_tnr`` tells whether a
tracker denies its presence then. Each episode counts the same in means, as each object of DAVIS. A tracker that gives
no mask in an episode has no rows.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import Score
from benchmarks.contract.metric import Better, Mean, Metric, Quantity
from scenarios.truth import Truth
from trackers.types import Estimate

TOLERANCE = 0.008
"""Of contours, in diagonals of the picture."""
_HALF = 0.5
_BINS = 4


class MaskScores:
    """The masks of one tracker in one episode; each is judged at once, and only numbers are kept."""

    def __init__(self) -> None:
        self._given = False
        self._values: list[tuple[float, float]] = []

    def keep(self, truth: Truth, target: int, estimate: Estimate) -> None:
        """Take one frame's answer; ``target``: index among the objects."""
        if truth.frame == 0 or not truth.instance_map.size:
            return
        mask, true = estimate.mask, truth.instance_map == truth.instance_id[target]
        self._given = self._given or mask is not None
        if true.any():
            none = (0.0, 0.0)
            self._values.append(none if mask is None else (region_similarity(mask, true), contour_accuracy(mask, true)))

    def scores(self) -> Iterator[Score]:
        """Yield the scores of the episode, after all frames."""
        if not (self._given and self._values):
            return
        means = []
        for name, values in zip(("mask_iou", "contour_accuracy"), np.array(self._values).T, strict=True):
            means.append(float(values.mean()))
            yield Score(name, means[-1])
            yield Score(f"{name}_recall", float((values > _HALF).mean()))
            yield Score(f"{name}_decay", decay(values))
        yield Score("j_and_f", float(np.mean(means)))


def region_similarity(mask: NDArray[np.bool_], true: NDArray[np.bool_]) -> float:
    """Return the intersection over union of two masks (H, W), in [0, 1]; 1 if both are empty."""
    union = np.count_nonzero(mask | true)
    return np.count_nonzero(mask & true) / union if union else 1.0


def contour_accuracy(mask: NDArray[np.bool_], true: NDArray[np.bool_]) -> float:
    """Return the F-measure of the contours of two masks (H, W), in [0, 1]; 1 if neither has one."""
    tolerance_px = int(np.ceil(TOLERANCE * np.hypot(*true.shape)))
    window = _window(mask | true, tolerance_px + 1)
    contours = [_contour(each[window]) for each in (mask, true)]
    counts = [np.count_nonzero(each) for each in contours]
    if not all(counts):
        return float(not any(counts))
    reach = np.hypot(*np.indices((2 * tolerance_px + 1,) * 2) - tolerance_px) <= tolerance_px
    near = [cv2.dilate(each.astype(np.uint8), reach.astype(np.uint8)).astype(bool) for each in contours]
    precision, recall = (np.count_nonzero(contours[k] & near[1 - k]) / counts[k] for k in (0, 1))
    return 2.0 * precision * recall / (precision + recall) if precision + recall else 0.0


def decay(values: NDArray[np.float64]) -> float:
    """Return how much less the mean of the last quarter of values (F,) is than that of the first, in [-1, 1].

    Neighbouring quarters share their border.
    """
    borders = np.round(np.linspace(0, len(values) - 1, _BINS + 1) + 1e-10).astype(int)
    return float(values[: borders[1] + 1].mean() - values[borders[-2] :].mean())


def _contour(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return (H, W): a pixel differs from the one right of it, below it, or right below it; beyond the picture none
    does.
    """
    beyond = np.pad(mask, ((0, 1), (0, 1)), mode="edge")
    return (mask != beyond[:-1, 1:]) | (mask != beyond[1:, :-1]) | (mask != beyond[1:, 1:])


def _window(mask: NDArray[np.bool_], margin_px: int) -> tuple[slice, slice]:
    """Return the part of the picture in which all of a mask lies, with a margin."""
    x, y, width, height = cv2.boundingRect(mask.astype(np.uint8))
    rows, columns = ((start - margin_px, start + length + margin_px) for start, length in ((y, height), (x, width)))
    return slice(max(rows[0], 0), rows[1]), slice(max(columns[0], 0), columns[1])


_FRAMES = "episodes with a mask: frames after the first that show at least one pixel of the target"
_DAVIS = "DAVIS: Perazzi et al., CVPR 2016, and Pont-Tuset et al., The 2017 DAVIS challenge, 2017"


def _metric(name: str, summary: str, low: float = 0.0, better: Better = "higher") -> Metric:
    of = Quantity(name, low, 1.0, _FRAMES, _DAVIS, (sys.modules[__name__],))
    return Metric(name, summary, "fraction", better, Mean(of))


MASKS = (
    _metric("j_and_f", "mean of mask_iou and contour_accuracy (J&F)"),
    _metric("mask_iou", "intersection over union of the mask and the target's pixels (J)"),
    _metric("mask_iou_recall", "frames on which it is above 0.5"),
    _metric("mask_iou_decay", "its mean in the first quarter of the frames minus that in the last", -1.0, "lower"),
    _metric("contour_accuracy", "F-measure of the mask's contour, within 0.008 of the picture's diagonal (F)"),
    _metric("contour_accuracy_recall", "frames on which it is above 0.5"),
    _metric(
        "contour_accuracy_decay", "its mean in the first quarter of the frames minus that in the last", -1.0, "lower"
    ),
)
