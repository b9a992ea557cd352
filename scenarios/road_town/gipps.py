"""Speeds by the model of Gipps (1981), for drivers that are not those of the intelligent driver model.

P. G. Gipps, "A behavioural car-following model for computer simulation", Transportation Research B 15 (1981) 105-111.
A bend is treated as a car ahead, at the speed the bend allows and in the distance that drivers keep from it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenarios.road_town.route import POINT_SPACING_M, Route

ACCELERATION_MPS2, BRAKING_MPS2, REACTION_S = 1.7, 3.4, 2 / 3
"""The paper's mean acceleration, twice that for braking, and its reaction time."""
LATERAL_ACCELERATION_MPS2 = 3.1
"""Side friction of 0.32 on streets driven at 25 km/h (AASHTO, Policy on Geometric Design, 2011, low-speed streets)."""
_HARDEST_BRAKING_MPS2 = 6.0
_SLOWEST_BEND_MPS = 2.0
_SEEN_BENDS_M = np.arange(0.0, 60.0, 1.0)


def bend_speeds_mps(route: Route, cruise_mps: float) -> NDArray[np.float64]:
    """Return the highest speed (M,) at each point of a route that the bend there allows."""
    curvature = np.maximum(np.abs(route.curvature_per_m()), 1e-6)
    return np.clip(np.sqrt(LATERAL_ACCELERATION_MPS2 / curvature), min(_SLOWEST_BEND_MPS, cruise_mps), cruise_mps)


def speed_for_bends_mps(bends_mps: NDArray[np.float64], arc_m: float, speed_mps: float) -> float:
    """Return the highest safe speed after the reaction time, from which a car can brake for every bend ahead.

    ``-b t + sqrt((b t + v)^2 + 2 b d)`` for a bend of speed v, d metres beyond the way driven in that time: the paper's
    safe speed as Krauss (1998) simplified it.

    Args:
        bends_mps: (M,) see ``bend_speeds_mps``.
    """
    points = np.arange(len(bends_mps)) * POINT_SPACING_M
    allowed = np.interp(arc_m + _SEEN_BENDS_M, points, bends_mps)
    reach = BRAKING_MPS2 * REACTION_S
    beyond = np.maximum(_SEEN_BENDS_M - REACTION_S * speed_mps, 0.0)
    return float((np.sqrt((reach + allowed) ** 2 + 2 * BRAKING_MPS2 * beyond) - reach).min())


def safe_speed_mps(gap_m: NDArray[np.float64], speed_mps: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the paper's safe speeds (N,) after the reaction time, behind something that may stand at once.

    ``-b t + sqrt(b^2 t^2 + 2 b gap - b v t)``, at least 0.
    """
    reach = BRAKING_MPS2 * REACTION_S
    squared = reach**2 + 2 * BRAKING_MPS2 * gap_m - reach * speed_mps
    speeds: NDArray[np.float64] = np.maximum(np.sqrt(np.maximum(squared, 0.0)) - reach, 0.0)
    return speeds


def acceleration_mps2(
    speed_mps: NDArray[np.float64],
    cruise_mps: NDArray[np.float64],
    bends_mps: NDArray[np.float64],
    gap_m: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return accelerations (N,) towards the speeds after the reaction time.

    Args:
        bends_mps: (N,) highest safe speeds for the bends ahead.
        gap_m: (N,) free distance to something that stands, or may stop at once.
    """
    share = np.clip(speed_mps / cruise_mps, 0.0, 1.0)
    free = speed_mps + 2.5 * ACCELERATION_MPS2 * REACTION_S * (1 - share) * np.sqrt(0.025 + share)
    wanted = np.minimum(np.minimum(free, bends_mps), safe_speed_mps(np.maximum(gap_m, 0.0), speed_mps))
    return np.clip((wanted - speed_mps) / REACTION_S, -_HARDEST_BRAKING_MPS2, 1.1 * ACCELERATION_MPS2)
