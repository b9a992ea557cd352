"""The features of one target's belief through one episode: the same for a policy in an env and as a controller."""

from __future__ import annotations

from typing import get_args

import numpy as np
from numpy.typing import NDArray

from trackers.belief.belief_filter import BeliefKeeper
from trackers.belief.features import FEATURES, features_of
from trackers.types import CameraCommand, Carrier, CommandName, Estimate, Observation


class FeatureKeeper:
    """Takes in what a tracker says of each picture, and what was commanded on the one before."""

    def __init__(self, carrier: Carrier) -> None:
        limits = {axis.name: axis.limit for axis in carrier.axes}
        self._limits = np.array([limits.get(name, np.inf) for name in get_args(CommandName)])
        self._keeper = BeliefKeeper(carrier.looks)

    def update(self, observation: Observation, estimate: Estimate, given: CameraCommand) -> NDArray[np.float32]:
        """Return the features (``len(FEATURES)``,) in [-1, 1] of the belief after the next picture, a fresh array.

        Args:
            given: the latest command, as it was given: zeros before the first.
        """
        belief = self._keeper.update(observation, estimate)
        command = np.array([[getattr(given, name) for name in get_args(CommandName)]]) / self._limits
        features = np.zeros((1, len(FEATURES)), np.float32)
        features_of(belief, np.clip(command, -1.0, 1.0), features)
        return np.clip(features[0], -1.0, 1.0)
