"""The judge of the suite ``many``: the boxes of tracks against those of all targets, as MOT Challenge scores them.

The similarity of a target and a track is the intersection over union of their boxes. A target is an object with a box
in the truth of a frame, of which some may be seen, unless its kind is ``DISTRACTOR`` or ``OTHER``. A track on a
distractor counts neither as right nor as wrong. Which track is on one is decided as in TrackEval, by the best
assignment of all boxes with a similarity of at least a half.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from benchmarks.contract.judging import Ending, Score
from benchmarks.contract.sequence_truth import DISTRACTOR, OTHER
from benchmarks.judges.identities import THRESHOLD, Pairing, clear_counts, numbered, track_scores
from scenarios.scenario import Episode, Frame, Scenario
from scenarios.truth import Truth
from trackers.kernels.boxes import intersections_over_union
from trackers.types import CameraCommand, Track

_EPSILON = float(np.finfo(float).eps)


class Objects(NamedTuple):
    """The N objects of a frame: number (N,), box_xyxy (N, 4), and whether each is a target or a distractor (N,)."""

    number: NDArray[np.int64]
    box_xyxy: NDArray[np.float64]
    is_target: NDArray[np.bool_]
    is_distractor: NDArray[np.bool_]


class ManyJudge:
    """See ``benchmarks.contract.judging.Judge``."""

    def __init__(self, episode: Episode, scenario: Scenario | None = None) -> None:
        """``scenario`` is None for a real sequence."""

    def see(self, frame: Frame, command: CameraCommand | None) -> None:
        """See ``Judge``."""
        self.objects = objects_of(frame.truth)

    def sheet(self) -> ManySheet:
        """See ``Judge``."""
        return ManySheet(self)


class ManySheet:
    """See ``benchmarks.contract.judging.ScoreSheet``."""

    def __init__(self, judge: ManyJudge) -> None:
        self._judge = judge
        self._objects: list[Objects] = []
        self._answers: list[Sequence[Track]] = []

    def keep(self, frame: Frame, tracks: Sequence[Track]) -> None:
        """See ``ScoreSheet``."""
        self._objects.append(self._judge.objects)
        self._answers.append(tracks)

    def scores(self, ending: Ending) -> Iterator[Score]:
        """Yield the scores of the answers, revised ones if there are any, that the tracker decides for."""
        final = self._answers if ending.revised is None else ending.revised
        named = numbered([paired(*frame, ending.decides_at) for frame in zip(self._objects, final, strict=True)])
        yield from track_scores(named, clear_counts(named))


def objects_of(truth: Truth) -> Objects:
    """Return the objects of a frame that have a box and may be seen."""
    seen = ~np.isin(truth.state, ("out", "absent")) & np.isfinite(truth.box_xyxy).all(axis=1)
    there = np.flatnonzero(seen & ~(truth.visible_fraction <= 0.0))
    kinds = np.array(truth.kinds)[there]
    return Objects(there, truth.box_xyxy[there], ~np.isin(kinds, (DISTRACTOR, OTHER)), kinds == DISTRACTOR)


def paired(objects: Objects, tracks: Sequence[Track], least: float) -> Pairing:
    """Return the pairing of a frame's targets, and of the tracks that have a box, a confidence of at least ``least`` or
    none, and are on no distractor.
    """
    decided = (each for each in tracks if each.confidence is None or each.confidence >= least)
    boxes = ((each.identity, each.estimate.box_xyxy) for each in decided)
    boxed = [(identity, box) for identity, box in boxes if box is not None and np.isfinite(box).all()]
    identities = np.array([identity for identity, _ in boxed], np.int64)
    answered_xyxy = np.array([box for _, box in boxed], float).reshape(-1, 4)
    similarity = intersections_over_union(objects.box_xyxy, answered_xyxy)
    kept = np.ones(len(boxed), bool)
    if objects.is_distractor.any():
        close = np.where(similarity < THRESHOLD - _EPSILON, 0.0, similarity)
        rows, columns = linear_sum_assignment(-close)
        kept[columns[(close[rows, columns] > _EPSILON) & objects.is_distractor[rows]]] = False
    return Pairing(objects.number[objects.is_target], identities[kept], similarity[objects.is_target][:, kept])
