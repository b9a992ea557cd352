"""How high the water stands.

Water ends at a line along a wall, which is seen higher in the picture when the tide is high, while the wall stands
still: the line's mean row belongs to the mean level.
"""

from __future__ import annotations

from collections import deque
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.site import SiteView

Picture = NDArray[np.float32]

_UNSURE_PX, _BELOW_PX, _LEAST_ABOVE_PX = 9, 12, 40
"""Rows by which the base lies below the edge of the water's area, that surely show water below the base, and that the
picture has above it."""
_SEARCHED = 1.3
"""Wall's heights above that edge that are searched: it lies between the levels of low tide and of the mean."""
_LINE_ROUNDS, _BOATS_WEIGHT = 20, 0.1
_FASTEST_PX = 2
_LEAST_SHARE_OF_COLUMNS, _LEAST_PEAK = 0.06, 0.6
"""Share of columns that must agree, and that share of the most agreed height which a higher one must have."""
_LEAST_PICTURES, _MEDIAN_OF = 20, 60
_OTHER = 5.0
"""Deviations from the water from which a pixel shows something else."""


class WaterLevel:
    """Level of the water from the row where it ends at a wall.

    In each column the water is followed upwards until something else is seen. Boats end it too early: of the heights
    on which many columns agree the highest counts.

    Attributes:
        mean_m: the mean level.
        mean_rise_px: rows from the band's base up to the mean level; below 0 if no level can be measured.
    """

    def __init__(
        self, view: SiteView, water: NDArray[np.bool_], noise: Picture, mean_m: float, mean_rise_px: float | None = None
    ) -> None:
        """Begin unsettled, or settled if ``mean_rise_px`` is given.

        Args:
            water: (H, W) where the picture shows water at its mean level. noise: (H, W) counts.
            mean_m: the mean level, of what ``settle`` will get.
            mean_rise_px: as of a level that is settled; below 0 if no level could be measured.
        """
        first = water.argmax(axis=0)
        columns = np.flatnonzero(water.any(axis=0) & (first > 0))
        self._view, self._noise, self.mean_m = view, noise, mean_m
        self.mean_rise_px = 0.0
        self._base, self._columns = _base(columns, first[columns], len(water))
        self._px_per_m = self._upright_px_per_m(0.0) if len(self._columns) else 1.0
        self._rows = self._base - np.arange(max(round(-_SEARCHED * mean_m * self._px_per_m), 2) + _UNSURE_PX)[:, None]
        self._last: deque[float] = deque(maxlen=_MEDIAN_OF)
        if mean_rise_px is not None:
            self._settle_at(mean_rise_px)

    def settle(self, pictures: Picture) -> None:
        """Learn which row belongs to the mean level from pictures (T, H, W) at all tides, in order of time."""
        if not len(self._columns):
            self._settle_at(-1.0)
            return
        shares = np.array([self._ends(picture) for picture in pictures])
        if len(pictures) < _LEAST_PICTURES or np.median(shares.max(axis=1)) < _LEAST_SHARE_OF_COLUMNS:
            self._settle_at(-1.0)
        else:
            self._settle_at(float(_smoothest(shares).mean()))

    def _settle_at(self, mean_rise_px: float) -> None:
        self.mean_rise_px = mean_rise_px
        if mean_rise_px < 0.0:
            self._columns = self._columns[:0]
        elif len(self._columns):
            self._px_per_m = self._upright_px_per_m(mean_rise_px)

    def of(self, picture: Picture) -> float | None:
        """Take in a picture (H, W) and return the level in metres; None where it cannot be measured."""
        if not len(self._columns):
            return None
        share = self._ends(picture)
        is_peak = (share >= np.roll(share, 1)) & (share >= np.roll(share, -1)) & (share > _LEAST_PEAK * share.max())
        if share.max() >= _LEAST_SHARE_OF_COLUMNS:
            rise_px = float(np.flatnonzero(is_peak).max())
            self._last.append(self.mean_m + (rise_px - self.mean_rise_px) / self._px_per_m)
        return float(np.median(self._last)) if self._last else None

    def below_quay(self, water: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return ``water`` (H, W) up to half the height of the wall: what stands there is afloat, in front of it."""
        below = water.copy()
        if len(self._columns):
            half_wall_px = -0.5 * self.mean_m * self._px_per_m
            rows = np.round(self._base - self.mean_rise_px - half_wall_px).astype(int)
            below[:, self._columns] |= np.arange(len(water))[:, None] >= rows
        return below

    def _upright_px_per_m(self, rise_px: float) -> float:
        """Return the pixels of a metre of the wall where the mean level is ``rise_px`` above the band's base."""
        middle = len(self._columns) // 2
        px = np.array([[self._columns[middle] + 0.5, self._base[middle] - rise_px]])
        foot_m = self._view.on_plane(px, self.mean_m)
        above, _ = self._view.project(np.add(foot_m, (0.0, 0.0, 1.0)))
        px_per_m = float(px[0, 1] - above[0, 1])
        return px_per_m if np.isfinite(px_per_m) else 1.0

    def _ends(self, picture: Picture) -> NDArray[np.float64]:
        """Return the share of columns whose water ends at each row above the base (R,), over three rows."""
        band = cv2.blur(picture, (3, 1))[self._rows, self._columns]
        water = np.median(picture[self._base + np.arange(_BELOW_PX)[:, None], self._columns], axis=0)
        other = np.abs(band - water) > _OTHER * self._noise[self._rows, self._columns]
        end = np.where(other.any(axis=0), other.argmax(axis=0), 0)
        share = np.bincount(end[end > 1], minlength=len(band)) / len(self._columns)
        return np.convolve(share, [0.5, 1.0, 0.5], "same")


def _base(columns: NDArray[np.intp], first: NDArray[np.intp], height_px: int) -> tuple[NDArray, NDArray]:
    """Return rows (C,) and columns (C,) of surely water below a straight wall, from which its foot is searched upwards.

    The water's upper edge at ``first`` (C,) is lower where boats lie: the base is a straight line along its highest
    parts, by asymmetric least squares (W. Newey, J. Powell, Econometrica 55(4), 1987), a bit lower.
    """
    if len(columns) < 2:
        return np.zeros(0, np.intp), columns[:0]
    line: NDArray[np.floating[Any]] = np.full(len(columns), float(first.min()))
    for _ in range(_LINE_ROUNDS):
        weights = np.where(first > line + 0.5, _BOATS_WEIGHT, 1.0)
        line = np.polyval(np.polyfit(columns, first, 1, w=weights), columns)
    base = np.round(line).astype(np.intp) + _UNSURE_PX
    inside = (base >= _LEAST_ABOVE_PX) & (base < height_px - _BELOW_PX)
    return base[inside], columns[inside]


def _smoothest(shares: NDArray[np.float64]) -> NDArray[np.intp]:
    """Return the row (T,) at each time that gathers most shares (T, R) while the tide moves by two rows at most."""
    total, back = shares[0].copy(), []
    for share in shares[1:]:
        padded = np.pad(total, _FASTEST_PX, constant_values=-np.inf)
        before = np.lib.stride_tricks.sliding_window_view(padded, 2 * _FASTEST_PX + 1)
        back.append(before.argmax(axis=1) - _FASTEST_PX)
        total = before.max(axis=1) + share
    path = [int(total.argmax())]
    for step in reversed(back):
        path.append(path[-1] + int(step[path[-1]]))
    return np.array(path[::-1])
