"""Candidates followed from picture to picture: what has been car-like for a while, where it goes, and
whether it can be the target.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from trackers.mosaic_graph.detector import Candidate

_GATE_M = 2.2
_POSITION_GAIN, _VELOCITY_GAIN = 0.7, 0.25
_PATIENCE = 4
_PLAUSIBLE = -2.0
_MOST_EXPECTED = 8
# One thing's pictures resemble one another: however long it is watched, it tells no more than so many
# independent ones, and no more than how rare things are that look like the target.
_INDEPENDENT_PICTURES, _MOST_EVIDENCE = 4.0, 8.0
_RIVAL_STEP, _RIVAL_MOST = 0.4, 5.0


@dataclass(eq=False)
class Sighting:
    """One thing that looks like the target, over time.

    Attributes:
        candidate: the latest.
        position_m, velocity_mps: (2,) smoothed.
        evidence: log-ratio that it is the target, by the pictures before the latest.
        rivalry: evidence that it is another car: it was there while the target was surely elsewhere.
        age, missed: pictures since it was first seen, and since it was last seen.
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
        """Direction of travel, or the axis where it hardly moves."""
        if np.linalg.norm(self.velocity_mps) > 1.5:
            return float(np.arctan2(self.velocity_mps[1], self.velocity_mps[0]))
        return self.candidate.axis_rad

    @property
    def told(self) -> float:
        """What the pictures before the latest tell."""
        return min(self.evidence, _MOST_EVIDENCE)

    @property
    def news(self) -> float:
        """What the latest picture adds to that, rivalry included."""
        return min(self.evidence_with_latest, _MOST_EVIDENCE) - self.told - self.rivalry

    @property
    def evidence_with_latest(self) -> float:
        """That of all pictures: their mean log-ratio times as many as are independent."""
        seen = min(float(self.age), _INDEPENDENT_PICTURES)
        before = min(self.age - 1.0, _INDEPENDENT_PICTURES)
        mean = self.evidence / max(before, 1.0)
        return seen * (mean + (self.candidate.log_ratio - mean) / (before + 1.0))

    @property
    def log_ratio(self) -> float:
        """Evidence of the latest picture, rivalry included."""
        return self.candidate.log_ratio - self.rivalry


class Sightings:
    """All sightings that are being followed."""

    def __init__(self) -> None:
        self.current: list[Sighting] = []

    def expected(self, dt_s: float) -> list[tuple[NDArray[np.float64], float]]:
        """Return where (2,) and along which heading the sightings should be now, the likeliest targets
        first.
        """
        ranked = sorted(self.current, key=lambda s: s.evidence - s.missed, reverse=True)
        return [(s.position_m + dt_s * s.velocity_mps, s.heading_rad) for s in ranked[:_MOST_EXPECTED]]

    def update(self, candidates: list[Candidate], dt_s: float) -> None:
        """Give each plausible candidate to the nearest sighting it may belong to, or start a new one;
        forget what is long gone.
        """
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
        """Return the sightings of the latest picture."""
        return [s for s in self.current if s.missed == 0]

    def nearest(self, position_m: NDArray[np.float64], within_m: float) -> Sighting | None:
        """Return the sighting of the latest picture nearest to a map point (2,), if one is near enough."""
        near = [(float(np.linalg.norm(s.position_m - position_m)), k) for k, s in enumerate(self.seen())]
        return self.seen()[min(near)[1]] if near and min(near)[0] < within_m else None

    def rule_out_others(self, target: Sighting) -> None:
        """Count it against all others that they are seen together with the target."""
        for sighting in self.seen():
            if sighting is not target:
                sighting.rivalry = min(sighting.rivalry + _RIVAL_STEP, _RIVAL_MOST)
        target.rivalry = max(target.rivalry - 2 * _RIVAL_STEP, 0.0)


def _follow(sighting: Sighting, candidate: Candidate, dt_s: float) -> None:
    sighting.evidence = sighting.evidence_with_latest
    surprise = candidate.position_m - sighting.position_m
    # What the border cuts is measured too far inside.
    trust = candidate.covered**3
    # The first step tells the velocity alone.
    gain = 0.8 if sighting.age == 1 else _VELOCITY_GAIN
    sighting.velocity_mps = sighting.velocity_mps + trust * gain * surprise / max(dt_s, 1e-3)
    sighting.position_m = sighting.position_m + trust * _POSITION_GAIN * surprise
    sighting.candidate = candidate
    sighting.age += 1
    sighting.missed = 0
