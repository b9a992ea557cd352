"""What the usual fish of a video is like, learnt from its blobs: area, length, contrast; and how dark shadows are."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

_REMEMBERED = 1500
_SOME, _MANY = 30, 300
"""Blobs from which on they are trusted."""
_ONE_BODY_QUANTILE = 0.4
"""Below the median, as some blobs are of several fish."""
_EVERY = 15
"""Calls of ``learn`` that share one lesson, once there are many blobs."""
_PARTED, _MINORITY, _FAINTER = 0.8, 0.1, 0.65
"""Least share of the scatter between two classes (0.75 for a uniform distribution), least share of either, and
greatest contrast of the fainter as a share of the other's."""
_REACH, _NOISE = 2.5, 0.02
"""Standard deviations of the shadows' contrast, and that of a pixel."""


class Norms:
    """Quantiles over the latest blobs; all values are 0 until enough are known.

    Contrasts are shares of the floor's brightness.

    Attributes:
        area_px, length_px: of one fish. contrast: mean over the dark part of one fish. shadow: contrast up to which a
            pixel may be of a shadow; 0 without shadows. centre: where one fish's contrast has its centre, as a share of
            its length behind the head.
    """

    def __init__(self) -> None:
        self._areas: deque[float] = deque(maxlen=_REMEMBERED)
        self._lengths: deque[float] = deque(maxlen=_REMEMBERED)
        self._contrasts: deque[float] = deque(maxlen=_REMEMBERED)
        self._centres: deque[float] = deque(maxlen=_REMEMBERED)
        self._cores: deque[float] = deque(maxlen=_REMEMBERED)
        self._calls = 0
        self.area_px = self.length_px = self.contrast = self.centre = self.shadow = 0.0

    def see_blob(self, core: float) -> None:
        """Take in a blob, fish or shadow, by the contrast of its core."""
        self._cores.append(core)

    def see_fish(self, area_px: float, length_px: float, contrast: float, centre: float) -> None:
        """Take in a blob that is no shadow."""
        self._areas.append(area_px)
        self._lengths.append(length_px)
        self._contrasts.append(contrast)
        self._centres.append(centre)

    def learn(self) -> None:
        """Update the values; call it once a picture."""
        self._calls += 1
        if self._calls % _EVERY and len(self._cores) > _MANY:
            return
        if len(self._cores) >= _SOME:
            shadow = shadow_limit(np.array(self._cores))
            if shadow > 0 and self.shadow == 0:
                # What was learnt so far was learnt from shadows too.
                self._forget()
                self.contrast = 0.0
            self.shadow = shadow
        if len(self._areas) >= _SOME and self.contrast == 0:
            # With a contrast to cut them by, blobs are smaller from now on.
            self.contrast = float(np.quantile(self._contrasts, _ONE_BODY_QUANTILE))
            self._forget()
        if len(self._areas) >= _SOME:
            self.area_px, self.length_px, self.contrast = (
                float(np.quantile(values, _ONE_BODY_QUANTILE))
                for values in (self._areas, self._lengths, self._contrasts)
            )
            self.centre = float(np.median(self._centres))

    def _forget(self) -> None:
        for values in (self._areas, self._lengths, self._contrasts, self._centres):
            values.clear()
        self.area_px = self.length_px = self.centre = 0.0


def shadow_limit(cores: NDArray[np.float64]) -> float:
    """Return the contrast up to which blobs are shadows, 0 if there are none.

    Fish throw shadows of one contrast, which is fainter than theirs. The contrasts (N,) of all blobs are cut in two
    where the scatter between the parts is greatest (Otsu 1979); there are shadows if the parts are far enough apart.
    """
    ordered = np.sort(cores)
    count = np.arange(1, len(ordered))
    sums = np.cumsum(ordered)
    low, high = sums[:-1] / count, (sums[-1] - sums[:-1]) / (len(ordered) - count)
    share = count / len(ordered)
    between = share * (1 - share) * (high - low) ** 2
    best = int(np.argmax(between))
    parted = between[best] > _PARTED * max(float(np.var(ordered)), 1e-12)
    if not parted or not _MINORITY < share[best] < 1 - _MINORITY or low[best] > _FAINTER * high[best]:
        return 0.0
    faint = ordered[: best + 1]
    middle = float(np.median(faint))
    # Shadows that touch a fish are darker than others, so the scatter is that of the middle half.
    scatter = float(np.subtract(*np.quantile(faint, [0.75, 0.25]))) / 1.35
    return float(min(middle + _REACH * scatter + _NOISE, 0.5 * (low[best] + high[best])))
