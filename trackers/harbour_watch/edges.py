"""The edges of a region to a fraction of a pixel."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_PAD_PX = 3
_NOISE = 1.5
"""Deviations that are taken off: less is noise."""
_FRACTION = 0.25
"""Share of a profile's high values at which its edge lies: a head is narrower than shoulders, and legs are colder."""
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
    part = np.maximum(np.minimum(part, np.median(strong)) - _NOISE, 0.0)
    columns, rows = _ends(part.sum(axis=0)), _ends(part.sum(axis=1))
    if columns is None or rows is None:
        return box_xyxy
    return np.array([x0 + columns[0], y0 + rows[0], x0 + columns[1], y0 + rows[1]])


def _ends(profile: NDArray[np.float32]) -> tuple[float, float] | None:
    """Return where a profile (N,) rises and falls through a share of its high values; pixel n covers [n, n + 1)."""
    high = profile[profile > 0.1 * profile.max()]
    level = _FRACTION * float(np.percentile(high, _HIGH)) if len(high) else 0.0
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
