"""The edges of a region to a fraction of a pixel."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

_PAD_PX = 3
_NOISE = 1.5
"""Deviations that are taken off: less is noise."""
_ACROSS, _UPRIGHT, _LOW = 0.25, 0.15, 0.3
"""Share of the high values of a profile at which an edge lies: of the columns, and of the rows of a body that is higher
than wide, whose head is narrow and whose legs are cold, and of others."""
_CLEAR = 4.5
"""Deviations beyond the noise from which a pixel of a low body is surely of it: windows differ less than a bonnet."""
_HALO = 0.3
"""Share of a neighbour's deviation below which a pixel shows its blur."""
_TWO_M, _TALL = (0.75, 1.5), 0.7
"""Widths of two people side by side, from shoulder in shoulder to an arm's length apart; least height by width."""
_ONE_M = 0.3
"""Least width of each."""
_VALLEY = 0.6
"""Depth of the profile between them, by the lower of both."""
_HIGH = 80.0
"""Percentile of the profile that stands for the body."""


def refined(deviation: NDArray[np.float32], box_xyxy: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a region's box (4,) with edges where the profiles of its deviations fall off.

    Args:
        deviation: (H, W) standard deviations from the background. box_xyxy: (4,) about the region, in pixels.
    """
    h, w = deviation.shape
    x0, y0 = np.maximum(np.floor(box_xyxy[:2]).astype(int) - _PAD_PX, 0)
    x1, y1 = np.minimum(np.ceil(box_xyxy[2:]).astype(int) + _PAD_PX, [w, h])
    part = np.abs(deviation[y0:y1, x0:x1])
    strong = part[part > 2 * _NOISE]
    if strong.size < 4:
        return box_xyxy
    mass = np.maximum(np.minimum(part, np.median(strong)) - _NOISE, 0.0)
    is_upright = box_xyxy[3] - box_xyxy[1] > box_xyxy[2] - box_xyxy[0]
    columns = _ends(mass.sum(axis=0), _ACROSS)
    rows = _ends(mass.sum(axis=1), _UPRIGHT) if is_upright else _ends(_clearest(part), _LOW)
    if columns is None or rows is None:
        return box_xyxy
    return np.array([x0 + columns[0], y0 + rows[0], x0 + columns[1], y0 + rows[1]])


def _clearest(part: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the mean (H,) of the third of each row that deviates most: a narrow cabin counts as a whole bonnet does.

    ``part`` (H, W): deviations without their sign.
    """
    is_body = part > _HALO * cv2.dilate(part, np.ones((3, 1), np.uint8))
    seen = np.sort(np.clip(np.where(is_body, part, 0.0) - _NOISE, 0.0, _CLEAR), axis=1)
    profile: NDArray[np.float32] = seen[:, -max(1, seen.shape[1] // 3) :].mean(axis=1)
    return profile


def side_by_side(
    deviation: NDArray[np.float32], box_xyxy: NDArray[np.float64], px_per_m: float
) -> list[NDArray[np.float64]]:
    """Return the boxes (4,) of two people who walk side by side, or the one box.

    A region as wide as two people is parted where the profile of its columns has a valley.
    """
    x0, y0, x1, y1 = np.round(box_xyxy).astype(int)
    x0, y0 = max(x0, 0), max(y0, 0)
    low, high = (round(each * px_per_m) for each in _TWO_M)
    if not (low <= x1 - x0 <= high and y1 - y0 >= _TALL * (x1 - x0)):
        return [box_xyxy]
    part = np.abs(deviation[y0:y1, x0:x1])
    profile = np.maximum(part - _NOISE, 0.0).sum(axis=0)
    quarter = len(profile) // 4
    at = quarter + int(profile[quarter : len(profile) - quarter].argmin())
    if not 0 < at < len(profile) - 1 or profile[at] > _VALLEY * min(profile[:at].max(), profile[at + 1 :].max()):
        return [box_xyxy]
    middle, least = x0 + at + 0.5, _ONE_M * px_per_m
    if min(middle - box_xyxy[0], box_xyxy[2] - middle) < least:
        return [box_xyxy]
    return [np.array([box_xyxy[0], y0, middle - 0.5, y1]), np.array([middle + 0.5, y0, box_xyxy[2], y1])]


def _ends(profile: NDArray[np.float32], share: float) -> tuple[float, float] | None:
    """Return where a profile (N,) rises and falls through a share of its high values; pixel n covers [n, n + 1)."""
    high = profile[profile > 0.1 * profile.max()]
    level = share * float(np.percentile(high, _HIGH)) if len(high) else 0.0
    above = np.flatnonzero(profile >= level)
    if level <= 0.0 or not len(above):
        return None
    first, last = int(above[0]), int(above[-1])
    return first + 1.0 - _covered(profile, first, -1, level), last + _covered(profile, last, 1, level)


def _covered(profile: NDArray[np.float32], at: int, outwards: int, level: float) -> float:
    """Return how far an edge lies beyond the inner side of pixel ``at``, by linear interpolation, 0.5 to 1.5."""
    beyond = at + outwards
    if not 0 <= beyond < len(profile):
        return 1.0
    return 0.5 + float((profile[at] - level) / max(float(profile[at] - profile[beyond]), 1e-6))
