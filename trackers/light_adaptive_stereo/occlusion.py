"""Occlusion of the target, and tracking of other people during it (paper B, section 3.3).

The paper takes its method from an earlier one and describes it so: the state of occlusion is estimated from the
positions of the target and of objects and people around it; it determines when the colour template may be updated and
how long prediction continues; during an occlusion other people are tracked by Kalman filters and associated from frame
to frame. The details are a reading.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from trackers.light_adaptive_stereo.candidates import Candidate
from trackers.light_adaptive_stereo.person_kalman import PersonKalman
from trackers.light_adaptive_stereo.robot_frame import Mounting
from trackers.types import CameraModel


class Occlusion(Enum):
    """No occluder near the line of sight; one near it or over a part; most is hidden; the target reappears."""

    NONE = "none"
    STARTING = "starting"
    OCCLUDED = "occluded"
    ENDING = "ending"


@dataclass(frozen=True)
class OcclusionParameters:
    """Limits of the states of occlusion.

    Attributes:
        nearer_m: an occluder is at least this much nearer than the target.
        body_width_m: width of the target's body.
        margin_m: width beside the body in which an occluder counts as about to hide it.
        lowest_m: height above which the body counts; below it the ground may be nearer.
        hidden_share: least hidden share of the body at which it is occluded.
        beside_share: least hidden share of the body with its margins at which an occlusion starts.
        same_m: association gate of another person: largest distance from the expected position.
        others_kept_s: time after which an unseen person is dropped.
    """

    nearer_m: float = 0.4
    body_width_m: float = 0.5
    margin_m: float = 0.3
    lowest_m: float = 0.4
    hidden_share: float = 0.5
    beside_share: float = 0.1
    same_m: float = 0.6
    others_kept_s: float = 1.0


def share_before(
    depth_m: NDArray[np.float32],
    place_m: NDArray[np.float64],
    height_m: float,
    width_m: float,
    mounting: Mounting,
    camera: CameraModel,
    parameters: OcclusionParameters,
) -> float:
    """Return the share of a body at a position (2,) that is hidden by nearer points, of its pixels with known depth.

    Args:
        depth_m: (H', W') of the left picture, NaN where unknown.
        width_m: width of the body around the position.

    Returns:
        A share in [0, 1]; 0 for a body without known pixels in the picture.
    """
    shrink = camera.width_px / depth_m.shape[1]
    ends_m = np.column_stack([np.tile(place_m, (2, 1)), [parameters.lowest_m, height_m]])
    (x, bottom), (_, top) = mounting.pixels(ends_m, camera) / shrink
    distance_m = mounting.depth_m(ends_m[0])
    half_px = 0.5 * width_m * camera.focal_px / shrink / max(distance_m, 0.05)
    rows, columns = (
        slice(*np.clip(np.round(edges), 0, size).astype(int))
        for edges, size in (((top, bottom), depth_m.shape[0]), ((x - half_px, x + half_px), depth_m.shape[1]))
    )
    seen_m = depth_m[rows, columns]
    known = int(np.isfinite(seen_m).sum())
    return float((seen_m < distance_m - parameters.nearer_m).sum()) / max(known, 1)


class OcclusionState:
    """State machine: none, starting, occluded, ending, and none again once no occluder is near the line of sight."""

    def __init__(self, parameters: OcclusionParameters) -> None:
        self._parameters = parameters
        self.now = Occlusion.NONE

    @property
    def template_may_change(self) -> bool:
        """Whether the colour template may be updated: not with an occluder at or near the line of sight."""
        return self.now is Occlusion.NONE

    def update(self, hidden: float, beside: float, found_last: bool) -> Occlusion:
        """Return the state of the next frame.

        Args:
            hidden: hidden share of the body at the target's expected position. beside: the same with its margins.
            found_last: whether the target was found in the previous frame; an occlusion ends only if it was.
        """
        near = beside >= self._parameters.beside_share
        was_hidden = self.now in (Occlusion.OCCLUDED, Occlusion.ENDING)
        if hidden >= self._parameters.hidden_share:
            self.now = Occlusion.OCCLUDED
        elif was_hidden and (near or not found_last):
            self.now = Occlusion.ENDING
        else:
            self.now = Occlusion.STARTING if near else Occlusion.NONE
        return self.now

    def reset(self) -> None:
        """Return to ``NONE``: the target's position is unknown."""
        self.now = Occlusion.NONE


@dataclass
class _Other:
    filter: PersonKalman
    unseen_s: float = 0.0


class OtherPeople:
    """People other than the target, tracked by position while it is hidden or about to be."""

    def __init__(self, parameters: OcclusionParameters, acceleration_mps2: float, place_noise_m: float) -> None:
        self._parameters = parameters
        self._acceleration_mps2, self._place_noise_m = acceleration_mps2, place_noise_m
        self._others: list[_Other] = []

    @property
    def places_m(self) -> NDArray[np.float64]:
        """Their expected positions (M, 2)."""
        return np.array([other.filter.place_m for other in self._others]).reshape(-1, 2)

    def predict(self, seconds: float) -> None:
        """Predict by ``seconds``."""
        for other in self._others:
            other.filter.predict(seconds)
            other.unseen_s += seconds

    def associate(
        self, candidates: Sequence[Candidate], target_costs: NDArray[np.float64], target_limit: float, per_m: float
    ) -> tuple[int | None, list[int | None]]:
        """Assign candidates to the target and the other people: the least sum of costs, each within its limit.

        The cost of another person is the distance from their expected position times ``per_m``; no candidate costs the
        limit. So a candidate that fits another person better is not taken for the target. Without other people the
        target is the candidate of least cost.

        Args:
            target_costs: (N,) cost of each candidate as the target.

        Returns:
            The index of the target's candidate, and those of the other people's in their order; None for no candidate.
        """
        places_m = np.array([candidate.place_m for candidate in candidates]).reshape(-1, 2)
        others_costs = per_m * np.linalg.norm(self.places_m[:, None] - places_m[None], axis=2)
        costs = np.concatenate([np.reshape(target_costs, (1, -1)), others_costs])
        limits = np.array([target_limit] + [per_m * self._parameters.same_m] * len(self._others))
        chosen = assign(costs, limits)
        return chosen[0], chosen[1:]

    def correct(
        self,
        candidates: Sequence[Candidate],
        target: int | None,
        associated: Sequence[int | None],
        expected_m: NDArray[np.float64],
    ) -> None:
        """Correct by the associated candidates, drop people not seen for long, and track the other candidates.

        While the target is not found, a candidate near its expected position may be the target and is not tracked.

        Args:
            expected_m: (2,) expected position of the target.
        """
        p = self._parameters
        for other, index in zip(self._others, associated, strict=True):
            if index is not None:
                other.filter.correct(candidates[index].place_m)
                other.unseen_s = 0.0
        self._others = [other for other in self._others if other.unseen_s <= p.others_kept_s]
        for index, candidate in enumerate(candidates):
            away_m = np.hypot(*(candidate.place_m - expected_m))
            if index != target and index not in associated and (target is not None or away_m > p.same_m):
                self._others.append(
                    _Other(PersonKalman(candidate.place_m, self._acceleration_mps2, self._place_noise_m))
                )

    def clear(self) -> None:
        """Drop all."""
        self._others = []


def assign(costs: NDArray[np.float64], limits: NDArray[np.float64]) -> list[int | None]:
    """Return the column of ``costs`` (R, C) assigned to each row, or None, with the least sum of costs.

    None costs the row's limit (R,), and no cost above it is chosen.
    """
    rows, columns = costs.shape
    never = 1e6
    allowed = np.where(costs <= limits[:, None], costs, never)
    none = np.where(np.eye(rows, dtype=bool), limits[:, None], never)
    chosen = linear_sum_assignment(np.concatenate([allowed, none], axis=1))[1]
    return [int(column) if column < columns else None for column in chosen]
