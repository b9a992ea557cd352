"""Regions of the picture placed on the quay or on the water."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from trackers.harbour_watch.classes import log_likelihoods
from trackers.harbour_watch.detection import Region
from trackers.site.view import SiteView

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Sighting:
    """One region on its plane.

    Attributes:
        region: as found.
        near_m: (2,) where its lower edge stands.
        afloat: whether it stands on the water.
        log_kinds: (4,) log likelihood of its width and height under each of ``KINDS``.
        m2_per_px: area of the plane that one pixel shows there.
    """

    region: Region
    near_m: Array
    afloat: bool
    log_kinds: Array
    m2_per_px: float


def place_regions(
    regions: Sequence[Region], view: SiteView, water: NDArray[np.bool_], level_m: float
) -> list[Sighting]:
    """Return the sightings of regions; those that meet neither plane before the camera are left out."""
    placed = []
    for region in regions:
        sightings = [_placed(each, view, water, level_m) for each in (region, _without_mirror(region))]
        whole, above = sightings
        if whole is not None:
            # Water mirrors what floats: its image below makes a region about twice as high as the object.
            is_mirrored = whole.afloat and above is not None and above.log_kinds.max() > whole.log_kinds.max()
            placed.append(above if is_mirrored and above is not None else whole)
    return placed


def _without_mirror(region: Region) -> Region:
    x0, y0, x1, y1 = region.box_xyxy
    return replace(region, box_xyxy=np.array([x0, y0, x1, 0.5 * (y0 + y1)]))


def _placed(region: Region, view: SiteView, water: NDArray[np.bool_], level_m: float) -> Sighting | None:
    x0, y0, x1, y1 = region.box_xyxy
    foot = np.array([0.5 * (x0 + x1), y1])
    row = min(max(int(y1 - 0.5), 0), water.shape[0] - 1)
    column = min(max(int(foot[0]), 0), water.shape[1] - 1)
    afloat = bool(water[row, column])
    points = view.on_plane(foot + np.array([[0.0, 0.0], [1.0, 0.0], [0.0, -1.0]]), level_m if afloat else 0.0)
    if not np.isfinite(points).all():
        return None
    _, depth_m = view.project(points[:1])
    px_per_m = view.camera.focal_px / float(depth_m[0])
    area = abs(float(np.linalg.det(points[1:, :2] - points[0, :2])))
    sight_m = view.place_m - points[0]
    from_above = float(sight_m[2] / np.linalg.norm(sight_m))
    kinds = log_likelihoods((x1 - x0) / px_per_m, (y1 - y0) / px_per_m, afloat, from_above)
    return Sighting(region, points[0, :2], afloat, kinds, area)
