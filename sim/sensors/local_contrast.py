"""Local contrast of thermal pictures: wide differences by the curve of the gain control, small ones by their own gain.

By day a quay is 20 K warmer than the water, and one curve leaves no grey levels to waves of a kelvin. So the counts c
are split into a base b, which keeps strong edges, and the detail about it,

    a = v / (v + e²),   b = <a> c + <(1 - a) m>,   grey = tone(b) + gain (c - b)

with the mean m and variance v of the counts around, and means <> around: the guided filter (He, Sun and Tang, "Guided
image filtering", IEEE TPAMI 35, 2013), for infrared pictures by Liu and Zhao ("Detail enhancement for
high-dynamic-range infrared images based on guided image filter", Infrared Physics & Technology 67, 2014). Its
statistics are those of a picture of a quarter of the size (He and Sun, "Fast guided filter", 2015). The curve leaves
``HEADROOM`` levels at both ends, so that detail shows in what is darkest and brightest.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

HEADROOM = 30.0
_SHRINK = 4
_REACH = 1.0 / 8.0
"""Half a side of what is around, as a share of the picture's height."""
_EDGE_K = 2.5
"""e: what differs more is an edge of the base."""


def show_detail(
    counts: NDArray[np.uint16],
    tone: NDArray[np.float32],
    grey_per_count: float,
    counts_per_k: float,
    grey: NDArray[np.uint8],
) -> None:
    """Write the grey levels (H, W) of counts (H, W).

    Args:
        tone: (BINS,) grey levels of the base, each of ``BINS / 16384`` counts.
        grey_per_count: the gain of the detail.
    """
    seen = counts.astype(np.float32)
    height, width = seen.shape
    small = cv2.resize(seen, (max(width // _SHRINK, 1), max(height // _SHRINK, 1)), interpolation=cv2.INTER_AREA)
    side = 2 * max(round(_REACH * height / _SHRINK), 1) + 1

    def around(values: NDArray[Any]) -> NDArray[np.float32]:
        return np.asarray(cv2.blur(values, (side, side), borderType=cv2.BORDER_REFLECT), np.float32)

    # Squares of differences from one count of the picture: those of counts have too many digits.
    middle = small.mean(dtype=np.float64).astype(np.float32)
    small -= middle
    mean = around(small)
    variance = np.maximum(around(small * small) - mean * mean, 0.0)
    share = variance / (variance + np.float32(_EDGE_K * counts_per_k) ** 2)
    slope, offset = (
        cv2.resize(around(each), (width, height), interpolation=cv2.INTER_LINEAR)
        for each in (share, (np.float32(1.0) - share) * mean)
    )
    seen -= middle
    base = slope * seen + offset
    cells = (base + middle) * np.float32(len(tone) / (1 << 14))
    level = tone[np.clip(cells, 0, len(tone) - 1).astype(np.int32)] + np.float32(grey_per_count) * (seen - base)
    grey[:] = np.clip(np.round(level), 0, 255)
