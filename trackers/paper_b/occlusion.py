"""Whether the target is hidden, by where it and others are, and who the others are meanwhile (paper 002, section 3.3).

The paper takes its method from an earlier one and says of it: the state of occlusion is estimated from the positions of
the target and of objects and people around it; it sets when the colour template may be updated and how long prediction
goes on; during an occlusion others are tracked by Kalman filters and associated from frame to frame. How, is a reading.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from trackers.paper_b.candidates import Candidate
from trackers.paper_b.person_kalman import PersonKalman
from trackers.paper_b.robot_frame import Mounting
from trackers.types import CameraModel


class Occlusion(Enum):
    """Nobody near the line of sight; something comes near or hides a part; most is hidden; it comes out again."""

    NONE = "none"
    STARTING = "starting"
    OCCLUDED = "occluded"
    ENDING = "ending"


@dataclass(frozen=True)
class OcclusionParameters:
    """When the target counts as hidden.

    Attributes:
        nearer_m: what is nearer than the target by this is before it.
        body_width_m: what of the target must be free.
        margin_m: how far beside the body something near counts as about to hide it.
        lowest_m: lower down the ground is before the target.
        hidden_share: from this share of the body on it is occluded.
        beside_share: from this share of the body with its margins on an occlusion is starting.
        same_m: what is this near to where an other is expected is he.
        others_kept_s: how long an other is expected who is not seen.
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
    """Return how much of a body at a place (2,) something nearer covers, a share of the pixels with a known distance.

    Args:
        depth_m: (H', W') of the left picture, NaN where it is unknown.
        width_m: of the body; its middle is at the place. Nothing of it in the picture, or unknown, is a share of 0.
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
    """Goes from none over starting and occluded to ending, and back when nobody is near the line of sight any more."""

    def __init__(self, parameters: OcclusionParameters) -> None:
        self._parameters = parameters
        self.now = Occlusion.NONE

    @property
    def template_may_change(self) -> bool:
        """Whether colours are the target's own: not while somebody is before it or beside its line of sight."""
        return self.now is Occlusion.NONE

    def update(self, hidden: float, beside: float, found_last: bool) -> Occlusion:
        """Return the state by what hides the target's expected place.

        Args:
            hidden: share of its body that something nearer covers. beside: the same of the body with its margins.
            found_last: whether the target was found in the frame before; a hidden one has to be for its end.
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
        """Forget it: the target's place is not known any more."""
        self.now = Occlusion.NONE


@dataclass
class _Other:
    filter: PersonKalman
    unseen_s: float = 0.0


class Others:
    """People besides the target, tracked by place while it is hidden or about to be."""

    def __init__(self, parameters: OcclusionParameters, acceleration_mps2: float, place_noise_m: float) -> None:
        self._parameters = parameters
        self._acceleration_mps2, self._place_noise_m = acceleration_mps2, place_noise_m
        self._others: list[_Other] = []

    @property
    def places_m(self) -> NDArray[np.float64]:
        """(M, 2) where they are expected."""
        return np.array([other.filter.place_m for other in self._others]).reshape(-1, 2)

    def predict(self, seconds: float) -> None:
        """Go on for some time."""
        for other in self._others:
            other.filter.predict(seconds)
            other.unseen_s += seconds

    def associate(
        self, candidates: Sequence[Candidate], target_costs: NDArray[np.float64], target_limit: float, per_m: float
    ) -> tuple[int | None, list[int | None]]:
        """Say which candidate is the target and which is which other: the least sum of costs, each within its limit.

        An other's cost is his distance to where he is expected times ``per_m``; not to be seen costs the limit. So a
        candidate whom an other explains better is not taken for the target. Without others it is the one of least cost.

        Args:
            target_costs: (N,) for each candidate to be the target.

        Returns:
            Index of the target's candidate, and those of the others' in their order; None where there is none.
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
        """Take in whom ``associate`` found; whoever else is seen becomes an other, unless he may be the target.

        Args:
            expected_m: (2,) where the target is expected.
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
        """Forget all."""
        self._others = []


def assign(costs: NDArray[np.float64], limits: NDArray[np.float64]) -> list[int | None]:
    """Return each row's column of ``costs`` (R, C), or None: the least sum, where none costs the row's limit (R,).

    What costs more than its row's limit is never chosen.
    """
    rows, columns = costs.shape
    never = 1e6
    allowed = np.where(costs <= limits[:, None], costs, never)
    none = np.where(np.eye(rows, dtype=bool), limits[:, None], never)
    chosen = linear_sum_assignment(np.concatenate([allowed, none], axis=1))[1]
    return [int(column) if column < columns else None for column in chosen]
