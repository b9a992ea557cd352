"""Regions as the VOT challenge writes them, one in a line of text: where a target is, or that it is nowhere.

========= =============================== =============================================================================
region    text                            meaning
========= =============================== =============================================================================
special   ``code``                        0: unknown, 1: the tracker was started here, 2: it failed here
point     ``x,y``
rectangle ``x,y,width,height``            from the left upper corner
polygon   ``x1,y1,x2,y2,x3,y3,…``         three corners or more; closed by itself
mask      ``mX,Y,WIDTH,HEIGHT,run,run,…`` whole numbers: a window of WIDTH by HEIGHT pixels whose left upper one is
                                          column X and row Y of the picture, and runs of its pixels, row by row,
                                          outside the target and on it in turn; pixels after the last run are outside
========= =============================== =============================================================================

A NaN among the numbers of a point, rectangle or polygon makes it the special region 0. Pixels as in ``trackers.types``.
Source: the VOT toolkit 0.9 (``vot.region``) and TraX 4 (``docs/protocol.rst`` and ``lib/region.c`` of the project
votchallenge/trax), with which ``tests/trackers/test_regions.py`` compares.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.types import Estimate

MOST_PIXELS = 2**27
"""The largest window of a mask, more than a picture of 16,000 by 8,000 pixels."""
_FARTHEST_PX = 2.0**20
"""A corner further away would take OpenCV seconds to draw to."""
_EXPECTED = (
    "a code, or x,y, or x,y,width,height, or three or more corners x1,y1,x2,y2,x3,y3, or a mask mX,Y,WIDTH,HEIGHT,run,…"
)


class _WithoutArea:
    __slots__ = ()

    @property
    def box_xyxy(self) -> None:
        """None."""
        return None

    def mask(self, height_px: int, width_px: int) -> NDArray[np.bool_]:
        """Return (H, W), False everywhere."""
        return np.zeros((height_px, width_px), bool)


@dataclass(frozen=True, slots=True)
class Special(_WithoutArea):
    """No place, but a code, a whole number."""

    code: int = 0

    def __str__(self) -> str:
        return str(self.code)


@dataclass(frozen=True, slots=True)
class Point(_WithoutArea):
    """A place without extent, ``position_px`` (2,)."""

    position_px: NDArray[np.float64]

    def __str__(self) -> str:
        return _text(self.position_px)


@dataclass(frozen=True, slots=True)
class Rectangle:
    """An upright rectangle, ``box_xyxy`` (4,)."""

    box_xyxy: NDArray[np.float64]

    def __str__(self) -> str:
        return _text(np.concatenate((self.box_xyxy[:2], self.box_xyxy[2:] - self.box_xyxy[:2])))

    def mask(self, height_px: int, width_px: int) -> NDArray[np.bool_]:
        """Return (H, W), True on the pixels of the rectangle whose corner and size are rounded to whole pixels."""
        corner, size = np.round(self.box_xyxy[:2]), np.round(self.box_xyxy[2:] - self.box_xyxy[:2])
        (x0, y0), (x1, y1) = np.clip((corner, corner + size), 0, (width_px, height_px)).astype(int)
        mask = np.zeros((height_px, width_px), bool)
        mask[y0:y1, x0:x1] = True
        return mask


@dataclass(frozen=True, slots=True)
class Polygon:
    """A polygon of ``corners_px`` (K, 2), K > 2."""

    corners_px: NDArray[np.float64]

    def __str__(self) -> str:
        return _text(self.corners_px.ravel())

    @property
    def box_xyxy(self) -> NDArray[np.float64]:
        """(4,), of its corners."""
        return np.concatenate((self.corners_px.min(axis=0), self.corners_px.max(axis=0)))

    def mask(self, height_px: int, width_px: int) -> NDArray[np.bool_]:
        """Return (H, W), True on the polygon whose corners are rounded to whole pixels, its border included.

        As with VOT a corner is the middle of a pixel here: of a rectangle's four corners it is a pixel wider and higher
        than the rectangle. On slanting borders VOT's own pixels differ from OpenCV's by one.
        """
        mask = np.zeros((height_px, width_px), np.uint8)
        cv2.fillPoly(mask, [np.round(self.corners_px).astype(np.int32)], 1)
        return mask.astype(bool)


@dataclass(frozen=True, slots=True)
class Mask:
    """The pixels of a window of the picture that belong to a target.

    Attributes:
        pixels: (H, W) bool. x, y: column and row of the picture that its left upper pixel is, also < 0.
    """

    pixels: NDArray[np.bool_]
    x: int = 0
    y: int = 0

    def __str__(self) -> str:
        """Return the text of the smallest window that has all pixels."""
        least = self.trimmed()
        pixels, (height, width) = least.pixels.ravel(), least.pixels.shape
        if not pixels.size:
            return "m0,0,0,0,0"
        changes = np.flatnonzero(pixels[1:] != pixels[:-1]) + 1
        runs = np.diff(changes, prepend=0, append=pixels.size).tolist()
        numbers = [least.x, least.y, width, height, *([0] if pixels[0] else []), *runs]
        return "m" + ",".join(map(str, numbers))

    def trimmed(self) -> Mask:
        """Return it with a copy of the smallest window that has all its pixels; (0, 0) without any."""
        box = box_of_mask(self.pixels)
        x0, y0, x1, y1 = (0, 0, 0, 0) if box is None else map(int, box)
        return Mask(self.pixels[y0:y1, x0:x1].copy(), self.x + x0, self.y + y0)

    @property
    def box_xyxy(self) -> NDArray[np.float64] | None:
        """(4,), the outer borders of its pixels; None without any."""
        box = box_of_mask(self.pixels)
        return None if box is None else box + np.array([self.x, self.y] * 2)

    def mask(self, height_px: int, width_px: int) -> NDArray[np.bool_]:
        """Return (H, W), its pixels in the picture."""
        height, width = self.pixels.shape
        y0, y1 = np.clip((self.y, self.y + height), 0, height_px)
        x0, x1 = np.clip((self.x, self.x + width), 0, width_px)
        mask = np.zeros((height_px, width_px), bool)
        mask[y0:y1, x0:x1] = self.pixels[y0 - self.y : y1 - self.y, x0 - self.x : x1 - self.x]
        return mask


Region = Special | Point | Rectangle | Polygon | Mask
"""All have ``str(region)``, the text; ``box_xyxy``; and ``mask(height_px, width_px)``."""


def read_region(text: str) -> Region:
    """Return the region of a text.

    Raises:
        ValueError: if it is none; names what was expected and what came.
    """
    stripped = text.strip()
    try:
        return _mask(stripped[1:]) if stripped.startswith("m") else _of_numbers(stripped)
    except (ValueError, OverflowError):
        shown = f"{stripped[:60]}{'…' if len(stripped) > 60 else ''}"
        raise ValueError(f"region: expected {_EXPECTED}; got {shown!r}") from None


def box_of_mask(mask: NDArray[np.bool_]) -> NDArray[np.float64] | None:
    """Return the box (4,) of a mask (H, W), the outer borders of its pixels; None if it is empty."""
    x, y, width, height = cv2.boundingRect(mask.astype(np.uint8)) if mask.size else (0, 0, 0, 0)
    return np.array([x, y, x + width, y + height], float) if width else None


def estimate_of(region: Region, height_px: int, width_px: int) -> Estimate:
    """Return a region as the answer on a picture of that size: the middle of its box, the box, and the mask of a mask.

    A special region or one without area is no estimate; a point has a position alone. A tracker that has a mask
    ``pixels`` (H, W) of the whole picture answers ``estimate_of(Mask(pixels), *pixels.shape)``.
    """
    if isinstance(region, Point):
        return Estimate(region.position_px)
    box = region.box_xyxy
    if box is None or not (box[2:] > box[:2]).all():
        return Estimate(np.full(2, np.nan))
    mask = region.mask(height_px, width_px) if isinstance(region, Mask) else None
    return Estimate(0.5 * (box[:2] + box[2:]), box, mask=mask)


def read_confidence(text: str) -> float | None:
    """Return the confidence of a text as an in-view probability; None of what is no number from 0 to 1."""
    try:
        confidence = float(text)
    except ValueError:
        return None
    return confidence if 0.0 <= confidence <= 1.0 else None


def _of_numbers(text: str) -> Region:
    numbers = np.array([float(each) for each in text.split(",")])
    if len(numbers) > 1 and len(numbers) % 2 == 0 and np.isnan(numbers).any():
        return Special()
    if not (np.abs(numbers) <= _FARTHEST_PX).all():
        raise ValueError
    match len(numbers):
        case 1 if numbers[0] == int(numbers[0]):
            return Special(int(numbers[0]))
        case 2:
            return Point(numbers)
        case 4 if (numbers[2:] >= 0).all():
            return Rectangle(np.concatenate((numbers[:2], numbers[:2] + numbers[2:])))
        case count if count >= 6 and count % 2 == 0:
            return Polygon(numbers.reshape(-1, 2))
    raise ValueError


def _mask(text: str) -> Mask:
    x, y, width, height, *runs = [int(each) for each in text.split(",")]
    area, inside = width * height, sum(runs)
    far = max(abs(x), abs(y)) > _FARTHEST_PX
    if far or min(width, height, *runs, 0) < 0 or area > MOST_PIXELS or inside > area:
        raise ValueError
    pixels = np.zeros(area, bool)
    pixels[:inside] = np.repeat(np.arange(len(runs)) % 2 == 1, runs)
    return Mask(pixels.reshape(height, width), x, y)


def _text(numbers: NDArray[np.float64]) -> str:
    return ",".join(repr(float(each)) for each in numbers)
