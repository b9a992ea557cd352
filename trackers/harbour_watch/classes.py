"""Classes of intruders: what is known of their sizes and motion before any picture, from published statistics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Kind:
    """One class.

    Attributes:
        name: ``person``, ``car`` or ``boat``.
        size_m: (3,) typical length, width and height. spread: (3,) standard deviations of their logarithms.
        speed_mps: root mean square of each component of the velocity.
        acceleration_mps2: standard deviation of the acceleration over one picture's interval.
        afloat: whether it stands on the water.
    """

    name: str
    size_m: NDArray[np.float64]
    spread: NDArray[np.float64]
    speed_mps: float
    acceleration_mps2: float
    afloat: bool


PERSON = Kind("person", np.array([0.45, 0.50, 1.70]), np.array([0.25, 0.2, 0.08]), 1.0, 0.35, False)
"""Stature: adults of the world, NCD Risk Factor Collaboration, eLife 5:e13410, 2016 (women 1.59 m, men 1.71 m; shoes
and headgear added); breadth over the clothed shoulders and depth: J. Fruin, "Pedestrian planning and design", 1971
(body ellipse of 0.61 m x 0.46 m with room for sway). Walking speed 1.34 m/s: U. Weidmann, "Transporttechnik der
Fussgänger", ETH Zürich, 1993."""

CAR = Kind("car", np.array([4.3, 1.8, 1.55]), np.array([0.13, 0.08, 0.12]), 3.5, 1.0, False)
"""New passenger cars of the European Union: ICCT, "European vehicle market statistics", 2020/21 (length 4.3 m, width
1.8 m, height 1.5 m); vans are higher. Speed: yards and quays are limited to walking pace up to 30 km/h."""

BOAT = Kind("boat", np.array([6.0, 2.2, 1.6]), np.array([0.35, 0.3, 0.35]), 1.5, 0.3, True)
"""Small open motor boats: ISO 8666 lengths of 4 to 9 m in makers' lists, beam about 0.37 of the length; the height is
over the waterline, with the people in them. Harbours are limited to about 3 to 5 knots."""

KINDS = (PERSON, CAR, BOAT)
