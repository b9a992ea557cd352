"""The gap protocol of paper C: gaps are cut out of unbroken tracks, and methods bridge them.

A gap of G frames follows ``PAST_FRAMES`` measured frames and, for interpolation, is followed by as many. No window
holds an unmeasured frame or a jump. Where the true positions are known, the gap itself may, and of the frames before
and after it a share of ``MEASURED`` must be measured, those next to it in any case. Methods learn only from frames
before the gap. Intervals come from a bootstrap over blocks of time, in which all targets stay together, since
gaps that are near in time are correlated.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sim.checks import check
from trackers.gaps import Bridge, GapMethod, Piece, Surroundings

PAST_FRAMES = 100
"""Measured frames before a gap and, for interpolation, after it."""
MEASURED = 0.9
"""Least share of measured frames on either side of a gap where the true positions are known."""
BLOCK_FRAMES = 500
"""Length of a block of the bootstrap; methods learn anew at the start of each."""
REGION = 0.95
"""Probability of the region whose coverage is measured."""

Measure = Literal["end", "mean"]
"""The error on the last lost frame, or its mean over the gap."""


@dataclass(frozen=True, slots=True)
class Tracks:
    """Measured tracks of N targets over T frames.

    Attributes:
        position_px: (T, N, 2), NaN where it was not measured.
        interval_s: time between frames, > 0.
        heading_rad: (T, N), see ``Piece``; None without.
        centre_line_px: (T, N, K, 2), see ``Piece``; None without.
        true_px: (T, N, 2) true positions, which bridges are judged by; None: they are judged by ``position_px``.
    """

    position_px: NDArray[np.float64]
    interval_s: float
    heading_rad: NDArray[np.float64] | None = None
    centre_line_px: NDArray[np.float64] | None = None
    true_px: NDArray[np.float64] | None = None

    @property
    def judged_px(self) -> NDArray[np.float64]:
        """The positions (T, N, 2) that bridges are judged by."""
        return self.position_px if self.true_px is None else self.true_px

    def piece(self, target: int, first: int, end: int) -> Piece:
        """Return frames [first, end) of one target."""
        where = slice(max(first, 0), end)
        return Piece(
            where.start,
            self.position_px[where, target],
            self.interval_s,
            None if self.heading_rad is None else self.heading_rad[where, target],
            None if self.centre_line_px is None else self.centre_line_px[where, target],
        )


@dataclass(frozen=True, slots=True)
class Gap:
    """Frames [first, first + count) of one target, taken as lost."""

    target: int
    first: int
    count: int


@dataclass(frozen=True, slots=True)
class BridgedGap:
    """Errors of one method on one gap.

    Attributes:
        block: number of the gap's block in the bootstrap; unique over all series.
        error_px: (G,) distance of the predicted to the true position, or to the measured one if that is unknown.
        inside: (G,) whether that position is in the region of probability ``REGION``; None without covariance.
        bridge: the method's answer.
    """

    gap: Gap
    block: int
    error_px: NDArray[np.float64]
    inside: NDArray[np.bool_] | None
    bridge: Bridge

    def measure(self, measure: Measure) -> float:
        """Return the error on the last lost frame or the mean over the gap, in pixels."""
        return float(self.error_px[-1] if measure == "end" else self.error_px.mean())


def cut_gaps(
    tracks: Tracks, counts: Sequence[int], *, stride: int, jump_px: float, both_ends: bool = False
) -> list[Gap]:
    """Return the gaps in order of time: for each count those whose window is unbroken.

    Args:
        counts: numbers of lost frames, >= 1.
        stride: frames from one gap of a target to the next of the same count, >= 1.
        jump_px: a step longer than this from one frame to the next breaks a track.
        both_ends: the window includes ``PAST_FRAMES`` after the gap.
    """
    check("counts", len(counts) > 0 and min(counts) >= 1, "numbers of at least 1", tuple(counts))
    check("stride", stride >= 1, "at least 1 frame", stride)
    whole_from = _unbroken_since(tracks, jump_px) if tracks.true_px is None else _known_well(tracks, jump_px)
    gaps = []
    for count in counts:
        after = PAST_FRAMES if both_ends else 0
        firsts = np.arange(PAST_FRAMES, len(tracks.position_px) - count - after + 1, stride)
        whole = whole_from(firsts, count, after)
        gaps += [Gap(int(target), int(firsts[k]), count) for k, target in np.argwhere(whole)]
    return sorted(gaps, key=lambda gap: (gap.first, gap.target, gap.count))


_Whole = Callable[[NDArray[np.int64], int, int], NDArray[np.bool_]]
"""From first frames (F,), lost frames and frames after them to whether each target's (F, N) window will do."""


def _unbroken_since(tracks: Tracks, jump_px: float) -> _Whole:
    """Windows without an unmeasured frame or a jump, the gap included."""
    broken = _counted(~(_steps_px(tracks) <= jump_px))
    return lambda firsts, count, after: broken[firsts - PAST_FRAMES] == broken[firsts + count + after - 1]


def _known_well(tracks: Tracks, jump_px: float) -> _Whole:
    """Windows with enough measured frames and without a jump on either side of the gap."""
    measured = np.asarray(np.isfinite(tracks.position_px[..., 0]))
    missing = np.concatenate([np.zeros((1, measured.shape[1]), int), np.cumsum(~measured, axis=0)])
    jumps = _counted(_steps_px(tracks) > jump_px)
    most = round((1.0 - MEASURED) * PAST_FRAMES)

    def side(begin: NDArray[np.int64]) -> NDArray[np.bool_]:
        end = begin + PAST_FRAMES
        return (missing[end] - missing[begin] <= most) & (jumps[begin] == jumps[end - 1])

    def whole(firsts: NDArray[np.int64], count: int, after: int) -> NDArray[np.bool_]:
        good = side(firsts - PAST_FRAMES) & measured[firsts - 1]
        return good & side(firsts + count) & measured[firsts + count] if after else good

    return whole


def _steps_px(tracks: Tracks) -> NDArray[np.float64]:
    return np.asarray(np.linalg.norm(np.diff(tracks.position_px, axis=0), axis=-1))


def _counted(flags: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return how many of the flags (T - 1, N), each of a step, lie before each frame (T, N)."""
    return np.concatenate([np.zeros((1, flags.shape[1]), int), np.cumsum(flags, axis=0)])


def bridge_gaps(
    method: GapMethod,
    tracks: Tracks,
    gaps: Sequence[Gap],
    *,
    both_ends: bool,
    learns: bool,
    mates: bool,
    series: int = 0,
) -> list[BridgedGap]:
    """Return a method's errors on the gaps; empty if it returns None for the first: it does not bridge such gaps.

    A later None is a failure, with errors of NaN.

    Args:
        both_ends: the method gets the track after the gap too.
        learns: the method learns at the start of each block from all tracks before it.
        mates: the method sees the other targets' tracks, in the gap too.
        series: number of the recording or episode, which sets blocks apart.
    """
    bridged: list[BridgedGap] = []
    learnt_to = 0
    bounds_xyxy = _bounds_xyxy(tracks.position_px)
    for gap in sorted(gaps, key=lambda gap: gap.first):
        start = gap.first - gap.first % BLOCK_FRAMES
        if learns and start > learnt_to:
            method.learn([tracks.piece(target, 0, start) for target in range(tracks.position_px.shape[1])])
            learnt_to = start
        end = gap.first + gap.count
        seen = tuple(_mates(tracks, gap, end + PAST_FRAMES if both_ends else end)) if mates else ()
        around = Surroundings(bounds_xyxy[gap.first - 1], seen)
        past = tracks.piece(gap.target, gap.first - PAST_FRAMES, gap.first)
        if both_ends:
            bridge = method.interpolate(past, tracks.piece(gap.target, end, end + PAST_FRAMES), around)
        else:
            bridge = method.extrapolate(past, gap.count, around)
        if bridge is None:
            if not bridged:
                return []
            bridge = Bridge(np.full((gap.count, 2), np.nan))
        error_px = tracks.judged_px[gap.first : end, gap.target] - bridge.position_px
        block = series * 1_000_000 + gap.first // BLOCK_FRAMES
        bridged.append(BridgedGap(gap, block, np.linalg.norm(error_px, axis=-1), _inside(bridge, error_px), bridge))
    return bridged


def turn_rad(tracks: Tracks, gap: Gap, over_frames: int = 10) -> float:
    """Return the change in the direction of travel across a gap in [0, pi], each taken over ``over_frames`` frames.

    NaN where the track does not reach so far.
    """
    end = gap.first + gap.count
    if gap.first <= over_frames or end + over_frames > len(tracks.position_px):
        return float("nan")
    xy = tracks.judged_px[:, gap.target]
    before, after = xy[gap.first - 1] - xy[gap.first - 1 - over_frames], xy[end + over_frames - 1] - xy[end - 1]
    across, along = before[0] * after[1] - before[1] * after[0], before @ after
    return float(abs(np.arctan2(across, along)))


def _mates(tracks: Tracks, gap: Gap, end: int) -> Iterator[Piece]:
    for target in range(tracks.position_px.shape[1]):
        if target != gap.target:
            yield tracks.piece(target, gap.first - PAST_FRAMES, end)


def _bounds_xyxy(position_px: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (T, 4) for each frame the box of all positions (T, N, 2) measured up to it."""
    low = np.fmin.accumulate(np.nanmin(position_px, axis=1, initial=np.inf))
    high = np.fmax.accumulate(np.nanmax(position_px, axis=1, initial=-np.inf))
    return np.concatenate([low, high], axis=1)


def _inside(bridge: Bridge, error_px: NDArray[np.float64]) -> NDArray[np.bool_] | None:
    if bridge.covariance_px is None:
        return None
    squared = np.einsum("ti,ti->t", error_px, np.linalg.solve(bridge.covariance_px, error_px[..., None])[..., 0])
    # The squared Mahalanobis distance of two coordinates is exponential with mean 2.
    return squared <= -2.0 * np.log(1.0 - REGION)
