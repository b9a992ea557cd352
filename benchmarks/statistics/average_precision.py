"""Average precision of boxes in single pictures, as the COCO benchmark computes it at one overlap.

Confidences are compared with the grid of ``statistics.froc``, the same for all trackers and episodes, so that episodes
add up and are resampled together: two answers whose confidences no threshold of it parts come in one step. Otherwise
the numbers are those of pycocotools, which the tests compare them with.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

LEAST_OVERLAP = 0.5
"""Intersection over union from which on a box is right."""
_RECALLS = np.linspace(0.0, 1.0, 101)


def told_right(
    boxes_xyxy: NDArray[np.float64],
    confidence: NDArray[np.float64],
    true_xyxy: NDArray[np.float64],
    counted: NDArray[np.bool_],
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return which boxes (M, 4) of one picture are right (M,), and which count at all (M,).

    The surest first, each takes the free true box (N, 4) that it overlaps most, from ``LEAST_OVERLAP`` on. One that
    finds none, but lies by that share of its own area in a true box that is not ``counted`` (N,), does not count.
    """
    first, second = boxes_xyxy[:, None], true_xyxy[None]
    sides = np.minimum(first[..., 2:], second[..., 2:]) - np.maximum(first[..., :2], second[..., :2])
    shared = np.maximum(sides, 0.0).prod(axis=-1)
    area, true_area = ((each[..., 2:] - each[..., :2]).prod(axis=-1) for each in (first, second))
    union = area + true_area - shared
    overlap = np.divide(shared, union, out=np.zeros_like(shared), where=union > 0)
    overlap[:, ~counted] = 0.0
    inside = np.divide(shared, area, out=np.zeros_like(shared), where=area > 0)[:, ~counted]
    right = np.zeros(len(boxes_xyxy), np.bool_)
    if len(true_xyxy):
        for k in np.argsort(-confidence, kind="stable"):
            best = int(overlap[k].argmax())
            if overlap[k, best] >= LEAST_OVERLAP:
                right[k] = True
                overlap[:, best] = 0.0
    return right, right | ~(inside >= LEAST_OVERLAP).any(axis=1)


def average(counts: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the average precision (...) of ``counts`` (..., 2 K): recall at K thresholds, the lowest first, then
    precision there, NaN where nothing counts.

    The mean, over 101 recalls from 0 to 1, of the greatest precision at any threshold with at least that recall.
    """
    recall, precision = np.split(np.nan_to_num(counts), 2, axis=-1)
    best = np.maximum.accumulate(precision, axis=-1)
    # Recall falls with the threshold: the first ones, up to the last that has so much, have at least that.
    reach = (recall[..., None, :] >= _RECALLS[:, None]).sum(axis=-1)
    last = np.take_along_axis(best, np.maximum(reach - 1, 0), axis=-1)
    return np.asarray(np.where(reach > 0, last, 0.0).mean(axis=-1))
