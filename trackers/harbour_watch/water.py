"""Where the picture shows water, and how high it stands: water is what waves keep moving.

Its level follows from the foot of the quay's wall: the line where waves end is seen higher in the picture when the tide
is high, and the wall stands still.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.site.view import SiteView

Picture = NDArray[np.float32]

_BLUR_PX = 2.5
_LEAST_SHARE = 0.02
_LEAST_CONTRAST = 1.5
"""Ratio of the waves' deviation to that of land below which there is no water."""
_REACH_PX = 40
_SHORTEST_LINE = 0.1


def water_of(noise: Picture) -> NDArray[np.bool_]:
    """Return where a picture (H, W) of noise, standard deviations from one picture to the next, shows water.

    Otsu's threshold between two classes of the logarithm of the smoothed noise; what lies within the largest part with
    waves is water too (moored boats). Nowhere if the classes hardly differ.
    """
    smooth = np.log(np.maximum(cv2.GaussianBlur(noise, (0, 0), _BLUR_PX), 1e-6))
    low, high = np.percentile(smooth, [0.5, 99.5])
    if high - low < 1e-3:
        return np.zeros(noise.shape, bool)
    grey = np.clip((smooth - low) / (high - low) * 255, 0, 255).astype(np.uint8)
    threshold, _ = cv2.threshold(grey, 0, 255, cv2.THRESH_BINARY | cv2.THRESH_OTSU)
    rough = grey > threshold
    if not 0 < rough.mean() < 1 or smooth[rough].mean() - smooth[~rough].mean() < np.log(_LEAST_CONTRAST):
        return np.zeros(noise.shape, bool)
    _, labels, stats, _ = cv2.connectedComponentsWithStats(rough.astype(np.uint8))
    largest = 1 + int(stats[1:, cv2.CC_STAT_AREA].argmax())
    if stats[largest, cv2.CC_STAT_AREA] < _LEAST_SHARE * noise.size:
        return np.zeros(noise.shape, bool)
    outline, _ = cv2.findContours((labels == largest).astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    filled: NDArray[np.uint8] = cv2.drawContours(np.zeros(noise.shape, np.uint8), outline, -1, 1, cv2.FILLED)
    return filled.astype(bool)


def upper_edge(water: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return the highest row (W,) of water in each column; NaN where there is none or it fills the column."""
    first = water.argmax(axis=0)
    return np.where(water.any(axis=0) & (first > 0), first, np.nan)


class WaterLevel:
    """Level of the water from the line where it meets a wall, against the line at the mean level.

    Attributes:
        mean_m: the mean level.
    """

    def __init__(self, view: SiteView, mean_edge_px: NDArray[np.float64], mean_level_m: float) -> None:
        """``mean_edge_px`` (W,): row of the line at the mean level by column; NaN where there is none."""
        self._columns = np.flatnonzero(np.isfinite(mean_edge_px))
        self._enough = max(2.0, _SHORTEST_LINE * len(mean_edge_px))
        self.mean_m, self._edge_px = mean_level_m, mean_edge_px[self._columns]
        px = np.column_stack([self._columns + 0.5, self._edge_px])
        foot_m = view.on_plane(px, mean_level_m)
        above, _ = view.project(np.add(foot_m, (0.0, 0.0, 1.0)))
        self._px_per_m = px[:, 1] - above[:, 1]

    def of(self, noise: Picture) -> float | None:
        """Return the level in metres from the noise (H, W) of recent pictures; None where it cannot be told."""
        if len(self._columns) < self._enough:
            return None
        smooth = np.log(np.maximum(cv2.GaussianBlur(noise, (0, 0), 1.0), 1e-6))
        rows = np.clip(np.round(self._edge_px).astype(int), 0, len(noise) - 1)
        low, high = max(0, rows.min() - _REACH_PX), min(len(noise), rows.max() + _REACH_PX)
        line = np.array([_step(smooth[low:high, column]) for column in self._columns]) + low
        rises_m = (self._edge_px - line) / self._px_per_m
        rises_m = rises_m[np.isfinite(rises_m)]
        return self.mean_m + float(np.median(rises_m)) if len(rises_m) >= self._enough else None


def _step(column: NDArray[np.float32]) -> float:
    """Return the row at which a column (N,) steps up best, by least squares of two levels; NaN without a step."""
    n = len(column)
    if n < 6:
        return float("nan")
    total = np.cumsum(column, dtype=np.float64)
    k = np.arange(2, n - 2)
    above, below = total[k - 1] / k, (total[-1] - total[k - 1]) / (n - k)
    gain = np.where(below > above, k * (n - k) / n * (below - above) ** 2, 0.0)
    at = int(gain.argmax())
    return float(k[at]) if below[at] - above[at] > np.log(_LEAST_CONTRAST) else float("nan")
