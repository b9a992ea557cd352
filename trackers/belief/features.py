"""A belief as a vector of numbers in [-1, 1]: the observation of a policy.

Ahead and right are horizontal, along and across the carrier's heading. Halves of the picture are measured on the ground
below a camera that looks down, at a distance of 1 m for one that looks ahead, and at the optical axis' point on the
ground for one that looks around. If the tracker watches another camera than the steered one, picture and height are
those of the steered camera. Squashed means ``x / (1 + |x|)``.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackers.belief.kernel import SECTORS, SEEN_PROBABILITY
from trackers.belief.sighting import BeliefFilter
from trackers.kernels.records import record_kernel
from trackers.types import CameraCommand, Carrier, Estimate, Observation

COMMANDS = 4
_SPEED_MPS, _TURN_RAD_S, _HEIGHT_M, _SPREAD_M, _SECONDS = 10.0, 1.0, 60.0, 5.0, 2.0
_HALVES = "in halves of the picture on the ground, squashed"
_SPEED, _TURN = f"over {_SPEED_MPS:g} m/s, squashed", f"over {_TURN_RAD_S:g} rad/s, squashed"

MEANINGS = {
    "known": "1 if the tracker answers on this picture, else 0",
    "in_view_probability": "the tracker's probability in [0, 1] that the target is in view; if it gives none, 1 while "
    "its estimate lies in the picture; 0 while it does not answer",
    "picture_x": "estimate, right of the picture's centre, in halves of its width, squashed",
    "picture_y": "estimate, below the picture's centre, in halves of its height, squashed",
    "length_share": "4 times the longer side of the estimated box over the picture's width, squashed; 0 without a box",
    "ahead": f"estimate, ahead of the carrier, {_HALVES}",
    "right": f"estimate, right of the carrier, {_HALVES}",
    "velocity_ahead": f"target's velocity along the carrier's heading, filtered from the estimates, {_SPEED}",
    "velocity_right": f"the same to the right, {_SPEED}",
    "spread": f"standard deviation of the posterior, mean of both axes, over {_SPREAD_M:g} m, squashed; 0 without one",
    "densest_ahead": f"centre of the picture-sized window that holds most of the posterior, ahead, {_HALVES}",
    "densest_right": f"the same, right, {_HALVES}",
    "densest_share": "share in [0, 1] of the posterior in that window",
    "since_seen": f"time since the tracker last gave a probability of 0.5 or more, over {_SECONDS:g} s, squashed",
    "seen_ahead": f"place where it then was, ahead of the carrier, {_HALVES}",
    "seen_right": f"the same, right, {_HALVES}",
    "height": f"camera's measured height, over {_HEIGHT_M:g} m, squashed",
    "axis_ahead": f"point on the ground that the camera looks at, ahead of the carrier, {_HALVES}",
    "axis_right": f"the same, right, {_HALVES}",
    "axis_ahead_motion": "its measured motion ahead in a second, smoothed, in the same unit, squashed",
    "axis_right_motion": "the same to the right",
    "own_ahead": f"carrier's measured velocity ahead, smoothed, {_SPEED}",
    "own_right": f"the same to the right, {_SPEED}",
    "own_climb": f"the same upwards, {_SPEED}",
    "own_yaw_rate": f"carrier's measured turn rate, counter-clockwise, smoothed, {_TURN}",
    **{
        f"searched_{sector}": f"set to 1 when the camera looks {360 * sector // SECTORS}° counter-clockwise from ahead "
        "of the place last seen, without success; decays within seconds"
        for sector in range(SECTORS)
    },
    "command_forward": "latest command ahead, over the carrier's limit, in [-1, 1]; 0 on an axis that it lacks; "
    "of a head that pans, tilts and zooms: to zoom in",
    "command_right": "the same to the right; of a head: 0",
    "command_climb": "the same upwards; of a head: to tilt upwards",
    "command_yaw_rate": "the same of the turn rate, counter-clockwise; of a head: to pan counter-clockwise",
}
"""Feature -> meaning, in the order of the vector."""
FEATURES = tuple(MEANINGS)
_NEVER_NEGATIVE = ("known", "in_view_probability", "length_share", "spread", "densest_share", "since_seen")
RANGES = {name: (0.0 if name in _NEVER_NEGATIVE or name.startswith("searched_") else -1.0, 1.0) for name in FEATURES}
"""Feature -> its smallest and largest value."""


@record_kernel()
def features_of(beliefs: NDArray[np.void], commands: NDArray[np.float64], out: NDArray[np.float32]) -> None:
    """Write the features of B beliefs (B,) of dtype ``BELIEF`` to ``out`` (B, ``len(FEATURES)``) float32.

    Args:
        commands: (B, 4) latest commands (forward, right, climb, yaw rate) as shares of the limits, in [-1, 1].
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


@record_kernel()
def _squashed(x: float) -> float:
    return x / (1.0 + abs(x))


class FeatureFilter:
    """Computes the features from a tracker's estimates and the commands given."""

    def __init__(self, carrier: Carrier, beliefs: BeliefFilter | None = None) -> None:
        """``beliefs``: filters the estimates; None = one of its own."""
        limits: dict[str, float] = {axis.name: axis.limit for axis in carrier.axes}
        self._limits = {name: limits.get(name, np.inf) for name in carrier.commands}
        self._beliefs = beliefs or BeliefFilter(carrier.looks)

    def update(self, observation: Observation, estimate: Estimate, given: CameraCommand) -> NDArray[np.float32]:
        """Return the features (``len(FEATURES)``,) in [-1, 1] of the belief after the next picture, a new array.

        Args:
            given: the latest command; zeros before the first.
        """
        belief = self._beliefs.update(observation, estimate)
        shares = [min(max(getattr(given, name) / limit, -1.0), 1.0) for name, limit in self._limits.items()]
        features = np.zeros((1, len(FEATURES)), np.float32)
        features_of(belief, np.array([shares]), features)
        return _clipped(features[0])


class FeatureHistory:
    """Features of B beliefs, and how they have changed since each of the pictures before.

    Attributes:
        width: numbers for each belief, ``(1 + frames) * len(FEATURES)``.
    """

    def __init__(self, count: int, frames: int) -> None:
        self.width = (1 + frames) * len(FEATURES)
        self._latest = np.zeros((count, 1 + frames, len(FEATURES)), np.float32)

    def begin(self, features: NDArray[np.float32], which: NDArray[Any] | slice = slice(None)) -> None:
        """Begin episodes of the beliefs ``which`` (K,) with features (K, F): nothing has changed yet."""
        self._latest[which] = features[:, None]

    def add(self, features: NDArray[np.float32]) -> None:
        """Add the features (B, F) of the next picture."""
        self._latest[:, 1:] = self._latest[:, :-1]
        self._latest[:, 0] = features

    def numbers(self, which: NDArray[Any] | slice = slice(None)) -> NDArray[np.float32]:
        """Return (K, width): the features, what they have changed since the picture before, since the one before, …"""
        numbers = self._latest[which].copy()
        numbers[:, 1:] = numbers[:, :1] - numbers[:, 1:]
        return numbers.reshape(len(numbers), self.width)


def command_of(carrier: Carrier, shares: NDArray[np.float64]) -> CameraCommand:
    """Return the command of shares (A,) of the limits, in the order of the carrier's axes, clipped to [-1, 1]."""
    values = _clipped(shares).tolist()
    return CameraCommand(**{axis.name: axis.limit * v for axis, v in zip(carrier.axes, values, strict=True)})


def shares_of(carrier: Carrier, command: CameraCommand) -> NDArray[np.float64]:
    """Return a command as shares (A,) of the carrier's limits, clipped to [-1, 1]."""
    return _clipped(np.array([getattr(command, axis.name) / axis.limit for axis in carrier.axes], dtype=float))


def _clipped(numbers: NDArray[Any]) -> NDArray[Any]:
    """Return numbers clipped to [-1, 1]: of so few ``np.clip`` takes three times as long."""
    return np.asarray(np.minimum(np.maximum(numbers, -1.0), 1.0))


def is_seen(estimate: Estimate) -> bool:
    """Return whether an estimate puts its target in view; without an in-view probability any finite estimate does."""
    if not np.isfinite(estimate.position_px).all():
        return False
    return estimate.in_view_probability is None or estimate.in_view_probability >= SEEN_PROBABILITY
