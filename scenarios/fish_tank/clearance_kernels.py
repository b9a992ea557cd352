"""Bodies keep clear of each other and of walls, floor and surface: kernels of ``scenarios.fish_tank.shoal``.

Seen from above a body is a chain of segments with a half width at each end; upright it reaches as far as its fins at
the middle or end. Where two of them come nearer than the sum w of their widths, at a distance r from axis to axis, they
must differ in height by ``(h_1 + h_2) sqrt(1 - (r / w)^2)``: elliptic cross sections then touch at most.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.meshes.fish import half_size
from sim.motion.swim import SEGMENT_COUNT, SEGMENT_ENDS, place_segments

_HALF_WIDTH, _HALF_HEIGHT = half_size(np.array(SEGMENT_ENDS))
_HALF_WIDTH = 1.15 * _HALF_WIDTH + 0.01
_HALF_HEIGHT = 1.05 * _HALF_HEIGHT
"""At the ends of the segments, shares of length; the width is that of the broadest fish, with room for water."""
_TALLEST = float(_HALF_HEIGHT.max())
_GIVING_WAY_S = 0.5
"""Fish see a meeting this long ahead."""
_GIVING_WAY_MPS2 = 0.35
_ROUNDS = 40


@njit(cache=True)
def yielding_mps2(
    length_m: NDArray[np.float64], position_m: NDArray[np.float64], velocity_mps: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the upward acceleration (N,) by which fish give way to those whom they will soon meet at their depth."""
    count = length_m.shape[0]
    yielding = np.zeros(count)
    for i in range(count):
        for j in range(i):
            reach_m = 0.45 * (length_m[i] + length_m[j])
            clear_m = 1.15 * _TALLEST * (length_m[i] + length_m[j])
            rise_m = position_m[i, 2] - position_m[j, 2]
            x, y = position_m[i, 0] - position_m[j, 0], position_m[i, 1] - position_m[j, 1]
            if abs(rise_m) > clear_m or x * x + y * y > 16.0 * reach_m * reach_m:
                continue
            u, v = velocity_mps[i, 0] - velocity_mps[j, 0], velocity_mps[i, 1] - velocity_mps[j, 1]
            time_s = min(max(-(x * u + y * v) / (u * u + v * v + 1e-9), 0.0), _GIVING_WAY_S)
            nearest_m = np.hypot(x + u * time_s, y + v * time_s)
            if nearest_m < reach_m:
                push = _GIVING_WAY_MPS2 * (1.0 - abs(rise_m) / clear_m) * (1.0 - nearest_m / reach_m)
                push = push if rise_m >= 0.0 else -push
                yielding[i] += push
                yielding[j] -= push
    return yielding


@njit(cache=True)
def keep_inside(
    length_m: NDArray[np.float64],
    position_m: NDArray[np.float64],
    yaw_rad: NDArray[np.float64],
    pitch_rad: NDArray[np.float64],
    joints_rad: NDArray[np.float64],
    size_m: NDArray[np.float64],
) -> None:
    """Move every fish back into the water, by as much as its body reaches beyond the walls."""
    axis_m = np.empty((SEGMENT_COUNT + 1, 3))
    for n in range(length_m.shape[0]):
        _axis_points(length_m[n], position_m[n], yaw_rad[n], pitch_rad[n], joints_rad[n], axis_m)
        for axis in range(2):
            over, under = 0.0, 0.0
            for k in range(SEGMENT_COUNT + 1):
                width_m = _HALF_WIDTH[k] * length_m[n]
                over = max(over, axis_m[k, axis] + width_m - 0.5 * size_m[axis])
                under = max(under, -0.5 * size_m[axis] - axis_m[k, axis] + width_m)
            position_m[n, axis] += under - over
        _keep_in_depth(n, length_m, position_m, pitch_rad, size_m)


@njit(cache=True)
def _reach_m(length_m: float, pitch_rad: float) -> float:
    """Return a bound of how far a body reaches above and below its position."""
    return (_TALLEST + 0.5 * abs(np.sin(pitch_rad))) * length_m


@njit(cache=True)
def _keep_in_depth(
    n: int,
    length_m: NDArray[np.float64],
    position_m: NDArray[np.float64],
    pitch_rad: NDArray[np.float64],
    size_m: NDArray[np.float64],
) -> None:
    reach_m = _reach_m(length_m[n], pitch_rad[n])
    position_m[n, 2] = min(max(position_m[n, 2], reach_m), size_m[2] - reach_m)


@njit(cache=True)
def keep_apart(
    length_m: NDArray[np.float64],
    position_m: NDArray[np.float64],
    yaw_rad: NDArray[np.float64],
    pitch_rad: NDArray[np.float64],
    joints_rad: NDArray[np.float64],
    size_m: NDArray[np.float64],
) -> None:
    """Move fish whose bodies penetrate apart, up and down, until none do (at most ``_ROUNDS`` times)."""
    count = length_m.shape[0]
    axes_m = np.empty((count, SEGMENT_COUNT + 1, 3))
    for n in range(count):
        _axis_points(length_m[n], position_m[n], yaw_rad[n], pitch_rad[n], joints_rad[n], axes_m[n])
    for _ in range(_ROUNDS):
        moved = False
        for i in range(count):
            for j in range(i):
                reach_m = 0.55 * (length_m[i] + length_m[j])
                x, y = position_m[i, 0] - position_m[j, 0], position_m[i, 1] - position_m[j, 1]
                if x * x + y * y > reach_m * reach_m:
                    continue
                tall_m = _reach_m(length_m[i], pitch_rad[i]) + _reach_m(length_m[j], pitch_rad[j])
                if abs(position_m[i, 2] - position_m[j, 2]) > tall_m:
                    continue
                upper, lower = (i, j) if position_m[i, 2] >= position_m[j, 2] else (j, i)
                missing_m = _missing_rise(axes_m[upper], axes_m[lower], length_m[upper], length_m[lower])
                if missing_m > 0.0:
                    moved = True
                    _shift(upper, 0.51 * missing_m, axes_m, length_m, position_m, pitch_rad, size_m)
                    _shift(lower, -0.51 * missing_m, axes_m, length_m, position_m, pitch_rad, size_m)
        if not moved:
            break


@njit(cache=True)
def _shift(
    n: int,
    rise_m: float,
    axes_m: NDArray[np.float64],
    length_m: NDArray[np.float64],
    position_m: NDArray[np.float64],
    pitch_rad: NDArray[np.float64],
    size_m: NDArray[np.float64],
) -> None:
    """Move one fish up, as far as there is water."""
    before_m = position_m[n, 2]
    position_m[n, 2] += rise_m
    _keep_in_depth(n, length_m, position_m, pitch_rad, size_m)
    axes_m[n, :, 2] += position_m[n, 2] - before_m


@njit(cache=True)
def _axis_points(
    length_m: float,
    position_m: NDArray[np.float64],
    yaw_rad: float,
    pitch_rad: float,
    joints_rad: NDArray[np.float64],
    axis_m: NDArray[np.float64],
) -> None:
    """Write the ends (S + 1, 3) of a fish's segments."""
    ends_xy, yaws = np.empty((SEGMENT_COUNT + 1, 2)), np.empty(SEGMENT_COUNT)
    place_segments(length_m, joints_rad, ends_xy, yaws)
    c, s, level, rise = np.cos(yaw_rad), np.sin(yaw_rad), np.cos(pitch_rad), np.sin(pitch_rad)
    for k in range(SEGMENT_COUNT + 1):
        ahead, left = ends_xy[k, 0], ends_xy[k, 1]
        axis_m[k, 0] = position_m[0] + level * c * ahead - s * left
        axis_m[k, 1] = position_m[1] + level * s * ahead + c * left
        axis_m[k, 2] = position_m[2] + rise * ahead


@njit(cache=True)
def _missing_rise(
    upper_m: NDArray[np.float64], lower_m: NDArray[np.float64], upper_length_m: float, lower_length_m: float
) -> float:
    """Return how much farther above the lower body the upper one must be, negative if it could be nearer."""
    missing = -1e9
    for a in range(SEGMENT_COUNT):
        for b in range(SEGMENT_COUNT):
            s, t, distance_m = _nearest(upper_m[a], upper_m[a + 1], lower_m[b], lower_m[b + 1])
            width = upper_length_m * (_HALF_WIDTH[a] + s * (_HALF_WIDTH[a + 1] - _HALF_WIDTH[a]))
            width += lower_length_m * (_HALF_WIDTH[b] + t * (_HALF_WIDTH[b + 1] - _HALF_WIDTH[b]))
            if distance_m >= width:
                continue
            height = upper_length_m * max(_HALF_HEIGHT[a], _HALF_HEIGHT[a + 1])
            height += lower_length_m * max(_HALF_HEIGHT[b], _HALF_HEIGHT[b + 1])
            rise = upper_m[a, 2] + s * (upper_m[a + 1, 2] - upper_m[a, 2])
            rise -= lower_m[b, 2] + t * (lower_m[b + 1, 2] - lower_m[b, 2])
            missing = max(missing, height * np.sqrt(1.0 - (distance_m / width) ** 2) - rise)
    return missing


@njit(cache=True)
def _nearest(
    p: NDArray[np.float64], q: NDArray[np.float64], r: NDArray[np.float64], u: NDArray[np.float64]
) -> tuple[float, float, float]:
    """Return the shares along two segments, seen from above, where they are nearest, and the distance there."""
    ax, ay, bx, by = q[0] - p[0], q[1] - p[1], u[0] - r[0], u[1] - r[1]
    cx, cy = p[0] - r[0], p[1] - r[1]
    aa, bb, ab = ax * ax + ay * ay, bx * bx + by * by, ax * bx + ay * by
    ac, bc = ax * cx + ay * cy, bx * cx + by * cy
    crossing = aa * bb - ab * ab
    s = min(max((ab * bc - bb * ac) / crossing, 0.0), 1.0) if crossing > 1e-12 * aa * bb else 0.0
    t = (ab * s + bc) / bb
    if t < 0.0 or t > 1.0:
        t = min(max(t, 0.0), 1.0)
        s = min(max((ab * t - ac) / aa, 0.0), 1.0)
    return s, t, np.hypot(cx + s * ax - t * bx, cy + s * ay - t * by)
