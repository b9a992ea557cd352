"""Links over the gaps of fish: is the identity after a gap that of before? And their scores, by kind of gap."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from benchmarks.contract.judging import Score
from benchmarks.judges.fish.gaps import FishGap
from benchmarks.judges.runs import runs
from trackers.types import Track

WINDOW_FRAMES = 10
"""A fish's identity before a gap is the latest one on these frames, that after it the first one."""
SHARE = 0.9
"""Share of all gaps over which links are compared at the same number of links."""
MOST_FISH = 20
"""Fish of an episode whose identities are kept in rows."""
_NONE = -1


class Group(NamedTuple):
    """Gaps that are scored together: in words, and whether one is among them."""

    words: str
    has: Callable[[FishGap], bool]


_SHORT = "those of at most 50 frames"
GROUPS = {
    "50": Group("gaps of at most 50 frames", lambda gap: gap.length_frames <= 50),
    "200": Group("gaps of at most 200 frames", lambda gap: gap.length_frames <= 200),
    "crossing_50": Group(f"{_SHORT} in which fish cross", lambda gap: gap.crosses and gap.length_frames <= 50),
    "touching_50": Group(f"{_SHORT} in which none cross", lambda gap: not gap.crosses and gap.length_frames <= 50),
    "pair_50": Group(f"{_SHORT} with two fish", lambda gap: gap.fish_count <= 2 and gap.length_frames <= 50),
    "crowd_50": Group(f"{_SHORT} with three or more fish", lambda gap: gap.fish_count > 2 and gap.length_frames <= 50),
}
LENGTHS = ("50", "200")
"""Groups by length alone."""


class Outcome(IntEnum):
    """What became of an identity over a gap."""

    RIGHT = 0
    WRONG = 1
    ABSTAINED = 2


@dataclass(frozen=True, slots=True)
class Link:
    """A tracker's link over a gap.

    Attributes:
        outcome: see ``judge_links``.
        confidence: the tracker's own in the track after the gap; NaN without one, or without a link.
    """

    gap: FishGap
    outcome: Outcome
    confidence: float

    @property
    def is_made(self) -> bool:
        """Whether there is a link."""
        return self.outcome != Outcome.ABSTAINED


class Answered(NamedTuple):
    """The M tracks of a frame that say where they are: identity (M,), position_px (M, 2), confidence (M,) or NaN."""

    identity: NDArray[np.int64]
    position_px: NDArray[np.float64]
    confidence: NDArray[np.float64]


def answered(tracks: Sequence[Track]) -> Answered:
    """Return the tracks whose position is not NaN."""
    some = [track for track in tracks if np.isfinite(track.estimate.position_px).all()]
    return Answered(
        np.array([track.identity for track in some], int),
        np.array([track.estimate.position_px for track in some]).reshape(-1, 2),
        np.array([np.nan if track.confidence is None else track.confidence for track in some], float),
    )


@dataclass(frozen=True, slots=True)
class Bearers:
    """The track on each fish.

    Attributes:
        identity: (T, N) of the track on each fish on each frame; -1 for none. confidence: (T, N) NaN without.
    """

    identity: NDArray[np.int64]
    confidence: NDArray[np.float64]


def bearers(answers: Sequence[Answered], position_px: NDArray[np.float64], gate_px: float) -> Bearers:
    """Return which track is on each fish, (T, N, 2): per frame the assignment of least distance within ``gate_px``."""
    identity = np.full(position_px.shape[:2], _NONE)
    confidence = np.full(position_px.shape[:2], np.nan)
    for frame, tracks in enumerate(answers):
        away_px = np.linalg.norm(position_px[frame][:, None] - tracks.position_px[None], axis=2)
        away_px = np.where(away_px < gate_px, away_px, gate_px)
        fish, column = linear_sum_assignment(away_px)
        on = away_px[fish, column] < gate_px
        identity[frame, fish[on]] = tracks.identity[column[on]]
        confidence[frame, fish[on]] = tracks.confidence[column[on]]
    return Bearers(identity, confidence)


class _Borne(NamedTuple):
    """Frames, in order, on which fish that stand apart bear an identity, and the fish."""

    frame: NDArray[np.int64]
    fish: NDArray[np.int64]

    def last(self, chosen: NDArray[np.bool_]) -> int | None:
        """Return the fish on the last of the ``chosen`` frames; None without one."""
        return int(self.fish[chosen][-1]) if chosen.any() else None


def judge_links(gaps: Sequence[FishGap], apart: NDArray[np.bool_], borne: Bearers) -> list[Link]:
    """Return the link over each gap.

    A link is right if the fish's identity after the gap is that of before, or another that this fish bore last. It is
    wrong if another fish bore it last, be it during the gap, or if the identity of before is on another fish after the
    gap. Without an identity before or after, or with one that is new, there is no link.
    """
    known = np.where(apart, borne.identity, _NONE)
    frame, fish = np.nonzero(known != _NONE)
    names = known[frame, fish]
    order = np.argsort(names, kind="stable")
    identities, first = np.unique(names[order], return_index=True)
    parts = [np.split(each[order], first[1:]) for each in (frame, fish)]
    history = dict(zip(identities.tolist(), map(_Borne, *parts), strict=False))
    links = []
    for gap in gaps:
        own, end = known[:, gap.fish], gap.end_frame
        start = max(gap.first_frame - WINDOW_FRAMES, 0)
        before = own[start : gap.first_frame][own[start : gap.first_frame] != _NONE]
        after = end + np.flatnonzero(own[end : end + WINDOW_FRAMES] != _NONE)
        outcome = Outcome.ABSTAINED
        if len(before):
            outcome = _outcome(gap, int(before[-1]), int(own[after[0]]) if len(after) else None, after, history)
        sure = outcome != Outcome.ABSTAINED and len(after) > 0
        links.append(Link(gap, outcome, float(borne.confidence[after[0], gap.fish]) if sure else np.nan))
    return links


def _outcome(
    gap: FishGap, before: int, after: int | None, frames: NDArray[np.int64], history: dict[int, _Borne]
) -> Outcome:
    """Return the outcome for the identities before and after a gap; ``frames``: after it, with an identity."""
    if before == after:
        return Outcome.RIGHT
    frame = int(frames[0]) if after is not None else gap.end_frame
    if after is not None:
        bore = history[after]
        # The gap's own fish counts only before its gap.
        owner = bore.last(bore.frame < np.where(bore.fish == gap.fish, gap.first_frame, frame))
        if owner is not None:
            return Outcome.RIGHT if owner == gap.fish else Outcome.WRONG
    bore = history[before]
    taken = bore.last((bore.frame >= gap.end_frame) & (bore.frame < frame + WINDOW_FRAMES))
    return Outcome.ABSTAINED if taken in (None, gap.fish) else Outcome.WRONG


def link_scores(links: Sequence[Link], ending: str = "", groups: Sequence[str] = tuple(GROUPS)) -> Iterator[Score]:
    """Yield the scores of the ``groups`` of gaps, see ``GROUPS``; ``ending`` is added to the names.

    ``link_precision_GROUP``: right links of those made. ``link_rate_GROUP``: links made, of all gaps.
    ``link_recall_GROUP``: right links, of all gaps. ``link_precision_GROUP_of_90``: see ``precision_at``.
    """
    for name in groups:
        own = [link for link in links if GROUPS[name].has(link.gap)]
        made, count = sum(link.is_made for link in own), float(len(own))
        right = sum(link.outcome == Outcome.RIGHT for link in own)
        if made:
            yield Score(f"link_precision_{name}{ending}", right / made, float(made))
        if own:
            yield Score(f"link_rate_{name}{ending}", made / count, count)
            yield Score(f"link_recall_{name}{ending}", right / count, count)
            yield Score(f"link_precision_{name}_of_90{ending}", precision_at(own), SHARE * count)


def precision_at(links: Sequence[Link], share: float = SHARE) -> float:
    """Return how many of the most confident links, as many as ``share`` of all gaps, are right, as a share of them.

    So trackers that abstain more or less often are compared at the same share of links. One that makes fewer has the
    missing ones wrong. Among links of equal confidence none is preferred; a link without confidence has 0.
    """
    made = [link for link in links if link.is_made]
    wanted = share * len(links)
    sure = np.array([np.nan_to_num(link.confidence) for link in made])
    right = np.array([link.outcome == Outcome.RIGHT for link in made], dtype=float)
    total, left = 0.0, wanted
    for level in np.unique(sure)[::-1]:
        alike = right[sure == level]
        taken = min(left, float(len(alike)))
        total += taken * float(alike.mean())
        left -= taken
    return total / wanted


def link_events(links: Sequence[Link]) -> Iterator[Score]:
    """Yield for each gap ``link_made`` (1 or 0) and, if a link was made, ``link_right`` (1 or 0)."""
    for link in links:
        yield Score("link_made", float(link.is_made), event=link.gap)
        if link.is_made:
            yield Score("link_right", float(link.outcome == Outcome.RIGHT), event=link.gap)


def identity_series(borne: Bearers, apart: NDArray[np.bool_]) -> Iterator[Score]:
    """Yield ``identity_runs_FISH`` (*series*: first frame, end and identity of every run of frames with one identity)
    and ``gap_runs_FISH`` (*series*: first frame and end of every stretch not apart) of the first 20 fish.
    """
    for fish in range(min(apart.shape[1], MOST_FISH)):
        own = borne.identity[:, fish]
        spans = [(first, end, name) for name in np.unique(own[own >= 0]).tolist() for first, end in runs(own == name)]
        yield Score(f"identity_runs_{fish}", [float(number) for span in sorted(spans) for number in span])
        yield Score(f"gap_runs_{fish}", [float(number) for span in runs(~apart[:, fish]) for number in span])
