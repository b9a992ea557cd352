"""What moves in footage, to start a tracker on without a box: what differs from the background behind it.

The background is the median of pictures of the last second and a half, each carried into the present one by the
camera's motion (``picture_motion``), so the camera may move. What stays where it is, is not found; nor does it say what
it has found. OpenCV's detector of people (HOG) left the wheels with OpenCV 5, and no other detector comes in one.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.data.footage.sources import Picture
from trackers.kernels.boxes import box_iou
from trackers.kernels.ground_camera import apply_homography
from trackers.kernels.picture_motion import picture_motion

_LONGEST_PX = 480
"""Longest side of the pictures that are compared."""
_KEPT, _EVERY_S = 7, 0.2
"""Pictures that the background is made of, and the time between them."""
_FEWEST = 5
_NORMAL_MAD = 1.4826
_LEAST_LEVELS, _LEAST_SIGMAS = 18.0, 6.0
"""Least difference from the background, in levels and in standard deviations of all pixels."""
_WEAK, _GAP = 0.5, 0.012
"""Share of that limit for what belongs to a thing that exceeds it, and gap within one, in sides of the picture."""
_LEAST_SHARE, _MOST_SHARE = 2e-4, 0.2
"""Of the picture that a moving thing covers."""
_MOST_DIFFERS = 0.3
"""Share of the picture that differs from which on the background does not fit it."""
_LEAST_FILL = 0.35
"""Of its box that a thing covers; what covers less is a seam."""
_LEAST_IOU = 0.4
"""Overlap of the boxes of a thing in two pictures running."""
_TIMES, _TIMES_IN_PLACE, _LEAST_WAY = 5, 20, 0.25
"""Pictures running on which a thing is found, if it has gone so many of its sides over the background, and if not."""
_LONGEST_S = 20.0


@dataclass(slots=True, eq=False)
class _Thing:
    """Something that differs, picture after picture.

    Attributes:
        box_xyxy: (4,) now. began_px: (2,) its middle in the first picture, carried along with the camera.
        size: pixels that differ much. times: pictures that it was found on.
    """

    box_xyxy: NDArray[np.float64]
    began_px: NDArray[np.float64]
    size: int
    times: int = 1

    @property
    def moves(self) -> bool:
        """Whether it has gone its way for some time, or has moved in place for longer."""
        middle, side = 0.5 * (self.box_xyxy[:2] + self.box_xyxy[2:]), max(self.box_xyxy[2:] - self.box_xyxy[:2])
        has_gone = bool(np.linalg.norm(middle - self.began_px) >= _LEAST_WAY * side)
        return self.times >= (_TIMES if has_gone else _TIMES_IN_PLACE)


def first_moving(pictures: Iterator[Picture]) -> tuple[Picture, NDArray[np.float64]]:
    """Return the first picture in which something moves for sure, and the box (4,) of the largest such thing.

    Pictures before it are used up.

    Raises:
        ValueError: if nothing moves in the first 20 seconds.
    """
    movement, began_s = _Movement(), None
    for picture in pictures:
        began_s = picture.time_s if began_s is None else began_s
        if picture.time_s - began_s > _LONGEST_S:
            break
        moving = [each for each in movement.things(picture) if each.moves]
        if moving:
            return picture, max(moving, key=lambda each: each.size).box_xyxy * movement.scale
    expected = f"footage in which something moves in the first {_LONGEST_S:g} s"
    raise ValueError(f"detect: expected {expected}, got none: give --box or --pick")


class _Movement:
    """Keeps a few small grey pictures and what differs from them, carried along with the camera.

    Attributes:
        scale: (4,) pixels of a picture over those of a small one.
    """

    def __init__(self) -> None:
        self._kept: deque[tuple[NDArray[np.uint8], NDArray[np.float64]]] = deque(maxlen=_KEPT)
        self._before: NDArray[np.uint8] | None = None
        self._kept_s = -np.inf
        self._things: list[_Thing] = []
        self.scale = np.ones(4)

    def things(self, picture: Picture) -> list[_Thing]:
        """Return what differs from the background in the next picture, in pixels of small ones."""
        height, width = picture.image_rgb.shape[:2]
        shrunk = min(1.0, _LONGEST_PX / max(height, width))
        size = max(round(width * shrunk), 1), max(round(height * shrunk), 1)
        self.scale = np.tile([width / size[0], height / size[1]], 2)
        small = cv2.resize(picture.image_rgb, size, interpolation=cv2.INTER_AREA)
        grey = np.asarray(cv2.GaussianBlur(cv2.cvtColor(small, cv2.COLOR_RGB2GRAY), (5, 5), 0), np.uint8)
        before, self._before = self._before, grey
        if before is not None:
            moved = picture_motion(before, grey)
            self._kept = deque(((each, moved @ H) for each, H in self._kept), maxlen=_KEPT)
            for thing in self._things:
                thing.began_px = apply_homography(moved, thing.began_px[None])[0]
        earlier = [_carried(each, H) for each, H in self._kept]
        found = _found_in(grey, earlier) if len(earlier) >= _FEWEST else []
        self._things = [_continued(each, self._things) for each in found]
        if picture.time_s - self._kept_s >= _EVERY_S:
            self._kept.append((grey, np.eye(3)))
            self._kept_s = picture.time_s
        return self._things


def _continued(found: _Thing, before: list[_Thing]) -> _Thing:
    """Return what was found as the thing that it overlaps most, if any."""
    if before:
        overlaps = box_iou(found.box_xyxy, np.array([each.box_xyxy for each in before]))
        best = int(overlaps.argmax())
        if overlaps[best] >= _LEAST_IOU:
            return _Thing(found.box_xyxy, before[best].began_px, found.size, before[best].times + 1)
    return found


def _carried(grey: NDArray[np.uint8], H: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return an earlier picture (H, W) as the present camera would see it; NaN where it did not look."""
    to_centres = np.array([[1.0, 0.0, -0.5], [0.0, 1.0, -0.5], [0.0, 0.0, 1.0]])
    moved = to_centres @ H @ np.linalg.inv(to_centres)
    shown = cv2.warpPerspective(grey.astype(np.float32), moved, grey.shape[::-1], borderValue=np.nan)
    return np.asarray(shown, np.float32)


def _found_in(grey: NDArray[np.uint8], earlier: list[NDArray[np.float32]]) -> list[_Thing]:
    """Return what differs from the median of earlier pictures (H, W) and is not cut by the border."""
    stack = np.array(earlier)
    known = np.isfinite(stack).sum(axis=0) >= _FEWEST
    if not known.any():
        return []
    background = np.nanmedian(np.where(known, stack, 0.0), axis=0)
    away = np.where(known, np.abs(grey - background), 0.0)
    limit = max(_LEAST_LEVELS, _LEAST_SIGMAS * _NORMAL_MAD * float(np.median(away[known])))
    differs = away > limit
    if differs.mean() > _MOST_DIFFERS:
        return []
    height, width = grey.shape
    side = max(3, round(_GAP * max(height, width)) | 1)
    weak = cv2.morphologyEx((away > _WEAK * limit).astype(np.uint8), cv2.MORPH_CLOSE, np.ones((side, side), np.uint8))
    count, label, stats, _ = cv2.connectedComponentsWithStats(weak)
    strong = np.bincount(label[differs], minlength=count)
    things = []
    for k in range(1, count):
        x, y, wide, high, area = stats[k]
        inside = min(x, y, width - x - wide, height - y - high) >= side
        fits = strong[k] >= _LEAST_SHARE * grey.size and area <= _MOST_SHARE * grey.size
        if inside and fits and area >= _LEAST_FILL * wide * high:
            box = np.array([x, y, x + wide, y + high], dtype=float)
            things.append(_Thing(box, 0.5 * (box[:2] + box[2:]), int(strong[k])))
    return things
