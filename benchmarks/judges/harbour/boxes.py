"""Boxes in single pictures, for the average precision of detectors."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from benchmarks.contract.judging import Score
from benchmarks.judges.harbour.answers import Answers, Objects
from benchmarks.statistics import froc
from benchmarks.statistics.average_precision import told_right


def box_scores(objects: Sequence[Objects], answers: Sequence[Answers]) -> Iterator[Score]:
    """Yield *series* over ``scores.froc.THRESHOLDS``, as if only tracks with such confidence were answered.

    ``boxes_right``: boxes, picture by picture, that overlap that of an intruder that is judged by an intersection over
    union of 0.5 at least, each intruder once, the surest first. ``boxes_told``: all boxes but those that lie, by half
    of their area, in the box of an intruder that is not judged. ``boxes_true``: of the intruders that are judged.
    """
    told, true = [np.empty((0, 2))], 0
    for there, answered in zip(objects, answers, strict=True):
        present = np.flatnonzero(there.present & np.isfinite(there.box_xyxy).all(axis=1))
        counted = there.judged[present]
        right, counts = told_right(answered.box_xyxy, answered.confidence, there.box_xyxy[present], counted)
        told.append(np.column_stack([answered.confidence, right])[counts])
        true += int(counted.sum())
    confidence, is_right = np.concatenate(told).T
    yield Score("boxes_right", froc.reached(confidence[is_right > 0]).tolist())
    yield Score("boxes_told", froc.reached(confidence).tolist())
    yield Score("boxes_true", float(true))
