"""The linker of the harbour's baselines: a Kalman filter on the ground for each object, and the assignment of blobs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from trackers.baselines.ground_blobs import Blob
from trackers.registry import tunable
from trackers.site.view import SiteView
from trackers.types import Estimate, Track

_GATE = 13.8
"""Squared Mahalanobis distance that a blob of the object exceeds once in a thousand (chi-square, two dimensions)."""
_FORBIDDEN = 1e6
_LEAST_INTERVAL_S, _LONGEST_INTERVAL_S = 0.01, 60.0


@dataclass(frozen=True)
class LinkParameters:
    """Parameters of the linker.

    Attributes:
        start_speed_mps: standard deviation of an object's velocity at first, in each direction.
        acceleration_mps2: of white acceleration.
        most_missed: pictures in a row without a blob after which a track ends.
        least_hits: blobs from which on a track is answered.
        sure_strength: contrast to noise of a blob at which half of its confidence is reached.
        hit_doubt: factor of the doubt of a track at each further blob.
    """

    start_speed_mps: float = tunable(1.5, 0.3, 8.0, log=True)
    acceleration_mps2: float = tunable(0.3, 0.02, 3.0, log=True)
    most_missed: int = tunable(3, 0, 30)
    least_hits: int = tunable(2, 1, 5)
    sure_strength: float = tunable(20.0, 2.0, 200.0, log=True)
    hit_doubt: float = tunable(0.8, 0.3, 0.97)


class _Target:
    """State (x, y, x', y') on the ground: ``x' = F x, P' = F P Fᵀ + Q``, Q of white acceleration."""

    def __init__(self, identity: int, blob: Blob, start_speed_mps: float) -> None:
        self.identity, self.blob = identity, blob
        self.state = np.concatenate([blob.place_m, np.zeros(2)])
        self.P = np.zeros((4, 4))
        self.P[:2, :2] = blob.covariance_m2
        self.P[2:, 2:] = start_speed_mps**2 * np.eye(2)
        self.hits, self.missed = 1, 0

    def predict(self, interval_s: float, acceleration_mps2: float) -> None:
        F = np.eye(4) + interval_s * np.eye(4, k=2)
        G = np.vstack([0.5 * interval_s**2 * np.eye(2), interval_s * np.eye(2)])
        self.state = F @ self.state
        self.P = F @ self.P @ F.T + acceleration_mps2**2 * G @ G.T

    def correct(self, blob: Blob) -> None:
        gain = self.P[:, :2] @ np.linalg.inv(self.P[:2, :2] + blob.covariance_m2)
        self.state = self.state + gain @ (blob.place_m - self.state[:2])
        self.P = self.P - gain @ self.P[:2]
        self.P = 0.5 * (self.P + self.P.T)
        self.blob, self.hits, self.missed = blob, self.hits + 1, 0


class GroundLinker:
    """Tracks of objects on the ground plane."""

    def __init__(self, parameters: LinkParameters, view: SiteView) -> None:
        self._parameters, self._view = parameters, view
        self._targets: list[_Target] = []
        self._identities = 0
        self._time_s: float | None = None

    def follow(self, blobs: Sequence[Blob], time_s: float) -> list[Track]:
        """Return the tracks on a picture with these blobs."""
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
        tracks = [self._track(each) for each in self._targets if each.hits >= p.least_hits]
        return [track for track in tracks if track is not None]

    def _assign(self, blobs: Sequence[Blob]) -> set[int]:
        """Correct the targets by the blobs that continue them, and return these: the least sum of distances."""
        cost = np.full((len(self._targets), len(blobs)), _FORBIDDEN)
        for i, target in enumerate(self._targets):
            for j, blob in enumerate(blobs):
                S = target.P[:2, :2] + blob.covariance_m2
                off_m = blob.place_m - target.state[:2]
                distance = float(off_m @ np.linalg.solve(S, off_m))
                if distance < _GATE:
                    cost[i, j] = distance + np.log(np.linalg.det(S))
        taken = set()
        for target in self._targets:
            target.missed += 1
        for i, j in zip(*linear_sum_assignment(cost), strict=True):
            if cost[i, j] < _FORBIDDEN:
                self._targets[i].correct(blobs[j])
                taken.add(int(j))
        return taken

    def _track(self, target: _Target) -> Track | None:
        """Return the track of a target at its filtered place; None if that is behind the camera."""
        p, blob = self._parameters, target.blob
        centre_m = np.array([*target.state[:2], 0.5 * blob.size_m[2]])
        px, depth_m = self._view.project(centre_m[None])
        if not np.isfinite(px).all():
            return None
        half_px = 0.5 * (blob.box_xyxy[2:] - blob.box_xyxy[:2])
        estimate = Estimate(px[0], np.concatenate([px[0] - half_px, px[0] + half_px]), depth_m=float(depth_m[0]))
        seen = blob.strength / (blob.strength + p.sure_strength)
        confidence = seen * blob.plausible * (1.0 - p.hit_doubt**target.hits) * 0.5**target.missed
        return Track(target.identity, estimate, size_m=blob.size_m, confidence=float(confidence))
