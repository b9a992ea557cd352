"""Places of a walking person's feet: rolling over heel, ball and tip on the ground, swinging in the air."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from sim.motion.skeleton import Skeleton

STANCE = 0.62
"""Share of the stride for which a foot is on the ground."""
_AHEAD = 0.239
"""Share of the stride by which the ankle is ahead of the hips when the heel meets the ground (with a flat sole)."""
_CLEARANCE = 0.011
"""Of the sole in the middle of its swing, share of stature: 2 cm (Winter 1992 measured 1.3 cm under the toe)."""
_LANDING = 0.23
"""Speed of the foot before its heel meets the ground, of that with which it is on the ground afterwards."""
TOE_OUT_RAD = np.deg2rad(6.0)


def _foot_pitch() -> NDArray[np.float64]:
    """Return the sole's angle (257,), toe up, radians, at 256 phases of its leg and again at the first one.

    Chosen after Winter 1991: 20° at contact, flat from 8 % to 30 %, the heel up until the toe leaves the ground
    at 62 %, level again in mid swing. The shoe has no joint at the ball, so its heel is raised less than a real one's.
    """
    percent = np.array([0, 3, 8, 30, 36, 43, 50, 56, 62, 67, 72, 79, 85, 91, 96, 100.0])
    degrees = np.array([20, 12, 0, 0, -3, -9, -19, -33, -49, -55, -50, -30, -9, 9, 19, 20.0])
    before, after = slice(-4, -1), slice(1, 4)
    interpolate = PchipInterpolator(
        np.concatenate([percent[before] - 100, percent, percent[after] + 100]),
        np.concatenate([degrees[before], degrees, degrees[after]]),
    )
    return np.deg2rad(interpolate(np.linspace(0.0, 100.0, 257)))


_FOOT_PITCH = _foot_pitch()


@njit(cache=True)
def _sole_point(bones: Skeleton, pitch: float) -> tuple[float, float, float]:
    """Return x and z of the point of the sole that touches the ground at a pitch, in the foot's frame, and its
    distance along the sole from the heel.
    """
    spring_m = np.sqrt((bones.toe - bones.ball) ** 2 + bones.toe_rise**2)
    if pitch > 0.0:
        return -bones.heel, -bones.ankle, 0.0
    if np.sin(pitch) >= -bones.toe_rise / spring_m:
        return bones.ball, -bones.ankle, bones.heel + bones.ball
    return bones.toe, bones.toe_rise - bones.ankle, bones.heel + bones.ball + spring_m


@njit(cache=True)
def _pitch(share: float, size: float) -> float:
    """Return the sole's angle at a share in [0, 1] of its leg's stride."""
    at = 256.0 * share
    k = min(int(at), 255)
    return size * (_FOOT_PITCH[k] + (at - k) * (_FOOT_PITCH[k + 1] - _FOOT_PITCH[k]))


@njit(cache=True)
def _rolling(bones: Skeleton, pitch: float) -> tuple[float, float]:
    """Return how far ahead of its place over the flat sole the ankle is, and its height, of a foot on the ground.

    The touching point c lies on the ground at its distance s along the sole: ``ankle = s - R(pitch) c``.
    """
    x, z, along = _sole_point(bones, pitch)
    c, s = np.cos(pitch), np.sin(pitch)
    return along - bones.heel - (x * c - z * s), -(x * s + z * c)


@njit(cache=True)
def _greater(a: float, b: float, softness: float) -> float:
    """Return the greater of two lengths, without a kink where they cross."""
    return 0.5 * (a + b + np.sqrt((a - b) ** 2 + softness**2))


@njit(cache=True)
def ankle_at(bones: Skeleton, share: float, stride: float, size: float) -> tuple[float, float, float, float]:
    """Return x and z of an ankle in the person's frame, the rolled distance from the place of the flat sole, and the
    pitch of the sole.

    On the ground: rolling, while the ground moves back by one stride length per stride. In the air: a cubic that joins
    places and velocities at both ends, as high as the lowest point of the sole requires.

    Args:
        share: of the leg's stride since its heel met the ground, in [0, 1].
        size: factor of the angles.
    """
    pitch = _pitch(share, size)
    start = _AHEAD * stride
    if share <= STANCE:
        ahead, z = _rolling(bones, pitch)
        return start - stride * share + ahead, z, ahead, pitch
    step = 1e-3
    t = (share - STANCE) / (1.0 - STANCE)
    off, _ = _rolling(bones, _pitch(STANCE, size))
    off_before, _ = _rolling(bones, _pitch(STANCE - step, size))
    on, _ = _rolling(bones, _pitch(0.0, size))
    on_after, _ = _rolling(bones, _pitch(step, size))
    x0, x1 = start - stride * STANCE + off, start + on
    v0 = (1.0 - STANCE) * ((off - off_before) / step - stride)
    v1 = (1.0 - STANCE) * _LANDING * ((on_after - on) / step - stride)
    x = (2 * t**3 - 3 * t**2 + 1) * x0 + (t**3 - 2 * t**2 + t) * v0 + (3 * t**2 - 2 * t**3) * x1 + (t**3 - t**2) * v1
    middle = np.sin(np.pi * t) ** 2
    c, s = np.cos(pitch), np.sin(pitch)
    heel = bones.heel * s + bones.ankle * c
    ball = -bones.ball * s + bones.ankle * c
    tip = -bones.toe * s + (bones.ankle - bones.toe_rise) * c
    softness = 0.02 * bones.stature * middle * size
    z = _greater(heel, _greater(ball, tip, softness), softness) + _CLEARANCE * bones.stature * size * middle
    return x, z, off + (on - off) * t * t * (3.0 - 2.0 * t), pitch
