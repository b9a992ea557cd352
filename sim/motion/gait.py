"""Gait of people: poses of all parts of a body at a phase of the stride, at any speed from standing still.

The feet are placed first. A foot on the ground rolls over heel, ball and tip without sliding at any speed; in the air
it swings. Pelvis and trunk follow the speed; thigh and shin connect hip and foot in one plane. So no foot slides, and
the angles of hip, knee and ankle agree within some degrees with the literature (Winter, "The biomechanics and motor
control of human gait", 1991, natural cadence).

Phases are those of the left leg: 0 is the contact of its heel, the right one's comes half a stride later.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import PchipInterpolator

from sim.checks import check
from sim.motion.skeleton import PART_NAMES, Skeleton
from sim.render.compilation import announce_compilation

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


WALK_RATIO_M = 0.0064 * 60.0
"""Step length over steps a second: 0.0064 m per step/min at all usual speeds (Sekiya and Nagasaki 1998)."""
USUAL_STATURE_M = 1.72
"""Stature of the people in that study; strides are proportional to it."""
LONGEST_STRIDE = 1.05
"""Longest stride, share of stature."""
USUAL_STRIDE = 0.82
"""Share of stature of the stride at 1.3 m/s, whose angles the numbers below are."""

_REACH = 0.9988
"""Greatest distance from hip to ankle over that of a straight leg: the knee keeps 6° (Winter: 4° to 5°)."""
_REACH_SAMPLES = 32
_BOB = 0.0093
"""Amplitude of the pelvis' way up and down at usual speed, share of stature."""
_LOWEST = 0.055
"""Share of the stride at which the pelvis is lowest."""


def stride_length_m(stature_m: float, speed_mps: float) -> float:
    """Return the length of two steps: ``2 sqrt(walk ratio * speed)``, in proportion to stature.

    1.40 m at 1.3 m/s for a stature of 1.70 m; the walk ratio of slow walkers is somewhat greater in truth.

    Raises:
        ValueError: for a speed < 0.
    """
    check("speed_mps", speed_mps >= 0, "a speed >= 0 m/s", speed_mps)
    return float(stride_lengths_m(stature_m, speed_mps))


def stride_lengths_m(stature_m: ArrayLike, speed_mps: ArrayLike) -> NDArray[np.float64]:
    """Return ``stride_length_m`` of many, unchecked."""
    stature, speed = np.asarray(stature_m, float), np.asarray(speed_mps, float)
    free_m = 2.0 * np.sqrt(WALK_RATIO_M * speed) * stature / USUAL_STATURE_M
    return np.minimum(free_m, LONGEST_STRIDE * stature)


def phase_rate_radps(stature_m: float, speed_mps: float) -> float:
    """Return the rate of the phase: ``2 pi speed / stride_length_m``; 0 when standing still."""
    stride_m = stride_length_m(stature_m, speed_mps)
    return 2.0 * np.pi * speed_mps / stride_m if stride_m > 0.0 else 0.0


def part_poses(
    bones: Skeleton, T_world_person: NDArray[np.float64], phase_rad: float, speed_mps: float
) -> NDArray[np.float64]:
    """Return T_world_part (P, 4, 4) of a walking person's parts, in the order of ``PART_NAMES``.

    At speed 0 the person stands, whatever the phase. A stance foot stays in place while the person moves straight on at
    ``speed_mps`` and the phase advances at ``phase_rate_radps``.

    Args:
        T_world_person: (4, 4) on the ground under the pelvis, x ahead, y left, z up.
        phase_rad: of the stride, 0 = contact of the left heel, pi = of the right one.
        speed_mps: >= 0.
    """
    announce_compilation(_place_parts)
    poses = np.zeros((len(PART_NAMES), 4, 4))
    poses[:, 3, 3] = 1.0
    stride_m = stride_length_m(bones.stature, speed_mps)
    _place_parts(bones, phase_rad / (2.0 * np.pi), stride_m, poses)
    return np.asarray(T_world_person, dtype=float) @ poses


@njit(cache=True)
def _pelvis_motion(bones: Skeleton, share: float, size: float) -> tuple[float, float, float, float]:
    """Return the pelvis' offset to the left and up from its mean, and its rotations about z and x, radians.

    Up and down by 3 cm twice a stride, lowest while both feet are on the ground; 2 cm to the side of the foot that
    stands; the hip of the leading leg 4° forward; the hip of the swinging leg 3.5° down. (Sizes and phases at usual
    speed after Inman, Ralston and Todd, "Human walking", 1981.)
    """
    turn = 2.0 * np.pi * share
    left = 0.012 * bones.stature * size * np.cos(turn - 2.0 * np.pi * 0.3)
    up = -_BOB * bones.stature * size * np.cos(2.0 * (turn - 2.0 * np.pi * _LOWEST))
    yaw = -np.deg2rad(4.0) * size * np.cos(turn)
    roll = np.deg2rad(3.5) * size * np.cos(turn - 2.0 * np.pi * 0.2)
    return left, up, yaw, roll


@njit(cache=True)
def _turned(about_x: float, about_y: float, about_z: float) -> NDArray[np.float64]:
    """Return R_z R_x R_y (3, 3)."""
    cx, sx = np.cos(about_x), np.sin(about_x)
    cy, sy = np.cos(about_y), np.sin(about_y)
    cz, sz = np.cos(about_z), np.sin(about_z)
    result = np.empty((3, 3))
    result[0, 0], result[0, 1], result[0, 2] = cz * cy - sz * sx * sy, -sz * cx, cz * sy + sz * sx * cy
    result[1, 0], result[1, 1], result[1, 2] = sz * cy + cz * sx * sy, cz * cx, sz * sy - cz * sx * cy
    result[2, 0], result[2, 1], result[2, 2] = -cx * sy, sx, cx * cy
    return result


@njit(cache=True)
def _pelvis_height(bones: Skeleton, stride: float, size: float) -> float:
    """Return the greatest mean height of the pelvis at which the left leg reaches its foot at every phase."""
    reach = _REACH * (bones.thigh + bones.shin)
    height = 10.0
    for k in range(_REACH_SAMPLES):
        share = k / _REACH_SAMPLES
        x, z, ahead, _ = ankle_at(bones, share, stride, size)
        left, up, yaw, roll = _pelvis_motion(bones, share, size)
        hip = _turned(roll, 0.0, yaw)[:, 1] * bones.half_hips
        across = bones.half_track + ahead * np.sin(TOE_OUT_RAD) - hip[1] - left
        height = min(height, z + np.sqrt(reach**2 - (x - hip[0]) ** 2 - across**2) - hip[2] - up)
    return height


@njit(cache=True)
def _put(poses: NDArray[np.float64], part: int, R: NDArray[np.float64], place: NDArray[np.float64]) -> None:
    """Write one pose except its last row."""
    for i in range(3):
        poses[part, i, 3] = place[i]
        for j in range(3):
            poses[part, i, j] = R[i, j]


@njit(cache=True)
def _place_parts(bones: Skeleton, phase: float, stride: float, poses: NDArray[np.float64]) -> None:
    """Write the poses (P, 4, 4) in the person's frame; ``phase`` counts strides."""
    share = phase - np.floor(phase)
    size = stride / (USUAL_STRIDE * bones.stature)
    left, up, yaw, roll = _pelvis_motion(bones, share, size)
    pelvis = np.array([0.0, left, _pelvis_height(bones, stride, size) + up])
    R_pelvis = _turned(roll, 0.0, yaw)
    _put(poses, 0, R_pelvis, pelvis)
    for leg in range(2):
        side = 1.0 - 2.0 * leg
        own = share + 0.5 * leg
        _place_leg(bones, side, own - np.floor(own), stride, size, pelvis, R_pelvis, poses[7 + 3 * leg : 10 + 3 * leg])
    waist = pelvis + R_pelvis[:, 2] * bones.pelvis
    wave = np.cos(2.0 * np.pi * share)
    R_torso = _turned(0.2 * roll, np.deg2rad(2.0 + 2.0 * size), np.deg2rad(4.0) * size * wave)
    _put(poses, 1, R_torso, waist)
    _put(poses, 2, _turned(0.0, np.deg2rad(1.0), np.deg2rad(1.0) * size * wave), waist + R_torso[:, 2] * bones.neck)
    for arm in range(2):
        side = 1.0 - 2.0 * arm
        shoulder = waist + R_torso[:, 1] * (side * bones.half_shoulders) + R_torso[:, 2] * bones.shoulder
        _place_arm(bones, side, side * wave, size, shoulder, R_torso, poses[3 + 2 * arm : 5 + 2 * arm])


@njit(cache=True)
def _place_leg(
    bones: Skeleton,
    side: float,
    share: float,
    stride: float,
    size: float,
    pelvis: NDArray[np.float64],
    R_pelvis: NDArray[np.float64],
    poses: NDArray[np.float64],
) -> None:
    """Write the poses (3, 4, 4) of thigh, shin and foot: two bones in the plane of hip, ankle and straight ahead."""
    x, z, ahead, pitch = ankle_at(bones, share, stride, size)
    ankle = np.array([x, side * (bones.half_track + ahead * np.sin(TOE_OUT_RAD)), z])
    hip = pelvis + R_pelvis[:, 1] * (side * bones.half_hips)
    dx, dy, dz = ankle[0] - hip[0], ankle[1] - hip[1], ankle[2] - hip[2]
    down = np.sqrt(dy**2 + dz**2)
    distance = min(np.sqrt(dx**2 + down**2), 0.99999 * (bones.thigh + bones.shin))
    lean, forward = np.arctan2(dy, -dz), np.arctan2(dx, down)
    at_hip = np.arccos((bones.thigh**2 + distance**2 - bones.shin**2) / (2.0 * bones.thigh * distance))
    at_ankle = np.arccos((bones.shin**2 + distance**2 - bones.thigh**2) / (2.0 * bones.shin * distance))
    R_thigh = _turned(lean, -forward - at_hip, 0.0)
    _put(poses, 0, R_thigh, hip)
    _put(poses, 1, _turned(lean, at_ankle - forward, 0.0), hip - R_thigh[:, 2] * bones.thigh)
    _put(poses, 2, _turned(0.0, -pitch, side * TOE_OUT_RAD), ankle)


@njit(cache=True)
def _place_arm(
    bones: Skeleton,
    side: float,
    wave: float,
    size: float,
    shoulder: NDArray[np.float64],
    R_torso: NDArray[np.float64],
    poses: NDArray[np.float64],
) -> None:
    """Write the poses (2, 4, 4) of upper arm and forearm: back by 22° when the leg of its side is ahead, forward by 10°
    half a stride later, the elbow bent by 18° and 40° (Murray, Sepic and Barnard 1967, at usual speed); 12° standing.

    Args:
        wave: 1 when the leg of its side meets the ground, -1 half a stride later.
    """
    swing = np.deg2rad(-2.0 - (4.0 + 16.0 * wave) * size)
    elbow = np.deg2rad(12.0 + (17.0 - 11.0 * wave) * size)
    R_upper = R_torso @ _turned(side * np.deg2rad(5.5), -swing, 0.0)
    _put(poses, 0, R_upper, shoulder)
    R_fore = R_upper @ _turned(-side * np.deg2rad(4.0), -elbow, 0.0)
    _put(poses, 1, R_fore, shoulder - R_upper[:, 2] * bones.upper_arm)
