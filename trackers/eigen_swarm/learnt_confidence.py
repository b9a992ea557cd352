"""``eigen_swarm_learnt_confidence``: paper D's method with the confidence that the harbour's baselines have."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from trackers.baselines.ground_linker import EVIDENCE, evidence_of, learnt_weights, probabilities
from trackers.eigen_swarm.tracker import EigenSwarm, EigenSwarmParameters
from trackers.registry import register
from trackers.site import off_edge_m
from trackers.types import CameraModel, Observation, Track

NAME = "eigen_swarm_learnt_confidence"
_SUREST = 1.0 - 1e-6


@register(
    NAME,
    role="variant",
    edition=2,
    summary="eigen_swarm, its confidence learnt as those of the baselines",
    suites=("harbour",),
)
class EigenSwarmLearntConfidence(EigenSwarm):
    """Answers as ``eigen_swarm``; only how sure it is of a track is a logistic regression on the evidence of the track.

    How strongly a track differs from the background is here ``1 / (1 - f)``, f the mean likelihood of its particles,
    which is the confidence of the method as written.

    Attributes:
        decides_at: see ``DecidingTracker``. Confidences are those of as many intruders as others.
        evidence: (N, 11) of the N tracks of the latest answer, see ``ground_linker.evidence_of``.
    """

    Parameters = EigenSwarmParameters
    decides_at = 0.5

    def __init__(self, parameters: EigenSwarmParameters, rng: np.random.Generator) -> None:
        super().__init__(parameters, rng)
        self._weights = learnt_weights(NAME, "trackers.eigen_swarm")
        self.evidence = np.empty((0, len(EVIDENCE)))
        self._met: dict[int, tuple[int, NDArray[np.float64]]] = {}

    def start(self, background: Sequence[Observation], camera: CameraModel) -> None:
        """See ``MultiTracker``."""
        super().start(background, camera)
        self._met = {}

    def update(self, observation: Observation) -> list[Track]:
        """See ``EigenSwarm``."""
        tracks = super().update(observation)
        self.evidence = np.array([self._evidence(each) for each in tracks]).reshape(-1, len(EVIDENCE))
        sure = probabilities(self.evidence, self._weights)
        return [replace(each, confidence=float(c)) for each, c in zip(tracks, sure, strict=True)]

    def _evidence(self, track: Track) -> NDArray[np.float64]:
        assert self._site is not None
        assert track.size_m is not None
        assert track.confidence is not None
        place_m = self._site.view.place_of(track.estimate)[:2]
        hits, first_m = self._met.get(track.identity, (0, place_m))
        self._met[track.identity] = hits + 1, first_m
        [off_m] = off_edge_m(self._site.survey, place_m[None])
        strength = 1.0 / (1.0 - min(track.confidence, _SUREST))
        moved_m = float(np.hypot(*(place_m - first_m)))
        return evidence_of(strength, track.size_m[1], track.size_m[2], hits + 1, moved_m, bool(off_m > 0.0))
