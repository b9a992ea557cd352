"""ByteTrack on the detections of ``fish_chain``: Zhang et al., Multi-object tracking by associating every detection
box, ECCV 2022.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from trackers.baselines.sort import FollowsDetections, track_of
from trackers.fish_chain.detection import Detection
from trackers.kernels.boxes import intersections_over_union
from trackers.registry import register, tunable
from trackers.types import Observation, Track


@dataclass(frozen=True)
class ByteTrackParameters:
    """Parameters of ``bytetrack``; costs are 1 - intersection over union.

    Attributes:
        high, low: scores from which on a detection takes part in the first and in the second association; published
            0.6 and 0.1. A track begins at ``high`` + 0.1.
        first_cost, second_cost, new_cost: greatest costs in the first association (there times the score), in the
            second, and of tracks that are one frame old; published 0.8, 0.5 and 0.7.
        buffer_frames: for which a lost track is kept; published 30.
        duplicate_cost: a lost and a followed track that are nearer are one; published 0.15.
    """

    high: float = tunable(0.7, 0.3, 0.8)
    low: float = tunable(0.15, 0.02, 0.3)
    first_cost: float = tunable(0.98, 0.6, 0.999)
    second_cost: float = tunable(0.9, 0.4, 0.999)
    new_cost: float = tunable(0.75, 0.5, 0.999)
    buffer_frames: int = tunable(25, 5, 200)
    duplicate_cost: float = 0.15


_ABOVE_HIGH = 0.1


class HeightFilter:
    """Kalman filter of constant velocity on (u, v, a, h) and their changes: centre, width over height, and height.

    Standard deviations are shares of the height, 1/20 for places and 1/160 for velocities, as in the authors' program.
    """

    _F = np.eye(8) + np.eye(8, k=4)

    def __init__(self, box_xyxy: NDArray[np.float64]) -> None:
        z = _measurement(box_xyxy)
        self._x = np.concatenate([z, np.zeros(4)])
        h = z[3]
        self._P = np.diag(np.square([h / 10, h / 10, 1e-2, h / 10, h / 16, h / 16, 1e-5, h / 16]))

    def predict(self, lost: bool) -> None:
        """Move on by a frame; the height of a lost target is kept."""
        if lost:
            self._x[7] = 0.0
        h = self._x[3]
        noise = np.diag(np.square([h / 20, h / 20, 1e-2, h / 20, h / 160, h / 160, 1e-5, h / 160]))
        self._x = self._F @ self._x
        self._P = self._F @ self._P @ self._F.T + noise

    def correct(self, box_xyxy: NDArray[np.float64]) -> None:
        """Take in a detected box (4,)."""
        h = self._x[3]
        noise = np.diag(np.square([h / 20, h / 20, 1e-1, h / 20]))
        gain = self._P[:, :4] @ np.linalg.inv(self._P[:4, :4] + noise)
        self._x = self._x + gain @ (_measurement(box_xyxy) - self._x[:4])
        self._P = self._P - gain @ self._P[:4]

    @property
    def box_xyxy(self) -> NDArray[np.float64]:
        """(4,) the expected box."""
        half = 0.5 * np.array([self._x[2] * self._x[3], self._x[3]])
        return np.concatenate([self._x[:2] - half, self._x[:2] + half])


def _measurement(box_xyxy: NDArray[np.float64]) -> NDArray[np.float64]:
    width, height = box_xyxy[2:] - box_xyxy[:2]
    return np.array([*(0.5 * (box_xyxy[:2] + box_xyxy[2:])), width / height, height])


class _Target:
    def __init__(self, identity: int, detection: Detection, frame: int) -> None:
        self.identity = identity
        self.filter = HeightFilter(detection.box_xyxy)
        self.detection = detection
        self.first_frame = self.last_frame = frame
        self.confirmed = frame == 0

    def correct(self, detection: Detection, frame: int) -> None:
        self.filter.correct(detection.box_xyxy)
        self.detection, self.last_frame, self.confirmed = detection, frame, True


@register(
    "bytetrack", role="baseline", summary="ByteTrack: weak detections continue tracks too", suites=("fish", "many")
)
class ByteTrack(FollowsDetections):
    """ByteTrack; it answers the detections that it assigned. Identities are those of the authors' program (checked).

    Overlaps are those of continuous boxes; the library of the authors' program adds a pixel to each width and height.

    The boxes of small, slender fish overlap little from frame to frame: the defaults were chosen by HOTA on development
    seeds of ``standard`` (0, 1) and ``hard`` (0), 80 settings tried.
    """

    Parameters = ByteTrackParameters
    _parameters: ByteTrackParameters

    def _begin(self, background: Sequence[Observation]) -> None:
        super()._begin(background)
        self._targets: list[_Target] = []
        self._expired: set[int] = set()
        self._frame = -1

    def follow(self, detections: Sequence[Detection]) -> list[Track]:
        """Return the tracks on a frame with these detections."""
        p, self._frame = self._parameters, self._frame + 1
        strong = [each for each in detections if each.score > p.high]
        weak = [each for each in detections if p.low < each.score < p.high]
        confirmed = [each for each in self._targets if each.confirmed]
        for each in confirmed:
            each.filter.predict(lost=each.last_frame < self._frame - 1)
        unmatched, strong = self._associate(confirmed, strong, p.first_cost, fused=True)
        followed = [each for each in unmatched if each.last_frame == self._frame - 1]
        self._associate(followed, weak, p.second_cost)
        tentative = [each for each in self._targets if not each.confirmed]
        gone, strong = self._associate(tentative, strong, p.new_cost, fused=True)
        begun = []
        for detection in strong:
            if detection.score >= p.high + _ABOVE_HIGH:
                begun.append(_Target(self._identities, detection, self._frame))
                self._identities += 1
        kept = [each for each in self._targets if each not in gone] + begun
        kept = [each for each in kept if each.last_frame == self._frame or each.identity not in self._expired]
        # As in the authors' program: a target that outlasts the buffer may be found for one more frame, and one found
        # then is dropped as soon as it is lost again.
        self._expired |= {each.identity for each in kept if self._frame - each.last_frame > p.buffer_frames}
        self._targets = self._without_duplicates(kept)
        current = [each for each in self._targets if each.confirmed and each.last_frame == self._frame]
        return [track_of(each.identity, each.detection) for each in current]

    def _associate(
        self, targets: Sequence[_Target], detections: Sequence[Detection], most: float, fused: bool = False
    ) -> tuple[list[_Target], list[Detection]]:
        """Correct targets by detections of a cost of at most ``most``; return the targets and detections left."""
        boxes = np.array([each.filter.box_xyxy for each in targets]).reshape(-1, 4)
        found = np.array([each.box_xyxy for each in detections]).reshape(-1, 4)
        likeness = intersections_over_union(boxes, found)
        if fused:
            likeness = likeness * np.array([each.score for each in detections])
        # Pairs above the limit cost as much as none at all, as in the authors' solver.
        cost = np.minimum(1.0 - likeness, most)
        rows, columns = linear_sum_assignment(cost)
        pairs = [(r, c) for r, c in zip(rows, columns, strict=True) if cost[r, c] < most]
        for row, column in pairs:
            targets[row].correct(detections[column], self._frame)
        matched, taken = {row for row, _ in pairs}, {column for _, column in pairs}
        left = [each for k, each in enumerate(targets) if k not in matched]
        return left, [each for k, each in enumerate(detections) if k not in taken]

    def _without_duplicates(self, targets: list[_Target]) -> list[_Target]:
        """Return the targets without those of a pair, one followed and one lost, that is one; the older one stays."""
        followed = [each for each in targets if each.last_frame == self._frame]
        lost = [each for each in targets if each.last_frame < self._frame]
        boxes = [np.array([each.filter.box_xyxy for each in group]).reshape(-1, 4) for group in (followed, lost)]
        removed = set()
        for a, b in np.argwhere(1.0 - intersections_over_union(*boxes) < self._parameters.duplicate_cost):
            ages = [each.last_frame - each.first_frame for each in (followed[a], lost[b])]
            removed.add(id(lost[b]) if ages[0] > ages[1] else id(followed[a]))
        return [each for each in targets if id(each) not in removed]
