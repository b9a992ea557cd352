"""The answers of a whole episode beside its intruders, a row for each track on each frame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.judges.harbour.answers import Answers, Objects
from benchmarks.judges.harbour.matching import Matcher, Matches


class Answered(NamedTuple):
    """The answer on one frame: tracks, their matches, and the causes (F,) of those on nothing, see ``Clutter``."""

    answers: Answers
    matches: Matches
    causes: NDArray[np.uint8]


class Met(NamedTuple):
    """K times that a track's region overlaps an intruder that is seen.

    Attributes:
        frame, target, identity, confidence: (K,). size_m: (K, 3) of the track.
        beyond_m: (K,) how far its place lies behind the intruder's centre as the camera sees it, over the ground; NaN
            without a place.
    """

    frame: NDArray[np.int64]
    target: NDArray[np.int64]
    identity: NDArray[np.int64]
    confidence: NDArray[np.float64]
    size_m: NDArray[np.float64]
    beyond_m: NDArray[np.float64]


class History(NamedTuple):
    """R tracks of all frames, in order of frames.

    Attributes:
        frame, identity: (R,); identities are numbered from 0 and are fewer than ``names``, at least 1.
        confidence, place_m (R, 2) over the ground, box_xyxy (R, 4), size_m (R, 3), kind: see ``Answers``.
        target, first, false: see ``Matches``. cause: (F,) of those that lie on nothing, see ``Clutter.causes``.
        error_m: (R,) distance over the ground to its target, NaN without one. met: see there.
    """

    frame: NDArray[np.int64]
    identity: NDArray[np.int64]
    names: int
    confidence: NDArray[np.float64]
    place_m: NDArray[np.float64]
    box_xyxy: NDArray[np.float64]
    size_m: NDArray[np.float64]
    kind: NDArray[np.str_]
    target: NDArray[np.int64]
    first: NDArray[np.bool_]
    false: NDArray[np.bool_]
    cause: NDArray[np.uint8]
    error_m: NDArray[np.float64]
    met: Met

    def on_nothing(self) -> NDArray[np.bool_]:
        """Return (R,) the rows of identities that lie on nothing more often than not."""
        told = np.bincount(self.identity, minlength=self.names)
        false = np.bincount(self.identity[self.false], minlength=self.names)
        return np.asarray((2 * false > told)[self.identity])

    def false_tracks(self) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
        """Return frames, identities and confidences (F,) of the tracks that lie on nothing."""
        return self.frame[self.false], self.identity[self.false], self.confidence[self.false]


def confident(objects: Sequence[Objects], frames: Sequence[Answered], least: float) -> list[Answered]:
    """Return the frames as if only tracks with a confidence of at least ``least`` had been answered."""
    matcher, kept = Matcher(), []
    for there, each in zip(objects, frames, strict=True):
        sure = each.answers.confidence >= least
        answers = each.answers.only(sure)
        kept.append(Answered(answers, matcher.match(there, answers), each.causes[sure[each.matches.false]]))
    return kept


def rows_of(objects: Sequence[Objects], frames: Sequence[Answered]) -> History:
    """Return the tracks of all frames as rows."""
    answers, matches, causes = zip(*frames, strict=True)
    counts = [len(each.identity) for each in answers]
    frame = np.repeat(np.arange(len(frames)), counts)
    names, identity = np.unique(np.concatenate([each.identity for each in answers]), return_inverse=True)
    confidence = np.concatenate([each.confidence for each in answers])
    place_m = np.concatenate([each.place_m[:, :2] for each in answers])
    size_m = np.concatenate([each.size_m for each in answers])
    target = np.concatenate([each.target for each in matches])
    true_m = np.array([each.place_m[:, :2] for each in objects])
    on, error_m = target >= 0, np.full(len(target), np.nan)
    error_m[on] = np.linalg.norm(place_m[on] - true_m[frame[on], target[on]], axis=1)
    starts = np.cumsum([0, *counts[:-1]])
    row, overlapped = np.concatenate(
        [each.overlapping + np.array([start, 0]) for each, start in zip(matches, starts, strict=True)]
    ).T
    ahead = np.array([each.ahead for each in objects])[frame[row], overlapped]
    beyond_m = ((place_m[row] - true_m[frame[row], overlapped]) * ahead).sum(axis=1)
    return History(
        frame=frame,
        identity=identity,
        names=max(len(names), 1),
        confidence=confidence,
        place_m=place_m,
        box_xyxy=np.concatenate([each.box_xyxy for each in answers]),
        size_m=size_m,
        kind=np.concatenate([each.kind for each in answers]),
        target=target,
        first=np.concatenate([each.first for each in matches]),
        false=np.concatenate([each.false for each in matches]),
        cause=np.concatenate(causes),
        error_m=error_m,
        met=Met(frame[row], overlapped, identity[row], confidence[row], size_m[row], beyond_m),
    )
