"""Sizes of an object from the extents of its regions, shrunk to its class by their uncertainty."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from trackers.harbour_watch.classes import Kind
from trackers.site.view import SiteView

Array = NDArray[np.float64]

_EXTENT_PX = 1.5
"""Standard deviation of a region's width and height: about a pixel at each side."""
_EXTENT_SHARE = 0.12
"""Standard deviation of the same by themselves: parts without contrast, limbs, shadows."""
_ALIKE = 4.0
"""Successive regions err alike (the same cold legs): so many of them count as one."""
_NUDGE = 0.02
"""Step of the numerical derivatives by the logarithms of sizes."""
_OUTLIER = 2.5
"""Deviations beyond which an extent counts less."""


class Size:
    """Normal distribution of the logarithms of length, width and height.

    An extended Kalman filter whose measurement is the width and height of the projected box.

    Attributes:
        kind: the class whose sizes are the prior.
    """

    def __init__(self, kind: Kind) -> None:
        """Begin at the class's sizes."""
        self.kind = kind
        self._log, self._covariance = np.log(kind.size_m), np.diag(kind.spread**2)

    @property
    def size_m(self) -> Array:
        """Median (3,) of length, width and height."""
        size: Array = np.exp(self._log)
        return size

    def update(self, extent_px: Array, view: SiteView, base_m: Array, heading_rad: float, doubt: float) -> None:
        """Take in a region's width and height (2,) of an object that stands at ``base_m`` (3,).

        Args:
            doubt: factor on the noise's variance, e.g. for a heading that is not known.
        """
        expected = self._extent_px(self._log, view, base_m, heading_rad)
        if expected is None:
            return
        nudged = [self._extent_px(self._log + _NUDGE * step, view, base_m, heading_rad) for step in np.eye(3)]
        jacobian = np.column_stack([(each - expected) / _NUDGE for each in nudged if each is not None])
        if jacobian.shape[1] != 3:
            return
        noise = np.diag(_EXTENT_PX**2 + (_EXTENT_SHARE * expected) ** 2) * _ALIKE * doubt
        innovation = jacobian @ self._covariance @ jacobian.T + noise
        off = extent_px - expected
        deviations = np.sqrt(np.maximum(off**2 / np.diag(innovation), 1e-12))
        gain = np.linalg.solve(innovation, jacobian @ self._covariance).T
        self._log = self._log + gain @ (off * np.minimum(1.0, _OUTLIER / deviations))
        self._covariance = self._covariance - gain @ jacobian @ self._covariance

    @staticmethod
    def _extent_px(log_size: Array, view: SiteView, base_m: Array, heading_rad: float) -> Array | None:
        size = np.exp(log_size)
        estimate = view.estimate_of(np.add(base_m, (0.0, 0.0, 0.5 * size[2])), size, heading_rad)
        if estimate is None or estimate.box_xyxy is None:
            return None
        extent: Array = estimate.box_xyxy[2:] - estimate.box_xyxy[:2]
        return extent
