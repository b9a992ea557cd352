"""Tracks cut into windows that a regression learns from: a past, a gap and, if wanted, what follows it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from trackers.gaps.types import Piece
from trackers.swimmer.features import PAST, Pasts

MOST_WINDOWS = 3000
"""Only so many windows, the latest, are learnt from."""
_STRIDE = 10
_JUMP = 5.0
"""A step longer than this many times the 95th percentile of all steps is a mistake of the tracker."""
_HOME_FRAMES = 1500.0
"""Time constant of the mean of places that gives a home."""
_FORGETTING_FRAMES = 2500.0
_FOLD_FRAMES = 400


@dataclass(frozen=True, eq=False)
class Windows:
    """M windows: a past, the lost frames, and the frames after them.

    Attributes:
        pasts: before the gaps.
        gap_px: (M, G, 2) the lost frames.
        after_px: (M, A, 2) the frames after them.
        weight: (M,) in (0, 1], the less the longer ago.
        fold: (M,) bool, alternating in time.
    """

    pasts: Pasts
    gap_px: NDArray[np.float64]
    after_px: NDArray[np.float64]
    weight: NDArray[np.float64]
    fold: NDArray[np.bool_]

    @property
    def independent(self) -> float:
        """About how many windows do not overlap in their gaps."""
        return float(self.weight.sum()) * min(_STRIDE / self.gap_px.shape[1], 1.0)


class Recording:
    """Tracks on a common axis of time, and where the targets have been up to each frame.

    Attributes:
        end_frame: index of the frame after the last.
    """

    def __init__(self, pieces: Sequence[Piece]) -> None:
        pieces = [piece for piece in pieces if np.isfinite(piece.position_px).any()]
        self._pieces = pieces
        self._postures = [postures_of(piece) for piece in pieces]
        self._first = min((piece.first_frame for piece in pieces), default=0)
        self.end_frame = max((piece.end_frame for piece in pieces), default=0)
        frames = self.end_frame - self._first
        sums, counts = np.zeros((frames, 2)), np.zeros(frames)
        low, high = np.full((frames, 2), np.inf), np.full((frames, 2), -np.inf)
        for piece in pieces:
            where = slice(piece.first_frame - self._first, piece.end_frame - self._first)
            measured = np.isfinite(piece.position_px.sum(axis=1))
            sums[where] += np.where(measured[:, None], piece.position_px, 0.0)
            counts[where] += measured
            low[where] = np.fmin(low[where], piece.position_px)
            high[where] = np.fmax(high[where], piece.position_px)
        self._bounds_xyxy = np.concatenate([np.minimum.accumulate(low), np.maximum.accumulate(high)], axis=1)
        self._home_px = _recent_mean(sums, counts)
        steps = [_steps_px(piece) for piece in pieces]
        known = np.concatenate(steps)[np.isfinite(np.concatenate(steps))] if steps else np.zeros(0)
        longest = _JUMP * float(np.percentile(known, 95)) if len(known) else 0.0
        # The number of unmeasured steps and jumps before each frame.
        self._breaks = [np.concatenate([[0], np.cumsum(~(step <= longest))]) for step in steps]

    @property
    def home_px(self) -> NDArray[np.float64] | None:
        """(2,) recent mean of all places at the end; None if nothing was measured."""
        return self._home_px[-1] if len(self._home_px) else None

    def windows(self, count: int, after: int) -> Windows:
        """Return the latest windows with gaps of ``count`` frames and ``after`` frames behind them."""
        length = PAST + count + after
        frames, wholes, postures = [np.zeros(0, int)], [np.zeros((0, length, 2))], [np.zeros((0, 3))]
        for piece, posture, breaks in zip(self._pieces, self._postures, self._breaks, strict=True):
            firsts = np.arange(0, len(breaks) - length + 1, _STRIDE)
            firsts = firsts[breaks[firsts] == breaks[firsts + length - 1]]
            if len(firsts):
                view = sliding_window_view(piece.position_px, length, axis=0)
                wholes.append(view[firsts].transpose(0, 2, 1))
                postures.append(posture[firsts + PAST - 1])
                frames.append(firsts + PAST + piece.first_frame)
        latest = np.argsort(np.concatenate(frames), kind="stable")[-MOST_WINDOWS:]
        frame, whole = np.concatenate(frames)[latest], np.concatenate(wholes)[latest]
        posture = np.concatenate(postures)[latest]
        at = frame - 1 - self._first
        return Windows(
            Pasts(whole[:, :PAST], self._bounds_xyxy[at], self._home_px[at], posture),
            whole[:, PAST : PAST + count],
            whole[:, PAST + count :],
            np.exp((frame + count - self.end_frame) / _FORGETTING_FRAMES),
            frame // _FOLD_FRAMES % 2 == 1,
        )


def _recent_mean(sums: NDArray[np.float64], counts: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (T, 2) the mean of all places so far, the less weight the longer ago."""
    kept = np.exp(-1.0 / _HOME_FRAMES)
    total, number, means = np.zeros(2), 0.0, np.zeros_like(sums)
    for t in range(len(sums)):
        total, number = kept * total + sums[t], kept * number + counts[t]
        means[t] = total / max(number, 1e-9)
    return means


def _steps_px(piece: Piece) -> NDArray[np.float64]:
    return np.linalg.norm(np.diff(piece.position_px, axis=0), axis=1)


def whole_past(piece: Piece) -> tuple[NDArray[np.float64], int]:
    """Return the last PAST positions (PAST, 2) up to the last measured one, and how many unmeasured frames follow it.

    Frames between measured ones are interpolated. A shorter past is continued backwards by its mirror image about its
    first position, which keeps speed and direction.

    Raises:
        ValueError: if nothing was measured.
    """
    measured = np.flatnonzero(np.isfinite(piece.position_px).all(axis=1))
    if len(measured) == 0:
        raise ValueError("past: expected at least one measured position, got none")
    first, last = measured[0], measured[-1]
    t = np.arange(max(first, last + 1 - PAST), last + 1)
    x = np.stack([np.interp(t, measured, piece.position_px[measured, axis]) for axis in (0, 1)], axis=1)
    while len(x) < PAST:
        mirrored = 2 * x[0] - x[1:][::-1] if len(x) > 1 else x
        x = np.concatenate([mirrored, x])[-PAST:]
    return x, len(piece.position_px) - 1 - int(last)


def postures_of(piece: Piece) -> NDArray[np.float64]:
    """Return (T, 3) the posture on each frame, see ``Pasts``; zeros where it is unknown."""
    posture = np.zeros((len(piece.position_px), 3))
    heading_rad = piece.heading_rad
    line = piece.centre_line_px
    if line is not None:
        middle = line.shape[1] // 2
        front, rear = line[:, 0] - line[:, middle], line[:, middle] - line[:, -1]
        across = rear[:, 0] * front[:, 1] - rear[:, 1] * front[:, 0]
        posture[:, 2] = np.arctan2(across, (rear * front).sum(axis=1))
        if heading_rad is None:
            heading_rad = np.arctan2(front[:, 1], front[:, 0])
    if heading_rad is not None:
        posture[:, 0], posture[:, 1] = np.cos(heading_rad), np.sin(heading_rad)
    return np.where(np.isfinite(posture).all(axis=1, keepdims=True), posture, 0.0)


def jitter_px(x: NDArray[np.float64]) -> float:
    """Return the standard deviation of a measured coordinate, from the median second difference of a way (T, 2)."""
    second = np.linalg.norm(np.diff(x, n=2, axis=0), axis=1)
    # Second differences have 6 times the variance; the median length of a round Gaussian is 1.18 standard deviations.
    return float(np.median(second)) / (np.sqrt(6.0) * np.sqrt(2.0 * np.log(2.0)))
