"""Keeps the belief of one target through one episode: what a controller steers by, and a policy sees."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from trackers.belief.kernel import BELIEF, take_in
from trackers.belief.sighting import sighting_of
from trackers.types import Estimate, Looks, Observation


class BeliefKeeper:
    """Takes in what a tracker says of each picture.

    Attributes:
        belief: (1,) of dtype ``BELIEF``, updated in place.
        interval_s: between the latest two pictures.
    """

    def __init__(self, looks: Looks) -> None:
        self._looks: Looks = looks
        self._time_s = 0.0
        self.interval_s = 1.0
        self.belief = np.zeros(1, BELIEF)

    def update(self, observation: Observation, estimate: Estimate) -> NDArray[np.void]:
        """Take in the next picture and return the belief (1,)."""
        if observation.time_s > self._time_s:
            self.interval_s = observation.time_s - self._time_s
        self._time_s = observation.time_s
        take_in(self.belief, sighting_of(self._looks, observation, estimate), self.interval_s)
        return self.belief
