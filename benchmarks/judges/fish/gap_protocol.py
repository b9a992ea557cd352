"""The gap protocol of paper C: gaps are cut out of unbroken tracks, and methods bridge them.

A gap of G frames follows ``PAST_FRAMES`` measured frames and, for interpolation, is followed by as many. No window
holds an unmeasured frame or a jump. Where the true positions are known, the gap itself may, and of the frames before
and after it a share of ``MEASURED`` must be measured, those next to it in any case. Methods learn only from frames
before the gap. Intervals come from a bootstrap over blocks of time, in which all targets stay together, since
gaps that are near in time are correlated.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from sim.checks import check
from trackers.gaps import Bridge, GapMethod, Piece, Surroundings

GAP_FRAMES = (50, 100, 200)
"""Numbers of lost frames, those of the paper."""
PAST_FRAMES = 100
"""Measured frames before a gap and, for interpolation, after it."""
MEASURED = 0.9
"""Least share of measured frames on either side of a gap where the true positions are known."""
BLOCK_FRAMES = 500
"""Length of a block of the bootstrap; methods learn anew at the start of each."""
REGION = 0.95
"""Probability of the region whose coverage is measured."""
_USUAL_STEP_QUANTILE, _JUMP = 0.99, 3.0
"""A step that is so many times as long as the longest usual one is a jump, which breaks a track."""


@dataclass(frozen=True)
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

    @cached_property
    def jump_px(self) -> float:
        """Length of a step from which on it breaks a track; NaN, which no step is below, without any step."""
        known = self.step_px[np.isfinite(self.step_px)]
        return _JUMP * float(np.quantile(known, _USUAL_STEP_QUANTILE)) if len(known) else float("nan")

    @cached_property
    def step_px(self) -> NDArray[np.float64]:
        """Lengths (T - 1, N) of the steps from each frame to the next."""
        return np.asarray(np.linalg.norm(np.diff(self.position_px, axis=0), axis=-1))

    @cached_property
    def bounds_xyxy(self) -> NDArray[np.float64]:
        """For each frame (T, 4) the box of all positions measured up to it."""
        low = np.fmin.accumulate(np.nanmin(self.position_px, axis=1, initial=np.inf))
        high = np.fmax.accumulate(np.nanmax(self.position_px, axis=1, initial=-np.inf))
        return np.concatenate([low, high], axis=1)

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

    def pieces(self, first: int, end: int, but: int | None = None) -> list[Piece]:
        """Return frames [first, end) of all targets ``but`` one."""
        return [self.piece(target, first, end) for target in range(self.position_px.shape[1]) if target != but]


@dataclass(frozen=True, slots=True)
class Gap:
    """Frames [first, first + count) of one target, taken as lost."""

    target: int
    first: int
    count: int

    @property
    def end(self) -> int:
        """The frame after the last lost one."""
        return self.first + self.count


@dataclass(frozen=True, slots=True)
class BridgedGap:
    """Errors of one method on one gap.

    Attributes:
        error_px: (G,) distance of the predicted to the true position, or to the measured one if that is unknown.
        inside: (G,) whether that position is in the region of probability ``REGION``; None without covariance.
        bridge: the method's answer.
    """

    gap: Gap
    error_px: NDArray[np.float64]
    inside: NDArray[np.bool_] | None
    bridge: Bridge


@dataclass(frozen=True)
class Bridged:
    """Gaps of one recording as a method bridged them.

    Attributes:
        extrapolated: the far end unknown. interpolated: known. Empty where the method does not.
    """

    extrapolated: list[BridgedGap]
    interpolated: list[BridgedGap]

    def of_block(self, block: int) -> Bridged:
        """Return the gaps that begin in a block of time."""
        kinds = self.extrapolated, self.interpolated
        return Bridged(*([each for each in kind if each.gap.first // BLOCK_FRAMES == block] for kind in kinds))


@dataclass(frozen=True)
class GapTask:
    """The gaps of one recording.

    Attributes:
        tracks: as measured.
        stride: frames from one gap of a fish to its next of the same length.
        cap_px: error of a prediction that failed; the diagonal of the picture.
        sees_mates: whether methods see the other fish's tracks, in the gap too.
    """

    tracks: Tracks
    stride: int
    cap_px: float
    sees_mates: bool

    @cached_property
    def open_gaps(self) -> list[Gap]:
        """Gaps whose far end is unknown."""
        return cut_gaps(self.tracks, self.stride)

    @cached_property
    def closed_gaps(self) -> list[Gap]:
        """Gaps whose far end is known."""
        return cut_gaps(self.tracks, self.stride, both_ends=True)

    def bridged(self, new_method: Callable[[], GapMethod]) -> Bridged:
        """Return what a method makes of all gaps; a fresh copy of it bridges each kind."""
        return Bridged(
            self._bridged(new_method(), self.open_gaps, both_ends=False),
            self._bridged(new_method(), self.closed_gaps, both_ends=True),
        )

    def _bridged(self, method: GapMethod, gaps: Sequence[Gap], *, both_ends: bool) -> list[BridgedGap]:
        """Return a method's errors on gaps in order of time; it learns at the start of each block from all before it.

        Empty if it returns None for the first: it does not bridge such gaps. A later None is a failure.
        """
        bridged: list[BridgedGap] = []
        learnt_to = 0
        for gap in gaps:
            learnt_to = learn_to(method, self.tracks, gap.first, learnt_to)
            seen_to = gap.end + PAST_FRAMES if both_ends else gap.end
            past_from = gap.first - PAST_FRAMES
            mates = self.tracks.pieces(past_from, seen_to, but=gap.target) if self.sees_mates else ()
            around = Surroundings(self.tracks.bounds_xyxy[gap.first - 1], tuple(mates))
            past = self.tracks.piece(gap.target, past_from, gap.first)
            if both_ends:
                bridge = method.interpolate(past, self.tracks.piece(gap.target, gap.end, seen_to), around)
            else:
                bridge = method.extrapolate(past, gap.count, around)
            if bridge is None and not bridged:
                return []
            bridged.append(self._judged(gap, bridge or Bridge(np.full((gap.count, 2), np.nan))))
        return bridged

    def _judged(self, gap: Gap, bridge: Bridge) -> BridgedGap:
        away_px = self.tracks.judged_px[gap.first : gap.end, gap.target] - bridge.position_px
        error_px = np.nan_to_num(np.linalg.norm(away_px, axis=-1), nan=self.cap_px)
        if bridge.covariance_px is None:
            return BridgedGap(gap, error_px, None, bridge)
        # The squared Mahalanobis distance of two coordinates is exponential with mean 2.
        inside = squared_distance(away_px, bridge.covariance_px) <= -2.0 * np.log(1.0 - REGION)
        return BridgedGap(gap, error_px, inside, bridge)


def learn_to(method: GapMethod, tracks: Tracks, frame: int, learnt_to: int) -> int:
    """Let a method learn from all whole blocks before a frame, if it has not; return the frame up to which it has."""
    start = frame - frame % BLOCK_FRAMES
    if start > learnt_to:
        method.learn(tracks.pieces(0, start))
    return max(start, learnt_to)


def squared_distance(away_px: NDArray[np.float64], covariance_px: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the squared Mahalanobis distances (...) of offsets (..., 2) under covariances (..., 2, 2)."""
    return np.einsum("...i,...i->...", away_px, np.linalg.solve(covariance_px, away_px[..., None])[..., 0])


def cut_gaps(tracks: Tracks, stride: int, counts: Sequence[int] = GAP_FRAMES, *, both_ends: bool = False) -> list[Gap]:
    """Return the gaps in order of time: for each count those whose window will do, see the module.

    Args:
        stride: frames from one gap of a target to the next of the same count, >= 1.
        counts: numbers of lost frames, >= 1.
        both_ends: the window includes ``PAST_FRAMES`` after the gap.
    """
    check("stride", stride >= 1, "at least 1 frame", stride)
    unknown = tracks.true_px is None
    measured = np.isfinite(tracks.position_px[..., 0])
    missing = _counted(~measured)
    # Where the gap must be whole too, a step to or from an unmeasured frame breaks a window as a jump does.
    jumps = _counted(~(tracks.step_px <= tracks.jump_px) if unknown else tracks.step_px > tracks.jump_px)
    most = round((1.0 - MEASURED) * PAST_FRAMES)

    def known_well(begin: NDArray[np.int64]) -> NDArray[np.bool_]:
        end = begin + PAST_FRAMES
        return np.asarray((missing[end] - missing[begin] <= most) & (jumps[begin] == jumps[end - 1]))

    gaps = []
    for count in counts:
        after = PAST_FRAMES if both_ends else 0
        firsts = np.arange(PAST_FRAMES, len(measured) - count - after + 1, stride)
        ends = firsts + count
        if unknown:
            whole = jumps[firsts - PAST_FRAMES] == jumps[ends + after - 1]
        else:
            whole = known_well(firsts - PAST_FRAMES) & measured[firsts - 1]
            if both_ends:
                whole &= known_well(ends) & measured[ends]
        gaps += [Gap(int(target), int(firsts[k]), count) for k, target in np.argwhere(whole)]
    return sorted(gaps, key=lambda gap: (gap.first, gap.target, gap.count))


def _counted(flags: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return how many of the flags (T, N) lie before each index (T + 1, N)."""
    return np.concatenate([np.zeros((1, flags.shape[1]), int), np.cumsum(flags, axis=0)])
