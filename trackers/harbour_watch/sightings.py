"""Regions of the picture placed on the quay or on the water."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.harbour_watch.classes import KINDS
from trackers.harbour_watch.detection import Region
from trackers.site.view import SiteView

Array = NDArray[np.float64]

_COLUMN_PX, _ROW_PX = 1.0, 1.3
"""Standard deviations of a region's middle and of its lower edge: about a pixel, for optics and sampling."""
_LOOSE = 0.15
"""Standard deviation of the same by the region's own width and height: parts without contrast are missing."""
_TOP_VIEW = 0.2
"""Share of a class's depth that adds to the height of its region, seen from above at about 11 degrees."""
_WIDTH_SPREAD, _HEIGHT_SPREAD = (0.35, 0.4, 0.5), (0.3, 0.3, 0.4)
"""Standard deviations of the logarithm of a region's width and height by class: sizes, headings, missing parts."""
_STRANGE = -6.0
"""Least log likelihood of a class: a region may show a part of an object."""


@dataclass(frozen=True, eq=False)
class Sighting:
    """One region on its plane.

    Attributes:
        region: as found.
        near_m: (2,) where its lower edge stands. covariance: (2, 2), square metres.
        px_per_m: at its place.
        afloat: whether it stands on the water.
        log_kinds: (3,) log likelihood of its width and height under each of ``KINDS``.
        px2_per_m2: area of a square metre of the plane in the picture.
    """

    region: Region
    near_m: Array
    covariance: Array
    px_per_m: float
    afloat: bool
    log_kinds: Array
    px2_per_m2: float


def place_regions(
    regions: Sequence[Region], view: SiteView, water: NDArray[np.bool_], level_m: float
) -> list[Sighting]:
    """Return the sightings of regions; those that meet neither plane before the camera are left out."""
    placed = []
    for region in regions:
        x0, y0, x1, y1 = region.box_xyxy
        foot = np.array([0.5 * (x0 + x1), y1])
        row = min(max(int(y1) - 1, 0), water.shape[0] - 1)
        column = min(max(int(foot[0]), 0), water.shape[1] - 1)
        afloat = bool(water[row, column])
        around = foot + np.array([[0.0, 0.0], [1.0, 0.0], [0.0, -1.0]])
        points = view.on_plane(around, level_m if afloat else 0.0)
        if not np.isfinite(points).all():
            continue
        jacobian = (points[1:, :2] - points[0, :2]).T
        sigma = np.array([_COLUMN_PX + _LOOSE * (x1 - x0), _ROW_PX + _LOOSE * (y1 - y0)])
        covariance = (jacobian * sigma**2) @ jacobian.T
        _, depth_m = view.project(points[:1])
        px_per_m = view.camera.focal_px / float(depth_m[0])
        area = abs(float(np.linalg.det(jacobian)))
        placed.append(
            Sighting(
                region,
                points[0, :2],
                covariance,
                px_per_m,
                afloat,
                _kinds((x1 - x0) / px_per_m, (y1 - y0) / px_per_m, afloat),
                1.0 / max(area, 1e-9),
            )
        )
    return placed


def _kinds(width_m: float, height_m: float, afloat: bool) -> Array:
    """Return the log likelihoods (3,) of a region's width and height."""
    found = np.full(len(KINDS), _STRANGE - 4.0)
    for k, kind in enumerate(KINDS):
        if kind.afloat == afloat:
            length, width, height = kind.size_m
            seen = np.array([np.sqrt(length * width), height + _TOP_VIEW * np.sqrt(length * width)])
            off = np.log(np.maximum([width_m, height_m], 1e-3) / seen) / [_WIDTH_SPREAD[k], _HEIGHT_SPREAD[k]]
            found[k] = max(_STRANGE, -0.5 * float(off @ off) - np.log(_WIDTH_SPREAD[k] * _HEIGHT_SPREAD[k]))
    return found
