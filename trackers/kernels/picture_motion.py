"""Motion of the scene in the picture between two frames, from corners of the pictures alone."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

_CORNERS, _QUALITY, _APART_PX = 200, 0.01, 10
_FEWEST, _LEAST_SHARE = 10, 0.4
_FEATURES, _FEATURE_LEVELS = 800, 8
_INLIER_PX = 2.0
_FARTHEST_SCALE = 1.5
_LEAST_DEPTH = 0.5


def picture_motion(before: NDArray[np.uint8], now: NDArray[np.uint8]) -> NDArray[np.float64]:
    """Return the homography (3, 3) from pixels of one grey picture (H, W) to those of the next one.

    Up to 200 corners (Shi and Tomasi) are followed, once from where they were and once from the shift that phase
    correlation finds; RANSAC fits each, so that houses and cars are outliers, and the fit with more corners counts.
    Where fewer than ten agree, or the picture would shrink or grow by more than half, the motion is the identity; a
    picture of another size counts as the same view.
    """
    before, resized = _as_large(before, now)
    corners = cv2.goodFeaturesToTrack(before, _CORNERS, _QUALITY, _APART_PX)
    if corners is None or len(corners) < _FEWEST:
        return resized
    fits = [_followed(before, now, corners[:, 0], shift_px) for shift_px in (np.zeros(2), _shift_px(before, now))]
    return max(fits, key=lambda fit: fit[1])[0] @ resized


def background_motion(
    before: NDArray[np.uint8], now: NDArray[np.uint8], target_xyxy: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the homography (3, 3) of what is behind a target in a box (4,) of the first picture.

    Corners outside the box are followed as in ``picture_motion``, from where they were. Where less than 40 % of those
    found agree, as after a jerk of the camera, features are matched by their looks (ORB: Rublee, Rabaud, Konolige,
    Bradski, An efficient alternative to SIFT or SURF, ICCV 2011), wherever they are; and where less than 40 % of these
    agree, as of waves, the motion is the identity.
    """
    mask = np.full_like(before, 255)
    left, top, right, bottom = np.clip(target_xyxy, 0, np.tile(before.shape[::-1], 2)).astype(int)
    mask[top:bottom, left:right] = 0
    before, resized = _as_large(before, now)
    if mask.shape != now.shape:
        mask = cv2.resize(mask, now.shape[::-1], interpolation=cv2.INTER_NEAREST)
    corners = cv2.goodFeaturesToTrack(before, _CORNERS, _QUALITY, _APART_PX, mask=mask)
    if corners is None or len(corners) < _FEWEST:
        return resized
    for fit in (lambda: _followed(before, now, corners[:, 0], np.zeros(2)), lambda: _matched(before, now, mask)):
        motion, _, share = fit()
        if share >= _LEAST_SHARE:
            return motion @ resized
    return resized


def moved_points(H: NDArray[np.float64], points_px: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return where a homography (3, 3) moves points (N, 2); those beyond its horizon are moved far off."""
    homogeneous = points_px @ H[:, :2].T + H[:, 2]
    return homogeneous[:, :2] / np.maximum(homogeneous[:, 2:], _LEAST_DEPTH)


def _shift_px(before: NDArray[np.uint8], now: NDArray[np.uint8]) -> NDArray[np.float64]:
    """Return the shift (2,) of the whole picture, by phase correlation."""
    window = cv2.createHanningWindow((now.shape[1], now.shape[0]), cv2.CV_32F)
    shift, _ = cv2.phaseCorrelate(before.astype(np.float32), now.astype(np.float32), window)
    return np.array(shift)


def _as_large(before: NDArray[np.uint8], now: NDArray[np.uint8]) -> tuple[NDArray[np.uint8], NDArray[np.float64]]:
    """Return a picture in the size of the next one, and the homography (3, 3) of that."""
    size, size_before = (np.array(each.shape[::-1], dtype=float) for each in (now, before))
    if not (size == size_before).all():
        before = cv2.resize(before, (now.shape[1], now.shape[0]), interpolation=cv2.INTER_AREA)
    return before, np.diag([*(size / size_before), 1.0])


_Fit = tuple[NDArray[np.float64], int, float]
"""Homography (3, 3), how many points agree with it, and their share; the identity, 0 and 0 if there is none."""


def _followed(
    before: NDArray[np.uint8], now: NDArray[np.uint8], corners: NDArray[np.float32], shift_px: NDArray[np.float64]
) -> _Fit:
    """Fit corners (N, 2) that are found again near a shift (2,)."""
    guess = (corners + shift_px).astype(np.float32)
    found, status, _ = cv2.calcOpticalFlowPyrLK(
        before,
        now,
        corners[:, None],
        guess[:, None].copy(),
        winSize=(15, 15),
        maxLevel=3,
        flags=cv2.OPTFLOW_USE_INITIAL_FLOW,
    )
    followed = status.ravel().astype(bool)
    return _fitted(corners[followed], found[followed, 0], now)


def _matched(before: NDArray[np.uint8], now: NDArray[np.uint8], mask: NDArray[np.uint8]) -> _Fit:
    """Fit features of the two pictures, the first one's where ``mask`` is not 0, that are most alike to one another."""
    orb = cv2.ORB.create(_FEATURES, fastThreshold=_FEATURE_LEVELS)
    (points, looks), (points_now, looks_now) = orb.detectAndCompute(before, mask), orb.detectAndCompute(now, None)
    if looks is None or looks_now is None:
        return np.eye(3), 0, 0.0
    pairs = cv2.BFMatcher(cv2.NORM_HAMMING, crossCheck=True).match(looks, looks_now)
    here = np.array([points[pair.queryIdx].pt for pair in pairs], np.float32).reshape(-1, 2)
    there = np.array([points_now[pair.trainIdx].pt for pair in pairs], np.float32).reshape(-1, 2)
    return _fitted(here, there, now)


def _fitted(points: NDArray[np.float32], points_now: NDArray[np.float32], now: NDArray[np.uint8]) -> _Fit:
    """Fit a homography to pairs of points (N, 2)."""
    if len(points) < _FEWEST:
        return np.eye(3), 0, 0.0
    # OpenCV counts pixel centres as whole numbers.
    H, agrees = cv2.findHomography(points + 0.5, points_now + 0.5, cv2.RANSAC, _INLIER_PX)
    count = 0 if H is None else int(np.count_nonzero(agrees))
    if count < _FEWEST or not _is_plausible(H, now.shape[::-1]):
        return np.eye(3), 0, 0.0
    return H, count, count / len(points)


def _is_plausible(H: NDArray[np.float64], size_px: tuple[int, ...]) -> bool:
    """Return whether a motion leaves the picture's corners before the camera and its area about as large."""
    width, height = size_px
    moved = np.array([[0.0, 0.0, 1.0], [width, 0.0, 1.0], [width, height, 1.0], [0.0, height, 1.0]]) @ H.T
    if not (moved[:, 2] > _LEAST_DEPTH).all():
        return False
    area = cv2.contourArea((moved[:, :2] / moved[:, 2:]).astype(np.float32))
    return bool(1.0 / _FARTHEST_SCALE < np.sqrt(area / (width * height)) < _FARTHEST_SCALE)
