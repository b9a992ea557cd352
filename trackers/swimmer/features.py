"""Windows cut from tracks, and their features for a regression of where a swimmer goes, which mirrors leave unchanged.

Every feature of an axis changes its sign when that axis is mirrored and keeps it when the other one is: tanks have no
preferred side, so both axes share one set of weights. Lengths are in units of half the longer side of the bounds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from trackers.gaps import Piece

PAST = 100
"""Frames of the past that are used; a shorter past is continued backwards at rest."""
LAGS = (1, 3, 6, 12, 25, 50, PAST - 1)
_DAMPED = tuple((lag, tau) for lag in (3, 12) for tau in (10.0, 20.0, 40.0, 80.0))
"""Frames over which a velocity is taken, and time constant of its decay, frames."""
_FITTED, _TURN_TAUS = (12, 25, 50), (15.0, 60.0)
"""Frames over which velocity and turn rate are fitted, and time constants of the turn rate's decay, frames."""
_ROUGH = 0.25
"""Roughness at which a past counts half as smooth."""
_AT_REST = 1e-3
"""Displacements shorter than this share of the unit give no direction."""


@dataclass(frozen=True, slots=True)
class Pasts:
    """The past of M gaps.

    Attributes:
        position_px: (M, PAST, 2) without NaN.
        bounds_xyxy: (M, 4) the region that swimmers reach.
        home_px: (M, 2) where swimmers have been of late.
        posture: (M, 3) at the end: direction of the head as a unit vector, and the angle from the rear half of the body
            to the front half; zeros where it is unknown.
    """

    position_px: NDArray[np.float64]
    bounds_xyxy: NDArray[np.float64]
    home_px: NDArray[np.float64]
    posture: NDArray[np.float64]

    @property
    def last_px(self) -> NDArray[np.float64]:
        """(M, 2) the last measured position."""
        return self.position_px[:, -1]

    @property
    def unit_px(self) -> NDArray[np.float64]:
        """(M, 1) half the longer side of the bounds."""
        side_px = (self.bounds_xyxy[:, 2:] - self.bounds_xyxy[:, :2]).max(axis=1, keepdims=True)
        return np.maximum(0.5 * side_px, 1.0)


def smoothness(position_px: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (M,) in (0, 1]: 1 where constant velocity predicts a past (M, PAST, 2) well, 0 where it does not.

    ``1 / (1 + (r / 0.25)^4)`` with r the mean error of a prediction over 30 frames over the length of the way.
    """
    rough = np.zeros(len(position_px))
    starts = (PAST - 60, PAST - 50, PAST - 40, PAST - 31)
    for t in starts:
        velocity = (position_px[:, t] - position_px[:, t - 20]) / 20
        error = position_px[:, t + 30] - position_px[:, t] - 30 * velocity
        way = np.linalg.norm(np.diff(position_px[:, t - 20 : t + 31 : 5], axis=1), axis=-1).sum(axis=1) * 30 / 50
        rough += np.linalg.norm(error, axis=1) / np.maximum(way, 1e-3) / len(starts)
    return 1.0 / (1.0 + (rough / _ROUGH) ** 4)


def activity(pasts: Pasts) -> NDArray[np.float64]:
    """Return (M,) the length of the way through the past, in units."""
    step_px = np.linalg.norm(np.diff(pasts.position_px[:, ::3], axis=1), axis=-1)
    return step_px.sum(axis=1) / pasts.unit_px[:, 0]


POSTURE_FEATURES = 8
"""The last features are those of posture; they are all zero where it is unknown."""


def features(pasts: Pasts, ahead: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (K, M, 2, D) features of the displacements within ``ahead`` (K,) frames, for x and y."""
    x = pasts.position_px
    smooth = smoothness(x)[:, None, None]
    rough_part = (1.0 - smooth) * np.stack([*_ways(pasts), *_walls(pasts), *_turns(pasts)], axis=-1)
    smooth_part = smooth * np.stack(_arcs(x, pasts.unit_px, ahead), axis=-1)
    posture = np.stack(_posture(pasts), axis=-1)
    posture_part = np.concatenate([(1.0 - smooth) * posture, smooth * posture], axis=-1)
    rough_part, posture_part = (np.broadcast_to(part, (len(ahead), *part.shape)) for part in (rough_part, posture_part))
    return np.concatenate([rough_part, smooth_part, posture_part], axis=-1)


def _steps(pasts: Pasts) -> list[NDArray[np.float64]]:
    """Displacements (M, 2) over the lags, in units."""
    x = pasts.position_px
    return [(x[:, -1] - x[:, -1 - lag]) / pasts.unit_px for lag in LAGS]


def lengths(vector: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the lengths (M, 1) of vectors (M, 2)."""
    return np.linalg.norm(vector, axis=-1, keepdims=True)


def _ways(pasts: Pasts) -> list[NDArray[np.float64]]:
    x, unit, low, high = pasts.position_px, pasts.unit_px, pasts.bounds_xyxy[:, :2], pasts.bounds_xyxy[:, 2:]
    steps, active = _steps(pasts), activity(pasts)[:, None]
    mean, home = (x.mean(axis=1) - x[:, -1]) / unit, (pasts.home_px - x[:, -1]) / unit
    within = [
        (np.clip(x[:, -1] + (x[:, -1] - x[:, -1 - lag]) / lag * tau, low, high) - x[:, -1]) / unit
        for lag, tau in _DAMPED
    ]
    return [
        *steps,
        *(step / (lengths(step) + 0.02) for step in steps),
        *within,
        mean,
        home,
        active * mean,
        active * home,
    ]


def _walls(pasts: Pasts) -> list[NDArray[np.float64]]:
    x, low, high = pasts.position_px, pasts.bounds_xyxy[:, :2], pasts.bounds_xyxy[:, 2:]
    steps, last = _steps(pasts), x[:, -1]
    # Place between the walls in [-1, 1].
    place = np.clip((2 * last - low - high) / np.maximum(high - low, 1.0), -1.0, 1.0)
    other = place[:, ::-1]
    found = [
        place,
        place * np.abs(place) ** 3,
        place * np.abs(place) ** 6,
        place * lengths(steps[3]),
        place * np.abs(other),
    ]
    for step in steps:
        found += [place * other * step[:, ::-1], np.maximum(step * np.sign(place), 0.0) * place]
    for reach in (30.0, 100.0):
        near = np.exp(-np.maximum(last - low, 0.0) / reach) + np.exp(-np.maximum(high - last, 0.0) / reach)
        found += [near * 0.1 * steps[2] / (lengths(steps[2]) + _AT_REST), near * steps[2] * 4, near * steps[4]]
    return found


def _turns(pasts: Pasts) -> list[NDArray[np.float64]]:
    """The direction to the side to which the way has turned."""
    steps = _steps(pasts)
    now = steps[1]
    side = np.stack([-now[:, 1], now[:, 0]], axis=1) / (lengths(now) + _AT_REST)
    found = []
    for step in steps[2:6]:
        sine = (step[:, :1] * now[:, 1:] - step[:, 1:] * now[:, :1]) / (
            (lengths(step) + _AT_REST) * (lengths(now) + _AT_REST)
        )
        found += [0.1 * sine * side, sine * side * lengths(now)]
    return found


def _posture(pasts: Pasts) -> list[NDArray[np.float64]]:
    """What the body adds to the way so far: the head's direction off that of travel, and the bend to its side."""
    head, bend, step = pasts.posture[:, :2], pasts.posture[:, 2:], _steps(pasts)[2]
    off = np.where(lengths(head) > 0.0, head - step / (lengths(step) + _AT_REST), 0.0)
    aside = bend * np.stack([-head[:, 1], head[:, 0]], axis=1)
    return [0.1 * off, off * lengths(step), 0.1 * aside, aside * lengths(step)]


def _arcs(x: NDArray[np.float64], unit: NDArray[np.float64], ahead: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Ways (K, M, 2) at constant speed, straight or with a turn rate that decays."""
    found = []
    for frames in _FITTED:
        velocity, turn = fitted_motion(x, frames)
        found.append(ahead[:, None, None] * velocity / unit)
        found += [_arc(velocity, turn, tau, ahead) / unit for tau in _TURN_TAUS]
    return found


def fitted_motion(x: NDArray[np.float64], frames: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return velocity (M, 2) and turn rate (M, 1), per frame, at the end of a parabola through the last frames."""
    velocity, acceleration = np.einsum("kt,mti->kmi", _parabola(frames), x[:, -frames:])
    across = velocity[:, :1] * acceleration[:, 1:] - velocity[:, 1:] * acceleration[:, :1]
    return velocity, across / np.maximum((velocity**2).sum(axis=1, keepdims=True), 1e-4)


@cache
def _parabola(frames: int) -> NDArray[np.float64]:
    """Return (2, T): slope and curvature at the end of the parabola of least squares through T values."""
    t = np.arange(1.0 - frames, 1.0)
    return np.linalg.pinv(np.stack([np.ones(frames), t, 0.5 * t * t], axis=1))[1:]


def _arc(
    velocity: NDArray[np.float64], turn: NDArray[np.float64], tau: float, ahead: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Integrate ``v (cos a, sin a)`` with ``a(t) = turn tau (1 - exp(-t / tau))`` by Simpson's rule, to (K, M, 2)."""
    t = ahead[:, None] * np.linspace(0.0, 1.0, 9)
    angle = np.clip(turn * tau, -3.0, 3.0) * (1.0 - np.exp(-t / tau))[:, None]
    weights = np.array([1, 4, 2, 4, 2, 4, 2, 4, 1]) / 24.0
    c, s = (ahead[:, None] * (turned @ weights) for turned in (np.cos(angle), np.sin(angle)))
    return np.stack([c * velocity[:, 0] - s * velocity[:, 1], s * velocity[:, 0] + c * velocity[:, 1]], axis=-1)


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
