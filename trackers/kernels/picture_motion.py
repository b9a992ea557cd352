"""Motion of the scene in the picture between two frames, from corners of the pictures alone."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

_CORNERS, _QUALITY, _APART_PX = 200, 0.01, 10
_FEWEST = 10
_INLIER_PX = 2.0
_FARTHEST_SCALE = 1.5
_LEAST_DEPTH = 0.5


def picture_motion(
    before: NDArray[np.uint8],
    now: NDArray[np.uint8],
    without_xyxy: NDArray[np.float64] | None = None,
    least_share: float = 0.0,
) -> NDArray[np.float64]:
    """Return the homography (3, 3) from pixels of one grey picture (H, W) to those of the next one.

    Up to 200 corners (Shi and Tomasi) are followed, once from where they were and once from the shift that phase
    correlation finds; RANSAC fits each, so that houses and cars are outliers, and the fit with more corners counts.
    Where fewer than ten agree, or fewer than ``least_share`` of them, or the picture would shrink or grow by more than
    half, the motion is the identity; a picture of another size counts as the same view.

    Args:
        without_xyxy: (4,) box in the first picture whose corners are left out: those of a target, which moves.
    """
    size, size_before = (np.array(each.shape[::-1], dtype=float) for each in (now, before))
    resized = np.diag([*(size / size_before), 1.0])
    mask = None
    if without_xyxy is not None:
        mask = np.full_like(before, 255)
        left, top, right, bottom = np.clip(without_xyxy, 0, np.tile(size_before, 2)).astype(int)
        mask[top:bottom, left:right] = 0
    if not (size == size_before).all():
        before = cv2.resize(before, (now.shape[1], now.shape[0]), interpolation=cv2.INTER_AREA)
        mask = mask if mask is None else cv2.resize(mask, before.shape[::-1], interpolation=cv2.INTER_NEAREST)
    corners = cv2.goodFeaturesToTrack(before, _CORNERS, _QUALITY, _APART_PX, mask=mask)
    if corners is None or len(corners) < _FEWEST:
        return resized
    fits = [_fitted(before, now, corners[:, 0], shift_px) for shift_px in (np.zeros(2), _shift_px(before, now))]
    motion, count = max(fits, key=lambda fit: fit[1])
    return motion @ resized if count >= least_share * len(corners) else resized


def moved_points(H: NDArray[np.float64], points_px: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return where a homography (3, 3) moves points (N, 2); those beyond its horizon are moved far off."""
    homogeneous = points_px @ H[:, :2].T + H[:, 2]
    return homogeneous[:, :2] / np.maximum(homogeneous[:, 2:], _LEAST_DEPTH)


def _shift_px(before: NDArray[np.uint8], now: NDArray[np.uint8]) -> NDArray[np.float64]:
    """Return the shift (2,) of the whole picture, by phase correlation."""
    window = cv2.createHanningWindow((now.shape[1], now.shape[0]), cv2.CV_32F)
    shift, _ = cv2.phaseCorrelate(before.astype(np.float32), now.astype(np.float32), window)
    return np.array(shift)


def _fitted(
    before: NDArray[np.uint8], now: NDArray[np.uint8], corners: NDArray[np.float32], shift_px: NDArray[np.float64]
) -> tuple[NDArray[np.float64], int]:
    """Return the homography fitted to corners (N, 2) found again near a shift, and how many agree; identity and 0."""
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
    if np.count_nonzero(followed) < _FEWEST:
        return np.eye(3), 0
    # OpenCV counts pixel centres as whole numbers.
    H, agrees = cv2.findHomography(corners[followed] + 0.5, found[followed, 0] + 0.5, cv2.RANSAC, _INLIER_PX)
    count = 0 if H is None else int(np.count_nonzero(agrees))
    return (H, count) if count >= _FEWEST and _is_plausible(H, now.shape[::-1]) else (np.eye(3), 0)


def _is_plausible(H: NDArray[np.float64], size_px: tuple[int, ...]) -> bool:
    """Return whether a motion leaves the picture's corners before the camera and its area about as large."""
    width, height = size_px
    moved = np.array([[0.0, 0.0, 1.0], [width, 0.0, 1.0], [width, height, 1.0], [0.0, height, 1.0]]) @ H.T
    if not (moved[:, 2] > _LEAST_DEPTH).all():
        return False
    area = cv2.contourArea((moved[:, :2] / moved[:, 2:]).astype(np.float32))
    return bool(1.0 / _FARTHEST_SCALE < np.sqrt(area / (width * height)) < _FARTHEST_SCALE)
