"""Tests whether a tracker's answer is on the target, on another person, or nowhere.

A frame counts as right (A), wrong (B) or missed (C)::

    A  an answer within 0.5 m of the target on the ground
    B  any other answer
    C  no answer although at least a tenth of the target is visible

Frames on which nothing of the target is visible do not count, nor does frame 0, where the answer is given.
``P = A / (A + B)``, ``R = A / (A + C)``, ``F = 2 P R / (P + R) = 2 A / (2 A + B + C)`` are paper B's. There a wrong
answer removes a frame from the recall, so a tracker that always answers, even with a constant, cannot miss. Trackers
are ranked by the F1 of detection, in which a wrong answer is a false positive and leaves the target missed:
``R = A / (A + B + C)`` and ``F1 = 2 A / (2 A + 2 B + C)``. A wrong answer costs more than none.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from scenarios.stereo_follow.truth import StereoTruth
from sim.optics import rays
from trackers.types import CameraModel, Estimate

RIGHT_WITHIN_M = 0.5
WORST_ERROR_M = 5.0
"""Cap of every error, and the error without an answer or without a place of it."""
SEEN_AT_LEAST = 0.1
ANSWERS_FROM = 0.5
"""Probability of being in view from which a tracker answers."""


class Outcome(IntEnum):
    """Classification of a frame, as stored in series of rows."""

    UNCOUNTED = 0
    RIGHT = 1
    WRONG = 2
    MISSED = 3
    WRONG_PERSON = 4
    """Wrong, and on another person."""
    UNCOUNTED_WRONG_PERSON = 5
    """On another person while nothing of the target is seen."""


@dataclass(frozen=True, eq=False)
class PeopleSeries:
    """Truth of F frames with N people, without its pictures.

    Attributes:
        rate_hz: frames a second.
        target: index of the target among the people.
        ground_m: (F, N, 2) world positions.
        visible_fraction: (F,) of the target.
        out: (F,) the target is wholly outside the picture.
        place: (F,) str, where the target is.
        light_event: (F,) str, the present change of light; "" without one.
        near_person: (F,) bool, another person is within 1.5 m of the camera and in its picture.
    """

    rate_hz: float
    target: int
    ground_m: NDArray[np.float64]
    visible_fraction: NDArray[np.float64]
    out: NDArray[np.bool_]
    place: NDArray[np.str_]
    light_event: NDArray[np.str_]
    near_person: NDArray[np.bool_]

    @property
    def seen(self) -> NDArray[np.bool_]:
        """(F,) at least a tenth of the target is seen, on a frame that counts."""
        return (self.visible_fraction >= SEEN_AT_LEAST) & (np.arange(len(self.place)) > 0)


def answers(estimate: Estimate) -> bool:
    """Return whether an estimate is an answer: a finite position, and a probability of at least 0.5 or none."""
    probability = estimate.in_view_probability
    return bool(np.isfinite(estimate.position_px).all()) and (probability is None or probability >= ANSWERS_FROM)


def answered_place_m(estimate: Estimate, truth: StereoTruth, camera: CameraModel) -> NDArray[np.float64]:
    """Return the answer's place (2,) on the ground: ``c + depth * ray(position)`` without its height, or NaN.

    A tracker of one camera cannot measure depth. It gets the *true* depth of the surface at its position, so that only
    the person at that position counts. A position outside the picture or on the sky gives NaN.
    """
    position_px = np.asarray(estimate.position_px, dtype=float)
    if estimate.depth_m is None:
        height, width = truth.depth_m.shape
        inside = ((position_px >= 0) & (position_px < (width, height))).all()
        column, row = position_px.astype(int) if inside else (0, 0)
        depth_m = float(truth.depth_m[row, column]) if inside else float("nan")
    else:
        depth_m = float(estimate.depth_m)
    if not np.isfinite([*position_px, depth_m]).all():
        return np.full(2, np.nan)
    ray = rays(camera, truth.T_world_camera, position_px)
    return (truth.T_world_camera[:3, 3] + depth_m * ray)[:2]


def distances_m(truth: PeopleSeries, place_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the distances (F, N) of answers (F, 2) to all people; infinite for an answer without a place."""
    distance_m = np.linalg.norm(place_m[:, None] - truth.ground_m, axis=-1)
    return np.where(np.isfinite(distance_m), distance_m, np.inf)


def on_other(truth: PeopleSeries, place_m: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return (F,): index of the other person that the answer is on; -1 = none.

    An answer is on another person if it is within 0.5 m of that person and not within 0.5 m of the target; of several
    persons the nearest counts.
    """
    distance_m = distances_m(truth, place_m)
    wrong = distance_m[:, truth.target] > RIGHT_WITHIN_M
    distance_m[:, truth.target] = np.inf
    nearest = np.argmin(distance_m, axis=1)
    on = wrong & (distance_m[np.arange(len(nearest)), nearest] < RIGHT_WITHIN_M)
    return np.where(on, nearest, -1)


def outcomes(truth: PeopleSeries, given: NDArray[np.bool_], place_m: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the classification (F,) of every frame, see ``Outcome``.

    Args:
        given: (F,) there is an answer. place_m: (F, 2) its place on the ground, NaN without one.
    """
    place_m = np.where(given[:, None], place_m, np.nan)
    right = distances_m(truth, place_m)[:, truth.target] <= RIGHT_WITHIN_M
    other = on_other(truth, place_m) >= 0
    hidden = truth.visible_fraction == 0
    outcome = np.full(len(truth.place), int(Outcome.UNCOUNTED))
    outcome[~given & truth.seen] = Outcome.MISSED
    outcome[given & ~hidden] = Outcome.WRONG
    outcome[given & ~hidden & other] = Outcome.WRONG_PERSON
    outcome[given & hidden & other] = Outcome.UNCOUNTED_WRONG_PERSON
    outcome[given & ~hidden & right] = Outcome.RIGHT
    outcome[0] = Outcome.UNCOUNTED
    return outcome


def counts(outcome: NDArray[np.int64]) -> tuple[int, int, int]:
    """Return the numbers A, B and C of right, wrong and missed frames among outcomes (K,)."""
    wrong = np.isin(outcome, (Outcome.WRONG, Outcome.WRONG_PERSON))
    return int((outcome == Outcome.RIGHT).sum()), int(wrong.sum()), int((outcome == Outcome.MISSED).sum())


def on_wrong_person(outcome: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return (K,): the answer is on another person, whether or not the target is seen."""
    return np.isin(outcome, (Outcome.WRONG_PERSON, Outcome.UNCOUNTED_WRONG_PERSON))


def position_error_m(
    truth: PeopleSeries, given: NDArray[np.bool_], place_m: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return ``min(|answer - target|, 5)`` (F,) in metres; 5 without an answer or its place.

    No frame is left out because the tracker is lost.
    """
    distance_m = distances_m(truth, np.where(given[:, None], place_m, np.nan))[:, truth.target]
    return np.minimum(distance_m, WORST_ERROR_M)
