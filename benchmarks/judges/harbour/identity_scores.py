"""Scores of whole tracks: HOTA, ID and CLEAR scores, GOSPA."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from benchmarks.contract.judging import Score
from benchmarks.judges.harbour.answers import Objects
from benchmarks.judges.harbour.matching import Answered
from benchmarks.judges.identities import Pairing, clear_counts, hota, identity_counts, numbered, pairing


def gospa(distance: NDArray[np.float64], cutoff: float, order: float = 1.0) -> float:
    """Return GOSPA with alpha = 2 (Rahmathullah, Garcia-Fernandez and Svensson 2017), in the unit of the distances.

    ``(sum over pairs of d^p + c^p / 2 (missed + false))^(1/p)``, the least over all one-to-one pairings of targets and
    tracks nearer than c. Tests hold it to recorded results of Stone Soup, which is not installed.

    Args:
        distance: (n, m) from each target to each track.
        cutoff: c > 0. order: p >= 1.
    """
    worth = np.maximum(cutoff**order - distance**order, 0.0)
    rows, columns = linear_sum_assignment(-worth)
    alone = 0.5 * cutoff**order * sum(distance.shape)
    return float(max(alone - worth[rows, columns].sum(), 0.0) ** (1.0 / order))


ZERO_M = 6.0
"""Distance over the ground at which the similarity is 0; 3 m is the 0.5 from which on a track is on its target."""
GOSPA_CUTOFF_M = 3.0


def identity_scores(objects: Sequence[Objects], frames: Sequence[Answered]) -> Iterator[Score]:
    """Yield the scores of whole tracks, over the frames on which intruders are judged; what is neither right nor wrong
    is left out.

    ``hota``, ``mota`` and the frames of ``idf1``: ``identity_right_frames``, ``identity_false_frames``,
    ``identity_missed_frames``, see ``benchmarks.judges.identities``; similarity 0 at 6 m over the ground.
    ``identity_switches``: CLEAR's, of an episode. ``gospa_m``: mean over frames of ``gospa`` of
    order 1 with a cut-off of 3 m over the ground.
    """
    pairs = [_paired(there, each) for there, each in zip(objects, frames, strict=True)]
    gospa_m = [gospa(ZERO_M * (1.0 - each.similarity), GOSPA_CUTOFF_M) for each in pairs]
    named = numbered(pairs)
    identities, clear = identity_counts(named), clear_counts(named)
    yield Score("hota", hota(named))
    yield Score("mota", clear.mota, float(max(clear.found + clear.missed, 1)))
    yield Score("identity_switches", float(clear.switches))
    yield Score("identity_right_frames", float(identities.right))
    yield Score("identity_false_frames", float(identities.false))
    yield Score("identity_missed_frames", float(identities.missed))
    yield Score("gospa_m", sum(gospa_m) / len(gospa_m), float(len(gospa_m)))


def _paired(objects: Objects, answered: Answered) -> Pairing:
    """Return a frame's judged intruders and tracks; one without a place is far from everything."""
    counted = ~answered.matches.excused
    place_m = np.nan_to_num(answered.answers.place_m[counted, :2], nan=np.inf)
    targets_m = np.where(objects.judged[:, None], objects.place_m[:, :2], np.nan)
    return pairing(targets_m, answered.answers.identity[counted], place_m, ZERO_M)
