"""The features of one target's belief during one episode, for a policy in an env and as a controller alike."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from trackers.belief.belief_filter import BeliefFilter
from trackers.belief.features import FEATURES, features_of
from trackers.types import CameraCommand, Carrier, Estimate, Observation

_COMMAND_SLOTS = (
    ("forward_mps", "zoom_per_s"),
    ("right_mps",),
    ("climb_mps", "tilt_rad_s"),
    ("yaw_rate_rad_s", "pan_rad_s"),
)
"""The four command features: axes of a carrier that moves as a whole, or of a pan-tilt-zoom head."""


class FeatureFilter:
    """Computes the features from a tracker's estimates and the commands given."""

    def __init__(self, carrier: Carrier) -> None:
        limits: dict[str, float] = {axis.name: axis.limit for axis in carrier.axes}
        self._names = [next((name for name in slot if name in limits), slot[0]) for slot in _COMMAND_SLOTS]
        self._limits = np.array([limits.get(name, np.inf) for name in self._names])
        self._filter = BeliefFilter(carrier.looks)

    def update(self, observation: Observation, estimate: Estimate, given: CameraCommand) -> NDArray[np.float32]:
        """Return the features (``len(FEATURES)``,) in [-1, 1] of the belief after the next picture, a new array.

        Args:
            given: the latest command; zeros before the first.
        """
        belief = self._filter.update(observation, estimate)
        command = np.array([[getattr(given, name) for name in self._names]]) / self._limits
        features = np.zeros((1, len(FEATURES)), np.float32)
        features_of(belief, np.clip(command, -1.0, 1.0), features)
        return np.clip(features[0], -1.0, 1.0)
