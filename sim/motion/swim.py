"""Bodies of fish that swim: poses of the segments of a chain, and the centre line through them.

A fish is a chain of rigid segments from snout to tail fin. The segment that holds the middle of the body has the fish's
yaw and pitch; all others hang on it by joints that turn about the body's own upright axis.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.checks import check
from sim.render.compilation import announce_compilation

SEGMENT_ENDS = (0.0, 0.20, 0.32, 0.43, 0.53, 0.63, 0.73, 0.83, 1.0)
"""Where the segments begin and end, shares of the fish's length behind the snout; joints lie between two of them."""
SEGMENT_COUNT = len(SEGMENT_ENDS) - 1
JOINT_COUNT = SEGMENT_COUNT - 1
MIDDLE = 0.5
"""Place of the fish's position on its centre line, share of its length."""
CENTRE_LINE_POINTS = 9

_ENDS = np.array(SEGMENT_ENDS)
_MIDDLE_SEGMENT = int(np.searchsorted(_ENDS, MIDDLE)) - 1
_POINTS = np.linspace(0.0, 1.0, CENTRE_LINE_POINTS)


class SwimPose(NamedTuple):
    """Where the bodies of N fish are.

    Attributes:
        T_world_segment: (N, S, 4, 4) from head to tail. A segment's frame has its origin at its front end, x ahead
            along it, y left and z up.
        centre_line_m: (N, 9, 3) points on the axes of the segments at equal distances along them, snout to tail.
    """

    T_world_segment: NDArray[np.float64]
    centre_line_m: NDArray[np.float64]


def swim_pose(
    length_m: NDArray[np.float64],
    position_m: NDArray[np.float64],
    yaw_rad: NDArray[np.float64],
    pitch_rad: NDArray[np.float64],
    joints_rad: NDArray[np.float64],
) -> SwimPose:
    """Return the poses of N fish.

    Args:
        length_m: (N,) from snout to the end of the tail fin, > 0.
        position_m: (N, 3) of the middle of the centre line.
        yaw_rad: (N,) of the middle segment, counter-clockwise from world x seen from above.
        pitch_rad: (N,) of the whole fish, positive with the snout up.
        joints_rad: (N, S - 1) from head to tail: yaw of the segment before a joint less that of the one behind it; a
            fish with all of them positive is bent to its left at both ends.

    Raises:
        ValueError: if the shapes do not fit.
    """
    count = len(length_m)
    check("position_m", position_m.shape == (count, 3), f"shape {(count, 3)}", position_m.shape)
    check("yaw_rad", yaw_rad.shape == (count,), f"shape {(count,)}", yaw_rad.shape)
    check("pitch_rad", pitch_rad.shape == (count,), f"shape {(count,)}", pitch_rad.shape)
    check("joints_rad", joints_rad.shape == (count, JOINT_COUNT), f"shape {(count, JOINT_COUNT)}", joints_rad.shape)
    announce_compilation(_place_fish)
    poses = np.zeros((count, SEGMENT_COUNT, 4, 4))
    line_m = np.empty((count, CENTRE_LINE_POINTS, 3))
    _place_fish(length_m, position_m, yaw_rad, pitch_rad, joints_rad, poses, line_m)
    return SwimPose(poses, line_m)


@njit(cache=True)
def _place_fish(
    length_m: NDArray[np.float64],
    position_m: NDArray[np.float64],
    yaw_rad: NDArray[np.float64],
    pitch_rad: NDArray[np.float64],
    joints_rad: NDArray[np.float64],
    poses: NDArray[np.float64],
    line_m: NDArray[np.float64],
) -> None:
    """Write the poses (N, S, 4, 4), zeros before, and centre lines (N, 9, 3) of all fish."""
    ends_xy, yaws = np.empty((SEGMENT_COUNT + 1, 2)), np.empty(SEGMENT_COUNT)
    for n in range(length_m.shape[0]):
        place_segments(length_m[n], joints_rad[n], ends_xy, yaws)
        R = _body_axes(yaw_rad[n], pitch_rad[n])
        for k in range(SEGMENT_COUNT):
            c, s = np.cos(yaws[k]), np.sin(yaws[k])
            for axis in range(3):
                ahead, left = R[axis, 0], R[axis, 1]
                poses[n, k, axis, 0] = ahead * c + left * s
                poses[n, k, axis, 1] = left * c - ahead * s
                poses[n, k, axis, 2] = R[axis, 2]
                poses[n, k, axis, 3] = position_m[n, axis] + ahead * ends_xy[k, 0] + left * ends_xy[k, 1]
            poses[n, k, 3, 3] = 1.0
        _write_line(ends_xy, R, position_m[n], line_m[n])


@njit(cache=True)
def place_segments(
    length_m: float, joints_rad: NDArray[np.float64], ends_xy: NDArray[np.float64], yaws: NDArray[np.float64]
) -> None:
    """Write the ends (S + 1, 2) of a fish's segments, snout to tail, and their yaws (S,), in its own frame.

    The frame lies at the middle of the centre line, x along the middle segment:
    ``yaw[k] = yaw[k + 1] + joint[k]``, ``end[k] = end[k + 1] + length[k] (cos yaw[k], sin yaw[k])``.
    """
    yaws[_MIDDLE_SEGMENT] = 0.0
    for k in range(_MIDDLE_SEGMENT - 1, -1, -1):
        yaws[k] = yaws[k + 1] + joints_rad[k]
    for k in range(_MIDDLE_SEGMENT + 1, SEGMENT_COUNT):
        yaws[k] = yaws[k - 1] - joints_rad[k - 1]
    ends_xy[_MIDDLE_SEGMENT, 0] = (MIDDLE - _ENDS[_MIDDLE_SEGMENT]) * length_m
    ends_xy[_MIDDLE_SEGMENT, 1] = 0.0
    for k in range(_MIDDLE_SEGMENT - 1, -1, -1):
        long_m = (_ENDS[k + 1] - _ENDS[k]) * length_m
        ends_xy[k, 0] = ends_xy[k + 1, 0] + long_m * np.cos(yaws[k])
        ends_xy[k, 1] = ends_xy[k + 1, 1] + long_m * np.sin(yaws[k])
    for k in range(_MIDDLE_SEGMENT, SEGMENT_COUNT):
        long_m = (_ENDS[k + 1] - _ENDS[k]) * length_m
        ends_xy[k + 1, 0] = ends_xy[k, 0] - long_m * np.cos(yaws[k])
        ends_xy[k + 1, 1] = ends_xy[k, 1] - long_m * np.sin(yaws[k])


@njit(cache=True)
def _body_axes(yaw_rad: float, pitch_rad: float) -> NDArray[np.float64]:
    """Return R_z(yaw) R_y(-pitch) (3, 3): ahead, left and up as columns."""
    c, s = np.cos(yaw_rad), np.sin(yaw_rad)
    level, rise = np.cos(pitch_rad), np.sin(pitch_rad)
    R = np.empty((3, 3))
    R[0, 0], R[1, 0], R[2, 0] = c * level, s * level, rise
    R[0, 1], R[1, 1], R[2, 1] = -s, c, 0.0
    R[0, 2], R[1, 2], R[2, 2] = -c * rise, -s * rise, level
    return R


@njit(cache=True)
def _write_line(
    ends_xy: NDArray[np.float64], R: NDArray[np.float64], position_m: NDArray[np.float64], line_m: NDArray[np.float64]
) -> None:
    """Write the points (9, 3) of the centre line."""
    k = 0
    for n in range(CENTRE_LINE_POINTS):
        while k < SEGMENT_COUNT - 1 and _ENDS[k + 1] < _POINTS[n]:
            k += 1
        share = (_POINTS[n] - _ENDS[k]) / (_ENDS[k + 1] - _ENDS[k])
        x = ends_xy[k, 0] + share * (ends_xy[k + 1, 0] - ends_xy[k, 0])
        y = ends_xy[k, 1] + share * (ends_xy[k + 1, 1] - ends_xy[k, 1])
        for axis in range(3):
            line_m[n, axis] = position_m[axis] + R[axis, 0] * x + R[axis, 1] * y
