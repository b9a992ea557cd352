"""Our controller of a ground robot: steers by the belief and searches for a lost target along its path."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackers.belief.kernel import SECTORS
from trackers.controllers.catalogue import Kernel, register_controller
from trackers.controllers.kernel_controller import KernelController, record_dtype
from trackers.kernels.records import record_kernel
from trackers.registry import tunable

_NEAREST_M = 0.4
"""Least distance of a target; bearings of nearer points change too fast to follow."""
_FASTEST_MPS = 2.0
"""Limit of the target's speed, a person's; estimates from a few frames exceed it."""
_ARRIVE_S = 5.0
"""Time limit to reach the point last seen; after it the robot looks around where it is."""


@record_kernel()
def steer_robot(
    beliefs: NDArray[Any],
    parameters: NDArray[Any],
    memory: NDArray[Any],
    times_s: NDArray[np.float64],
    out: NDArray[np.float64],
) -> None:
    """Write the commands of B beliefs (B,), each from the belief alone; see ``catalogue.Kernel``.

    A target in view, or out of view for less than ``patience_s``, is kept in the picture at a distance; where the
    straight path is blocked, as at a corner, the robot follows the target's trail. A target lost for longer is searched
    for: along its trail to where it was last seen, on in its direction of travel, then all around, likely directions
    first.

    Args:
        parameters: (1,) record of ``ReentryRobotParameters``.
    """
    p = parameters[0]
    for k in range(len(beliefs)):
        b = beliefs[k]
        out[k, 1] = out[k, 2] = 0.0
        if b.frames == 0.0 or (b.trail_places == 0.0 and b.known == 0.0):
            out[k, 0] = out[k, 3] = 0.0
        elif b.known > 0.0 or b.seconds_since_seen < p.patience_s:
            out[k, 0], out[k, 3] = _follow(b, p)
        else:
            out[k, 0], out[k, 3] = _search(b, p)


@record_kernel()
def _follow(b: Any, p: Any) -> tuple[float, float]:
    """Return forward speed and turn rate to keep the target in the picture and at its distance."""
    # Without an estimate the belief keeps the last position; the target's motion is extrapolated.
    gone_s = (1.0 - b.known) * min(b.seconds_since_seen, p.onward_s)
    ahead_mps, left_mps = _velocity(b)
    ahead_m, left_m = _in_own_frame(b, b.x_m, b.y_m)
    ahead_m, left_m = ahead_m + gone_s * ahead_mps, left_m + gone_s * left_mps
    distance_m = max(np.hypot(ahead_m, left_m), _NEAREST_M)
    past_mps = ahead_mps - b.own_ahead_mps
    soon_ahead_m, soon_left_m = ahead_m + p.turn_lead_s * past_mps, left_m + p.turn_lead_s * left_mps
    if ahead_m > 0.0:
        soon_ahead_m = max(soon_ahead_m, _NEAREST_M)
    bearing_rad = np.arctan2(soon_left_m, soon_ahead_m)
    # Turn rate of the line of sight, from the target's velocity relative to the robot's.
    line_rad_s = (ahead_m * left_mps - left_m * past_mps) / distance_m**2
    away_mps = (ahead_m * ahead_mps + left_m * left_mps) / distance_m
    # Far enough away to have all possible positions of a target out of view in the picture.
    wanted_m = max(p.distance_m, p.stray_mps * b.seconds_since_seen / max(b.half_right_m, 0.1))
    forward_mps = p.speed_gain_per_s * (distance_m - wanted_m) + p.speed_feed_forward * away_mps
    course_rad = bearing_rad
    if forward_mps > 0.0:
        course_rad = _course_rad(b, p, bearing_rad, forward_mps)
        forward_mps *= max(np.cos(course_rad), 0.0)
    return forward_mps, p.turn_gain_per_s * course_rad + p.turn_feed_forward * line_rad_s


@record_kernel()
def _course_rad(b: Any, p: Any, bearing_rad: float, forward_mps: float) -> float:
    """Return the course, positive to the left of the heading, that follows the trail with the target in view."""
    index = _next_on_trail(b, p.carrot_m)
    if index < 0:
        return bearing_rad
    ahead_m, left_m = _in_own_frame(b, b.trail_x_m[index], b.trail_y_m[index])
    # A robot much slower than commanded is blocked by an obstacle.
    blocked = min(max(1.0 - b.own_ahead_mps / max(forward_mps, 0.1), 0.0), 1.0)
    share = p.trail_share + (1.0 - p.trail_share) * blocked
    aside_rad = share * _wrapped(np.arctan2(left_m, ahead_m) - bearing_rad)
    return bearing_rad + min(max(aside_rad, -p.aside_rad), p.aside_rad)


@record_kernel()
def _next_on_trail(b: Any, carrot_m: float) -> int:
    """Return the index of the first trail point after the nearest one that is farther than ``carrot_m``, or -1."""
    nearest, best_m = -1, np.inf
    for place in range(int(b.trail_places)):
        off_m = np.hypot(b.trail_x_m[place] - b.carrier_x_m, b.trail_y_m[place] - b.carrier_y_m)
        # Where the trail crosses itself the later point counts.
        if off_m < best_m - 0.1:
            nearest, best_m = place, off_m
    for place in range(nearest, -1, -1):
        if np.hypot(b.trail_x_m[place] - b.carrier_x_m, b.trail_y_m[place] - b.carrier_y_m) > carrot_m:
            return place
    return -1


@record_kernel()
def _search(b: Any, p: Any) -> tuple[float, float]:
    """Return forward speed and turn rate along the trail to where the target was last seen, then around there."""
    onward_s = min(b.seconds_since_seen, p.onward_s)
    ahead_mps, left_mps = _velocity(b)
    ahead_m, left_m = _in_own_frame(b, b.seen_x_m, b.seen_y_m)
    ahead_m, left_m = ahead_m + onward_s * ahead_mps, left_m + onward_s * left_mps
    distance_m = np.hypot(ahead_m, left_m)
    if distance_m < p.reached_m or b.seconds_since_seen > p.patience_s + _ARRIVE_S:
        turn_rad = _unsearched_rad(b, p)
        return 0.0, min(max(p.turn_gain_per_s * turn_rad, -p.look_rad_s), p.look_rad_s)
    index = _next_on_trail(b, p.carrot_m)
    if index >= 0:
        ahead_m, left_m = _in_own_frame(b, b.trail_x_m[index], b.trail_y_m[index])
    course_rad = np.arctan2(left_m, ahead_m)
    return _FASTEST_MPS * max(np.cos(course_rad), 0.0) ** 2, p.turn_gain_per_s * course_rad


@record_kernel()
def _unsearched_rad(b: Any, p: Any) -> float:
    """Return the turn, positive to the left, to the best direction to search: not searched lately, near the target's
    direction of travel, and not far to turn.
    """
    went_rad = np.arctan2(b.velocity_y_mps, b.velocity_x_mps)
    best, best_rad = -np.inf, 0.0
    for sector in range(SECTORS):
        direction_rad = 2.0 * np.pi * sector / SECTORS
        turn_rad = _wrapped(direction_rad - b.heading_rad)
        worth = p.ahead_rather * np.cos(direction_rad - went_rad) - p.turn_cost * abs(turn_rad)
        worth += np.log(max(1.0 - b.searched[sector], 1e-3))
        if worth > best:
            best, best_rad = worth, turn_rad
    return best_rad


@record_kernel()
def _velocity(b: Any) -> tuple[float, float]:
    """Return the target's velocity ahead and to the left, limited to a person's speed."""
    ahead_mps, left_mps = b.velocity_ahead_mps, -b.velocity_right_mps
    slower = min(1.0, _FASTEST_MPS / max(np.hypot(ahead_mps, left_mps), 1e-9))
    return slower * ahead_mps, slower * left_mps


@record_kernel()
def _in_own_frame(b: Any, x_m: float, y_m: float) -> tuple[float, float]:
    """Return a point's coordinates ahead and to the left of the robot."""
    c, s = np.cos(b.heading_rad), np.sin(b.heading_rad)
    east_m, north_m = x_m - b.carrier_x_m, y_m - b.carrier_y_m
    return c * east_m + s * north_m, c * north_m - s * east_m


@record_kernel()
def _wrapped(angle_rad: float) -> float:
    return (angle_rad + np.pi) % (2.0 * np.pi) - np.pi


@dataclass(frozen=True)
class ReentryRobotParameters:
    """Settings.

    Attributes:
        turn_gain_per_s: turn rate per radian of bearing.
        turn_lead_s: prediction time of the target's bearing.
        turn_feed_forward: share of the line of sight's turn rate that is added to the turn rate.
        speed_gain_per_s: speed per metre that the target is too far away.
        speed_feed_forward: share of the target's speed away from the robot that is added to the speed.
        distance_m: distance to keep.
        stray_mps: assumed sideways speed of a target out of view; the robot keeps far enough away to have all its
            possible positions in the picture.
        patience_s: time without an estimate during which the target's motion is extrapolated.
        carrot_m: look-ahead distance on the target's trail (pure pursuit).
        trail_share: how far the robot steers to the trail while the straight path is free; 0: not at all.
        aside_rad: largest angle between the course and the target's bearing; half the picture is 0.58.
        onward_s: time by which the search extrapolates the target's motion from the point last seen.
        reached_m: distance to that point at which the robot looks around.
        look_rad_s: turn rate while looking around.
        ahead_rather: weight of the target's direction of travel when looking around; 0: none.
        turn_cost: weight of each radian to turn when looking around.
    """

    turn_gain_per_s: float = tunable(2.2, 0.5, 6.0, log=True)
    turn_lead_s: float = tunable(0.2, 0.0, 0.6)
    turn_feed_forward: float = tunable(0.5, 0.0, 1.0)
    speed_gain_per_s: float = tunable(1.1, 0.3, 3.0, log=True)
    speed_feed_forward: float = tunable(0.8, 0.0, 1.0)
    distance_m: float = tunable(2.2, 1.2, 3.0)
    stray_mps: float = tunable(0.5, 0.0, 1.0)
    patience_s: float = tunable(3.0, 0.0, 5.0)
    carrot_m: float = tunable(0.9, 0.5, 1.6)
    trail_share: float = tunable(0.3, 0.0, 1.0)
    aside_rad: float = tunable(0.35, 0.1, 0.5)
    onward_s: float = tunable(1.0, 0.0, 4.0)
    reached_m: float = tunable(0.6, 0.3, 1.5)
    look_rad_s: float = tunable(1.0, 0.4, 1.6)
    ahead_rather: float = tunable(0.5, 0.0, 1.5)
    turn_cost: float = tunable(0.5, 0.0, 1.5)


@register_controller(
    "reentry", role="ours", carrier="robot", summary="steers by the belief; looks to where the target must come back"
)
class ReentryRobotController(KernelController):
    """Steers by ``steer_robot``; the belief's trail of the target needs measured poses (odometry)."""

    Parameters = ReentryRobotParameters
    LOOKS, KERNEL = "ahead", Kernel(steer_robot, record_dtype(ReentryRobotParameters))
