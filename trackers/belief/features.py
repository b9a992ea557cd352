"""A belief as a vector of numbers in [-1, 1]: what a policy is told."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from trackers.belief.kernel import SECTORS

FEATURES = (
    "known",
    "in_view_probability",
    "picture_x",
    "picture_y",
    "length_share",
    "ahead",
    "right",
    "velocity_ahead",
    "velocity_right",
    "spread",
    "densest_ahead",
    "densest_right",
    "densest_share",
    "since_seen",
    "seen_ahead",
    "seen_right",
    "height",
    "axis_ahead",
    "axis_right",
    "axis_ahead_motion",
    "axis_right_motion",
    "own_ahead",
    "own_right",
    "own_climb",
    "own_yaw_rate",
    *(f"searched_{sector}" for sector in range(SECTORS)),
    "command_forward",
    "command_right",
    "command_climb",
    "command_yaw_rate",
)
"""Names of the numbers, in order. Lengths are in halves of the picture on the ground (at the target's distance of a
camera that looks ahead) and, as speeds and times, squashed by x / (1 + |x|); ``searched`` counts counter-clockwise from
ahead; ``command`` is the latest one over its limits."""
COMMANDS = 4
_SPEED_MPS, _TURN_RAD_S, _HEIGHT_M, _SPREAD_M, _SECONDS = 10.0, 1.0, 60.0, 5.0, 2.0


@njit(cache=True)
def features_of(beliefs: NDArray[np.void], commands: NDArray[np.float64], out: NDArray[np.float32]) -> None:
    """Write the features of B beliefs (B,) of dtype ``BELIEF`` to (B, ``len(FEATURES)``) float32.

    Args:
        commands: (B, 4) the latest command (forward, right, climb, yaw rate) over its limits, in [-1, 1].
    """
    for k in range(len(beliefs)):
        b, row = beliefs[k], out[k]
        ahead, right = max(b.half_ahead_m, 1e-3), max(b.half_right_m, 1e-3)
        c, s = np.cos(b.heading_rad), np.sin(b.heading_rad)
        east_m, north_m = b.seen_x_m - b.carrier_x_m, b.seen_y_m - b.carrier_y_m
        row[0] = b.known
        row[1] = b.in_view_probability
        row[2] = _squashed(b.picture_x)
        row[3] = _squashed(b.picture_y)
        row[4] = _squashed(4.0 * b.length_share)
        row[5] = _squashed(b.ahead_m / ahead)
        row[6] = _squashed(b.right_m / right)
        row[7] = _squashed(b.velocity_ahead_mps / _SPEED_MPS)
        row[8] = _squashed(b.velocity_right_mps / _SPEED_MPS)
        row[9] = _squashed(b.spread_m / _SPREAD_M)
        row[10] = _squashed(b.densest_ahead_m / ahead)
        row[11] = _squashed(b.densest_right_m / right)
        row[12] = b.densest_share
        row[13] = _squashed(b.seconds_since_seen / _SECONDS)
        row[14] = _squashed((c * east_m + s * north_m) / ahead)
        row[15] = _squashed((s * east_m - c * north_m) / right)
        row[16] = _squashed(b.height_m / _HEIGHT_M)
        row[17] = _squashed(b.axis_ahead_m / ahead)
        row[18] = _squashed(b.axis_right_m / right)
        row[19] = _squashed(b.axis_ahead_mps / ahead)
        row[20] = _squashed(b.axis_right_mps / right)
        row[21] = _squashed(b.own_ahead_mps / _SPEED_MPS)
        row[22] = _squashed(b.own_right_mps / _SPEED_MPS)
        row[23] = _squashed(b.own_climb_mps / _SPEED_MPS)
        row[24] = _squashed(b.own_yaw_rate_rad_s / _TURN_RAD_S)
        turned = int(np.floor(b.heading_rad / (2 * np.pi) * SECTORS + 0.5))
        for sector in range(SECTORS):
            row[25 + sector] = b.searched[(sector + turned) % SECTORS]
        for axis in range(COMMANDS):
            row[25 + SECTORS + axis] = commands[k, axis]


@njit(cache=True)
def _squashed(x: float) -> float:
    return x / (1.0 + abs(x))
