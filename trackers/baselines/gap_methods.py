"""Baselines that bridge gaps in tracks: hold, constant and damped velocity, straight lines and Hermite cubics.

Each is a tracker without tracks: what it does is its ``gap_method``. Time is counted in frames.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources

import numpy as np
from numpy.typing import NDArray

from trackers.gaps import Bridge, Pictureless, Piece, Surroundings, last_state, reversed_in_time
from trackers.registry import NoParameters, register, tunable

DECAY_FILE = "velocity_decay.json"
_DECAY = json.loads(resources.files("trackers.baselines").joinpath(DECAY_FILE).read_text())
"""Learnt from development swims by ``python -m tools learn-swims``."""
_LESSON_FRAMES = 50
"""``DampedVelocity`` learns from its errors after so many frames."""
_DECAYS_FRAMES = np.geomspace(2.0, 500.0, 30)


class _Extrapolation(Pictureless):
    """A gap method that learns nothing and does not use the far end."""

    @property
    def gap_method(self) -> _Extrapolation:
        """The method itself."""
        return self

    def learn(self, pieces: Sequence[Piece]) -> None:
        """See ``GapMethod``."""

    def extrapolate(self, past: Piece, count: int, around: Surroundings) -> Bridge | None:
        """See ``GapMethod``."""
        raise NotImplementedError

    def interpolate(self, past: Piece, future: Piece, around: Surroundings) -> Bridge | None:
        """See ``GapMethod``."""
        return None


@register("fish_hold", role="baseline", summary="stays at the last measured position", suites=("fish",))
class HoldPlace(_Extrapolation):
    """``x(t) = x(0)``. The covariance is the mean square displacement within t in the past itself.

    Beyond half the past it grows in proportion to time.
    """

    Parameters = NoParameters

    def __init__(self, parameters: NoParameters, rng: np.random.Generator) -> None:
        pass

    def extrapolate(self, past: Piece, count: int, around: Surroundings) -> Bridge:
        """See ``GapMethod``."""
        last_px, _, since = last_state(past, 1)
        x = past.position_px
        t = since + np.arange(1, count + 1)
        most = max(len(x) // 2, 1)
        variance = np.array([_mean_square_px(x, int(lag)) for lag in np.minimum(t, most)]) * np.maximum(t / most, 1.0)
        return Bridge(np.tile(last_px, (count, 1)), variance[:, None, None] * np.eye(2))


def _mean_square_px(x: NDArray[np.float64], lag: int) -> float:
    """Return half the mean square displacement within ``lag`` frames, at least 1 px²."""
    squares = ((x[lag:] - x[:-lag]) ** 2).sum(axis=1)
    measured = squares[np.isfinite(squares)]
    return max(0.5 * float(measured.mean()), 1.0) if len(measured) else 1.0


@dataclass(frozen=True)
class VelocityParameters:
    """Settings of ``fish_constant_velocity`` and ``fish_hermite``.

    Attributes:
        over_frames: the velocity at an end is the mean over so many frames.
    """

    over_frames: int = tunable(3, 1, 30)


@register(
    "fish_constant_velocity", role="baseline", summary="goes on with the velocity of the last frames", suites=("fish",)
)
class ConstantVelocityGap(_Extrapolation):
    """``x(t) = x(0) + v t``."""

    Parameters = VelocityParameters

    def __init__(self, parameters: VelocityParameters, rng: np.random.Generator) -> None:
        self._over_frames = parameters.over_frames

    def extrapolate(self, past: Piece, count: int, around: Surroundings) -> Bridge:
        """See ``GapMethod``."""
        last_px, velocity, since = last_state(past, self._over_frames)
        return Bridge(last_px + (since + np.arange(1, count + 1))[:, None] * velocity)


@dataclass(frozen=True)
class DampedParameters:
    """Settings of ``fish_damped_velocity``.

    Attributes:
        over_frames: the velocity is the mean over so many frames.
        decay_frames: time constant of its decay, until ``learn`` finds another.
    """

    over_frames: int = tunable(3, 1, 30)
    decay_frames: float = tunable(_DECAY["decay_frames"], 1.0, 500.0, log=True)


@register("fish_damped_velocity", role="baseline", summary="goes on with a velocity that decays", suites=("fish",))
class DampedVelocity(_Extrapolation):
    """``x(t) = x(0) + v tau (1 - exp(-t / tau))``, the mean of an integrated Ornstein-Uhlenbeck process.

    Its covariance is that of the process: ``s² tau² (2 t / tau - 3 + 4 exp(-t / tau) - exp(-2 t / tau))``, with the
    mean square s² of a coordinate of the velocity in the past. ``learn`` takes the tau with the least mean error after
    50 frames.

    Attributes:
        decay_frames: tau.
    """

    Parameters = DampedParameters

    def __init__(self, parameters: DampedParameters, rng: np.random.Generator) -> None:
        self._over_frames = parameters.over_frames
        self.decay_frames = self._shipped_frames = parameters.decay_frames

    def learn(self, pieces: Sequence[Piece]) -> None:
        """See ``GapMethod``."""
        lessons = [_lessons(piece.position_px, self._over_frames) for piece in pieces]
        step, velocity = (np.concatenate([np.zeros((0, 2)), *(each[k] for each in lessons)]) for k in (0, 1))
        if len(step) == 0:
            self.decay_frames = self._shipped_frames
            return
        reach = _DECAYS_FRAMES * (1.0 - np.exp(-_LESSON_FRAMES / _DECAYS_FRAMES))
        errors_px = [np.linalg.norm(step - velocity * each, axis=1).mean() for each in reach]
        self.decay_frames = float(_DECAYS_FRAMES[int(np.argmin(errors_px))])

    def extrapolate(self, past: Piece, count: int, around: Surroundings) -> Bridge:
        """See ``GapMethod``."""
        last_px, velocity, since = last_state(past, self._over_frames)
        tau = self.decay_frames
        t = (since + np.arange(1, count + 1)) / tau
        steps = np.diff(past.position_px, axis=0)
        known = steps[np.isfinite(steps).all(axis=1)]
        square = max(0.5 * float((known**2).sum(axis=1).mean()), 1e-3) if len(known) else 1.0
        variance = square * tau**2 * (2 * t - 3 + 4 * np.exp(-t) - np.exp(-2 * t)) + 1.0
        return Bridge(last_px + tau * (1.0 - np.exp(-t))[:, None] * velocity, variance[:, None, None] * np.eye(2))


def _lessons(x: NDArray[np.float64], over_frames: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return steps (M, 2) within 50 frames and the velocities (M, 2) before them, both measured."""
    t = np.arange(over_frames, len(x) - _LESSON_FRAMES, 5)
    step, velocity = x[t + _LESSON_FRAMES] - x[t], (x[t] - x[t - over_frames]) / over_frames
    known = np.isfinite(step).all(axis=1) & np.isfinite(velocity).all(axis=1)
    return step[known], velocity[known]


class _Interpolation(_Extrapolation):
    """A gap method that needs both ends."""

    def extrapolate(self, past: Piece, count: int, around: Surroundings) -> Bridge | None:
        """See ``GapMethod``."""
        return None


@register("fish_linear", role="baseline", summary="a straight line from end to end", suites=("fish",))
class Linear(_Interpolation):
    """``x(s) = (1 - s) a + s b``."""

    Parameters = NoParameters

    def __init__(self, parameters: NoParameters, rng: np.random.Generator) -> None:
        pass

    def interpolate(self, past: Piece, future: Piece, around: Surroundings) -> Bridge:
        """See ``GapMethod``."""
        (a, _), (b, _), s, _ = _ends(past, future, 1)
        return Bridge((1 - s) * a + s * b)


@register("fish_hermite", role="baseline", summary="a cubic with the velocities at both ends", suites=("fish",))
class Hermite(_Interpolation):
    """``x(s) = (2 s³ - 3 s² + 1) a + (s³ - 2 s² + s) T v + (3 s² - 2 s³) b + (s³ - s²) T w`` with s = t / T."""

    Parameters = VelocityParameters

    def __init__(self, parameters: VelocityParameters, rng: np.random.Generator) -> None:
        self._over_frames = parameters.over_frames

    def interpolate(self, past: Piece, future: Piece, around: Surroundings) -> Bridge:
        """See ``GapMethod``."""
        (a, v), (b, w), s, T = _ends(past, future, self._over_frames)
        towards_b = (3 * s**2 - 2 * s**3) * b + (s**3 - s**2) * T * w
        return Bridge((2 * s**3 - 3 * s**2 + 1) * a + (s**3 - 2 * s**2 + s) * T * v + towards_b)


_End = tuple[NDArray[np.float64], NDArray[np.float64]]


def _ends(past: Piece, future: Piece, over_frames: int) -> tuple[_End, _End, NDArray[np.float64], int]:
    """Return position and velocity at both ends, the lost frames' shares (G, 1) of the time between, and that time."""
    a, v, since = last_state(past, over_frames)
    b, back, until = last_state(reversed_in_time(future), over_frames)
    count = future.first_frame - past.end_frame
    T = since + count + until + 1
    return (a, v), (b, -back), ((since + np.arange(1, count + 1)) / T)[:, None], T
