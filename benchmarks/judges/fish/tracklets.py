"""Links between pieces of real tracks, by a gap method's predictions alone: the successor of each lost piece.

The file's own identities tell which links are right. A piece ends where the file lost the animal or has it jump; a
link across a jump alone is not judged, since the file's identity is most in doubt there.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.judges.fish.gap_protocol import PAST_FRAMES, Tracks, learn_to, squared_distance
from benchmarks.judges.fish.gap_scores import assigned
from benchmarks.judges.fish.gaps import APART_FRAMES, FishGap
from benchmarks.judges.fish.links import Link, Outcome
from benchmarks.judges.runs import runs
from sim.rng import generator
from trackers.gaps import GapMethod, Surroundings

SEARCH_FRAMES = 200
"""A successor begins within so many frames."""


@dataclass(frozen=True, slots=True)
class Tracklet:
    """Frames [first, end) on which one animal is tracked without a pause."""

    animal: int
    first: int
    end: int


def find_tracklets(tracks: Tracks) -> list[Tracklet]:
    """Return the unbroken pieces of all animals of at least ``APART_FRAMES`` frames, in order of their ends."""
    jumps = tracks.step_px > tracks.jump_px
    found = []
    for animal, measured in enumerate(np.isfinite(tracks.position_px[..., 0]).T):
        for first, end in runs(measured):
            cuts = [first, *(first + 1 + np.flatnonzero(jumps[first : end - 1, animal])).tolist(), end]
            found += [Tracklet(animal, a, b) for a, b in itertools.pairwise(cuts) if b - a >= APART_FRAMES]
    return sorted(found, key=lambda each: (each.end, each.animal))


def link_tracklets(new_method: Callable[[], GapMethod], tracks: Tracks) -> list[Link]:
    """Return a method's link over each gap of at most ``SEARCH_FRAMES`` frames between successive pieces of an animal.

    A piece may go on in every one that begins within ``SEARCH_FRAMES`` frames after its end. With p the density that
    the method predicts for the successor's first place and A the area in which animals have been, a link is worth
    ``log(p A)``: the pieces are linked so that the worth adds up to most, links below zero are not made. The
    confidence is ``p A / (1 + sum of p A over all candidates)``. A piece that the method fails on is not linked. Empty
    for a method that does not extrapolate, see ``GapTask``, or predicts no covariance.
    """
    pieces = find_tracklets(tracks)
    worth = _worth(new_method(), tracks, pieces)
    if worth is None:
        return []
    columns = assigned(-np.maximum(worth, 0.0), generator(len(pieces), "tracklets"))
    links: list[Link] = []
    for i, (piece, j) in enumerate(zip(pieces, columns, strict=True)):
        later = [each for each in pieces if each.animal == piece.animal and each.first >= piece.end]
        following = min(later, key=lambda each: each.first, default=piece)
        length = following.first - piece.end
        if not 0 < length <= SEARCH_FRAMES:
            continue
        outcome, confidence = Outcome.ABSTAINED, np.nan
        if worth[i, j] > 0:
            outcome = Outcome.RIGHT if pieces[j] == following else Outcome.WRONG
            # Relative to the best one, so that nothing overflows.
            best = max(float(worth[i].max()), 0.0)
            rivals = np.exp(-best) + np.exp(worth[i] - best).sum()
            confidence = float(np.exp(worth[i, j] - best) / rivals)
        lost = {each.animal for each in pieces if piece.end <= each.end < following.first} - {piece.animal}
        gap = FishGap(len(links), piece.animal, piece.end, length, 1 + len(lost), crosses=False)
        links.append(Link(gap, outcome, confidence))
    return links


def _worth(method: GapMethod, tracks: Tracks, pieces: Sequence[Tracklet]) -> NDArray[np.float64] | None:
    """Return the worth (P, P) of linking each piece to each, -inf where none may follow or the method fails.

    None if the method does not extrapolate the first piece, or gives no covariance.
    """
    extrapolates, learnt_to = False, 0
    worth = np.full((len(pieces), len(pieces)), -np.inf)
    starts = np.array([each.first for each in pieces])
    for i, piece in enumerate(pieces):
        learnt_to = learn_to(method, tracks, piece.end, learnt_to)
        candidates = np.flatnonzero((starts >= piece.end) & (starts - piece.end <= SEARCH_FRAMES))
        if len(candidates) == 0:
            continue
        bounds_xyxy = tracks.bounds_xyxy[piece.end - 1]
        past = tracks.piece(piece.animal, max(piece.first, piece.end - PAST_FRAMES), piece.end)
        steps = starts[candidates] - piece.end
        bridge = method.extrapolate(past, int(steps.max()) + 1, Surroundings(bounds_xyxy))
        if bridge is None and not extrapolates:
            return None
        extrapolates = True
        if bridge is None or not np.isfinite(bridge.position_px).all():
            continue
        if bridge.covariance_px is None:
            return None
        places = np.array([tracks.position_px[pieces[j].first, pieces[j].animal] for j in candidates.tolist()])
        covariance = bridge.covariance_px[steps]
        squared = squared_distance(places - bridge.position_px[steps], covariance)
        log_density = -0.5 * (squared + np.linalg.slogdet(covariance)[1]) - np.log(2.0 * np.pi)
        area_px = float(np.prod(np.maximum(bounds_xyxy[2:] - bounds_xyxy[:2], 1.0)))
        worth[i, candidates] = np.log(area_px) + log_density
    return worth
