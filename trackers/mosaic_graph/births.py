"""Where the target may be although no particle is there, or none moves so."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.mosaic_graph.motion_model import Birth
from trackers.mosaic_graph.sightings import Sighting

FASTEST_MPS = 15.0
_REACH_MARGIN_M = 12.0
_LEAP_M, _SPEED_ERROR_MPS, _HARDEST_MPS2 = 3.0, 2.0, 3.0
_RELIABLE_S = 3.0
_BIRTH_AREA_M2, _DRIVABLE_SHARE, _LEAST_EVIDENCE = 1.6, 0.25, 5.0
# Born heading as the car there was seen to, a particle agrees with its axis by more than chance would have it: by this
# at most.
_AXIS_LOG_RATIO = 2.3
_CLEARLY_MOVING_MPS = 1.0


@dataclass(frozen=True, eq=False)
class LastSeen:
    """Where (2,) the target was when it was surely seen last, how fast, and how long ago."""

    position_m: NDArray[np.float64]
    speed_mps: float
    since_s: float


def renewal(target: Sighting, heading_rad: float, probability: float) -> Birth:
    """Return a birth on the sighting of the target, in case it does what no particle does.

    Args:
        heading_rad: where the particles head, on average: where it hardly moves, its axis is known up to half a turn.
        probability: of that, in any one picture.
    """
    if np.linalg.norm(target.velocity_mps) > _CLEARLY_MOVING_MPS:
        heading_rad = float(np.arctan2(target.velocity_mps[1], target.velocity_mps[0]))
    axis_rad = target.candidate.axis_rad
    if np.cos(axis_rad - heading_rad) < 0:
        axis_rad += np.pi
    # Not the particles' own mean: that would uphold itself.
    along = np.array([np.cos(axis_rad), np.sin(axis_rad)])
    speed_mps = max(float(target.velocity_mps @ along), 0.0)
    return Birth(target.candidate.position_m, axis_rad, speed_mps, float(np.log(probability)))


def may_be_target(sighting: Sighting, last: LastSeen) -> bool:
    """Return whether the target can have got there, and the sighting has looked like it for long enough."""
    fastest_mps = last.speed_mps + _SPEED_ERROR_MPS + 0.5 * _HARDEST_MPS2 * last.since_s
    reach_m = _LEAP_M + min(fastest_mps, FASTEST_MPS) * last.since_s
    near = float(np.linalg.norm(sighting.position_m - last.position_m)) < reach_m
    return near and sighting.age >= 2 and sighting.evidence + sighting.log_ratio > _LEAST_EVIDENCE


def surprise(sighting: Sighting, last: LastSeen, probability: float) -> Birth:
    """Return a birth on a sighting where no particle need be.

    Prior: the probability that the particles have lost the target, ``probability (1 - exp(-(t / 3 s)^2))`` (for a while
    they cover all it can do), spread evenly over the roads of a wide circle about where it was last seen, times what
    the pictures before this one said.
    """
    lost = probability * (1.0 - np.exp(-((last.since_s / _RELIABLE_S) ** 2)))
    area_m2 = _DRIVABLE_SHARE * np.pi * (_REACH_MARGIN_M + FASTEST_MPS * last.since_s) ** 2
    log_prior = float(np.log(lost * _BIRTH_AREA_M2 / area_m2)) + sighting.told - _AXIS_LOG_RATIO
    speed_mps = float(np.linalg.norm(sighting.velocity_mps))
    return Birth(sighting.candidate.position_m, sighting.heading_rad, speed_mps, log_prior)
