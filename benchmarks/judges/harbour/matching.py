"""Which track lies on which intruder, which on none, and which is neither right nor wrong: on a frame, and on all."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from benchmarks.judges.harbour.answers import Answers, Objects
from trackers.kernels.boxes import intersections_over_union

RADIUS_M = 3.0
"""A track lies on an intruder if its centre is no farther from the true one, over the ground, and both overlap in the
picture.
"""
_AT_IT_PX, _AT_IT_IOU = 2.0, 0.1
"""A track is at an intruder in the picture if its point lies in the intruder's box, so much larger on each side, or the
boxes' intersection over union is so large.
"""
_KEPT = 1000.0
"""What it is worth that an intruder keeps the track that it had; more than all distances together."""


class Matches(NamedTuple):
    """The M tracks of a frame beside its N intruders.

    Attributes:
        target: (M,) intruder that a track lies on, -1 for none. Only intruders that are judged have tracks.
        first: (M,) whether it is the one track of its intruder; other tracks on the same one are duplicates.
        excused: (M,) at an intruder, in the world or in the picture, but not on a judged one: neither right nor wrong.
        overlapping: (M, N) whether track and intruder overlap in the picture, the intruder seen.
    """

    target: NDArray[np.int64]
    first: NDArray[np.bool_]
    excused: NDArray[np.bool_]
    overlapping: NDArray[np.bool_]

    @property
    def false(self) -> NDArray[np.bool_]:
        """(M,) whether a track lies on nothing."""
        return (self.target < 0) & ~self.excused


class Matcher:
    """Matches the tracks of one frame after the other."""

    def __init__(self) -> None:
        self._latest: NDArray[np.int64] | None = None

    def match(self, objects: Objects, answers: Answers) -> Matches:
        """Return the matches of the next frame, see ``match_frame``."""
        if self._latest is None:
            self._latest = np.full(len(objects.judged), -1)
        matches = match_frame(objects, answers, self._latest)
        self._latest[matches.target[matches.first]] = answers.identity[matches.first]
        return matches


def match_frame(objects: Objects, answers: Answers, latest: NDArray[np.int64]) -> Matches:
    """Return the matches of a frame.

    One to one by least sum of distances (Hungarian method), where an intruder keeps the ``latest`` track that it had,
    an identity (N,) or -1, if that still lies on it. A track that is left over lies on the nearest intruder that it may
    lie on, as a duplicate: if all others were taken away it would be its one track.
    """
    away_m = np.linalg.norm(answers.place_m[:, None, :2] - objects.place_m[None, :, :2], axis=2)
    near = objects.present & (away_m <= RADIUS_M)
    overlaps = overlaps_of(answers.box_xyxy[:, None], objects.box_xyxy[None])
    may = near & overlaps & objects.judged
    target, first = np.full(len(may), -1), np.zeros(len(may), dtype=bool)
    if may.any():
        kept = answers.identity[:, None] == latest
        worth = np.where(may, _KEPT * kept + 2.0 - away_m / RADIUS_M, 0.0)
        rows, columns = linear_sum_assignment(worth, maximize=True)
        paired = may[rows, columns]
        target[rows[paired]], first[rows[paired]] = columns[paired], True
        spare = may.any(axis=1) & ~first
        target[spare] = np.where(may, away_m, np.inf)[spare].argmin(axis=1)
    # Points of no extent overlap what they lie in.
    larger_xyxy = objects.box_xyxy + _AT_IT_PX * np.array([-1.0, -1.0, 1.0, 1.0])
    inside = overlaps_of(np.tile(answers.position_px, 2)[:, None], larger_xyxy[None])
    at_it = inside | (intersections_over_union(answers.box_xyxy, objects.box_xyxy) >= _AT_IT_IOU)
    excused = (target < 0) & (near | at_it & objects.present).any(axis=1)
    return Matches(target, first, excused, overlaps & objects.seen)


def overlaps_of(a_xyxy: NDArray[np.float64], b_xyxy: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return (...) whether boxes (..., 4) meet; a box of no extent meets those it lies in."""
    sides = np.minimum(a_xyxy[..., 2:], b_xyxy[..., 2:]) - np.maximum(a_xyxy[..., :2], b_xyxy[..., :2])
    inside = (a_xyxy[..., :2] >= b_xyxy[..., :2]) & (a_xyxy[..., 2:] <= b_xyxy[..., 2:])
    return np.asarray((sides > 0).all(axis=-1) | inside.all(axis=-1))


class Answered(NamedTuple):
    """The answer on one frame: tracks, their matches, and the causes (F,) of those on nothing, see ``Clutter``."""

    answers: Answers
    matches: Matches
    causes: NDArray[np.uint8]


def confident(objects: Sequence[Objects], frames: Sequence[Answered], least: float) -> list[Answered]:
    """Return the frames as if only tracks with a confidence of at least ``least`` had been answered."""
    matcher, kept = Matcher(), []
    for there, each in zip(objects, frames, strict=True):
        sure = each.answers.confidence >= least
        answers = each.answers.only(sure)
        kept.append(Answered(answers, matcher.match(there, answers), each.causes[sure[each.matches.false]]))
    return kept


class History(NamedTuple):
    """The R tracks of all frames, in order of frames.

    Attributes:
        frame: (R,). identity: (R,) numbered from 0.
        answers, matches: of all R tracks. cause: (F,) of those that lie on nothing, see ``Clutter.causes``.
    """

    frame: NDArray[np.int64]
    identity: NDArray[np.int64]
    answers: Answers
    matches: Matches
    cause: NDArray[np.uint8]

    @property
    def names(self) -> int:
        """A number that no identity reaches, at least 1."""
        return int(self.identity.max(initial=0)) + 1

    def on_nothing(self) -> NDArray[np.bool_]:
        """Return (R,) the rows of identities that lie on nothing more often than not."""
        all_rows = np.bincount(self.identity, minlength=self.names)
        false = np.bincount(self.identity[self.matches.false], minlength=self.names)
        return np.asarray((2 * false > all_rows)[self.identity])

    def false_tracks(self) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
        """Return frames, identities and confidences (F,) of the tracks that lie on nothing."""
        false = self.matches.false
        return self.frame[false], self.identity[false], self.answers.confidence[false]


def history_of(frames: Sequence[Answered]) -> History:
    """Return the tracks of all frames as rows."""
    answers, matches, causes = zip(*frames, strict=True)
    joined = Answers._make(map(np.concatenate, zip(*answers, strict=True)))
    frame = np.repeat(np.arange(len(frames)), [len(each.identity) for each in answers])
    _, identity = np.unique(joined.identity, return_inverse=True)
    matched = Matches._make(map(np.concatenate, zip(*matches, strict=True)))
    return History(frame, identity, joined, matched, np.concatenate(causes))
