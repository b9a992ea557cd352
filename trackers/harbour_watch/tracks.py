"""Tracks on the quay and the water with probabilities of existence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from trackers.harbour_watch.association import existence, marginals
from trackers.harbour_watch.classes import KINDS, Kind
from trackers.harbour_watch.sightings import Sighting
from trackers.harbour_watch.sizes import Size
from trackers.site.view import SiteView

Array = NDArray[np.float64]

_SEES = np.hstack([np.eye(2), np.zeros((2, 2))])
_GATE = 4.5
"""Deviations beyond which a region is not of a track."""
_MOST_LOG_ODDS = 12.0
_ALONE, _LEAST_BIRTH = 0.5, 0.01
"""Least probabilities that a region is of no known track, and of existence, to begin a track with it."""
_KIND_FORGETS = 0.95
_SURELY_MOVES = 2.0
"""Deviations of the velocity from zero from which it gives the heading."""
_UNKNOWN_HEADING_DOUBT = 4.0
_DETECTED = (9.0, 1.0)
"""Beta prior of the share of pictures on which an object is found."""


@dataclass(eq=False)
class Mark:
    """One track.

    Attributes:
        identity: its number. state: (4,) x, y, velocity of its middle on its plane, metres.
        covariance: (4, 4). log_odds: of its existence. log_kinds: (3,) log likelihoods of ``KINDS``.
        size: estimate of its size. heading_rad: direction of travel; None if it is not known.
        found, missed: weights of pictures with and without a region of it.
        seen_px: (4,) last region. evidence: sum of log likelihood ratios.
    """

    identity: int
    state: Array
    covariance: Array
    log_odds: float
    log_kinds: Array
    size: Size
    heading_rad: float | None = None
    found: float = _DETECTED[0]
    missed: float = _DETECTED[1]
    seen_px: Array = field(default_factory=lambda: np.zeros(4))
    age: int = 0
    hits: float = 0.0

    @property
    def kind(self) -> Kind:
        """The most likely class."""
        return KINDS[int(self.log_kinds.argmax())]

    @property
    def probability(self) -> float:
        """Of existence."""
        return float(1.0 / (1.0 + np.exp(-self.log_odds)))


@dataclass(frozen=True)
class Rates:
    """Parameters of the filter.

    Attributes:
        births: new objects a square metre and picture. survives: probability to stay from picture to picture.
        removed: log odds of existence below which a track ends.
    """

    births: float = 4e-6
    survives: float = 0.995
    removed: float = -5.0


class Tracks:
    """All tracks."""

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
            self._predict(mark, dt_s)
        log_pairs = self._log_pairs(sightings, log_ratios)
        prior = np.array([mark.probability for mark in self.marks], dtype=float)
        detected = np.array([mark.found / (mark.found + mark.missed) for mark in self.marks], dtype=float)
        births = np.array([self._rates.births / each.px2_per_m2 for each in sightings]) * np.exp(
            np.minimum(log_ratios, 50.0)
        )
        paired = (prior * detected)[:, None] * np.exp(np.minimum(log_pairs, 50.0))
        pairs, alone = marginals(1.0 - prior * detected, paired, 1.0 + births)
        posterior = existence(prior, detected, pairs)
        for i, mark in enumerate(self.marks):
            self._correct(mark, pairs[i], sightings, level_m)
            p = min(max(float(posterior[i]), 1e-9), 1.0 - 1e-9)
            mark.log_odds = min(max(float(np.log(p / (1.0 - p))), -_MOST_LOG_ODDS), _MOST_LOG_ODDS)
        self.marks = [mark for mark in self.marks if mark.log_odds > self._rates.removed]
        for j, sighting in enumerate(sightings):
            p = float(alone[j] * births[j] / (1.0 + births[j]))
            if alone[j] > _ALONE and p > _LEAST_BIRTH:
                self._begin(sighting, p)

    def _predict(self, mark: Mark, dt_s: float) -> None:
        motion = np.eye(4)
        motion[0, 2] = motion[1, 3] = dt_s
        pushed = np.vstack([0.5 * dt_s**2 * np.eye(2), dt_s * np.eye(2)])
        mark.state = motion @ mark.state
        noise = mark.kind.acceleration_mps2**2
        mark.covariance = motion @ mark.covariance @ motion.T + noise * pushed @ pushed.T
        p = mark.probability * self._rates.survives
        mark.log_odds = float(np.log(p / (1.0 - p)))
        mark.age += 1

    def _near_m(self, mark: Mark) -> Array:
        """Return the displacement (2,) from a track's middle to where its region's lower edge stands."""
        towards = self._view.place_m[:2] - mark.state[:2]
        towards /= max(float(np.linalg.norm(towards)), 1e-9)
        length, width, _ = mark.size.size_m
        if mark.heading_rad is None:
            return towards * 0.25 * (length + width)
        along = abs(float(towards @ [np.cos(mark.heading_rad), np.sin(mark.heading_rad)]))
        return towards * 0.5 * (length * along + width * np.sqrt(max(0.0, 1.0 - along**2)))

    def _log_pairs(self, sightings: Sequence[Sighting], log_ratios: Array) -> Array:
        """Return log of (density of a sighting for a track / density of false regions), (N, M); -inf beyond gates."""
        found = np.full((len(self.marks), len(sightings)), -np.inf)
        for i, mark in enumerate(self.marks):
            near = mark.state[:2] + self._near_m(mark)
            for j, sighting in enumerate(sightings):
                if sighting.afloat != mark.kind.afloat:
                    continue
                spread = _SEES @ mark.covariance @ _SEES.T + sighting.covariance
                off = sighting.near_m - near
                square = float(off @ np.linalg.solve(spread, off))
                if square < _GATE**2:
                    density = -0.5 * square - np.log(2 * np.pi * np.sqrt(np.linalg.det(spread)))
                    # The density of places is per square metre, that of false regions per pixel.
                    found[i, j] = density - np.log(sighting.px2_per_m2) + log_ratios[j]
        return found

    def _correct(self, mark: Mark, pairs: Array, sightings: Sequence[Sighting], level_m: float) -> None:
        """Update a track by its sightings, weighted by their probabilities (probabilistic data association)."""
        hit = float(pairs.sum())
        mark.found, mark.missed = 0.95 * mark.found + hit * 0.5, 0.95 * mark.missed + (1.0 - hit) * 0.5
        if hit < 1e-3:
            return
        near = self._near_m(mark)
        state, covariance, weights = [mark.state], [mark.covariance], [max(0.0, 1.0 - hit)]
        for p, sighting in zip(pairs, sightings, strict=True):
            if p > 1e-3:
                spread = _SEES @ mark.covariance @ _SEES.T + sighting.covariance
                gain = np.linalg.solve(spread, _SEES @ mark.covariance).T
                state.append(mark.state + gain @ (sighting.near_m - near - mark.state[:2]))
                covariance.append(mark.covariance - gain @ _SEES @ mark.covariance)
                weights.append(float(p))
        share = np.array(weights) / sum(weights)
        mean = share @ np.array(state)
        spreads = [p + np.outer(x - mean, x - mean) for x, p in zip(state, covariance, strict=True)]
        mark.covariance = np.tensordot(share, np.array(spreads), axes=1)
        mark.state = mean
        best = int(pairs.argmax())
        if pairs[best] > 0.5:
            self._look(mark, sightings[best], level_m)

    def _look(self, mark: Mark, sighting: Sighting, level_m: float) -> None:
        """Take in the width and height of the region that is most likely of a track."""
        mark.log_kinds = _KIND_FORGETS * mark.log_kinds + sighting.log_kinds
        mark.seen_px = sighting.region.box_xyxy
        mark.hits += 1
        if mark.size.kind is not mark.kind:
            mark.size = Size(mark.kind)
        velocity, spread = mark.state[2:], mark.covariance[2:, 2:]
        if float(velocity @ np.linalg.solve(spread, velocity)) > _SURELY_MOVES**2:
            mark.heading_rad = float(np.arctan2(velocity[1], velocity[0]))
        base = np.array([*mark.state[:2], level_m if mark.kind.afloat else 0.0])
        x0, y0, x1, y1 = mark.seen_px
        known = mark.heading_rad is not None
        mark.size.update(
            np.array([x1 - x0, y1 - y0]),
            self._view,
            base,
            mark.heading_rad if mark.heading_rad is not None else 0.25 * np.pi,
            1.0 if known else _UNKNOWN_HEADING_DOUBT,
        )

    def _begin(self, sighting: Sighting, probability: float) -> None:
        kind = KINDS[int(sighting.log_kinds.argmax())]
        covariance = np.zeros((4, 4))
        covariance[:2, :2] = sighting.covariance
        covariance[2:, 2:] = kind.speed_mps**2 * np.eye(2)
        p = min(max(probability, 1e-9), 1.0 - 1e-9)
        mark = Mark(
            self.next_identity,
            np.array([*sighting.near_m, 0.0, 0.0]),
            covariance,
            min(float(np.log(p / (1.0 - p))), _MOST_LOG_ODDS),
            sighting.log_kinds.copy(),
            Size(kind),
        )
        mark.state[:2] -= self._near_m(mark)
        mark.seen_px = sighting.region.box_xyxy
        mark.hits = 1
        self.next_identity += 1
        self.marks.append(mark)
