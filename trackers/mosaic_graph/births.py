"""Births of particles where the target may be although no particle is there, or none moves like it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.mosaic_graph.motion_model import Birth
from trackers.mosaic_graph.sightings import Sighting

FASTEST_MPS = 15.0
"""Desired speed of city traffic, 54 km/h (Treiber & Kesting, Traffic Flow Dynamics, 2013, table 11.2)."""
_REACH_MARGIN_M = 12.0
_LEAP_M, _SPEED_ERROR_MPS, _HARDEST_MPS2 = 3.0, 2.0, 3.0
_RELIABLE_S = 3.0
_BIRTH_AREA_M2, _DRIVABLE_SHARE, _LEAST_EVIDENCE = 1.6, 0.25, 5.0
_AXIS_LOG_RATIO = 2.3
"""A newborn particle's heading agrees with the candidate's axis by construction: greatest log-weight that adds."""
_CLEARLY_MOVING_MPS = 1.0


@dataclass(frozen=True, eq=False)
class LastSeen:
    """Place (2,) and speed of the target when it was last seen with certainty, and the time since then."""

    position_m: NDArray[np.float64]
    speed_mps: float
    since_s: float


def renewal(target: Sighting, heading_rad: float, probability: float) -> Birth:
    """Return a birth on the target's sighting, in case it moves as no particle does.

    Args:
        heading_rad: mean heading of the particles, which resolves the axis of a target that hardly moves.
        probability: of such a motion in one picture.
    """
    if np.linalg.norm(target.velocity_mps) > _CLEARLY_MOVING_MPS:
        heading_rad = float(np.arctan2(target.velocity_mps[1], target.velocity_mps[0]))
    axis_rad = target.candidate.axis_rad
    if np.cos(axis_rad - heading_rad) < 0:
        axis_rad += np.pi
    # The particles' own mean speed would confirm itself.
    along = np.array([np.cos(axis_rad), np.sin(axis_rad)])
    speed_mps = max(float(target.velocity_mps @ along), 0.0)
    return Birth(target.candidate.position_m, axis_rad, speed_mps, float(np.log(probability)))


def may_be_target(sighting: Sighting, last: LastSeen) -> bool:
    """Return whether a sighting is within the target's reach, with evidence enough over two pictures or more."""
    fastest_mps = last.speed_mps + _SPEED_ERROR_MPS + 0.5 * _HARDEST_MPS2 * last.since_s
    reach_m = _LEAP_M + min(fastest_mps, FASTEST_MPS) * last.since_s
    near = float(np.linalg.norm(sighting.position_m - last.position_m)) < reach_m
    return near and sighting.age >= 2 and sighting.evidence + sighting.log_ratio > _LEAST_EVIDENCE


def surprise(sighting: Sighting, last: LastSeen, probability: float) -> Birth:
    """Return a birth on a sighting that may be far from all particles.

    Prior: the probability that the particles have lost the target, ``probability (1 - exp(-(t / 3 s)^2))``, spread
    evenly over the roads of a wide circle around its last place, times the evidence of the earlier pictures.
    """
    lost = probability * (1.0 - np.exp(-((last.since_s / _RELIABLE_S) ** 2)))
    area_m2 = _DRIVABLE_SHARE * np.pi * (_REACH_MARGIN_M + FASTEST_MPS * last.since_s) ** 2
    log_prior = float(np.log(lost * _BIRTH_AREA_M2 / area_m2)) + sighting.past_evidence - _AXIS_LOG_RATIO
    speed_mps = float(np.linalg.norm(sighting.velocity_mps))
    return Birth(sighting.candidate.position_m, sighting.heading_rad, speed_mps, log_prior)
