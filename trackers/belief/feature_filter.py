"""The features of one target's belief through one episode: the same for a policy in an env and as a controller."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from trackers.belief.belief_filter import BeliefKeeper
from trackers.belief.features import FEATURES, features_of
from trackers.types import CameraCommand, Carrier, Estimate, Observation

_COMMAND_SLOTS = (
    ("forward_mps", "zoom_per_s"),
    ("right_mps",),
    ("climb_mps", "tilt_rad_s"),
    ("yaw_rate_rad_s", "pan_rad_s"),
)
"""What the four numbers of the latest command are: of a carrier that moves as a whole, or of a pan-tilt-zoom head."""


class FeatureKeeper:
    """Takes in what a tracker says of each picture, and what was commanded on the one before."""

    def __init__(self, carrier: Carrier) -> None:
        limits: dict[str, float] = {axis.name: axis.limit for axis in carrier.axes}
        self._names = [next((name for name in slot if name in limits), slot[0]) for slot in _COMMAND_SLOTS]
        self._limits = np.array([limits.get(name, np.inf) for name in self._names])
        self._keeper = BeliefKeeper(carrier.looks)

    def update(self, observation: Observation, estimate: Estimate, given: CameraCommand) -> NDArray[np.float32]:
        """Return the features (``len(FEATURES)``,) in [-1, 1] of the belief after the next picture, a fresh array.

        Args:
            given: the latest command, as it was given: zeros before the first.
        """
        belief = self._keeper.update(observation, estimate)
        command = np.array([[getattr(given, name) for name in self._names]]) / self._limits
        features = np.zeros((1, len(FEATURES)), np.float32)
        features_of(belief, np.clip(command, -1.0, 1.0), features)
        return np.clip(features[0], -1.0, 1.0)
