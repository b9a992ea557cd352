"""Regions of the picture placed on the quay or on the water, and the classes of what they may be."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from trackers.harbour_watch.detection import Region
from trackers.site import SiteView

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Kind:
    """One class.

    Attributes:
        name: ``person``, ``car``, ``boat`` or ``bird``; a bird is no intruder.
        size_m: (3,) typical length, width and height. spread: (3,) standard deviations of their logarithms.
        speed_mps: root mean square of each component of the velocity.
        acceleration_mps2: standard deviation of the acceleration from picture to picture.
        roof: shares of length and width that its highest part takes, about its middle.
        on_land, afloat: where it may be.
    """

    name: str
    size_m: Array
    spread: Array
    speed_mps: float
    acceleration_mps2: float
    roof: tuple[float, float]
    on_land: bool = False
    afloat: bool = False


PERSON = Kind("person", np.array([0.33, 0.50, 1.70]), np.array([0.25, 0.2, 0.1]), 1.0, 0.3, (0.5, 0.5), on_land=True)
"""Stature: adults of the world, NCD Risk Factor Collaboration, eLife 5:e13410, 2016 (women 1.59 m, men 1.71 m; shoes
and headgear added); breadth over the clothed shoulders and depth: J. Fruin, "Pedestrian planning and design", 1971
(95th percentile 0.58 m x 0.33 m). Walking speed 1.34 m/s: U. Weidmann, "Transporttechnik der
Fussgänger", ETH Zürich, 1993. The spread is that of a population with children."""

CAR = Kind("car", np.array([4.3, 1.8, 1.55]), np.array([0.13, 0.1, 0.13]), 2.5, 0.6, (0.45, 0.8), on_land=True)
"""New passenger cars of the European Union: ICCT, "European vehicle market statistics", 2020/21 (length 4.3 m, width
1.8 m, height 1.5 m); vans are higher. Speed: yards and quays are limited to walking pace up to 30 km/h."""

BOAT = Kind("boat", np.array([6.0, 2.2, 1.6]), np.array([0.35, 0.3, 0.35]), 1.5, 0.2, (0.3, 0.6), afloat=True)
"""Small open motor boats: ISO 8666 lengths of 4 to 9 m in makers' lists, beam about 0.37 of the length; the height is
over the waterline, with the people in them. Harbours are limited to about 3 to 5 knots."""

BIRD = Kind(
    "bird", np.array([0.5, 0.2, 0.3]), np.array([0.3, 0.3, 0.3]), 1.0, 0.5, (0.5, 0.5), on_land=True, afloat=True
)
"""Herring gull: S. Cramp et al., "The Birds of the Western Palearctic" III, 1983 (length 0.55 to 0.67 m with the tail,
folded wings); a standing or swimming one is about half as high as long."""

KINDS = (PERSON, CAR, BOAT, BIRD)

_NEVER = -30.0
_STRANGE = -6.0
"""Least log likelihood where a class may be: a region may show a part of an object, or two."""
_SEEN_WIDE, _SEEN_HIGH = 0.3, 0.25
"""Standard deviation of the logarithm of a region's width and height for one object: headings, missing parts."""


def log_likelihoods(width_m: float, height_m: float, afloat: bool, from_above: float) -> Array:
    """Return the log likelihoods (4,) of ``KINDS`` for a region's width and height at its place.

    ``from_above``: sine of the slope of the line of sight, the share of its depth by which an object's region is
    higher.
    """
    found = np.full(len(KINDS), _NEVER)
    for k, kind in enumerate(KINDS):
        if kind.afloat if afloat else kind.on_land:
            across = float(np.sqrt(kind.size_m[0] * kind.size_m[1]))
            expected = np.array([across, kind.size_m[2] + from_above * across])
            turns = 0.5 * np.log(kind.size_m[0] / kind.size_m[1])
            spread = np.hypot([_SEEN_WIDE, _SEEN_HIGH], [np.hypot(0.6 * turns, kind.spread[0]), kind.spread[2]])
            off = np.log(np.maximum([width_m, height_m], 1e-3) / expected) / spread
            found[k] = max(_STRANGE, -0.5 * float(off @ off) - float(np.log(spread).sum()))
    return found


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
