"""HOTA, ID and CLEAR scores of the tracks of many targets, as TrackEval 1.3.0 computes them for one sequence.

The similarity of a target and a track is ``max(0, 1 - d / zero_at)`` for their distance d, TrackEval's Euclidean one.
Tests hold the results to recorded ones of TrackEval, which is not installed: it needs another OpenCV.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import inf
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from benchmarks.contract.judging import Score
from benchmarks.contract.metric import Mean, Metric, Quantity
from benchmarks.statistics.pooling import f_of

THRESHOLD = 0.5
"""Similarity from which on a track is on a target, for ID and CLEAR scores."""
_LEVELS = np.arange(0.05, 0.99, 0.05)
_EPSILON = float(np.finfo(float).eps)


class Pairing(NamedTuple):
    """Targets and tracks of one frame.

    Attributes:
        targets: (n,) indices of the targets that are there. tracks: (m,) indices of the tracks, each once.
        similarity: (n, m) in [0, 1].
    """

    targets: NDArray[np.int64]
    tracks: NDArray[np.int64]
    similarity: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class IdentityCounts:
    """Frames of targets under the best one-to-one map of targets to tracks (Ristani et al. 2016).

    Attributes:
        right: on their track. missed: not. false: frames of tracks that are not on their target.
    """

    right: int
    missed: int
    false: int

    @property
    def idf1(self) -> float:
        """Return 2 right / (2 right + missed + false) in [0, 1]."""
        return self.right / max(1.0, self.right + 0.5 * self.false + 0.5 * self.missed)


@dataclass(frozen=True, slots=True)
class ClearCounts:
    """CLEAR's counts (Bernardin and Stiefelhagen 2008).

    Attributes:
        found, missed: frames of targets with and without a track. false: frames of tracks on no target.
        switches: times that a target's track is another one than the last time it had one.
    """

    found: int
    missed: int
    false: int
    switches: int

    @property
    def mota(self) -> float:
        """Return 1 - (missed + false + switches) / (found + missed), at most 1; 0 without targets."""
        targets = self.found + self.missed
        return (self.found - self.false - self.switches) / targets if targets else 0.0


def pairing(
    targets: NDArray[np.float64], identities: NDArray[np.int64], tracks: NDArray[np.float64], zero_at: float
) -> Pairing:
    """Return the pairing of a frame; targets (N, 2) with NaN are not there, tracks are (M,) and (M, 2).

    Places and ``zero_at``, the distance at which the similarity is 0, have one unit: pixels, or metres.
    """
    there = np.flatnonzero(np.isfinite(targets).all(axis=1))
    away = np.linalg.norm(targets[there][:, None] - tracks[None], axis=2)
    return Pairing(there, identities, np.maximum(0.0, 1.0 - away / zero_at))


def numbered(frames: Sequence[Pairing]) -> list[Pairing]:
    """Return the frames with targets and tracks numbered from 0 without a pause, in their order."""
    targets = np.unique(np.concatenate([frame.targets for frame in frames]))
    tracks = np.unique(np.concatenate([frame.tracks for frame in frames]))
    return [
        Pairing(np.searchsorted(targets, each.targets), np.searchsorted(tracks, each.tracks), each.similarity)
        for each in frames
    ]


def hota(frames: Sequence[Pairing]) -> float:
    """Return the mean over the levels a of ``sqrt(DetA_a AssA_a)`` (Luiten et al. 2021) of ``numbered`` frames."""
    shape = _shape(frames)
    potential = np.zeros(shape)
    of_target, of_track = np.zeros((shape[0], 1)), np.zeros((1, shape[1]))
    for frame in frames:
        similarity = frame.similarity
        union = similarity.sum(0)[None, :] + similarity.sum(1)[:, None] - similarity
        overlap = np.divide(similarity, union, out=np.zeros_like(similarity), where=union > _EPSILON)
        potential[frame.targets[:, None], frame.tracks[None, :]] += overlap
        of_target[frame.targets] += 1
        of_track[0, frame.tracks] += 1
    alignment = potential / (of_target + of_track - potential)
    matches = np.zeros((len(_LEVELS), *shape))
    for frame in frames:
        score = alignment[frame.targets[:, None], frame.tracks[None, :]] * frame.similarity
        rows, columns = linear_sum_assignment(-score)
        high = frame.similarity[rows, columns] >= _LEVELS[:, None] - _EPSILON
        levels, pairs = np.nonzero(high)
        matches[levels, frame.targets[rows[pairs]], frame.tracks[columns[pairs]]] += 1
    found = matches.sum(axis=(1, 2))
    detection = found / np.maximum(1.0, of_target.sum() + of_track.sum() - found)
    association = matches / np.maximum(1.0, of_target + of_track - matches)
    mean = (matches * association).sum(axis=(1, 2)) / np.maximum(1.0, found)
    return float(np.sqrt(detection * mean).mean())


def identity_counts(frames: Sequence[Pairing]) -> IdentityCounts:
    """Return the counts of ``numbered`` frames."""
    together = np.zeros(_shape(frames))
    for frame in frames:
        rows, columns = np.nonzero(frame.similarity >= THRESHOLD)
        together[frame.targets[rows], frame.tracks[columns]] += 1
    # A target or a track without a partner has no frame in common with one: the most right frames are the fewest wrong.
    right = int(together[linear_sum_assignment(together, maximize=True)].sum())
    targets, tracks = _frames(frames)
    return IdentityCounts(right, targets - right, tracks - right)


def clear_counts(frames: Sequence[Pairing]) -> ClearCounts:
    """Return the counts of ``numbered`` frames; a target keeps its track of the frame before where it can."""
    latest = np.full(_shape(frames)[0], -1)
    before = latest.copy()
    found = switches = 0
    for frame in frames:
        if len(frame.targets) == 0 or len(frame.tracks) == 0:
            continue
        kept = frame.tracks[None, :] == before[frame.targets][:, None]
        score = np.where(frame.similarity < THRESHOLD - _EPSILON, 0.0, 1000.0 * kept + frame.similarity)
        rows, columns = linear_sum_assignment(-score)
        on = score[rows, columns] > _EPSILON
        targets, tracks = frame.targets[rows[on]], frame.tracks[columns[on]]
        switches += int(((latest[targets] >= 0) & (latest[targets] != tracks)).sum())
        latest[targets] = tracks
        before[:] = -1
        before[targets] = tracks
        found += len(targets)
    all_targets, all_tracks = _frames(frames)
    return ClearCounts(found, all_targets - found, all_tracks - found, switches)


def track_scores(frames: Sequence[Pairing], clear: ClearCounts, ending: str = "") -> Iterator[Score]:
    """Yield the scores of whole tracks of ``numbered`` frames and their CLEAR counts; ``ending`` is added to the names.

    ``hota``, ``mota``, ``identity_switches`` of CLEAR in an episode, and the frames of ``idf1``:
    ``identity_right_frames``, ``identity_false_frames``, ``identity_missed_frames``.
    """
    identities = identity_counts(frames)
    yield Score(f"hota{ending}", hota(frames))
    yield Score(f"identity_right_frames{ending}", float(identities.right))
    yield Score(f"identity_false_frames{ending}", float(identities.false))
    yield Score(f"identity_missed_frames{ending}", float(identities.missed))
    yield Score(f"mota{ending}", clear.mota, float(max(clear.found + clear.missed, 1)))
    yield Score(f"identity_switches{ending}", float(clear.switches))


def _shape(frames: Sequence[Pairing]) -> tuple[int, int]:
    """Return the numbers of targets and of tracks of ``numbered`` frames."""
    targets, tracks = (np.concatenate([frame[side] for frame in frames]).max(initial=-1) for side in range(2))
    return int(targets) + 1, int(tracks) + 1


def _frames(frames: Sequence[Pairing]) -> tuple[int, int]:
    """Return the frames of all targets, and of all tracks."""
    return sum(len(frame.targets) for frame in frames), sum(len(frame.tracks) for frame in frames)


_HOTA = "HOTA: Luiten et al., HOTA: a higher order metric for evaluating multi-object tracking, IJCV 129, 2021"
_IDF1 = "IDF1: Ristani et al., Performance measures and a data set for multi-target, multi-camera tracking, ECCV 2016"
_CLEAR = "CLEAR: Bernardin and Stiefelhagen, Evaluating multiple object tracking performance, EURASIP JIVP 2008"


def identity_metrics(
    similar: str, within: str, conditions: str, defined_by: Any, ending: str = "", when: str = ""
) -> tuple[Metric, ...]:
    """Return the metrics of whole tracks of a suite.

    Args:
        similar, within: where the similarity is 0, and where it is a half, in words.
        conditions: which frames count. defined_by: function that yields the rows.
        ending: of the names of rows and metrics. when: end of each summary.
    """

    def quantity(name: str, low: float, high: float, source: str) -> Quantity:
        return Quantity(f"{name}{ending}", low, high, conditions, source, (defined_by,))

    counts = (quantity(f"identity_{kind}_frames", 0, inf, _IDF1) for kind in ("right", "false", "missed"))
    hota, mota = quantity("hota", 0, 1, _HOTA), quantity("mota", -inf, 1, _CLEAR)
    switches = quantity("identity_switches", 0, inf, _CLEAR)
    return (
        Metric(hota.name, f"HOTA, similarity 0 at {similar}{when}", "fraction", "higher", Mean(hota)),
        Metric(f"idf1{ending}", f"IDF1, within {within}{when}", "fraction", "higher", f_of(*counts)),
        Metric(mota.name, f"MOTA of CLEAR, within {within}{when}", "fraction", "higher", Mean(mota)),
        Metric(switches.name, f"switches of CLEAR in an episode{when}", "1", "lower", Mean(switches)),
    )
