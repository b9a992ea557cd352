"""The steering law of ``reentry`` for a ground robot whose camera looks ahead, for many beliefs at a time."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from trackers.kernels.belief import SECTORS

REENTRY_ROBOT = np.dtype(
    [
        (name, "f8")
        for name in (
            "turn_gain_per_s",
            "turn_lead_s",
            "turn_feed_forward",
            "speed_gain_per_s",
            "speed_feed_forward",
            "distance_m",
            "slowest_mps",
            "patience_s",
            "onward_s",
            "reached_m",
            "look_rad_s",
            "ahead_rather",
            "turn_cost",
        )
    ],
    align=True,
)
"""What ``ReentryRobotParameters`` says, as the kernel reads it."""
_NEAREST_M = 0.4
"""Bearings to what is nearer change too fast to be followed."""
_SEARCHED = 0.05
"""A direction that was looked in so long ago is as good as new."""


@njit(cache=True)
def steer_robot(beliefs: NDArray[Any], parameters: NDArray[Any], out: NDArray[np.float64]) -> None:
    """Write what to command by B beliefs (B,) of dtype ``BELIEF`` to (B, 4): forward, right, climb in m/s, yaw in
    rad/s; right and climb are 0.

    A target in sight, or for moments out of it, is faced where it will be, and followed at a distance. One lost for
    longer is looked for: where it was last seen going, then all around there, likely directions first.

    Args:
        parameters: (1,) of dtype ``REENTRY_ROBOT``.
    """
    p = parameters[0]
    for k in range(len(beliefs)):
        b = beliefs[k]
        if b.frames == 0.0:
            forward_mps, yaw_rate_rad_s = 0.0, 0.0
        elif b.known > 0.0 or b.seconds_since_seen < p.patience_s:
            forward_mps, yaw_rate_rad_s = _follow(b, p)
        else:
            forward_mps, yaw_rate_rad_s = _look_for(b, p)
        out[k, 0], out[k, 1], out[k, 2], out[k, 3] = forward_mps, 0.0, 0.0, yaw_rate_rad_s


@njit(cache=True)
def _follow(b: Any, p: Any) -> tuple[float, float]:
    """Return forward speed and turn rate to face the target and keep its distance."""
    # While nothing is said the record keeps the place; he has gone on.
    gone_s = (1.0 - b.known) * b.seconds_since_seen
    ahead_m = _ahead(b, b.x_m, b.y_m) + gone_s * b.velocity_ahead_mps
    left_m = -_right(b, b.x_m, b.y_m) - gone_s * b.velocity_right_mps
    ahead_mps, left_mps = b.velocity_ahead_mps, -b.velocity_right_mps
    soon_ahead_m = ahead_m + p.turn_lead_s * (ahead_mps - b.own_ahead_mps)
    soon_left_m = left_m + p.turn_lead_s * left_mps
    bearing_rad = np.arctan2(soon_left_m, max(soon_ahead_m, _NEAREST_M) if ahead_m > 0.0 else soon_ahead_m)
    distance_m = np.hypot(ahead_m, left_m)
    near_m = max(distance_m, _NEAREST_M)
    # How fast the line to it turns, by its motion past the robot's.
    line_rad_s = (ahead_m * left_mps - left_m * (ahead_mps - b.own_ahead_mps)) / near_m**2
    away_mps = (ahead_m * ahead_mps + left_m * left_mps) / near_m
    forward_mps = p.speed_gain_per_s * (distance_m - p.distance_m) + p.speed_feed_forward * away_mps
    facing = max(ahead_m / near_m, 0.0)
    return forward_mps * facing, p.turn_gain_per_s * bearing_rad + p.turn_feed_forward * line_rad_s


@njit(cache=True)
def _look_for(b: Any, p: Any) -> tuple[float, float]:
    """Return forward speed and turn rate to go where the target was last seen going, and to look around there."""
    onward_s = min(b.seconds_since_seen, p.onward_s)
    x_m, y_m = b.seen_x_m + onward_s * b.velocity_x_mps, b.seen_y_m + onward_s * b.velocity_y_mps
    ahead_m, left_m = _ahead(b, x_m, y_m), -_right(b, x_m, y_m)
    distance_m = np.hypot(ahead_m, left_m)
    if distance_m > p.reached_m and not _has_looked(b):
        facing = max(ahead_m / distance_m, 0.0)
        speed_mps = max(p.speed_gain_per_s * distance_m, p.slowest_mps)
        return facing * speed_mps, p.turn_gain_per_s * np.arctan2(left_m, ahead_m)
    turn_rad = _unsearched_rad(b, p)
    return 0.0, min(max(p.turn_gain_per_s * turn_rad, -p.look_rad_s), p.look_rad_s)


@njit(cache=True)
def _has_looked(b: Any) -> bool:
    """Return whether it has begun to look around: some direction from the place last seen was looked in."""
    for sector in range(SECTORS):
        if b.searched[sector] > _SEARCHED:
            return True
    return False


@njit(cache=True)
def _unsearched_rad(b: Any, p: Any) -> float:
    """Return how far to turn, to the left, to the direction most worth looking in: not looked in of late, about as the
    target went, and not far to turn to.
    """
    went_rad = np.arctan2(b.velocity_y_mps, b.velocity_x_mps)
    if b.velocity_x_mps == 0.0 and b.velocity_y_mps == 0.0:
        went_rad = b.heading_rad
    best, best_rad = -np.inf, 0.0
    for sector in range(SECTORS):
        direction_rad = 2.0 * np.pi * sector / SECTORS
        turn_rad = _wrapped(direction_rad - b.heading_rad)
        worth = (1.0 - b.searched[sector]) * np.exp(p.ahead_rather * np.cos(direction_rad - went_rad))
        worth *= np.exp(-p.turn_cost * abs(turn_rad))
        if worth > best:
            best, best_rad = worth, turn_rad
    return best_rad


@njit(cache=True)
def _ahead(b: Any, x_m: float, y_m: float) -> float:
    return np.cos(b.heading_rad) * (x_m - b.carrier_x_m) + np.sin(b.heading_rad) * (y_m - b.carrier_y_m)


@njit(cache=True)
def _right(b: Any, x_m: float, y_m: float) -> float:
    return np.sin(b.heading_rad) * (x_m - b.carrier_x_m) - np.cos(b.heading_rad) * (y_m - b.carrier_y_m)


@njit(cache=True)
def _wrapped(angle_rad: float) -> float:
    return (angle_rad + np.pi) % (2.0 * np.pi) - np.pi
