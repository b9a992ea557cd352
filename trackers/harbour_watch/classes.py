"""Classes of what is tracked: what is known of their sizes and motion before any picture, from published statistics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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
