"""A helicopter's model-predictive controller: plans its way through the swing of the camera that it foresees."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackers.controllers.catalogue import Kernel, register_controller
from trackers.controllers.kernel_controller import KernelController, record_dtype
from trackers.controllers.reentry import aim_point, climb_rate, in_picture, tilted_axes, turn_rate
from trackers.controllers.swing_forecast import (
    HISTORY,
    TILT_FIELDS,
    SwingForecast,
    foresee,
    keep_tilt,
    kept_tilts,
    swing_forecast,
)
from trackers.kernels.records import record_kernel
from trackers.registry import tunable

_STEPS, _KNOTS = 20, 5
"""A plan has commands at so many knots, straight between them, and counts at so many times."""
_ROUNDS = 2
_FINE = 4
"""Steps of the response between two times at which the plan counts."""
_CLIMBS_S = 1.0
"""Time for which the present climb rate is taken to go on."""
_STEEPEST_RAD = 1.4
"""Limit of the optical axis' angle from straight down."""
_NARROWEST = 0.1
"""Least half of the picture within its border."""

_MEMORY = np.dtype(
    [
        # The own motion as the observer has it, in the world: place, velocity, and the wind that commands do not know.
        ("observed", "f8"),
        ("observed_s", "f8"),
        ("place_m", "f8", (2,)),
        ("velocity_mps", "f8", (2,)),
        ("wind_mps", "f8", (2,)),
        # The latest command (ahead, right) with the heading at which it was given, and the plan's knots.
        ("given_mps", "f8", (2,)),
        ("given_rad", "f8"),
        ("plan_mps", "f8", (_KNOTS, 2)),
        *TILT_FIELDS,
    ],
    align=True,
)


@dataclass(frozen=True)
class PredictiveParameters:
    """Settings, see ``PredictiveController``.

    Attributes:
        horizon_s: time that is planned.
        lag_s: time constant with which the carrier's velocity follows its command.
        slew_mps2: largest change of the command in a second.
        border: margin inside the picture's border that does not count as in view, a share of the half sizes.
        caution: widens the border by so many standard deviations of the forecast.
        saturation: excess beyond the border, in halves of the picture, from which more excess costs little.
        level: weight of the picture in still air; the forecast one has the rest.
        centre: weight of the target's squared place in the picture, that of the squared excess being 1.
        effort: weight of the squared velocity relative to the target, per (m/s)².
        change: weight of the squared changes from knot to knot, per (m/s)².
        place_share, velocity_share, wind_share: gains of the observer of the own motion.
        height_m: height above ground while the target's position is known.
        sink_mps, doubt, patience_s, search_mps, fastest_mps, turn_per_s: see ``ReentryParameters``.
    """

    horizon_s: float = tunable(1.0, 0.8, 2.5)
    lag_s: float = tunable(1.0, 0.2, 1.2)
    slew_mps2: float = tunable(40.0, 10.0, 60.0)
    border: float = tunable(0.23, 0.0, 0.5)
    caution: float = tunable(1.1, 0.0, 2.0)
    saturation: float = tunable(1.4, 0.1, 5.0, log=True)
    level: float = tunable(0.17, 0.0, 0.7)
    centre: float = tunable(0.057, 1e-4, 0.5, log=True)
    effort: float = tunable(6.5e-5, 1e-7, 1e-2, log=True)
    change: float = tunable(1.9e-6, 1e-7, 1e-2, log=True)
    place_share: float = tunable(0.42, 0.1, 1.0)
    velocity_share: float = tunable(0.28, 0.02, 0.8)
    wind_share: float = tunable(0.15, 0.0, 0.3)
    height_m: float = tunable(40.5, 40.0, 65.0)
    sink_mps: float = tunable(4.4, 0.5, 5.0)
    doubt: float = 0.4
    patience_s: float = 1.5
    search_mps: float = 6.0
    fastest_mps: float = 25.0
    turn_per_s: float = 2.0


def plan_flight(
    beliefs: NDArray[np.void],
    parameters: NDArray[np.void],
    memory: NDArray[np.void],
    times_s: NDArray[np.float64],
    out: NDArray[np.float64],
) -> None:
    """Write the commands of B beliefs (B,); see ``catalogue.Kernel``.

    Args:
        parameters: (1,) record of ``PredictiveParameters``. The equations are in ``PredictiveController``.
    """
    _plan_flight(beliefs, parameters, memory, times_s, swing_forecast(), out)


@record_kernel()
def _plan_flight(
    beliefs: NDArray[np.void],
    parameters: NDArray[np.void],
    memory: NDArray[np.void],
    times_s: NDArray[np.float64],
    network: SwingForecast,
    out: NDArray[np.float64],
) -> None:
    p = parameters[0]
    step_s = p.horizon_s / _STEPS
    place_of = responses(p.lag_s, step_s)
    soon_s = step_s * np.arange(1.0, _STEPS + 1.0)
    tilts, axes, spreads = np.zeros((HISTORY + 1, 2)), np.zeros((_STEPS, 2)), np.zeros(_STEPS)
    free_m, heights_m = np.zeros((_STEPS, 2)), np.zeros(_STEPS)
    for k in range(len(beliefs)):
        b, m = beliefs[k], memory[k]
        height_m, mount_rad = max(b.height_m, 1.0), np.arctan(b.mount_slope)
        tilt_ahead = np.tan(np.arctan(b.axis_ahead_m / height_m) - mount_rad)
        keep_tilt(m, tilt_ahead, b.axis_right_m / height_m, times_s[k])
        kept_tilts(m, network.step_s, tilts)
        foresee(tilts, network, soon_s, axes, spreads)
        interval_s = observe_motion(b, p, m, times_s[k])
        aim_ahead_m, aim_right_m, moving = aim_point(b, p)
        goes_ahead_mps, goes_right_mps = moving * b.velocity_ahead_mps, moving * b.velocity_right_mps
        climb_mps = climb_rate(b, p)
        c, s = np.cos(b.heading_rad), np.sin(b.heading_rad)
        wind_ahead_mps, wind_right_mps = _turned(m.wind_mps, c, s)
        own_ahead_mps, own_right_mps = _turned(m.velocity_mps, c, s)
        for step in range(_STEPS):
            t = soon_s[step]
            axes[step, 0] = np.tan(min(np.arctan(axes[step, 0]) + mount_rad, _STEEPEST_RAD))
            heights_m[step] = max(height_m + climb_mps * min(t, _CLIMBS_S), 1.0)
            # Where the target will be, from the carrier, if the plan's commands are zero.
            blown = place_of[step, : _KNOTS + 1].sum()
            kept, first = place_of[step, _KNOTS + 1], place_of[step, 0]
            free_m[step, 0] = aim_ahead_m + t * goes_ahead_mps - kept * own_ahead_mps
            free_m[step, 1] = aim_right_m + t * goes_right_mps - kept * own_right_mps
            free_m[step, 0] -= first * m.given_mps[0] + blown * wind_ahead_mps
            free_m[step, 1] -= first * m.given_mps[1] + blown * wind_right_mps
        rest_ahead_mps, rest_right_mps = goes_ahead_mps - wind_ahead_mps, goes_right_mps - wind_right_mps
        half_ahead, half_right = b.half_ahead_m / height_m, b.half_right_m / height_m
        for _ in range(_ROUNDS):
            improve_plan(
                m.plan_mps,
                m.given_mps,
                (rest_ahead_mps, rest_right_mps),
                (half_ahead, half_right),
                b.mount_slope,
                free_m,
                heights_m,
                axes,
                spreads,
                place_of,
                p,
            )
        share = min(interval_s * _KNOTS / p.horizon_s, 1.0)
        change_ahead_mps = share * (m.plan_mps[0, 0] - m.given_mps[0])
        change_right_mps = share * (m.plan_mps[0, 1] - m.given_mps[1])
        less = min(1.0, p.slew_mps2 * interval_s / max(np.hypot(change_ahead_mps, change_right_mps), 1e-9))
        m.given_mps[0] += less * change_ahead_mps
        m.given_mps[1] += less * change_right_mps
        m.given_rad = b.heading_rad
        out[k, 0], out[k, 1], out[k, 2], out[k, 3] = m.given_mps[0], m.given_mps[1], climb_mps, 0.0
        if b.mount_slope > 0.0:
            out[k, 3] = turn_rate(b, p, aim_ahead_m, aim_right_m)


@record_kernel()
def responses(lag_s: float, step_s: float) -> NDArray[np.float64]:
    """Return the place (T, J + 2) after each step of a carrier whose velocity follows its command with a lag.

    Column j is the response to a command of 1 m/s at knot j, 0 at the others and straight between them, where knot 0 is
    now; the last column that to a velocity of 1 m/s now.
    """
    places = np.zeros((_STEPS, _KNOTS + 2))
    fine_s, apart = step_s / _FINE, _STEPS / _KNOTS
    follows = 1.0 - np.exp(-fine_s / lag_s)
    for column in range(_KNOTS + 2):
        velocity, place = 1.0 if column > _KNOTS else 0.0, 0.0
        for step in range(_STEPS):
            for part in range(_FINE):
                at = (step + (part + 0.5) / _FINE) / apart
                command = max(1.0 - abs(at - column), 0.0) if column <= _KNOTS else 0.0
                before, velocity = velocity, velocity + follows * (command - velocity)
                place += 0.5 * fine_s * (before + velocity)
            places[step, column] = place
    return places


@record_kernel()
def observe_motion(b: Any, p: Any, m: Any, time_s: float) -> float:
    """Correct the own motion by the measured place; return the time since the last picture, 0 on the first.

    A Luenberger observer with the states place, velocity and wind: ``dv/dt = (command + wind - v) / lag_s``.
    """
    interval_s = time_s - m.observed_s if m.observed > 0.0 else 0.0
    m.observed_s = time_s
    if m.observed == 0.0:
        m.observed = 1.0
        m.place_m[0], m.place_m[1] = b.carrier_x_m, b.carrier_y_m
    if interval_s <= 0.0:
        return 0.0
    c, s = np.cos(m.given_rad), np.sin(m.given_rad)
    follows = 1.0 - np.exp(-interval_s / p.lag_s)
    for axis in range(2):
        ahead, right = (c, s) if axis == 0 else (s, -c)
        command_mps = ahead * m.given_mps[0] + right * m.given_mps[1]
        velocity_mps = m.velocity_mps[axis] + follows * (command_mps + m.wind_mps[axis] - m.velocity_mps[axis])
        place_m = m.place_m[axis] + 0.5 * interval_s * (m.velocity_mps[axis] + velocity_mps)
        off_m = (b.carrier_x_m if axis == 0 else b.carrier_y_m) - place_m
        m.place_m[axis] = place_m + p.place_share * off_m
        m.velocity_mps[axis] = velocity_mps + p.velocity_share * off_m / interval_s
        wind_mps = m.wind_mps[axis] + p.wind_share * off_m / interval_s
        m.wind_mps[axis] = min(max(wind_mps, -p.fastest_mps), p.fastest_mps)
    return interval_s


@record_kernel()
def improve_plan(
    plan_mps: NDArray[np.float64],
    given_mps: NDArray[np.float64],
    rest_mps: tuple[float, float],
    halves: tuple[float, float],
    mount_slope: float,
    free_m: NDArray[np.float64],
    heights_m: NDArray[np.float64],
    axes: NDArray[np.float64],
    spreads: NDArray[np.float64],
    place_of: NDArray[np.float64],
    p: Any,
) -> None:
    """Move the plan's knots (J, 2) by a step of Gauss and Newton to less cost, see ``PredictiveController``.

    Args:
        given_mps: (2,) latest command. rest_mps: the command that stays with the target. halves: tangents of half the
            fields of view (up, aside). free_m: (T, 2) the target's place without commands. heights_m: (T,).
        axes: (T, 2) where the optical axis will meet the ground, over the height; spreads: (T,) of it.
        place_of: (T, J + 2) of ``responses``.
    """
    unknowns = 2 * _KNOTS
    curve, slope = np.zeros((unknowns, unknowns)), np.zeros(unknowns)
    bends, pulls = np.zeros((2, 2)), np.zeros(2)
    for step in range(_STEPS):
        ahead_m, right_m = free_m[step, 0], free_m[step, 1]
        for knot in range(_KNOTS):
            ahead_m -= place_of[step, knot + 1] * plan_mps[knot, 0]
            right_m -= place_of[step, knot + 1] * plan_mps[knot, 1]
        bends[:], pulls[:] = 0.0, 0.0
        _add_picture(
            ahead_m,
            right_m,
            heights_m[step],
            axes[step, 0],
            axes[step, 1],
            spreads[step],
            halves,
            p,
            1.0 - p.level,
            bends,
            pulls,
        )
        _add_picture(ahead_m, right_m, heights_m[step], mount_slope, 0.0, 0.0, halves, p, p.level, bends, pulls)
        for knot in range(_KNOTS):
            moved = place_of[step, knot + 1]
            for axis in range(2):
                slope[2 * knot + axis] -= moved * pulls[axis]
                for other in range(knot + 1):
                    both = moved * place_of[step, other + 1]
                    for across in range(2):
                        curve[2 * knot + axis, 2 * other + across] += both * bends[axis, across]
    for knot in range(_KNOTS):
        for axis in range(2):
            here = 2 * knot + axis
            before_mps = plan_mps[knot - 1, axis] if knot > 0 else given_mps[axis]
            change_mps = plan_mps[knot, axis] - before_mps
            curve[here, here] += p.effort + p.change
            slope[here] += p.effort * (plan_mps[knot, axis] - rest_mps[axis]) + p.change * change_mps
            if knot > 0:
                curve[here - 2, here - 2] += p.change
                curve[here, here - 2] -= p.change
                slope[here - 2] -= p.change * change_mps
    solve_symmetric(curve, slope)
    for knot in range(_KNOTS):
        ahead_mps, right_mps = plan_mps[knot, 0] - slope[2 * knot], plan_mps[knot, 1] - slope[2 * knot + 1]
        slower = min(1.0, p.fastest_mps / max(np.hypot(ahead_mps, right_mps), 1e-9))
        plan_mps[knot, 0], plan_mps[knot, 1] = slower * ahead_mps, slower * right_mps


@record_kernel()
def _add_picture(
    ahead_m: float,
    right_m: float,
    height_m: float,
    axis_ahead: float,
    axis_right: float,
    spread: float,
    halves: tuple[float, float],
    p: Any,
    weight: float,
    bends: NDArray[np.float64],
    pulls: NDArray[np.float64],
) -> None:
    """Add the cost of the target's place in a picture: its second and first derivatives by the target's place."""
    cp, sp, cr, sr = tilted_axes(axis_ahead, axis_right)
    depth, up, aside = in_picture(ahead_m / height_m, right_m / height_m, cp, sp, cr, sr)
    for axis in range(2):
        # Place in the picture, in halves of it, and its derivatives by the target's place.
        if axis == 0:
            place, by_ahead, by_right = up, cp - up * sp * cr, up * sr
        else:
            place, by_ahead, by_right = aside, sp * sr - aside * sp * cr, cr + aside * sr
        per_m = 1.0 / (halves[axis] * depth * height_m)
        place, by_ahead, by_right = place / halves[axis], per_m * by_ahead, per_m * by_right
        inner = max(1.0 - p.border - p.caution * spread / halves[axis], _NARROWEST)
        excess = place - min(max(place, -inner), inner)
        # Iteratively reweighted least squares with the weights of Geman and McClure.
        urgent = weight / (1.0 + (excess / p.saturation) ** 2) ** 2 if excess != 0.0 else 0.0
        second, first = urgent + weight * p.centre, urgent * excess + weight * p.centre * place
        pulls[0] += first * by_ahead
        pulls[1] += first * by_right
        bends[0, 0] += second * by_ahead * by_ahead
        bends[0, 1] += second * by_ahead * by_right
        bends[1, 0] += second * by_ahead * by_right
        bends[1, 1] += second * by_right * by_right


@record_kernel()
def solve_symmetric(matrix: NDArray[np.float64], values: NDArray[np.float64]) -> None:
    """Solve a positive definite system (N, N), of which the lower triangle is read, by Cholesky; in place."""
    count = len(values)
    for row in range(count):
        for column in range(row + 1):
            total = matrix[row, column]
            for k in range(column):
                total -= matrix[row, k] * matrix[column, k]
            matrix[row, column] = np.sqrt(max(total, 1e-12)) if row == column else total / matrix[column, column]
        for k in range(row):
            values[row] -= matrix[row, k] * values[k]
        values[row] /= matrix[row, row]
    for row in range(count - 1, -1, -1):
        for k in range(row + 1, count):
            values[row] -= matrix[k, row] * values[k]
        values[row] /= matrix[row, row]


@record_kernel()
def _turned(vector: NDArray[np.float64], c: float, s: float) -> tuple[float, float]:
    """Return a vector (2,) of the world ahead and to the right of a heading, of which cosine and sine are given."""
    return c * vector[0] + s * vector[1], s * vector[0] - c * vector[1]


@register_controller(
    "predictive",
    role="baseline",
    carrier="helicopter",
    summary="plans ahead (MPC), through the swing of the camera that a learnt network expects",
)
class PredictiveController(KernelController):
    """Plans its commands for ``horizon_s`` on every picture, and gives the first (model-predictive control).

    All points are on the ground, ahead and right of the point below the camera. The plan's commands ``u`` lie at knots;
    between these they are straight. Its model: own velocity ``du'/dt = (u + w - u') / lag_s`` with the wind ``w`` that
    an observer of the measured own motion finds, the target with the belief's constant velocity ``v``, and an optical
    axis that swings as ``swing_forecast`` expects, or stands as in still air. With the target's place ``y`` in the
    picture, in halves of it, and the excess ``e`` beyond a border that widens with the forecast's uncertainty, the plan
    has the least::

        sum over time, both axes and both pictures of  e² / (1 + e² / saturation²) + centre y²
        + sum over knots of  effort (u + w - v)² + change (u - the u before)²

    found by Gauss-Newton steps from the last picture's plan. A target that is lost, heights and turns are those of
    ``ReentryController``.
    """

    Parameters = PredictiveParameters
    LOOKS, KERNEL = "down", Kernel(plan_flight, record_dtype(PredictiveParameters), _MEMORY)
