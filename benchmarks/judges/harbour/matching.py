"""Which track lies on which intruder, which on none, and which is neither right nor wrong."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from benchmarks.judges.harbour.answers import Answers, Objects

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


@dataclass(frozen=True, slots=True, eq=False)
class Matches:
    """The M tracks of a frame beside its N intruders.

    Attributes:
        target: (M,) intruder that a track lies on, -1 for none. Only intruders that are judged have tracks.
        first: (M,) whether it is the one track of its intruder; other tracks on the same one are duplicates.
        excused: (M,) at an intruder, in the world or in the picture, but not on a judged one: neither right nor wrong.
        overlapping: (K, 2) pairs of track and intruder that overlap in the picture, the intruder seen.
    """

    target: NDArray[np.int64]
    first: NDArray[np.bool_]
    excused: NDArray[np.bool_]
    overlapping: NDArray[np.int64]

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
    there = np.flatnonzero(objects.present)
    away_m = np.linalg.norm(answers.place_m[:, None, :2] - objects.place_m[None, there, :2], axis=2)
    near = away_m <= RADIUS_M
    boxes = answers.box_xyxy[:, None], objects.box_xyxy[None, there]
    overlaps = overlaps_of(*boxes)
    may = near & overlaps & objects.judged[there]
    target, first = np.full(len(may), -1), np.zeros(len(may), dtype=bool)
    if may.any():
        kept = answers.identity[:, None] == latest[there]
        worth = np.where(may, _KEPT * kept + 2.0 - away_m / RADIUS_M, 0.0)
        rows, columns = linear_sum_assignment(-worth)
        paired = may[rows, columns]
        target[rows[paired]], first[rows[paired]] = there[columns[paired]], True
        spare = may.any(axis=1) & ~first
        target[spare] = there[np.where(may, away_m, np.inf)[spare].argmin(axis=1)]
    at_it = _inside(answers.position_px, objects.box_xyxy[there]) | (_shared(*boxes) >= _AT_IT_IOU)
    pairs = np.argwhere(overlaps & objects.seen[there])
    pairs[:, 1] = there[pairs[:, 1]]
    return Matches(target, first, (target < 0) & (near | at_it).any(axis=1), pairs)


def overlaps_of(a_xyxy: NDArray[np.float64], b_xyxy: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return (...) whether boxes (..., 4) meet; a box of no extent meets those it lies in."""
    sides = np.minimum(a_xyxy[..., 2:], b_xyxy[..., 2:]) - np.maximum(a_xyxy[..., :2], b_xyxy[..., :2])
    inside = (a_xyxy[..., :2] >= b_xyxy[..., :2]) & (a_xyxy[..., 2:] <= b_xyxy[..., 2:])
    return np.asarray((sides > 0).all(axis=-1) | inside.all(axis=-1))


def _shared(a_xyxy: NDArray[np.float64], b_xyxy: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the intersection over union (...) of boxes (..., 4)."""
    sides = np.minimum(a_xyxy[..., 2:], b_xyxy[..., 2:]) - np.maximum(a_xyxy[..., :2], b_xyxy[..., :2])
    shared = np.maximum(sides, 0.0).prod(axis=-1)
    areas = [(each[..., 2:] - each[..., :2]).prod(axis=-1) for each in (a_xyxy, b_xyxy)]
    union = areas[0] + areas[1] - shared
    return np.divide(shared, union, out=np.zeros_like(shared), where=union > 0)


def _inside(points_px: NDArray[np.float64], boxes_xyxy: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return (M, P) whether points lie in boxes that are ``_AT_IT_PX`` larger on each side."""
    points = points_px[:, None]
    low, high = boxes_xyxy[None, :, :2] - _AT_IT_PX, boxes_xyxy[None, :, 2:] + _AT_IT_PX
    return np.asarray(((points >= low) & (points <= high)).all(axis=-1))
