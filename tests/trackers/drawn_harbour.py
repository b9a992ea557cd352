"""A hand-drawn harbour before a thermal camera: warm quay, cool sea, slow light, people who walk. No simulator."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.estimate_check import check_tracks
from trackers.protocols import MultiTracker
from trackers.site import SiteView
from trackers.types import CameraModel, EgoPose, Observation, SiteSurvey, Track

WIDTH_PX, HEIGHT_PX = 192, 144
CAMERA = CameraModel(WIDTH_PX, HEIGHT_PX, 770.0, band="thermal")
SURVEY = SiteSurvey((-15.0, 0.0), (-1.0, 0.0), -1.8, (90.0, 33.0, 6.0), -2.5)
INTERVAL_S = 2.0
PERSON_M = np.array([0.5, 0.5, 1.7])
_WARM, _NOISE, _SWING = 60.0, 1.0, 6.0


def looking(place_m: NDArray[np.float64], at_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return T_world_camera (4, 4) of a camera that looks at a point, its horizon level."""
    forward = (at_m - place_m) / np.linalg.norm(at_m - place_m)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    T = np.eye(4)
    T[:3, :3] = np.column_stack([right, np.cross(forward, right), forward])
    T[:3, 3] = place_m
    return T


VIEW = SiteView(CAMERA, looking(np.array([-100.0, 0.0, 20.0]), np.zeros(3)))


class DrawnHarbour:
    """Pictures of one camera at rest."""

    def __init__(self, seed: int) -> None:
        self._rng = np.random.default_rng(seed)
        shape = HEIGHT_PX, WIDTH_PX
        ground_m = VIEW.on_plane(np.argwhere(np.ones(shape))[:, ::-1] + 0.5, 0.0)
        on_land = (ground_m[:, 0] > -15.0).reshape(shape)
        blotches = cv2.resize(self._rng.normal(0, 8, (18, 24)).astype(np.float32), shape[::-1])
        self._still = np.where(on_land, 110.0, 60.0) + blotches
        self._frames = 0

    def picture(self, people_m: Sequence[NDArray[np.float64]] = (), warm: float = _WARM) -> Observation:
        """Return the next picture, with people standing at places (2,) of the quay, ``warm`` grey levels above it."""
        grey = self._still + _SWING * np.sin(0.11 * self._frames)
        for place_m in people_m:
            estimate = VIEW.estimate_of(np.array([*place_m, 0.5 * PERSON_M[2]]), PERSON_M, 0.0)
            assert estimate is not None
            assert estimate.box_xyxy is not None
            x0, y0, x1, y1 = np.round(estimate.box_xyxy).astype(int)
            grey[max(y0, 0) : max(y1, 0), max(x0, 0) : max(x1, 0)] += warm
        grey = grey + self._rng.normal(0, _NOISE, grey.shape)
        values = np.clip(np.round(grey), 0, 255).astype(np.uint8)
        self._frames += 1
        image_rgb = np.broadcast_to(values[..., None], (*values.shape, 3))
        return Observation(image_rgb, INTERVAL_S * self._frames, CAMERA, ego=EgoPose(VIEW.T_world_camera))

    def pictures(self, count: int) -> list[Observation]:
        """Return the next pictures, without people."""
        return [self.picture() for _ in range(count)]


def checked_answers(tracker: MultiTracker, pictures: Sequence[Observation]) -> list[Sequence[Track]]:
    """Return a started tracker's answers on pictures; all of them keep their contract."""
    answers = [tracker.update(picture) for picture in pictures]
    for tracks in answers:
        check_tracks(tracks)
    return answers
