"""The judge of the suite ``many``: the boxes of tracks against those of all targets, as MOT Challenge scores them.

The similarity of a target and a track is the intersection over union of their boxes. Targets are all objects of which a
frame's truth has a box and of which some may be seen. An object whose kind is in ``Distractors`` is none: a track on it
counts neither as right nor as wrong, and other objects that are none neither; which track is on what is decided as
TrackEval decides it, by the best assignment of all boxes with a similarity of at least a half.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from benchmarks.contract.judging import Ending, Score
from benchmarks.judges.boxes import box_iou
from benchmarks.judges.identities import THRESHOLD, Pairing, clear_counts, numbered, track_scores
from scenarios.scenario import Episode, Frame, Scenario
from scenarios.truth import Truth
from trackers.types import CameraCommand, Track

DISTRACTOR, OTHER = "distractor", "other"
"""Kinds of objects of real sequences that are no targets: what a tracker may take for one, and what else has a box."""
_EPSILON = float(np.finfo(float).eps)


class ManyJudge:
    """See ``benchmarks.contract.judging.Judge``."""

    def __init__(self, episode: Episode, scenario: Scenario | None = None) -> None:
        """``scenario`` is None for a real sequence."""

    def see(self, frame: Frame, command: CameraCommand | None) -> None:
        """See ``Judge``."""
        self.truth = frame.truth

    def sheet(self) -> ManySheet:
        """See ``Judge``."""
        return ManySheet(self)


class ManySheet:
    """See ``benchmarks.contract.judging.ScoreSheet``."""

    def __init__(self, judge: ManyJudge) -> None:
        self._judge = judge
        self._truths: list[tuple[NDArray[np.int64], NDArray[np.bool_], NDArray[np.float64], NDArray[np.bool_]]] = []
        self._answers: list[Sequence[Track]] = []

    def keep(self, frame: Frame, tracks: Sequence[Track]) -> None:
        """See ``ScoreSheet``."""
        self._truths.append(objects_of(self._judge.truth))
        self._answers.append(tracks)

    def scores(self, ending: Ending) -> Iterator[Score]:
        """Yield the scores of the answers, revised ones if there are any, that the tracker decides for."""
        final = self._answers if ending.revised is None else ending.revised
        frames = [
            paired(*objects, [each for each in tracks if _decided(each, ending.decides_at)])
            for objects, tracks in zip(self._truths, final, strict=True)
        ]
        named = numbered(frames)
        yield from track_scores(named, clear_counts(named))


def objects_of(
    truth: Truth,
) -> tuple[NDArray[np.int64], NDArray[np.bool_], NDArray[np.float64], NDArray[np.bool_]]:
    """Return the N objects of a frame that have a box: index, whether each is a target, box (N, 4), and whether it is a
    distractor.
    """
    seen = ~np.isin(truth.state, ("out", "absent")) & np.isfinite(truth.box_xyxy).all(axis=1)
    there = np.flatnonzero(seen & ~(truth.visible_fraction <= 0.0))
    kinds = np.array(truth.kinds)[there]
    return there, ~np.isin(kinds, (DISTRACTOR, OTHER)), truth.box_xyxy[there], kinds == DISTRACTOR


def paired(
    index: NDArray[np.int64],
    is_target: NDArray[np.bool_],
    box_xyxy: NDArray[np.float64],
    is_distractor: NDArray[np.bool_],
    tracks: Sequence[Track],
) -> Pairing:
    """Return the pairing of a frame's objects, see ``objects_of``, and of the tracks that have a box."""
    boxed = [
        each for each in tracks if each.estimate.box_xyxy is not None and np.isfinite(each.estimate.box_xyxy).all()
    ]
    identities = np.array([each.identity for each in boxed], np.int64)
    answered_xyxy = np.array([each.estimate.box_xyxy for each in boxed], float).reshape(-1, 4)
    similarity = box_iou(box_xyxy[:, None], answered_xyxy)
    kept = np.ones(len(boxed), bool)
    if is_distractor.any():
        close = np.where(similarity < THRESHOLD - _EPSILON, 0.0, similarity)
        rows, columns = linear_sum_assignment(-close)
        kept[columns[(close[rows, columns] > _EPSILON) & is_distractor[rows]]] = False
    return Pairing(index[is_target], identities[kept], similarity[is_target][:, kept])


def _decided(track: Track, least: float) -> bool:
    return track.confidence is None or track.confidence >= least
