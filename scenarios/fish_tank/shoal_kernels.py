"""The kernels of ``scenarios.fish_tank.shoal``: one step of a shoal."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scenarios.fish_tank.presets import Character
from sim.meshes.fish import half_size
from sim.motion.swim import JOINT_COUNT, SEGMENT_COUNT, SEGMENT_ENDS, place_segments

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
    length_m: NDArray[np.float64],
    height_m: NDArray[np.float64],
    position_m: NDArray[np.float64],
    velocity_mps: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return the upward acceleration (N,) by which fish avoid others that they will soon meet at their depth.

    Args:
        height_m: (N,) lengths times factors of height, here and below: those of fish as high as zebrafish are lengths.
    """
    count = length_m.shape[0]
    yielding = np.zeros(count)
    for i in range(count):
        for j in range(i):
            reach_m = 0.45 * (length_m[i] + length_m[j])
            clear_m = 1.15 * _TALLEST * (height_m[i] + height_m[j])
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
    height_m: NDArray[np.float64],
    position_m: NDArray[np.float64],
    yaw_rad: NDArray[np.float64],
    pitch_rad: NDArray[np.float64],
    joints_rad: NDArray[np.float64],
    size_m: NDArray[np.float64],
    is_round: bool,
) -> None:
    """Move every fish back into the water, by as much as its body reaches beyond the walls."""
    axis_m = np.empty((SEGMENT_COUNT + 1, 3))
    for n in range(length_m.shape[0]):
        _axis_points(length_m[n], position_m[n], yaw_rad[n], pitch_rad[n], joints_rad[n], axis_m)
        if is_round:
            _keep_in_circle(n, length_m, position_m, axis_m, 0.5 * size_m[0])
        for axis in range(2):
            over, under = 0.0, 0.0
            for k in range(SEGMENT_COUNT + 1):
                width_m = _HALF_WIDTH[k] * length_m[n]
                over = max(over, axis_m[k, axis] + width_m - 0.5 * size_m[axis])
                under = max(under, -0.5 * size_m[axis] - axis_m[k, axis] + width_m)
            position_m[n, axis] += under - over
        _keep_in_depth(n, length_m, height_m, position_m, pitch_rad, size_m)


@njit(cache=True)
def _keep_in_circle(
    n: int,
    length_m: NDArray[np.float64],
    position_m: NDArray[np.float64],
    axis_m: NDArray[np.float64],
    radius_m: float,
) -> None:
    """Move a fish towards the axis of a round tank, by as much as it reaches beyond the wall."""
    for _ in range(3):
        most, worst = 0.0, -1
        for k in range(SEGMENT_COUNT + 1):
            over = np.hypot(axis_m[k, 0], axis_m[k, 1]) + _HALF_WIDTH[k] * length_m[n] - radius_m
            if over > most:
                most, worst = over, k
        if worst < 0:
            return
        away = np.hypot(axis_m[worst, 0], axis_m[worst, 1])
        for axis in range(2):
            step = most * axis_m[worst, axis] / away
            position_m[n, axis] -= step
            axis_m[:, axis] -= step


@njit(cache=True)
def _reach_m(length_m: float, height_m: float, pitch_rad: float) -> float:
    """Return a bound of how far a body reaches above and below its position."""
    return (_TALLEST * (height_m / length_m) + 0.5 * abs(np.sin(pitch_rad))) * length_m


@njit(cache=True)
def _keep_in_depth(
    n: int,
    length_m: NDArray[np.float64],
    height_m: NDArray[np.float64],
    position_m: NDArray[np.float64],
    pitch_rad: NDArray[np.float64],
    size_m: NDArray[np.float64],
) -> None:
    reach_m = _reach_m(length_m[n], height_m[n], pitch_rad[n])
    position_m[n, 2] = min(max(position_m[n, 2], reach_m), size_m[2] - reach_m)


@njit(cache=True)
def keep_apart(
    length_m: NDArray[np.float64],
    height_m: NDArray[np.float64],
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
                tall_m = _reach_m(length_m[i], height_m[i], pitch_rad[i])
                tall_m += _reach_m(length_m[j], height_m[j], pitch_rad[j])
                if abs(position_m[i, 2] - position_m[j, 2]) > tall_m:
                    continue
                upper, lower = (i, j) if position_m[i, 2] >= position_m[j, 2] else (j, i)
                missing_m = _missing_rise(
                    axes_m[upper], axes_m[lower], length_m[upper], length_m[lower], height_m[upper], height_m[lower]
                )
                if missing_m > 0.0:
                    moved = True
                    _shift(upper, 0.51 * missing_m, axes_m, length_m, height_m, position_m, pitch_rad, size_m)
                    _shift(lower, -0.51 * missing_m, axes_m, length_m, height_m, position_m, pitch_rad, size_m)
        if not moved:
            break


@njit(cache=True)
def _shift(
    n: int,
    rise_m: float,
    axes_m: NDArray[np.float64],
    length_m: NDArray[np.float64],
    height_m: NDArray[np.float64],
    position_m: NDArray[np.float64],
    pitch_rad: NDArray[np.float64],
    size_m: NDArray[np.float64],
) -> None:
    """Move one fish up, as far as there is water."""
    before_m = position_m[n, 2]
    position_m[n, 2] += rise_m
    _keep_in_depth(n, length_m, height_m, position_m, pitch_rad, size_m)
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
    upper_m: NDArray[np.float64],
    lower_m: NDArray[np.float64],
    upper_length_m: float,
    lower_length_m: float,
    upper_height_m: float,
    lower_height_m: float,
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
            height = upper_height_m * max(_HALF_HEIGHT[a], _HALF_HEIGHT[a + 1])
            height += lower_height_m * max(_HALF_HEIGHT[b], _HALF_HEIGHT[b + 1])
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


_CLIMB_MPS, _DEPTH_SETTLING_S = 0.04, 0.7
"""Greatest vertical speed of swimming, and time constant of the approach to the wanted depth."""
_STEEPEST_RAD, _PITCHING_S = 0.3, 0.2
_WALL_TURN, _WALL_INSET = 6.0, 0.4
"""Rate of turn at a wall straight ahead, in radians for each ``wall_reach_m`` swum; nearest approach, in lengths."""
_WALL_PULL, _WALL_LEAN = 4.0, 1.0
"""Walls attract fish nearer than this many ``wall_reach_m``; there they near it by this slope, less so the nearer."""
_HALT_S = 0.35
"""A fish that would meet a wall sooner than this slows down."""
_BEAT_HZ_PER_LENGTH, _FASTEST_BEAT_HZ = 1.3, 9.0
_BEAT_RAD = np.array([0.05, 0.06, 0.09, 0.13, 0.19, 0.27, 0.38])
"""Amplitudes of the joints in the tail beat of a burst, head to tail."""
_BEAT_LAG_RAD = 2.0 * np.pi * 0.9 * np.array([0.20, 0.32, 0.43, 0.53, 0.63, 0.73, 0.83])
"""The wave of a beat is 1 / 0.9 bodies long."""
_BEAT_RISE_S, _BEAT_FALL_S = 0.05, 0.18
_BEND_SHARES = np.array([0.09, 0.13, 0.17, 0.18, 0.17, 0.15, 0.11])
_BEND_S, _MOST_BEND_RAD = 0.11, 1.7
"""Bend of the whole body over its rate of turn, for slow turns, and its bound."""
_BEND_LAG_S = 0.012
"""Delay of a bend from one joint to the next: it travels from head to tail."""


class School(NamedTuple):
    """State of N fish.

    Attributes:
        length_m: (N,). position_m, velocity_mps: (N, 3). yaw_rad, pitch_rad, speed_mps: (N,).
        joints_rad: (N, S - 1), the sum of ``bend_rad`` and the tail beat.
        mood: (N, 2) logarithm of the activity, after one and two filters. veer_radps: (N, 2) likewise.
        wait_s: (N,) until the next burst. burst_left_s, push_mps2: (N,) rest of the burst, and its acceleration.
        turn_at_s, turn_rad: (N,) time since a turn began, and the whole turn.
        wanted_z_m, depth_wait_s: (N,) wanted height above the floor, and time until it changes.
        beat: (N, 2) phase and amplitude in [0, 1] of the tail beat.
        bend_rad: (N, S - 1) bend of the joints by turning.
        height_m: (N,) lengths times factors of height. pace: (N,) factor of speeds and of how far a fish sees walls and
            mates. bond: (N,) factor of ``Character.school``. kind: (N,) who are mates of each other.
    """

    length_m: NDArray[np.float64]
    position_m: NDArray[np.float64]
    velocity_mps: NDArray[np.float64]
    yaw_rad: NDArray[np.float64]
    pitch_rad: NDArray[np.float64]
    joints_rad: NDArray[np.float64]
    speed_mps: NDArray[np.float64]
    mood: NDArray[np.float64]
    veer_radps: NDArray[np.float64]
    wait_s: NDArray[np.float64]
    burst_left_s: NDArray[np.float64]
    push_mps2: NDArray[np.float64]
    turn_at_s: NDArray[np.float64]
    turn_rad: NDArray[np.float64]
    wanted_z_m: NDArray[np.float64]
    depth_wait_s: NDArray[np.float64]
    beat: NDArray[np.float64]
    bend_rad: NDArray[np.float64]
    height_m: NDArray[np.float64]
    pace: NDArray[np.float64]
    bond: NDArray[np.float64]
    kind: NDArray[np.int64]


@njit(cache=True)
def run(
    school: School,
    character: Character,
    size_m: NDArray[np.float64],
    is_round: bool,
    steps: int,
    interval_s: float,
    rng: np.random.Generator,
) -> None:
    """Let the shoal swim for some steps of ``interval_s`` in water of size (3,), or in a round tank of that width."""
    count = school.length_m.shape[0]
    before_m = np.empty((count, 3))
    for _ in range(steps):
        before_m[:] = school.position_m
        yielding = yielding_mps2(school.length_m, school.height_m, school.position_m, school.velocity_mps)
        for n in range(count):
            _drift(school, character, n, interval_s, rng)
            _decide(school, character, size_m, is_round, n, interval_s, rng)
            rate_radps = _steer(school, character, size_m, is_round, n, interval_s)
            _bend(school, character, n, rate_radps, interval_s)
            _move(school, n, yielding[n], interval_s)
        length_m, height_m, position_m, yaw_rad = school.length_m, school.height_m, school.position_m, school.yaw_rad
        keep_inside(length_m, height_m, position_m, yaw_rad, school.pitch_rad, school.joints_rad, size_m, is_round)
        keep_apart(length_m, height_m, position_m, yaw_rad, school.pitch_rad, school.joints_rad, size_m)
        for n in range(count):
            for axis in range(3):
                school.velocity_mps[n, axis] = (school.position_m[n, axis] - before_m[n, axis]) / interval_s
            school.velocity_mps[n, 2] = min(max(school.velocity_mps[n, 2], -_CLIMB_MPS), _CLIMB_MPS)


@njit(cache=True)
def _drift(school: School, character: Character, n: int, interval_s: float, rng: np.random.Generator) -> None:
    """Change activity and rate of turn: white noise after two filters of first order, with the wanted spread.

    ``da = -a dt / tau + sqrt(4 / tau) sigma dW``, ``db = (a - b) dt / tau``: the variance of b is sigma^2.
    """
    for value, spread, time_s in (
        (school.mood[n], character.mood_spread, character.mood_s),
        (school.veer_radps[n], character.veer_radps, character.veer_s),
    ):
        kept = np.exp(-interval_s / time_s)
        value[0] = kept * value[0] + spread * np.sqrt(2.0 * (1.0 - kept * kept)) * rng.standard_normal()
        value[1] = kept * value[1] + (1.0 - kept) * value[0]


@njit(cache=True)
def _decide(
    school: School,
    character: Character,
    size_m: NDArray[np.float64],
    is_round: bool,
    n: int,
    interval_s: float,
    rng: np.random.Generator,
) -> None:
    """Begin a burst with its turn, and choose another depth, when it is time."""
    activity = np.exp(school.mood[n, 1])
    school.wait_s[n] -= interval_s * activity
    if school.wait_s[n] <= 0.0:
        school.wait_s[n] = character.burst_interval_s * rng.gamma(3.0, 1.0 / 3.0)
        peak_mps = (
            school.pace[n] * activity * character.burst_mps * np.exp(character.burst_spread * rng.standard_normal())
        )
        school.burst_left_s[n] = character.burst_s
        school.push_mps2[n] = max(peak_mps - school.speed_mps[n], 0.0) / character.burst_s
        school.turn_at_s[n] = 0.0
        # A Student variable with three degrees of freedom.
        heavy = rng.standard_normal() / np.sqrt(rng.gamma(1.5, 2.0) / 3.0)
        turn = character.turn_rad * heavy + _towards_wall(school, character, size_m, is_round, n)
        turn += school.bond[n] * character.school * _towards_mates(school, character, n)
        school.turn_rad[n] = min(max(turn, -2.6), 2.6)
    school.depth_wait_s[n] -= interval_s
    if school.depth_wait_s[n] <= 0.0:
        school.depth_wait_s[n] = rng.exponential(character.depth_s)
        inset_m = 0.15 * school.length_m[n]
        school.wanted_z_m[n] = inset_m + (size_m[2] - 2.0 * inset_m) * rng.random()


@njit(cache=True)
def _towards_wall(school: School, character: Character, size_m: NDArray[np.float64], is_round: bool, n: int) -> float:
    """Return the turn of a fish near a wall to a way along it that leads nearer to it."""
    x, y = school.position_m[n, 0], school.position_m[n, 1]
    c, s = np.cos(school.yaw_rad[n]), np.sin(school.yaw_rad[n])
    x_gap, y_gap = 0.5 * size_m[0] - abs(x), 0.5 * size_m[1] - abs(y)
    gap_m = 0.5 * size_m[0] - np.hypot(x, y) if is_round else min(x_gap, y_gap)
    share = gap_m / (_WALL_PULL * school.pace[n] * character.wall_reach_m)
    if share > 1.0:
        return 0.0
    if is_round:
        # Along the wall, the way that is nearer to the heading, and a little outwards.
        out = np.arctan2(y, x)
        side = 1.0 if c * -np.sin(out) + s * np.cos(out) >= 0.0 else -1.0
        wanted = out + side * (0.5 * np.pi - np.arctan(_WALL_LEAN * share))
    elif x_gap < y_gap:
        wanted = np.arctan2(1.0 if s >= 0.0 else -1.0, _WALL_LEAN * share * (1.0 if x >= 0.0 else -1.0))
    else:
        wanted = np.arctan2(_WALL_LEAN * share * (1.0 if y >= 0.0 else -1.0), 1.0 if c >= 0.0 else -1.0)
    return character.wall_follow * _wrapped(wanted - school.yaw_rad[n]) * (1.0 - share)


@njit(cache=True)
def _towards_mates(school: School, character: Character, n: int) -> float:
    """Return the turn to the mean of the directions to the mates in sight and of their headings."""
    x, y = 0.0, 0.0
    for k in range(school.length_m.shape[0]):
        dx = school.position_m[k, 0] - school.position_m[n, 0]
        dy = school.position_m[k, 1] - school.position_m[n, 1]
        distance_m = np.hypot(dx, dy)
        if k == n or distance_m > school.pace[n] * character.school_reach_m or school.kind[k] != school.kind[n]:
            continue
        near = school.length_m[n]
        # Too near, they turn away.
        pull = (distance_m - near) / (distance_m + near) / (distance_m + 1e-6)
        x += pull * dx + character.align * np.cos(school.yaw_rad[k])
        y += pull * dy + character.align * np.sin(school.yaw_rad[k])
    if x == 0.0 and y == 0.0:
        return 0.0
    return _wrapped(np.arctan2(y, x) - school.yaw_rad[n])


@njit(cache=True)
def _wrapped(angle_rad: float) -> float:
    return angle_rad - 2.0 * np.pi * np.floor(angle_rad / (2.0 * np.pi) + 0.5)


@njit(cache=True)
def _steer(
    school: School, character: Character, size_m: NDArray[np.float64], is_round: bool, n: int, interval_s: float
) -> float:
    """Change yaw and speed; return the rate of turn.

    ``dv/dt = push - (v - cruise) / glide``, and ``-(v / halt)`` where a wall is nearer ahead than ``halt v``; a turn of
    size D within T goes as ``D / T (1 - cos(2 pi t / T))``.
    """
    rate = school.veer_radps[n, 1]
    if school.turn_at_s[n] < character.turn_s:
        share = school.turn_at_s[n] / character.turn_s
        rate += school.turn_rad[n] / character.turn_s * (1.0 - np.cos(2.0 * np.pi * share))
        school.turn_at_s[n] += interval_s
    speed = school.speed_mps[n]
    if is_round:
        wall_rate, ahead_m = _round_wall_ahead(school, character, 0.5 * size_m[0], n)
    else:
        wall_rate, ahead_m = _wall_ahead(school, character, size_m, n)
    rate += wall_rate
    cruise = school.pace[n] * character.cruise_mps * np.exp(school.mood[n, 1])
    change = -(speed - cruise) / character.glide_s
    if school.burst_left_s[n] > 0.0:
        change += school.push_mps2[n]
        school.burst_left_s[n] -= interval_s
    if ahead_m < _HALT_S * speed:
        change -= (1.0 - ahead_m / (_HALT_S * speed)) * speed / (0.5 * _HALT_S)
    school.speed_mps[n] = max(speed + change * interval_s, 0.2 * cruise)
    school.yaw_rad[n] += rate * interval_s
    return rate


@njit(cache=True)
def _wall_ahead(school: School, character: Character, size_m: NDArray[np.float64], n: int) -> tuple[float, float]:
    """Return the rate of turn away from the walls, and the way ahead to the nearest approach.

    The rate is ``_WALL_TURN v / reach (1 - gap / reach)`` times the cosine of the angle to the wall.
    """
    c, s = np.cos(school.yaw_rad[n]), np.sin(school.yaw_rad[n])
    inset_m = _WALL_INSET * school.length_m[n]
    most, side, near_walls, way_m = 0.0, 0.0, 0, 1e9
    wall_reach_m = school.pace[n] * character.wall_reach_m
    for axis in range(2):
        for sign in (-1.0, 1.0):
            gap_m = 0.5 * size_m[axis] - inset_m - sign * school.position_m[n, axis]
            towards = sign * (c if axis == 0 else s)
            near_walls += gap_m < 0.6 * wall_reach_m
            if towards <= 0.0:
                continue
            way_m = min(way_m, max(gap_m, 0.0) / max(towards, 0.2))
            urgency = min(1.0 - gap_m / wall_reach_m, 1.5) * towards
            if urgency > most:
                most = urgency
                # Positive where the wall's normal lies to the right of the heading.
                side = sign * s if axis == 0 else -sign * c
    if near_walls > 1:
        # In a corner: to the side where the middle of the tank lies.
        side = school.position_m[n, 0] * s - school.position_m[n, 1] * c
    turn = most * (1.0 if side >= 0.0 else -1.0)
    speed_mps = max(school.speed_mps[n], school.pace[n] * character.cruise_mps)
    return _WALL_TURN * turn * speed_mps / wall_reach_m, way_m


@njit(cache=True)
def _round_wall_ahead(school: School, character: Character, radius_m: float, n: int) -> tuple[float, float]:
    """Return the same in a round tank: the wall is square to the way from the middle."""
    x, y = school.position_m[n, 0], school.position_m[n, 1]
    c, s = np.cos(school.yaw_rad[n]), np.sin(school.yaw_rad[n])
    from_middle_m = np.hypot(x, y) + 1e-9
    gap_m = radius_m - _WALL_INSET * school.length_m[n] - from_middle_m
    towards = (c * x + s * y) / from_middle_m
    if towards <= 0.0:
        return 0.0, 1e9
    wall_reach_m = school.pace[n] * character.wall_reach_m
    turn = max(min(1.0 - gap_m / wall_reach_m, 1.5), 0.0) * towards
    # Positive where the wall's normal lies to the right of the heading.
    turn = turn if x * s - y * c >= 0.0 else -turn
    speed_mps = max(school.speed_mps[n], school.pace[n] * character.cruise_mps)
    return _WALL_TURN * turn * speed_mps / wall_reach_m, max(gap_m, 0.0) / max(towards, 0.2)


@njit(cache=True)
def _bend(school: School, character: Character, n: int, rate_radps: float, interval_s: float) -> None:
    """Bend the body: the bend of a turn runs from joint to joint towards the tail, and so does the wave of a beat."""
    whole = _MOST_BEND_RAD * np.tanh(_BEND_S * rate_radps / _MOST_BEND_RAD)
    follow = 1.0 - np.exp(-interval_s / _BEND_LAG_S)
    before = whole
    for k in range(JOINT_COUNT):
        share = school.bend_rad[n, k] / _BEND_SHARES[k]
        share += follow * (before - share)
        school.bend_rad[n, k], before = share * _BEND_SHARES[k], share
    lengths_ps = school.speed_mps[n] / school.length_m[n]
    wanted = 1.0 if school.burst_left_s[n] > 0.0 and school.push_mps2[n] > 0.0 else character.glide_beat
    time_s = _BEAT_RISE_S if wanted > school.beat[n, 1] else _BEAT_FALL_S
    school.beat[n, 1] += (1.0 - np.exp(-interval_s / time_s)) * (wanted - school.beat[n, 1])
    beat_hz = min(character.beat_hz + _BEAT_HZ_PER_LENGTH * lengths_ps, _FASTEST_BEAT_HZ)
    school.beat[n, 0] += 2.0 * np.pi * beat_hz * interval_s
    for k in range(JOINT_COUNT):
        wave = school.beat[n, 1] * _BEAT_RAD[k] * np.sin(school.beat[n, 0] - _BEAT_LAG_RAD[k])
        school.joints_rad[n, k] = school.bend_rad[n, k] + wave


@njit(cache=True)
def _move(school: School, n: int, yielding_mps2: float, interval_s: float) -> None:
    """Move ahead, and up or down: ``dw/dt = (z* - z) / T^2 - 2 w / T`` plus the acceleration of giving way."""
    off_m = school.wanted_z_m[n] - school.position_m[n, 2]
    climb = school.velocity_mps[n, 2]
    pull = min(max(off_m / _DEPTH_SETTLING_S, -_CLIMB_MPS), _CLIMB_MPS)
    climb += interval_s * ((pull - 2.0 * climb) / _DEPTH_SETTLING_S + yielding_mps2)
    climb = min(max(climb, -_CLIMB_MPS), _CLIMB_MPS)
    speed = school.speed_mps[n]
    school.position_m[n, 0] += speed * np.cos(school.yaw_rad[n]) * interval_s
    school.position_m[n, 1] += speed * np.sin(school.yaw_rad[n]) * interval_s
    school.position_m[n, 2] += climb * interval_s
    steep = np.arctan2(climb, max(speed, 0.04))
    steep = min(max(steep, -_STEEPEST_RAD), _STEEPEST_RAD)
    school.pitch_rad[n] += (1.0 - np.exp(-interval_s / _PITCHING_S)) * (steep - school.pitch_rad[n])
