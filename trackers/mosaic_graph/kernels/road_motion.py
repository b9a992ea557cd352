"""One step of driving: along roads, with speeds for bends, turns and halts ahead, or freely."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from trackers.mosaic_graph.kernels.crossing import curve_over, reach_before, wrap
from trackers.mosaic_graph.kernels.road_course import choose_way, distance_to_node_m, move_along, point_ahead
from trackers.mosaic_graph.kernels.road_position import (
    BOUND,
    CHOICE,
    CORNERING,
    CRUISE,
    CURVE,
    DIRECTION,
    EDGE,
    HALTS,
    HEADING,
    LATERAL,
    LOOK,
    ON_ROAD,
    SPEED,
    TURN,
    URGE,
    VIGOUR,
    RoadGraph,
    Roads,
    X,
    Y,
    associate_one,
    nearest_point,
)

_COMMITTED_M = 5.5
_DECIDE_M = 28.0
_HALT_BEFORE_M = 8.0
_BEND_STEP_M, _BEND_STEPS, _SHORTEST_BEND_M = 10.0, 3, 3.0
_FREE_ROAD_EXPONENT = 4
_HARDEST_BRAKING = 8.0
"""On a dry road (Treiber & Kesting, Traffic Flow Dynamics, 2013, section 11.1: 8 to 9 m/s^2 at most)."""
SHORTEST_LOOK_M, LONGEST_LOOK_M = 3.0, 6.0
NORMALS = 10
"""Number of normal variates of a step."""
_SHARPEST_PER_M, _TURN_PER_M, _STRAIGHT_PER_M = 0.22, 0.13, 0.02
_LEAST_TURN_RAD, _LEAST_BEND_RAD = 0.3, 0.15
_HURRY, _HARDEST = 1.2, 1.6
_TURN_ENDS_RATE = 1.5
_LOOK_S, _WIDEST_AIM_RAD = 0.5, 1.5
"""Least look-ahead as a time, and greatest angle to the point aimed at."""
_SLOWEST_GOAL_MPS, _FULL_NOISE_MPS, _HALTED_MPS, _SLOWEST_FREE_MPS = 0.5, 2.0, 0.7, 1.0
_UNSEEN_TURN_RAD, _WIDEST_LEAVING_RAD = 1.57, 0.8
"""Angle of a turn without a known road, and greatest angle of a turn off the road."""


class Habits(NamedTuple):
    """Parameters of driving. Rates are per second, noises per square root of a second.

    Attributes:
        cruise_mps, cruise_spread_mps, cruise_rate: desired speed: mean, deviation, rate of return to the mean. The mean
            is learnt online; at first it lies between the usual limits in towns, 30 and 50 km/h.
        urge_spread, urge_rate: additional random acceleration: deviation (m/s^2), rate of decay.
        curve_spread_per_m, curve_rate: curvature of paths off the known roads: deviation, rate of decay.
        unseen_turns_per_m: turns per metre off the known roads.
        speed_noise, heading_noise, position_noise: of the step.
        leave_rate, return_rate: of leaving the road, and of joining one nearby.
        turn_weight: of a turn at a crossing by a right angle, against 1 for going straight on.
        lateral_acceleration, braking, acceleration: m/s^2; medians over drivers of the comfortable ones, and of the
            greatest acceleration. Lateral: the side friction of 0.23 that drivers accept at 40 km/h (AASHTO, Policy on
            Geometric Design, 2011, low-speed streets). Braking: 10 ft/s^2, for which amber lights are timed (ITE).
            Acceleration: of city traffic (Treiber & Kesting, Traffic Flow Dynamics, 2013, table 11.2).
        vigour_spread, cornering_spread, style_rate: deviation of the logarithm over drivers, of the accelerations along
            the road and of the lateral one, and its rate of return. Each particle has its own; the filter selects.
        halt_share, halt_s: share of crossings where a car halts, and mean duration; assumed.
        lane_m, lane_spread_m, lane_rate: offset of the lane to the right of the centre line (left-hand traffic:
            negative), its deviation, and rate of moving into it. Learnt online, see ``LaneOffset``.
        rethink_rate: of drawing the way at a crossing again, up to 5.5 m before its middle.
    """

    cruise_spread_mps: float
    cruise_rate: float
    urge_spread: float
    curve_spread_per_m: float
    unseen_turns_per_m: float
    speed_noise: float
    leave_rate: float
    turn_weight: float
    lateral_acceleration: float = 2.3
    braking: float = 3.0
    acceleration: float = 1.0
    vigour_spread: float = 0.5
    cornering_spread: float = 0.25
    style_rate: float = 0.05
    cruise_mps: float = 11.1
    urge_rate: float = 0.7
    curve_rate: float = 0.5
    heading_noise: float = 0.06
    position_noise: float = 0.15
    return_rate: float = 0.5
    halt_share: float = 0.2
    halt_s: float = 1.5
    lane_m: float = 0.0
    lane_spread_m: float = 0.0
    lane_rate: float = 1.0
    rethink_rate: float = 1.0


@njit(cache=True)
def _allowed_speed(s: NDArray[np.float64], graph: RoadGraph, habits: Habits) -> float:
    """Return the speed allowed by bends within 30 m, the way over the crossing and a halt before it.

    ``v^2 = a_lateral r + 2 b d`` for a bend of radius r at distance d, braking by b.
    """
    allowed = max(s[CRUISE], 0.0)
    lateral = habits.lateral_acceleration * np.exp(s[CORNERING])
    braking = habits.braking * np.exp(s[VIGOUR])
    to_node = distance_to_node_m(s, graph)
    street_m = _BEND_STEPS * _BEND_STEP_M
    if s[CHOICE] >= 0:
        edge = int(s[EDGE])
        _, _, radius, turn = curve_over(graph, edge, s[DIRECTION], int(s[CHOICE]), habits.lane_m)
        if abs(turn) > _LEAST_TURN_RAD:
            street_m = min(street_m, to_node - reach_before(graph, edge))
            squared = lateral * radius + 2 * braking * max(street_m, 0.0)
            allowed = min(allowed, np.sqrt(squared))
    heading = s[HEADING]
    for step in range(_BEND_STEPS):
        way = step * _BEND_STEP_M
        length = min(_BEND_STEP_M, street_m - way)
        if length < _SHORTEST_BEND_M:
            break
        _, _, beyond = point_ahead(s, graph, way + length)
        bend = abs(wrap(beyond - heading))
        heading = beyond
        if bend > _LEAST_BEND_RAD:
            squared = lateral * length / bend + 2 * braking * way
            allowed = min(allowed, np.sqrt(squared))
    if s[HALTS] > 0:
        allowed = min(allowed, np.sqrt(2 * braking * max(0.0, to_node - _HALT_BEFORE_M)))
    return allowed


@njit(cache=True)
def drive(
    states: NDArray[np.float64],
    roads: Roads,
    habits: Habits,
    dt_s: float,
    normals: NDArray[np.float64],
    uniforms: NDArray[np.float64],
) -> None:
    """Move every state on by ``dt_s``, in place.

    On a road: the heading turns towards the lane's point ``L = max(look, 0.5 v)`` ahead along the chosen way (pure
    pursuit: ``curvature = 2 sin(alpha) / L``). The speed approaches the goal g, limited by ``_allowed_speed`` and the
    present curvature: ``a = A (1 - (v / g)^4)``, the free road of the intelligent driver model with its authors'
    exponent (Treiber, Hennecke, Helbing 2000); the urge covers drivers that differ. Free: the curvature is an
    Ornstein-Uhlenbeck process, but constant in a turn as far as the speed allows. Turns begin where no road is known,
    and may end early. Both: ``v' = v + (a + u) dt + n``, ``x' = x + v' dt (cos, sin) + n``; desired speed, urge u,
    style and place in the lane are Ornstein-Uhlenbeck processes.

    Args:
        states: (N, COLUMNS).
        normals: (N, NORMALS) standard normal: speed, heading, x, y, desired speed, urge, curvature, two of style, lane.
        uniforms: (N, 7) in [0, 1): mode, way, halt, release, turn, side, rethinking.
    """
    root = np.sqrt(dt_s)
    for i in range(states.shape[0]):
        s = states[i]
        s[CRUISE] = habits.cruise_mps + _fade(
            s[CRUISE] - habits.cruise_mps, habits.cruise_spread_mps, habits.cruise_rate, dt_s, normals[i, 4]
        )
        s[URGE] = _fade(s[URGE], habits.urge_spread, habits.urge_rate, dt_s, normals[i, 5])
        s[VIGOUR] = _fade(s[VIGOUR], habits.vigour_spread, habits.style_rate, dt_s, normals[i, 7])
        s[CORNERING] = _fade(s[CORNERING], habits.cornering_spread, habits.style_rate, dt_s, normals[i, 8])
        on_road = s[ON_ROAD] > 0
        if on_road:
            s[LATERAL] = habits.lane_m + _fade(
                s[LATERAL] - habits.lane_m, habits.lane_spread_m, habits.lane_rate, dt_s, normals[i, 9]
            )
            goal, curvature = _follow_road(s, roads.graph, habits, dt_s, uniforms[i])
        else:
            goal, curvature = _go_free(s, roads, habits, dt_s, normals[i, 6], uniforms[i])
        share = (s[SPEED] / max(goal, _SLOWEST_GOAL_MPS)) ** _FREE_ROAD_EXPONENT
        push = habits.acceleration * np.exp(s[VIGOUR]) * (1.0 - share)
        push = max(push, -_HARDEST_BRAKING)
        s[SPEED] = max(0.0, s[SPEED] + (push + s[URGE]) * dt_s + habits.speed_noise * root * normals[i, 0])
        # A standing car neither turns nor drifts.
        noise = root * min(1.0, s[SPEED] / _FULL_NOISE_MPS)
        s[HEADING] = wrap(s[HEADING] + curvature * s[SPEED] * dt_s + habits.heading_noise * noise * normals[i, 1])
        step_x = s[SPEED] * dt_s * np.cos(s[HEADING])
        step_y = s[SPEED] * dt_s * np.sin(s[HEADING])
        s[X] += step_x + habits.position_noise * noise * normals[i, 2]
        s[Y] += step_y + habits.position_noise * noise * normals[i, 3]
        if on_road:
            move_along(s, roads.graph, step_x, step_y)


@njit(cache=True)
def _fade(value: float, spread: float, rate: float, dt_s: float, normal: float) -> float:
    """Return a step of an Ornstein-Uhlenbeck process: ``f x + s sqrt(1 - f^2) n``, ``f = exp(-rate dt)``."""
    factor = np.exp(-rate * dt_s)
    return factor * value + spread * np.sqrt(1 - factor * factor) * normal


@njit(cache=True)
def _follow_road(
    s: NDArray[np.float64], graph: RoadGraph, habits: Habits, dt_s: float, uniforms: NDArray[np.float64]
) -> tuple[float, float]:
    """Return goal speed and curvature of a car on a road; it may choose a way, halt, or start to leave the road."""
    edge = int(s[EDGE])
    to_node = distance_to_node_m(s, graph)
    undecided = s[CHOICE] < 0
    # The chosen way is unobservable before the turn begins. Drawing it again keeps the particles of a car in view from
    # agreeing on one way by resampling.
    if to_node < _DECIDE_M and (undecided or (to_node > _COMMITTED_M and uniforms[6] < habits.rethink_rate * dt_s)):
        if not undecided:
            s[BOUND] = np.nan
        elif np.isnan(s[BOUND]):
            crossing = graph.ends[edge, 1 if s[DIRECTION] > 0 else 0]
            wide = graph.node_first[crossing + 1] - graph.node_first[crossing] > 2
            can_halt = wide and to_node > _HALT_BEFORE_M
            s[HALTS] = 1.0 if can_halt and uniforms[2] < habits.halt_share else 0.0
        choose_way(s, graph, habits.turn_weight, habits.lane_m, uniforms[1])
        s[LOOK] = SHORTEST_LOOK_M + (LONGEST_LOOK_M - SHORTEST_LOOK_M) * uniforms[5]
    elif undecided:
        # Decisions for a crossing that is passed, or no longer drawn.
        s[BOUND], s[HALTS] = np.nan, 0.0
    goal = _allowed_speed(s, graph, habits)
    if s[HALTS] > 0 and s[SPEED] < _HALTED_MPS and uniforms[3] < dt_s / habits.halt_s:
        s[HALTS] = 0.0
    distance = max(s[LOOK], _LOOK_S * s[SPEED])
    x, y, _ = point_ahead(s, graph, distance)
    alpha = wrap(np.arctan2(y - s[Y], x - s[X]) - s[HEADING])
    curvature = 2.0 * np.sin(min(max(alpha, -_WIDEST_AIM_RAD), _WIDEST_AIM_RAD)) / distance
    curvature = min(max(curvature, -_SHARPEST_PER_M), _SHARPEST_PER_M)
    s[CURVE] = curvature
    # No acceleration before the end of a turn.
    if abs(curvature) > _STRAIGHT_PER_M:
        lateral = habits.lateral_acceleration * np.exp(s[CORNERING])
        goal = min(goal, np.sqrt(_HURRY * lateral / abs(curvature)))
    if uniforms[0] < habits.leave_rate * dt_s:
        s[ON_ROAD] = 0.0
        _begin_turn(s, 2 * _WIDEST_LEAVING_RAD * uniforms[4] - _WIDEST_LEAVING_RAD)
    return goal, curvature


@njit(cache=True)
def _begin_turn(s: NDArray[np.float64], turn: float) -> None:
    s[TURN] = turn
    s[CURVE] = _TURN_PER_M if turn > 0 else -_TURN_PER_M


@njit(cache=True)
def _go_free(
    s: NDArray[np.float64], roads: Roads, habits: Habits, dt_s: float, normal: float, uniforms: NDArray[np.float64]
) -> tuple[float, float]:
    """Return goal speed and curvature of a car off the known roads; it may turn if none is near, or join one."""
    goal = max(s[CRUISE], 0.0)
    if s[TURN] == 0.0:
        s[CURVE] = _fade(s[CURVE], habits.curve_spread_per_m, habits.curve_rate, dt_s, normal)
        if uniforms[4] < habits.unseen_turns_per_m * s[SPEED] * dt_s and nearest_point(s[X], s[Y], roads) < 0:
            _begin_turn(s, _UNSEEN_TURN_RAD if uniforms[5] < 0.5 else -_UNSEEN_TURN_RAD)
    elif uniforms[4] < _TURN_ENDS_RATE * dt_s:
        # The angle of a turn without a known road is unknown.
        s[TURN] = 0.0
    if uniforms[0] < habits.return_rate * dt_s:
        associate_one(s, roads, uniforms[1])
    if s[TURN] == 0.0:
        return goal, s[CURVE]
    lateral = habits.lateral_acceleration * np.exp(s[CORNERING])
    sharpest = _HARDEST * lateral / max(s[SPEED], _SLOWEST_FREE_MPS) ** 2
    curvature = min(max(s[CURVE], -sharpest), sharpest)
    goal = min(goal, np.sqrt(lateral / max(abs(s[CURVE]), _STRAIGHT_PER_M)))
    rest = s[TURN] - curvature * s[SPEED] * dt_s
    if rest * s[TURN] > 0:
        s[TURN] = rest
    else:
        s[TURN], s[CURVE] = 0.0, 0.0
    return goal, curvature
