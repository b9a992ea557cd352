"""The belief about one target during one episode, filtered from a tracker's estimates."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from trackers.belief.kernel import BELIEF, update_beliefs
from trackers.belief.sighting import sighting_of
from trackers.types import Estimate, Looks, Observation


class BeliefFilter:
    """Filters a tracker's estimates to a belief.

    Attributes:
        belief: (1,) of dtype ``BELIEF``, updated in place.
        interval_s: time between the last two pictures.
    """

    def __init__(self, looks: Looks) -> None:
        self._looks: Looks = looks
        self._time_s = 0.0
        self.interval_s = 1.0
        self.belief = np.zeros(1, BELIEF)

    def update(self, observation: Observation, estimate: Estimate) -> NDArray[np.void]:
        """Update the belief with the next picture's estimate and return it (1,)."""
        if observation.time_s > self._time_s:
            self.interval_s = observation.time_s - self._time_s
        self._time_s = observation.time_s
        update_beliefs(self.belief, sighting_of(self._looks, observation, estimate), self.interval_s)
        return self.belief
