"""Tracks on the quay and the water with probabilities of existence, and their association with detections.

J. Williams, R. Lau, "Approximate evaluation of marginal association probabilities with belief propagation", IEEE
Trans. Aerospace and Electronic Systems 50(4), 2014; existence: D. Musicki, R. Evans, "Joint integrated probabilistic
data association: JIPDA", same journal 40(3), 2004.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from trackers.harbour_watch.mark import Mark, begun
from trackers.harbour_watch.sightings import Sighting
from trackers.site import SiteView

Array = NDArray[np.float64]

_ROUNDS = 200
_CONVERGED = 1e-7


def marginals(missed: Array, paired: Array, alone: Array) -> tuple[Array, Array]:
    """Return (tracks, detections) probabilities of each pair, and of each detection to belong to none (detections,).

    Each joint event pairs tracks and detections one to one, at most; its weight is the product of ``paired`` over its
    pairs, ``missed`` over the other tracks and ``alone`` over the other detections. Loopy belief propagation: exact for
    one track or one detection, and close to it else.

    Args:
        missed: (N,) > 0. paired: (N, M) >= 0. alone: (M,) > 0.
    """
    psi = paired / missed[:, None] / alone
    nu = np.ones_like(psi)
    for _ in range(_ROUNDS):
        product = psi * nu
        mu = psi / (1.0 + product.sum(axis=1, keepdims=True) - product)
        before, nu = nu, 1.0 / (1.0 + mu.sum(axis=0, keepdims=True) - mu)
        if np.abs(nu - before).max(initial=0.0) < _CONVERGED:
            break
    product = psi * nu
    pairs = product / (1.0 + product.sum(axis=1, keepdims=True))
    mu = psi / (1.0 + product.sum(axis=1, keepdims=True) - product)
    return pairs, 1.0 / (1.0 + mu.sum(axis=0))


def existence(prior: Array, detected: Array, pairs: Array) -> Array:
    """Return the probabilities (N,) that tracks exist after a picture.

    ``r = sum_j p_j + p_0 r (1 - P_D) / (1 - r P_D)``.

    Args:
        prior: (N,) probabilities before. detected: (N,) probabilities P_D of a detection of an existing object.
        pairs: (N, M) of ``marginals`` with ``missed = 1 - prior * detected``.
    """
    paired = pairs.sum(axis=1)
    hidden = prior * (1.0 - detected) / (1.0 - prior * detected)
    posterior: Array = paired + np.maximum(1.0 - paired, 0.0) * hidden
    return posterior


_GATE = 4.5
"""Deviations beyond which a region is not of a track."""
_MOST_LOG_ODDS = 12.0
_FIRST = 3
"""Pictures on which what begins was there before the watch."""
_ALONE, _LEAST_BIRTH = 0.5, 1e-3
"""Least probabilities that a region is of no known track, and of existence, to begin a track with it."""
_LEAST_LOG_DENSITY = -8.0
"""Log density per pixel from which a region is what a track expects, if doubtful: no other begins there."""
_SURELY, _KNOWN_PX = 4.0, 1.5
"""Log odds of existence, and standard deviation of the place in the picture, of an object whose outline is known."""
_LEAST_PAIR = 0.1
_STANDS = 2
"""Pictures in a row on which something has not moved, from which it stands."""
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
        marks: in order of their beginning.
    """

    def __init__(self, view: SiteView, rates: Rates) -> None:
        """Begin with none."""
        self.marks: list[Mark] = []
        self._identities = self._pictures = 0
        self._view, self._rates = view, rates

    def predicted(self, dt_s: float, level_m: float) -> list[Array]:
        """Predict by ``dt_s`` and return the boxes (4,) of objects that surely are there, and whose place is known."""
        for mark in self.marks:
            mark.predict(dt_s, self._rates.survives)
            mark.expect(level_m if mark.afloat else 0.0)
        self.marks = [mark for mark in self.marks if np.isfinite(mark.expected_px).all()]
        for mark in self.marks:
            mark.note_way()
        return [mark.expected_px for mark in self.marks if mark.log_odds > _SURELY and mark.middle_px() < _KNOWN_PX]

    def update(self, sightings: Sequence[Sighting], log_ratios: Array, log_caps: Array, level_m: float) -> None:
        """Associate, update, begin and end tracks, once ``predicted``.

        Args:
            log_ratios: (M,) log of the scores' density for objects over the density of false regions per pixel.
            log_caps: (M,) most that one region may add to the log odds of a track.
        """
        self._pictures += 1
        log_ratios = np.minimum(log_ratios, _MOST_LOG)
        prior = np.array([mark.probability for mark in self.marks], dtype=float)
        detected = np.array([mark.found_share for mark in self.marks], dtype=float)
        births = self._rates.births * np.array([each.m2_per_px for each in sightings]) * np.exp(log_ratios)
        log_densities = self._log_densities(sightings)
        paired = (prior * detected)[:, None] * np.exp(np.minimum(log_densities + log_ratios, log_caps))
        pairs, alone = marginals(1.0 - prior * detected, paired, 1.0 + births)
        posterior = existence(prior, detected, pairs)
        chosen = _one_to_one(pairs)
        expected = log_densities.max(axis=0, initial=-np.inf) > _LEAST_LOG_DENSITY
        for i, (mark, probability) in enumerate(zip(self.marks, posterior, strict=True)):
            p = min(max(float(probability), 1e-9), 1.0 - 1e-9)
            mark.log_odds = min(max(float(np.log(p / (1.0 - p))), -_MOST_LOG_ODDS), _MOST_LOG_ODDS)
            mark.correct(sightings[chosen[i]] if i in chosen else None, float(pairs[i].sum()))
        self.marks = [mark for mark in self.marks if mark.log_odds > self._rates.removed]
        for j, sighting in enumerate(sightings):
            p = float(alone[j] * births[j] / (1.0 + births[j]))
            if not expected[j] and alone[j] > _ALONE and p > _LEAST_BIRTH:
                base_m = level_m if sighting.afloat else 0.0
                mark = begun(self._identities, sighting, p, self._view, base_m)
                mark.from_start = self._pictures <= _FIRST
                self.marks.append(mark)
                self._identities += 1

    def standing(self) -> list[Mark]:
        """Return the tracks of what stands still on the quay."""
        return [mark for mark in self.marks if not mark.afloat and mark.still_frames >= _STANDS]

    def drop(self, mark: Mark) -> None:
        """End a track."""
        self.marks = [each for each in self.marks if each is not mark]

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


def _one_to_one(pairs: Array) -> dict[int, int]:
    """Return the likeliest detection of each track, each given once.

    Averages over detections would draw the tracks of two cars side by side to the middle between them (H. Blom,
    E. Bloem, IEEE Trans. Automatic Control 45(2), 2000).
    """
    rows, columns = linear_sum_assignment(-np.log(np.maximum(pairs, 1e-12)))
    return {int(i): int(j) for i, j in zip(rows, columns, strict=True) if pairs[i, j] > _LEAST_PAIR}
