"""A harbour from above, the camera below the picture: its line of sight points upwards."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from benchmarks.show.video import marks
from scenarios.harbour.truth import HarbourMap

_MARGIN_M = 6.0
_SEA, _LAND, _QUIET = (36, 48, 62), (62, 60, 56), (150, 156, 166)


class PlanView:
    """A plan view to draw on.

    Attributes:
        ground: picture (H, W, 3) of land, sea, the quay's edge and the watched volume.
    """

    def __init__(self, site: HarbourMap, height_px: int) -> None:
        """``height_px``: of the picture; the watched volume fills it but for a margin."""
        depth_m, width_m = site.volume_m[:2]
        self._px_per_m = height_px / (depth_m + 2.0 * _MARGIN_M)
        self._top_left_m = site.volume_centre_m[:2] + 0.5 * site.volume_m[:2] + _MARGIN_M
        shape = height_px, round((width_m + 2.0 * _MARGIN_M) * self._px_per_m), 3
        self.ground = np.full(shape, _SEA, np.uint8)
        cv2.fillPoly(self.ground, [marks.fixed_point(self.at(site.land_m))], _LAND, cv2.LINE_AA, 4)
        marks.draw_lines(self.ground, [self.at(site.wall_m)], _QUIET, 1)
        corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)]) * 0.5 * site.volume_m[:2]
        marks.draw_lines(self.ground, [self.at(site.volume_centre_m[:2] + corners)], _QUIET, 1)
        marks.draw_text(self.ground, (8, 18), f"watched from above: {depth_m:g} m × {width_m:g} m", _QUIET, size=13)

    def at(self, places_m: ArrayLike) -> NDArray[np.float64]:
        """Return places (..., 2) of the world in the picture."""
        return (self._top_left_m - np.asarray(places_m, float)[..., :2])[..., ::-1] * self._px_per_m
