"""Links over the gaps of true fish: is the identity after a gap that of before?

A *gap* of a fish is a stretch of frames on which it does not stand apart (``contact``). Gaps with less than
``APART_FRAMES`` frames between them are one gap; those without as many frames before and after are not judged.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from benchmarks.judges.runs import runs
from trackers.types import Track

APART_FRAMES = 5
"""Fewer frames apart do not part two gaps."""
WINDOW_FRAMES = 10
"""A fish's identity before a gap is the latest one on these frames, that after it the first one."""
_NOBODY = -1


class Outcome(IntEnum):
    """What became of an identity over a gap."""

    RIGHT = 0
    WRONG = 1
    ABSTAINED = 2


@dataclass(frozen=True, slots=True)
class FishGap:
    """A gap of one fish, an event.

    Attributes:
        index: in the episode. fish: index of the object.
        first_frame, length_frames: of the gap.
        fish_count: number of fish in it: this one and all that lay together with it.
        crosses: whether its centre line crossed another's.
    """

    index: int
    fish: int
    first_frame: int
    length_frames: int
    fish_count: int
    crosses: bool

    @property
    def end_frame(self) -> int:
        """The frame after its last one."""
        return self.first_frame + self.length_frames

    def attributes(self) -> dict[str, Any]:
        """See ``benchmarks.contract.judging.Event``; ``up_to_G``: of at most G frames."""
        return {
            "index": self.index,
            "kind": "gap",
            "fish": self.fish,
            "first_frame": self.first_frame,
            "length_frames": self.length_frames,
            "fish_count": self.fish_count,
            "crosses": self.crosses,
            "up_to_50": self.length_frames <= 50,
            "up_to_200": self.length_frames <= 200,
            "crosses_up_to_50": self.crosses and self.length_frames <= 50,
        }


@dataclass(frozen=True, slots=True)
class Link:
    """A tracker's link over a gap.

    Attributes:
        outcome: see ``outcome_of``.
        confidence: the tracker's own in the track after the gap; NaN without one, or without a link.
    """

    gap: FishGap
    outcome: Outcome
    confidence: float


@dataclass(frozen=True, slots=True)
class Bearers:
    """The track on each fish.

    Attributes:
        identity: (T, N) of the track on each fish on each frame; -1 for none. confidence: (T, N) NaN without.
    """

    identity: NDArray[np.int64]
    confidence: NDArray[np.float64]


def find_gaps(
    apart: NDArray[np.bool_], together_with: Sequence[NDArray[np.bool_]], crosses: NDArray[np.bool_]
) -> list[FishGap]:
    """Return the gaps of an episode in order of time.

    Args:
        apart: (T, N) see ``contact.stands_apart``. together_with: (N, N) on each frame. crosses: (T, N).
    """
    found = []
    for fish in range(apart.shape[1]):
        for first, end in runs(~_long_runs(apart[:, fish])):
            if first > 0 and end < len(apart):
                others = np.any([each[fish] for each in together_with[first:end]], axis=0)
                crossed = bool(crosses[first:end, fish].any())
                found.append((first, fish, end - first, 1 + int(others.sum()), crossed))
    return [
        FishGap(index, fish, first, length, count, crossed)
        for index, (first, fish, length, count, crossed) in enumerate(sorted(found))
    ]


def _long_runs(apart: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the frames (T,) of runs of at least ``APART_FRAMES``."""
    long = np.zeros_like(apart)
    for first, end in runs(apart):
        long[first:end] = end - first >= APART_FRAMES
    return long


def bearers(answers: Sequence[Sequence[Track]], position_px: NDArray[np.float64], gate_px: float) -> Bearers:
    """Return which track is on each fish, (T, N, 2): per frame the assignment of least distance within ``gate_px``."""
    identity = np.full(position_px.shape[:2], _NOBODY)
    confidence = np.full(position_px.shape[:2], np.nan)
    for frame, tracks in enumerate(answers):
        answered = [track for track in tracks if np.isfinite(track.estimate.position_px).all()]
        places = np.array([track.estimate.position_px for track in answered]).reshape(-1, 2)
        away_px = np.linalg.norm(position_px[frame][:, None] - places[None], axis=2)
        away_px = np.where(away_px < gate_px, away_px, gate_px)
        for fish, column in zip(*linear_sum_assignment(away_px), strict=True):
            if away_px[fish, column] < gate_px:
                identity[frame, fish] = answered[column].identity
                if (sure := answered[column].confidence) is not None:
                    confidence[frame, fish] = sure
    return Bearers(identity, confidence)


def judge_links(gaps: Sequence[FishGap], apart: NDArray[np.bool_], borne: Bearers) -> list[Link]:
    """Return the link over each gap.

    A link is right if the fish's identity after the gap is that of before, or another that this fish bore last. It is
    wrong if another fish bore it last, be it during the gap, or if the identity of before is on another fish after the
    gap. Without an identity before or after, or with one that is new, there is no link.
    """
    history = _history(borne.identity, apart)
    return [_judged(gap, apart, borne, history) for gap in gaps]


_History = dict[int, tuple[list[int], list[int]]]
"""Identity → the frames on which a fish that stands apart bears it, in order, and the fish."""


def _history(identity: NDArray[np.int64], apart: NDArray[np.bool_]) -> _History:
    history: _History = defaultdict(lambda: ([], []))
    for frame, fish in np.argwhere((identity != _NOBODY) & apart):
        frames, bearing = history[int(identity[frame, fish])]
        frames.append(int(frame))
        bearing.append(int(fish))
    return history


def _judged(gap: FishGap, apart: NDArray[np.bool_], borne: Bearers, history: _History) -> Link:
    own, stands = borne.identity[:, gap.fish], apart[:, gap.fish]
    start = max(gap.first_frame - WINDOW_FRAMES, 0)
    before = [k for k in range(start, gap.first_frame) if stands[k] and own[k] != _NOBODY]
    end = min(gap.end_frame + WINDOW_FRAMES, len(own))
    after = [k for k in range(gap.end_frame, end) if stands[k] and own[k] != _NOBODY]
    outcome = Outcome.ABSTAINED
    if before and after:
        outcome = _outcome(gap, int(own[before[-1]]), int(own[after[0]]), after[0], history)
    elif before and _fish_of(int(own[before[-1]]), history, gap.end_frame, end) not in (None, gap.fish):
        outcome = Outcome.WRONG
    confidence = float(borne.confidence[after[0], gap.fish]) if outcome != Outcome.ABSTAINED and after else np.nan
    return Link(gap, outcome, confidence)


def _outcome(gap: FishGap, before: int, after: int, frame: int, history: _History) -> Outcome:
    if before == after:
        return Outcome.RIGHT
    owner = _owner(after, history, gap, frame)
    if owner is not None:
        return Outcome.RIGHT if owner == gap.fish else Outcome.WRONG
    taken = _fish_of(before, history, gap.end_frame, frame + WINDOW_FRAMES)
    return Outcome.ABSTAINED if taken in (None, gap.fish) else Outcome.WRONG


def _owner(identity: int, history: _History, gap: FishGap, frame: int) -> int | None:
    """Return the fish that bore an identity last before ``frame``, the gap's own only before its gap; None if none."""
    borne = zip(*history.get(identity, ([], [])), strict=True)
    found = (fish for k, fish in reversed(list(borne)) if k < (gap.first_frame if fish == gap.fish else frame))
    return next(found, None)


def _fish_of(identity: int, history: _History, first: int, end: int) -> int | None:
    """Return the fish that bore an identity last on frames [first, end); None if none did."""
    frames, fish = history.get(identity, ([], []))
    place = int(np.searchsorted(frames, end)) - 1
    return fish[place] if place >= 0 and frames[place] >= first else None
