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

from benchmarks.judges.fish.gap_protocol import BLOCK_FRAMES, PAST_FRAMES, Tracks
from benchmarks.judges.fish.gap_scores import assigned
from benchmarks.judges.fish.links import APART_FRAMES, FishGap, Link, Outcome
from benchmarks.judges.runs import runs
from sim.rng import generator
from trackers.gaps import Bridge, GapMethod, Surroundings

SEARCH_FRAMES = 200
"""A successor begins within so many frames."""


@dataclass(frozen=True, slots=True)
class Tracklet:
    """Frames [first, end) on which one animal is tracked without a pause."""

    animal: int
    first: int
    end: int


def find_tracklets(tracks: Tracks, jump_px: float) -> list[Tracklet]:
    """Return the unbroken pieces of all animals of at least ``APART_FRAMES`` frames, in order of their ends."""
    position_px = tracks.position_px
    found = []
    for animal in range(position_px.shape[1]):
        step_px = np.linalg.norm(np.diff(position_px[:, animal], axis=0), axis=1)
        jumps = np.concatenate([[False], step_px > jump_px])
        for first, end in runs(np.isfinite(position_px[:, animal, 0]).tolist()):
            cuts = [first, *(first + np.flatnonzero(jumps[first:end])).tolist(), end]
            found += [Tracklet(animal, a, b) for a, b in itertools.pairwise(cuts) if b - a >= APART_FRAMES]
    return sorted(found, key=lambda each: (each.end, each.animal))


def link_tracklets(new_method: Callable[[], GapMethod], tracks: Tracks, jump_px: float) -> list[Link]:
    """Return a method's link over each gap of at most ``SEARCH_FRAMES`` frames between successive pieces of an animal.

    A piece may go on in every one that begins within ``SEARCH_FRAMES`` frames after its end. With p the density that
    the method predicts for the successor's first place and A the area in which animals have been, a link is worth
    ``log(p A)``: the pieces are linked so that the worth adds up to most, links below zero are not made. The
    confidence is ``p A / (1 + sum of p A over all candidates)``. A piece that the method fails on is not linked. Empty
    for a method that does not extrapolate, see ``bridge_gaps``, or predicts no covariance.
    """
    pieces = find_tracklets(tracks, jump_px)
    worth = _worth(new_method, tracks, pieces)
    if worth is None:
        return []
    columns = assigned(-np.maximum(worth, 0.0), generator(len(pieces), "tracklets"))
    chosen = {i: j for i, j in enumerate(columns) if worth[i, j] > 0}
    links: list[Link] = []
    for i, piece in enumerate(pieces):
        following = _next_of(pieces, piece)
        if following is None or not 0 < following.first - piece.end <= SEARCH_FRAMES:
            continue
        outcome, confidence = Outcome.ABSTAINED, np.nan
        if i in chosen:
            outcome = Outcome.RIGHT if pieces[chosen[i]] == following else Outcome.WRONG
            # Relative to the best one, so that nothing overflows.
            best = max(float(worth[i].max()), 0.0)
            rivals = np.exp(-best) + np.exp(worth[i] - best).sum()
            confidence = float(np.exp(worth[i, chosen[i]] - best) / rivals)
        length = following.first - piece.end
        others = [each for each in pieces if each.animal != piece.animal]
        lost = {each.animal for each in others if piece.end <= each.end < following.first}
        gap = FishGap(len(links), piece.animal, piece.end, length, 1 + len(lost), crosses=False)
        links.append(Link(gap, outcome, confidence))
    return links


def _next_of(pieces: Sequence[Tracklet], piece: Tracklet) -> Tracklet | None:
    later = [each for each in pieces if each.animal == piece.animal and each.first >= piece.end]
    return min(later, key=lambda each: each.first, default=None)


def _worth(
    new_method: Callable[[], GapMethod], tracks: Tracks, pieces: Sequence[Tracklet]
) -> NDArray[np.float64] | None:
    """Return the worth (P, P) of linking each piece to each, -inf where none may follow or the method fails.

    None if the method does not extrapolate the first piece, or gives no covariance.
    """
    method, extrapolates = new_method(), False
    worth = np.full((len(pieces), len(pieces)), -np.inf)
    starts = np.array([each.first for each in pieces])
    learnt_to = 0
    for i, piece in enumerate(pieces):
        learn_to = piece.end - piece.end % BLOCK_FRAMES
        if learn_to > learnt_to:
            method.learn([tracks.piece(animal, 0, learn_to) for animal in range(tracks.position_px.shape[1])])
            learnt_to = learn_to
        candidates = np.flatnonzero((starts >= piece.end) & (starts - piece.end <= SEARCH_FRAMES))
        if len(candidates) == 0:
            continue
        bounds_xyxy = _bounds(tracks.position_px[: piece.end])
        past = tracks.piece(piece.animal, max(piece.first, piece.end - PAST_FRAMES), piece.end)
        count = int(starts[candidates].max()) - piece.end + 1
        bridge = method.extrapolate(past, count, Surroundings(bounds_xyxy))
        if bridge is None and not extrapolates:
            return None
        extrapolates = True
        if bridge is None or not np.isfinite(bridge.position_px).all():
            continue
        if bridge.covariance_px is None:
            return None
        follow = [pieces[int(j)] for j in candidates]
        places = np.array([tracks.position_px[each.first, each.animal] for each in follow])
        area_px = float(np.prod(np.maximum(bounds_xyxy[2:] - bounds_xyxy[:2], 1.0)))
        worth[i, candidates] = np.log(area_px) + _log_density(bridge, starts[candidates] - piece.end, places)
    return worth


def _bounds(position_px: NDArray[np.float64]) -> NDArray[np.float64]:
    flat = position_px.reshape(-1, 2)
    return np.concatenate([np.nanmin(flat, axis=0), np.nanmax(flat, axis=0)])


def _log_density(bridge: Bridge, steps: NDArray[np.int64], places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the log density (C,) at each place (C, 2) on the frame with index ``steps`` (C,) after the end."""
    assert bridge.covariance_px is not None
    covariance = bridge.covariance_px[steps]
    away_px = places - bridge.position_px[steps]
    squared = np.einsum("ci,ci->c", away_px, np.linalg.solve(covariance, away_px[..., None])[..., 0])
    return np.asarray(-0.5 * (squared + np.linalg.slogdet(covariance)[1]) - np.log(2.0 * np.pi))
