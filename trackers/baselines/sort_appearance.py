"""SORT with looks, on the detections of ``fish_chain``: as Wojke et al., Simple online and realtime tracking with a
deep association metric, ICIP 2017, but with measured features of a fish in place of the network's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from trackers.baselines.sort import Sort, SortParameters, Target, matched_by_overlap
from trackers.fish_chain.detection import Detection
from trackers.fish_chain.tracklets import look_of, turned
from trackers.registry import register, tunable
from trackers.types import Observation

_PRIOR_LOOKS = 50
"""Looks for which the spread of all fish counts in that of one fish."""
_LEAST_SPREAD = 1e-3
_FORBIDDEN = 1e5


@dataclass(frozen=True)
class SortAppearanceParameters(SortParameters):
    """Parameters of ``sort_appearance``; the first three as in ``SortParameters``.

    Attributes:
        gate: greatest squared Mahalanobis distance of a detection to where a target is expected; published 5.99, the
            95 % quantile for places in two dimensions.
        most_unlike: greatest unlikeness of a detection and a target, which is 1 on average for the same fish.
        motion_share: of the distance in the cost of an assignment, the other part is the unlikeness; published 0.
        memory: weight of the look before in that of a target, on each detection; 0.9 in later work.
        settled: detections from which on a target's look counts; published 3.
    """

    max_age: int = tunable(40, 1, 200)
    gate: float = tunable(280.0, 1.0, 2000.0, log=True)
    most_unlike: float = tunable(3.4, 1.2, 20.0, log=True)
    motion_share: float = tunable(0.2, 0.0, 1.0)
    memory: float = tunable(0.95, 0.5, 0.99)
    settled: int = 3


class Spread:
    """The variance (D,) of one fish's look about its target's, as it is learnt; at first that of all fish."""

    def __init__(self) -> None:
        self._all = np.zeros((0, 0))
        self._same: NDArray[np.float64] | float = 0.0
        self._count = 0

    def see(self, looks: NDArray[np.float64]) -> None:
        """Take in the looks (M, D) of a frame with several fish; the first such gives the spread of all."""
        if len(self._all) < 2:
            self._all = looks

    def learn(self, difference: NDArray[np.float64]) -> None:
        """Take in the difference (D,) of a look to that of its target."""
        self._same = self._same + difference**2
        self._count += 1

    def variance(self) -> NDArray[np.float64]:
        """Return the variance (D,)."""
        of_all = self._all.var(axis=0) if len(self._all) > 1 else 0.0
        found = (_PRIOR_LOOKS * of_all + self._same) / (_PRIOR_LOOKS + self._count)
        return np.asarray(found + _LEAST_SPREAD**2)


class LookingTarget(Target):
    """A fish that is followed by its looks too.

    Attributes:
        look: (D,) running mean, None before it was seen alone and whole. hits: detections so far.
    """

    def __init__(self, identity: int, detection: Detection, memory: float, spread: Spread) -> None:
        super().__init__(identity, detection)
        self.look: NDArray[np.float64] | None = None
        self.hits = 0
        self._memory, self._spread = memory, spread
        self._see(detection)

    def correct(self, detection: Detection) -> None:
        """See ``Target``."""
        super().correct(detection)
        self._see(detection)

    def _see(self, detection: Detection) -> None:
        self.hits += 1
        ways = _both_ways(detection)
        if ways is None:
            return
        if self.look is None:
            self.look = ways[0]
            return
        differences = ways - self.look
        nearest = differences[(differences**2 / self._spread.variance()).mean(axis=1).argmin()]
        self._spread.learn(nearest)
        self.look = self.look + max(1.0 - self._memory, 1.0 / self.hits) * nearest


@register(
    "sort_appearance",
    role="baseline",
    summary="SORT that also compares shade, shape, size and colour, as DeepSORT without a network",
    suites=("fish", "many"),
)
class SortAppearance(Sort):
    """Detections go to targets by place and look, those of most recent targets first; what is left by overlap.

    A look is what ``shoal_chain`` has too: brightness and width along the body, length, area and colour. It is
    compared in units of its spread, feature by feature, which is learnt from the targets. Which end the head is does
    not matter. Blobs of several fish, or half hidden ones, have no look: they go by overlap alone.

    Fish dart, and the filter's published noise is that of people on foot: the defaults were chosen by HOTA on
    development seeds 0 and 1 of ``standard``, about 90 settings tried.
    """

    Parameters = SortAppearanceParameters
    _parameters: SortAppearanceParameters

    def _begin(self, background: Sequence[Observation]) -> None:
        super()._begin(background)
        self._spread = Spread()

    def _begun(self, identity: int, detection: Detection) -> Target:
        return LookingTarget(identity, detection, self._parameters.memory, self._spread)

    def _matched(self, expected_xyxy: NDArray[np.float64], detections: Sequence[Detection]) -> list[tuple[int, int]]:
        pairs = self._matched_by_look(detections)
        rows, columns = {row for row, _ in pairs}, {column for _, column in pairs}
        recent = [k for k, each in enumerate(self._targets) if k not in rows and each.frames_since == 1]
        left = [k for k in range(len(detections)) if k not in columns]
        rest = [detections[k] for k in left]
        nearest = matched_by_overlap(expected_xyxy[recent], rest, self._parameters.least_overlap)
        return pairs + [(recent[row], left[column]) for row, column in nearest]

    def _matched_by_look(self, detections: Sequence[Detection]) -> list[tuple[int, int]]:
        """Return the pairs of the matching cascade: targets of the fewest frames without a detection choose first."""
        p = self._parameters
        targets = {
            k: each
            for k, each in enumerate(self._targets)
            if isinstance(each, LookingTarget) and each.look is not None and each.hits >= p.settled
        }
        seen = {k: ways for k, each in enumerate(detections) if (ways := _both_ways(each)) is not None}
        if len(seen) > 1:
            self._spread.see(np.array([ways[0] for ways in seen.values()]))
        if not targets or not seen:
            return []
        places = np.array([detections[k].box_xyxy for k in seen]).reshape(-1, 2, 2).mean(axis=1)
        away = np.array([each.filter.distances(places) for each in targets.values()])
        known = np.array([each.look for each in targets.values()])
        differences = np.array(list(seen.values()))[None] - known[:, None, None]
        unlike = (differences**2 / self._spread.variance()).mean(axis=3).min(axis=2)
        cost = p.motion_share * away / p.gate + (1.0 - p.motion_share) * unlike / p.most_unlike
        cost[(away > p.gate) | (unlike > p.most_unlike)] = _FORBIDDEN
        rows, columns, ages = list(targets), list(seen), np.array([each.frames_since for each in targets.values()])
        free = np.ones(len(columns), dtype=bool)
        pairs = []
        for age in np.unique(ages):
            some, open_columns = np.flatnonzero(ages == age), np.flatnonzero(free)
            for row, column in zip(*linear_sum_assignment(cost[np.ix_(some, open_columns)]), strict=True):
                chosen = some[row], open_columns[column]
                if cost[chosen] < _FORBIDDEN:
                    free[chosen[1]] = False
                    pairs.append((rows[chosen[0]], columns[chosen[1]]))
        return pairs


def _both_ways(detection: Detection) -> NDArray[np.float64] | None:
    """Return the look of a fish and that with head and tail exchanged (2, D); None if it is not whole or not alone."""
    if detection.merged or detection.covered:
        return None
    look = look_of(detection, detection.widths_px, detection.shades)[None]
    return np.concatenate([look, turned(look, len(detection.widths_px))])
