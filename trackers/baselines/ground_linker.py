"""Blobs of a foreground mask, upright on a quay or the water before it, and their tracks by Kalman filters."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from trackers.registry import tunable
from trackers.site import Site, SiteView, stood_on
from trackers.types import Estimate, Track


@dataclass(frozen=True)
class BlobParameters:
    """Parameters of the blobs.

    Attributes:
        opening_px, closing_px: sides of the squares of both morphological operations, 1 for none.
        least_area_px: of a blob.
        greatest_share: of the picture that may be foreground; beyond it the camera's gain has changed.
    """

    opening_px: int = tunable(1, 1, 3)
    closing_px: int = tunable(5, 1, 9)
    least_area_px: int = tunable(6, 2, 40)
    greatest_share: float = tunable(0.25, 0.05, 0.8)


@dataclass(frozen=True, eq=False)
class Blob:
    """An object on the quay or the water.

    Attributes:
        place_m: (3,) middle of its base, half its width behind the foot of the blob.
        covariance_m2: (2, 2) of the place: a pixel in each direction, and the object's own width.
        box_xyxy: (4,) in the picture.
        size_m: (3,) its width, twice, since its depth is not seen, and its height.
        strength: root of the sum of squared contrasts to noise over its pixels, >= 0.
    """

    place_m: NDArray[np.float64]
    covariance_m2: NDArray[np.float64]
    box_xyxy: NDArray[np.float64]
    size_m: NDArray[np.float64]
    strength: float


def blobs_of(
    foreground: NDArray[np.uint8], contrast: NDArray[np.float32], site: Site, parameters: BlobParameters
) -> list[Blob]:
    """Return the objects of a mask whose feet stand inside the watched volume, seen from above.

    Args:
        foreground: (H, W), not 0 where something is.
        contrast: (H, W) magnitude of the difference from the background, in standard deviations of its noise.
    """
    p = parameters
    mask = (foreground != 0).astype(np.uint8)
    if float(np.count_nonzero(mask)) > p.greatest_share * mask.size:
        return []
    for operation, side_px in ((cv2.MORPH_OPEN, p.opening_px), (cv2.MORPH_CLOSE, p.closing_px)):
        if side_px > 1:
            mask = cv2.morphologyEx(mask, operation, np.ones((side_px, side_px), np.uint8))
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask)
    power = np.bincount(labels.ravel(), weights=np.square(contrast, dtype=np.float64).ravel(), minlength=count)
    found = []
    for label in range(1, count):
        if stats[label, cv2.CC_STAT_AREA] >= p.least_area_px:
            blob = _standing(stats[label, : cv2.CC_STAT_AREA].astype(float), float(np.sqrt(power[label])), site)
            if blob is not None:
                found.append(blob)
    return found


def _standing(box_xywh: NDArray[np.float64], strength: float, site: Site) -> Blob | None:
    """Return a box (4,) in the picture as an object; None if it stands outside the watched volume."""
    x, y, width_px, height_px = box_xywh
    foot = np.array([x + 0.5 * width_px, y + height_px])
    feet_m = stood_on(site.survey, site.view, foot + np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]))
    if not (np.isfinite(feet_m).all() and site.volume.contains(feet_m[:1])[0]):
        return None
    depth_m = float(site.view.project(feet_m[:1])[1][0])
    width_m, height_m = np.array([width_px, height_px]) * depth_m / site.view.camera.focal_px
    steps_m = (feet_m[1:, :2] - feet_m[0, :2]).T
    covariance_m2 = steps_m @ steps_m.T + (0.25 * width_m) ** 2 * np.eye(2)
    box_xyxy = np.array([x, y, x + width_px, y + height_px])
    size_m = np.array([width_m, width_m, height_m])
    ahead = feet_m[0] - site.view.place_m
    ahead[2] = 0.0
    place_m = feet_m[0] + 0.5 * width_m * ahead / max(float(np.linalg.norm(ahead)), 1e-9)
    return Blob(place_m, covariance_m2, box_xyxy, size_m, strength)


_GATE = 13.8
"""Squared Mahalanobis distance that a blob of the object exceeds once in a thousand (chi-square, two dimensions)."""
_FORBIDDEN = 1e6
_LEAST_INTERVAL_S, _LONGEST_INTERVAL_S = 0.01, 60.0
_USUAL_HEIGHT_M, _USUAL_WIDTH_M = 1.7, 0.8
CONFIDENCE_FILE = "ground_confidence.json"
EVIDENCE = (
    "constant",
    "log_strength",
    *("log_height", "log_height_2", "too_high_2", "log_width", "log_width_2", "too_wide_2"),
    *("log_hits", "log_moved", "afloat"),
)
"""What the confidence of a track is a logistic regression on, see ``evidence_of``."""


@dataclass(frozen=True)
class LinkParameters:
    """Parameters of the linker.

    Attributes:
        start_speed_mps: standard deviation of an object's velocity at first, in each direction.
        acceleration_mps2: of white acceleration.
        most_missed: pictures in a row without a blob after which a track ends.
        least_hits: blobs from which on a track is answered.
    """

    start_speed_mps: float = tunable(1.5, 0.3, 8.0, log=True)
    acceleration_mps2: float = tunable(0.3, 0.02, 3.0, log=True)
    most_missed: int = tunable(15, 0, 60)
    least_hits: int = tunable(2, 1, 5)


class _Target:
    """State (x, y, x', y') on the ground: ``x' = F x, P' = F P Fᵀ + Q``, Q of white acceleration."""

    def __init__(self, identity: int, blob: Blob, start_speed_mps: float) -> None:
        self.identity, self.blob = identity, blob
        self.state = np.concatenate([blob.place_m[:2], np.zeros(2)])
        self.P = np.zeros((4, 4))
        self.P[:2, :2] = blob.covariance_m2
        self.P[2:, 2:] = start_speed_mps**2 * np.eye(2)
        self.hits, self.missed = 1, 0
        self.first_m = blob.place_m[:2]

    def predict(self, interval_s: float, acceleration_mps2: float) -> None:
        F = np.eye(4) + interval_s * np.eye(4, k=2)
        G = np.vstack([0.5 * interval_s**2 * np.eye(2), interval_s * np.eye(2)])
        self.state = F @ self.state
        self.P = F @ self.P @ F.T + acceleration_mps2**2 * G @ G.T

    def correct(self, blob: Blob) -> None:
        gain = self.P[:, :2] @ np.linalg.inv(self.P[:2, :2] + blob.covariance_m2)
        self.state = self.state + gain @ (blob.place_m[:2] - self.state[:2])
        self.P = self.P - gain @ self.P[:2]
        self.P = 0.5 * (self.P + self.P.T)
        self.blob, self.hits, self.missed = blob, self.hits + 1, 0


def evidence_of(
    strength: float, width_m: float, height_m: float, hits: int, moved_m: float, is_afloat: bool
) -> NDArray[np.float64]:
    """Return the evidence (11,) for a track, in the order of ``EVIDENCE``.

    How strongly it differs from the background, e.g. contrast to noise, height and width beside those of a person, on
    how many pictures it was found, the way that it has come since the first of these, since moored boats and shadows
    change where they are, and whether it is lower than the quay.
    """
    height, width = np.log(height_m / _USUAL_HEIGHT_M), np.log(width_m / _USUAL_WIDTH_M)
    heights = height, height**2, max(height, 0.0) ** 2
    widths = width, width**2, max(width, 0.0) ** 2
    strong = np.log(max(strength, 1.0))
    return np.array([1.0, strong, *heights, *widths, np.log(hits), np.log1p(moved_m), float(is_afloat)])


def _evidence(blob: Blob, hits: int, moved_m: float) -> NDArray[np.float64]:
    return evidence_of(blob.strength, blob.size_m[0], blob.size_m[2], hits, moved_m, bool(blob.place_m[2] < 0.0))


def learnt_weights(tracker: str, room: str = "trackers.baselines") -> NDArray[np.float64]:
    """Return the weights (11,) of ``EVIDENCE`` for a tracker of a room, learnt on development seeds."""
    stored = json.loads(resources.files(room).joinpath(CONFIDENCE_FILE).read_text())
    return np.array([stored["weights"][tracker][name] for name in EVIDENCE])


def probabilities(evidence: NDArray[np.float64], weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the confidences (N,) of tracks by their evidence (N, 11)."""
    return np.asarray(1.0 / (1.0 + np.exp(-np.clip(evidence @ weights, -700.0, 700.0))))


class GroundLinker:
    """Tracks of objects over the ground.

    Attributes:
        evidence: (N, 11) of the N tracks of the latest answer.
    """

    def __init__(self, parameters: LinkParameters, view: SiteView, weights: NDArray[np.float64]) -> None:
        """``weights``: (11,) of the evidence."""
        self._parameters, self._view, self._weights = parameters, view, weights
        self.evidence = np.empty((0, len(EVIDENCE)))
        self._targets: list[_Target] = []
        self._identities = 0
        self._time_s: float | None = None

    def follow(self, blobs: Sequence[Blob], time_s: float) -> list[Track]:
        """Return the tracks on a picture with these blobs, each with a blob of its own."""
        p = self._parameters
        interval_s = 0.0 if self._time_s is None else time_s - self._time_s
        self._time_s = time_s
        for each in self._targets:
            each.predict(min(max(interval_s, _LEAST_INTERVAL_S), _LONGEST_INTERVAL_S), p.acceleration_mps2)
        taken = self._assign(blobs)
        self._targets = [each for each in self._targets if each.missed <= p.most_missed]
        for k, blob in enumerate(blobs):
            if k not in taken:
                self._targets.append(_Target(self._identities, blob, p.start_speed_mps))
                self._identities += 1
        shown = [each for each in self._targets if each.missed == 0 and each.hits >= p.least_hits]
        moved_m = [float(np.hypot(*(each.state[:2] - each.first_m))) for each in shown]
        rows = [_evidence(each.blob, each.hits, moved) for each, moved in zip(shown, moved_m, strict=True)]
        self.evidence = np.array(rows).reshape(-1, len(EVIDENCE))
        confidences = probabilities(self.evidence, self._weights)
        return [self._track(each, float(sure)) for each, sure in zip(shown, confidences, strict=True)]

    def _assign(self, blobs: Sequence[Blob]) -> set[int]:
        """Correct the targets by the blobs that continue them, and return these: the least sum of distances."""
        cost = np.full((len(self._targets), len(blobs)), _FORBIDDEN)
        if cost.size:
            P = np.array([target.P[:2, :2] for target in self._targets])
            state_m = np.array([target.state[:2] for target in self._targets])
            S = P[:, None] + np.array([blob.covariance_m2 for blob in blobs])
            off_m = np.array([blob.place_m[:2] for blob in blobs]) - state_m[:, None]
            distance = (off_m * np.linalg.solve(S, off_m[..., None])[..., 0]).sum(axis=-1)
            cost = np.where(distance < _GATE, distance + np.log(np.linalg.det(S)), cost)
        taken = set()
        for target in self._targets:
            target.missed += 1
        for i, j in zip(*linear_sum_assignment(cost), strict=True):
            if cost[i, j] < _FORBIDDEN:
                self._targets[i].correct(blobs[j])
                taken.add(int(j))
        return taken

    def _track(self, target: _Target, confidence: float) -> Track:
        """Return the track of a target at its filtered place, or where its blob is if that is behind the camera."""
        blob = target.blob
        centre_m = np.array([*target.state[:2], blob.place_m[2] + 0.5 * blob.size_m[2]])
        px, depth_m = self._view.project(np.stack([centre_m, [*blob.place_m[:2], centre_m[2]]]))
        k = 0 if np.isfinite(px[0]).all() else 1
        half_px = 0.5 * (blob.box_xyxy[2:] - blob.box_xyxy[:2])
        estimate = Estimate(px[k], np.concatenate([px[k] - half_px, px[k] + half_px]), depth_m=float(depth_m[k]))
        return Track(target.identity, estimate, size_m=blob.size_m, confidence=confidence)
