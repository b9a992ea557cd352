"""What the past of a swimmer tells of where it goes: features for a regression that mirrors leave unchanged.

Every feature of an axis changes its sign when that axis is mirrored and keeps it when the other one is: tanks have no
preferred side, so both axes share one set of weights. Lengths are in units of half the longer side of the bounds.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

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
