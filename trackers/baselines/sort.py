"""SORT on the detections of ``fish_chain``: Bewley et al., Simple online and realtime tracking, ICIP 2016."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from trackers.fish_chain.detection import Detection, Detector, DetectorParameters
from trackers.kernels.boxes import intersections_over_union
from trackers.registry import register, tunable
from trackers.types import CameraModel, Estimate, Observation, Track


@dataclass(frozen=True)
class SortParameters:
    """Parameters of ``sort``.

    Attributes:
        least_overlap: intersection over union from which on a detection may continue a track; published 0.3.
        max_age: frames without a detection after which a track ends; published 1.
        min_hits: detections after which a track is answered; published 3.
    """

    least_overlap: float = tunable(0.02, 0.01, 0.5, log=True)
    max_age: int = tunable(30, 1, 60)
    min_hits: int = tunable(1, 1, 5)


class BoxFilter:
    """Kalman filter of constant velocity on x = (u, v, s, r, u', v', s'): centre, area and ratio of a box.

    ``x' = F x, P' = F P Fᵀ + Q``; ``K = P Hᵀ (H P Hᵀ + R)⁻¹, x += K (z - H x), P -= K H P``, H picks u, v, s, r. The
    matrices are those of the authors' program.
    """

    _F = np.eye(7) + np.eye(7, k=4)
    _Q = np.diag([1, 1, 1, 1, 1e-2, 1e-2, 1e-4])
    _R = np.diag([1.0, 1.0, 10.0, 10.0])

    def __init__(self, box_xyxy: NDArray[np.float64]) -> None:
        self._x = np.concatenate([_measurement(box_xyxy), np.zeros(3)])
        self._P = np.diag([10.0] * 4 + [1e4] * 3)

    def predict(self) -> NDArray[np.float64]:
        """Move on by a frame and return the expected box (4,)."""
        if self._x[2] + self._x[6] <= 0:
            self._x[6] = 0.0
        self._x = self._F @ self._x
        self._P = self._F @ self._P @ self._F.T + self._Q
        width = np.sqrt(max(self._x[2] * self._x[3], 0.0))
        half = 0.5 * np.array([width, self._x[2] / width if width > 0 else 0.0])
        return np.concatenate([self._x[:2] - half, self._x[:2] + half])

    def distances(self, places_px: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the squared Mahalanobis distances (M,) of places (M, 2) to the expected centre."""
        away_px = places_px - self._x[:2]
        return np.asarray((away_px @ np.linalg.inv((self._P[:4, :4] + self._R)[:2, :2]) * away_px).sum(axis=1))

    def correct(self, box_xyxy: NDArray[np.float64]) -> None:
        """Take in a detected box (4,)."""
        gain = self._P[:, :4] @ np.linalg.inv(self._P[:4, :4] + self._R)
        self._x = self._x + gain @ (_measurement(box_xyxy) - self._x[:4])
        self._P = self._P - gain @ self._P[:4]


def _measurement(box_xyxy: NDArray[np.float64]) -> NDArray[np.float64]:
    width, height = box_xyxy[2:] - box_xyxy[:2]
    return np.array([*(0.5 * (box_xyxy[:2] + box_xyxy[2:])), width * height, width / height])


class Target:
    """A fish that is followed.

    Attributes:
        identity: its name. filter: of its box. detection: the last one.
        frames_since: that one. streak: detections on successive frames.
    """

    def __init__(self, identity: int, detection: Detection) -> None:
        self.identity = identity
        self.filter = BoxFilter(detection.box_xyxy)
        self.detection = detection
        self.frames_since = 0
        self.streak = 0

    def predict(self) -> NDArray[np.float64]:
        """Move on by a frame and return the expected box (4,)."""
        if self.frames_since > 0:
            self.streak = 0
        self.frames_since += 1
        return self.filter.predict()

    def correct(self, detection: Detection) -> None:
        """Take in the detection of this frame."""
        self.filter.correct(detection.box_xyxy)
        self.detection = detection
        self.frames_since = 0
        self.streak += 1


class FollowsDetections:
    """A ``MultiTracker`` of what the detector of ``fish_chain`` finds."""

    def __init__(self, parameters: Any, rng: np.random.Generator) -> None:
        self._parameters = parameters
        self._begin(())

    def start(self, background: Sequence[Observation], camera: CameraModel) -> None:
        """See ``MultiTracker``."""
        self._begin(background)

    def _begin(self, background: Sequence[Observation]) -> None:
        """Begin a video: without targets, with the detector on its background."""
        self._detector = Detector(DetectorParameters())
        self._detector.start(background)
        self._identities = 0

    def update(self, observation: Observation) -> list[Track]:
        """See ``MultiTracker``."""
        return self.follow(self._detector.detect(observation))

    def follow(self, detections: Sequence[Detection]) -> list[Track]:
        """Return the tracks on a frame with these detections."""
        raise NotImplementedError


@register("sort", role="baseline", summary="SORT: box Kalman filters, assignment by overlap", suites=("fish", "many"))
class Sort(FollowsDetections):
    """SORT; it answers the detections that it assigned, which lie nearer to the fish than the filters' boxes.

    Identities are those of the authors' program (checked against it).

    The boxes of small, slender fish overlap little from frame to frame, and fish are hidden for longer than people: the
    defaults were chosen by HOTA on development seeds of ``standard`` (0, 1) and ``hard`` (0), 40 settings tried.
    """

    Parameters = SortParameters
    _parameters: SortParameters

    def _begin(self, background: Sequence[Observation]) -> None:
        super()._begin(background)
        self._targets: list[Target] = []
        self._frames = 0

    def follow(self, detections: Sequence[Detection]) -> list[Track]:
        """Return the tracks on a frame with these detections."""
        p = self._parameters
        self._frames += 1
        expected = np.array([each.predict() for each in self._targets]).reshape(-1, 4)
        taken = set()
        for row, column in self._matched(expected, detections):
            self._targets[row].correct(detections[column])
            taken.add(column)
        for column, detection in enumerate(detections):
            if column not in taken:
                self._targets.append(self._begun(self._identities, detection))
                self._identities += 1
        self._targets = [each for each in self._targets if each.frames_since <= p.max_age]
        sure = [each for each in self._targets if each.streak >= p.min_hits or self._frames <= p.min_hits]
        return [track_of(each.identity, each.detection) for each in sure if each.frames_since == 0]

    def _matched(self, expected_xyxy: NDArray[np.float64], detections: Sequence[Detection]) -> list[tuple[int, int]]:
        """Return which targets (rows), of these expected boxes (N, 4), are which of the detections (columns)."""
        return matched_by_overlap(expected_xyxy, detections, self._parameters.least_overlap)

    def _begun(self, identity: int, detection: Detection) -> Target:
        return Target(identity, detection)


def matched_by_overlap(
    expected_xyxy: NDArray[np.float64], detections: Sequence[Detection], least: float
) -> list[tuple[int, int]]:
    """Return rows and columns of the assignment of most overlap of boxes (N, 4) and detections, from ``least`` on."""
    boxes = np.array([each.box_xyxy for each in detections]).reshape(-1, 4)
    overlap = intersections_over_union(expected_xyxy, boxes)
    pairs = zip(*_pairs(overlap, least), strict=True)
    return [(int(row), int(column)) for row, column in pairs if overlap[row, column] >= least]


def _pairs(overlap: NDArray[np.float64], least: float) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return rows and columns (K,) of the assignment of most overlap (N, M), pairs below ``least`` among them.

    As in the authors' program, pairs of which no two compete are taken as they are: the sum of all overlaps could be
    greater without them.
    """
    enough = overlap > least
    if enough.any() and enough.sum(axis=0).max() == 1 and enough.sum(axis=1).max() == 1:
        rows, columns = np.nonzero(enough)
    else:
        rows, columns = linear_sum_assignment(-overlap)
    return rows, columns


def track_of(identity: int, detection: Detection) -> Track:
    """Return a detection as the track of a target."""
    estimate = Estimate(
        detection.position_px,
        detection.box_xyxy,
        heading_rad=detection.heading_rad,
        centre_line_px=detection.centre_line_px,
    )
    return Track(identity, estimate, kind="fish", confidence=detection.score)
