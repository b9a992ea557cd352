"""Tracks of candidates from picture to picture, the evidence that each is the target, and births of particles."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from trackers.mosaic_graph.detector import Candidate
from trackers.mosaic_graph.motion_model import Birth

_GATE_M = 2.2
_POSITION_GAIN, _VELOCITY_GAIN = 0.7, 0.25
_PATIENCE = 4
_PLAUSIBLE = -2.0
_MOST_EXPECTED = 8
# Pictures of one car resemble one another: any number of them counts as so many independent ones at most, and its
# evidence is limited by the rarity of cars that look like the target.
_INDEPENDENT_PICTURES, _MOST_EVIDENCE = 4.0, 8.0
_RIVAL_STEP, _RIVAL_MOST = 0.4, 5.0


@dataclass(eq=False)
class Sighting:
    """Track of a candidate.

    Attributes:
        candidate: the latest.
        position_m, velocity_mps: (2,) smoothed.
        evidence: log-ratio that it is the target, from the pictures before the latest.
        rivalry: evidence that it is another car, seen together with the target.
        age, missed: pictures that show it, and pictures since the latest of these.
    """

    candidate: Candidate
    position_m: NDArray[np.float64]
    velocity_mps: NDArray[np.float64] = field(default_factory=lambda: np.zeros(2))
    evidence: float = 0.0
    rivalry: float = 0.0
    age: int = 1
    missed: int = 0

    @property
    def heading_rad(self) -> float:
        """Direction of travel, or the axis below 1.5 m/s."""
        if np.linalg.norm(self.velocity_mps) > 1.5:
            return float(np.arctan2(self.velocity_mps[1], self.velocity_mps[0]))
        return self.candidate.axis_rad

    @property
    def past_evidence(self) -> float:
        """Evidence of the pictures before the latest, limited."""
        return min(self.evidence, _MOST_EVIDENCE)

    @property
    def news(self) -> float:
        """Evidence that the latest picture adds to that, less rivalry."""
        return min(self.evidence_with_latest, _MOST_EVIDENCE) - self.past_evidence - self.rivalry

    @property
    def evidence_with_latest(self) -> float:
        """Evidence of all pictures: their mean log-ratio times the number of independent ones."""
        seen = min(float(self.age), _INDEPENDENT_PICTURES)
        before = min(self.age - 1.0, _INDEPENDENT_PICTURES)
        mean = self.evidence / max(before, 1.0)
        return seen * (mean + (self.candidate.log_ratio - mean) / (before + 1.0))

    @property
    def log_ratio(self) -> float:
        """Evidence of the latest picture alone, less rivalry."""
        return self.candidate.log_ratio - self.rivalry


class Sightings:
    """All present sightings."""

    def __init__(self) -> None:
        self.current: list[Sighting] = []

    def expected(self, dt_s: float) -> list[tuple[NDArray[np.float64], float]]:
        """Return predicted places (2,) and headings of the sightings, the likeliest targets first."""
        ranked = sorted(self.current, key=lambda s: s.evidence - s.missed, reverse=True)
        return [(s.position_m + dt_s * s.velocity_mps, s.heading_rad) for s in ranked[:_MOST_EXPECTED]]

    def update(self, candidates: list[Candidate], dt_s: float) -> None:
        """Assign each plausible candidate to the nearest sighting or a new one; drop sightings missed for too long."""
        candidates = [candidate for candidate in candidates if candidate.log_ratio > _PLAUSIBLE]
        for sighting in self.current:
            sighting.position_m = sighting.position_m + dt_s * sighting.velocity_mps
            sighting.missed += 1
        pairs = sorted(
            (float(np.linalg.norm(candidate.position_m - sighting.position_m)), s, c)
            for s, sighting in enumerate(self.current)
            for c, candidate in enumerate(candidates)
        )
        taken: set[int] = set()
        for distance_m, s, c in pairs:
            sighting = self.current[s]
            if distance_m < _GATE_M and sighting.missed > 0 and c not in taken:
                _follow(sighting, candidates[c], dt_s)
                taken.add(c)
        fresh = [Sighting(c, c.position_m.copy()) for k, c in enumerate(candidates) if k not in taken]
        self.current = [s for s in self.current if s.missed <= _PATIENCE] + fresh

    def seen(self) -> list[Sighting]:
        """Return the sightings in the latest picture."""
        return [s for s in self.current if s.missed == 0]

    def nearest(self, position_m: NDArray[np.float64], within_m: float) -> Sighting | None:
        """Return the sighting in the latest picture nearest to a map point (2,) within ``within_m``, or None."""
        near = [(float(np.linalg.norm(s.position_m - position_m)), k) for k, s in enumerate(self.seen())]
        return self.seen()[min(near)[1]] if near and min(near)[0] < within_m else None

    def rule_out_others(self, target: Sighting) -> None:
        """Raise the rivalry of all sightings in the latest picture but the target; lower the target's."""
        for sighting in self.seen():
            if sighting is not target:
                sighting.rivalry = min(sighting.rivalry + _RIVAL_STEP, _RIVAL_MOST)
        target.rivalry = max(target.rivalry - 2 * _RIVAL_STEP, 0.0)


def _follow(sighting: Sighting, candidate: Candidate, dt_s: float) -> None:
    sighting.evidence = sighting.evidence_with_latest
    surprise = candidate.position_m - sighting.position_m
    # A box cut by the border is measured too far inside.
    trust = candidate.covered**3
    # The first displacement is the only measurement of the velocity yet.
    gain = 0.8 if sighting.age == 1 else _VELOCITY_GAIN
    sighting.velocity_mps = sighting.velocity_mps + trust * gain * surprise / max(dt_s, 1e-3)
    sighting.position_m = sighting.position_m + trust * _POSITION_GAIN * surprise
    sighting.candidate = candidate
    sighting.age += 1
    sighting.missed = 0


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
