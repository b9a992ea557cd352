"""What moves in footage, to start a tracker on without a box: what differs from the background behind it.

The background is the median of pictures of the last second and a half, each carried into the present one by the
camera's motion (``picture_motion``), so the camera may move. What stays where it is, is not found; nor does it say what
it has found. OpenCV's detector of people (HOG) left the wheels with OpenCV 5, and no other detector comes in one.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.data.footage.sources import Picture
from trackers.baselines.ground_view import picture_motion

_LONGEST_PX = 480
"""Longest side of the pictures that are compared."""
_KEPT, _EVERY_S = 7, 0.2
"""Pictures that the background is made of, and the time between them."""
_FEWEST = 5
_NORMAL_MAD = 1.4826
_LEAST_LEVELS, _LEAST_SIGMAS = 18.0, 6.0
"""Least difference from the background, in levels and in standard deviations of all pixels."""
_LEAST_SHARE, _MOST_SHARE = 2e-4, 0.2
"""Of the picture that a moving thing covers."""
_SAME_SIDES, _TIMES = 1.0, 3
"""Something is there if it is found on so many pictures running, within so many of its sides."""
_LONGEST_S = 20.0


def first_moving(pictures: Iterator[Picture]) -> tuple[Picture, NDArray[np.float64]]:
    """Return the first picture in which something moves for sure, and the box (4,) of the largest such thing.

    Pictures before it are used up.

    Raises:
        ValueError: if nothing moves in the first 20 seconds.
    """
    found: deque[NDArray[np.float64]] = deque(maxlen=_TIMES)
    background = _Background()
    began_s = None
    for picture in pictures:
        began_s = picture.time_s if began_s is None else began_s
        if picture.time_s - began_s > _LONGEST_S:
            break
        box = background.differing(picture)
        if box is None or (found and not _is_near(found[-1], box)):
            found.clear()
        if box is not None:
            found.append(box)
            if len(found) == _TIMES:
                return picture, box
    expected = f"footage in which something moves in the first {_LONGEST_S:g} s"
    raise ValueError(f"detect: expected {expected}, found nothing: give --box or --pick")


class _Background:
    """Keeps a few small grey pictures, carried along with the camera."""

    def __init__(self) -> None:
        self._kept: deque[tuple[NDArray[np.uint8], NDArray[np.float64]]] = deque(maxlen=_KEPT)
        self._before: NDArray[np.uint8] | None = None
        self._kept_s = -np.inf

    def differing(self, picture: Picture) -> NDArray[np.float64] | None:
        """Return the box (4,) of the largest thing that differs from the background, in pixels; None without one."""
        height, width = picture.image_rgb.shape[:2]
        scale = min(1.0, _LONGEST_PX / max(height, width))
        size = max(round(width * scale), 1), max(round(height * scale), 1)
        small = cv2.resize(picture.image_rgb, size, interpolation=cv2.INTER_AREA)
        grey = np.asarray(cv2.GaussianBlur(cv2.cvtColor(small, cv2.COLOR_RGB2GRAY), (5, 5), 0), np.uint8)
        before, self._before = self._before, grey
        if before is not None:
            moved = picture_motion(before, grey)
            self._kept = deque(((each, moved @ H) for each, H in self._kept), maxlen=_KEPT)
        box = _box_of(grey, [_carried(each, H) for each, H in self._kept]) if len(self._kept) >= _FEWEST else None
        if picture.time_s - self._kept_s >= _EVERY_S:
            self._kept.append((grey, np.eye(3)))
            self._kept_s = picture.time_s
        return None if box is None else box * np.tile([width / size[0], height / size[1]], 2)


def _carried(grey: NDArray[np.uint8], H: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return an earlier picture (H, W) as the present camera would see it; NaN where it did not look."""
    to_centres = np.array([[1.0, 0.0, -0.5], [0.0, 1.0, -0.5], [0.0, 0.0, 1.0]])
    moved = to_centres @ H @ np.linalg.inv(to_centres)
    shown = cv2.warpPerspective(grey.astype(np.float32), moved, grey.shape[::-1], borderValue=np.nan)
    return np.asarray(shown, np.float32)


def _box_of(grey: NDArray[np.uint8], earlier: list[NDArray[np.float32]]) -> NDArray[np.float64] | None:
    stack = np.array(earlier)
    known = np.isfinite(stack).sum(axis=0) >= _FEWEST
    if not known.any():
        return None
    with np.errstate(invalid="ignore"):
        background = np.nanmedian(np.where(known, stack, 0.0), axis=0)
    away = np.where(known, np.abs(grey - background), 0.0)
    limit = max(_LEAST_LEVELS, _LEAST_SIGMAS * _NORMAL_MAD * float(np.median(away[known])))
    differs = (away > limit).astype(np.uint8)
    side = max(3, round(0.012 * max(grey.shape)) | 1)
    closed = cv2.morphologyEx(differs, cv2.MORPH_CLOSE, np.ones((side, side), np.uint8))
    count, _, stats, _ = cv2.connectedComponentsWithStats(closed)
    share = stats[1:count, cv2.CC_STAT_AREA] / grey.size
    fitting = np.flatnonzero((share >= _LEAST_SHARE) & (share <= _MOST_SHARE))
    if not fitting.size:
        return None
    x, y, width, height, _ = stats[1 + fitting[share[fitting].argmax()]]
    return np.array([x, y, x + width, y + height], dtype=float)


def _is_near(before: NDArray[np.float64], box: NDArray[np.float64]) -> bool:
    middles = 0.5 * (before[:2] + before[2:]), 0.5 * (box[:2] + box[2:])
    return bool(np.linalg.norm(middles[1] - middles[0]) <= _SAME_SIDES * max(box[2:] - box[:2]))
