"""Tracks on the quay and the water with probabilities of existence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.harbour_watch.association import existence, marginals
from trackers.harbour_watch.mark import Mark, begun
from trackers.harbour_watch.sightings import Sighting
from trackers.site.view import SiteView

Array = NDArray[np.float64]

_GATE = 4.5
"""Deviations beyond which a region is not of a track."""
_MOST_LOG_ODDS = 12.0
_ALONE, _LEAST_BIRTH = 0.5, 1e-3
"""Least probabilities that a region is of no known track, and of existence, to begin a track with it."""
_LEAST_PAIR = 1e-3
_MOST_LOG = 60.0


@dataclass(frozen=True)
class Rates:
    """Parameters of the filter.

    Attributes:
        births: new objects a square metre and picture: one in some minutes on a quay.
        survives: probability to stay from picture to picture. removed: log odds of existence below which a track ends.
    """

    births: float = 4e-6
    survives: float = 0.995
    removed: float = -7.0


class Tracks:
    """All tracks.

    Attributes:
        marks: in order of their beginning. next_identity: of the next one.
    """

    def __init__(self, view: SiteView, rates: Rates, next_identity: int = 0) -> None:
        """Begin with none."""
        self.marks: list[Mark] = []
        self.next_identity = next_identity
        self._view, self._rates = view, rates

    def update(self, sightings: Sequence[Sighting], log_ratios: Array, dt_s: float, level_m: float) -> None:
        """Predict by ``dt_s``, associate, update, begin and end tracks.

        Args:
            log_ratios: (M,) log of the scores' density for objects over the density of false regions per pixel.
        """
        for mark in self.marks:
            mark.predict(dt_s, self._rates.survives)
            mark.expect(self._view, level_m)
        self.marks = [mark for mark in self.marks if np.isfinite(mark.expected_px).all()]
        log_ratios = np.minimum(log_ratios, _MOST_LOG)
        prior = np.array([mark.probability for mark in self.marks], dtype=float)
        detected = np.array([mark.found_share for mark in self.marks], dtype=float)
        births = self._rates.births * np.array([each.m2_per_px for each in sightings]) * np.exp(log_ratios)
        paired = (prior * detected)[:, None] * np.exp(self._log_densities(sightings) + log_ratios)
        pairs, alone = marginals(1.0 - prior * detected, paired, 1.0 + births)
        posterior = existence(prior, detected, pairs)
        for mark, probability, row in zip(self.marks, posterior, pairs, strict=True):
            p = min(max(float(probability), 1e-9), 1.0 - 1e-9)
            mark.log_odds = min(max(float(np.log(p / (1.0 - p))), -_MOST_LOG_ODDS), _MOST_LOG_ODDS)
            hits = [(float(p), each) for p, each in zip(row, sightings, strict=True) if p > _LEAST_PAIR]
            mark.correct(hits)
        self.marks = [mark for mark in self.marks if mark.log_odds > self._rates.removed]
        for j, sighting in enumerate(sightings):
            p = float(alone[j] * births[j] / (1.0 + births[j]))
            if alone[j] > _ALONE and p > _LEAST_BIRTH:
                self.marks.append(begun(self.next_identity, sighting, p, self._view))
                self.next_identity += 1

    def _log_densities(self, sightings: Sequence[Sighting]) -> Array:
        """Return the log density per pixel of each sighting's middle for each track, (N, M); -inf beyond the gate."""
        found = np.full((len(self.marks), len(sightings)), -np.inf)
        if not len(sightings):
            return found
        boxes = np.array([each.region.box_xyxy for each in sightings])
        middles = 0.5 * (boxes[:, :2] + boxes[:, 2:])
        afloat = np.array([each.afloat for each in sightings])
        for i, mark in enumerate(self.marks):
            expected, spread = mark.expected_middle()
            off = middles - expected
            square = np.einsum("mi,im->m", off, np.linalg.solve(spread, off.T))
            near = (square < _GATE**2) & (afloat == mark.afloat)
            found[i, near] = -0.5 * square[near] - np.log(2 * np.pi) - 0.5 * np.log(np.linalg.det(spread))
        return found
