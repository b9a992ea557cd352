"""How much more likely a candidate's measures are of the target than of anything else, both learnt while
tracking.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from trackers.mosaic_graph.kernels import oriented_box as ob

_FEATURES = (ob.INSIDE, ob.AROUND, ob.MISMATCH, ob.MOVED, ob.MOVED_AROUND)
# Means, deviations and least deviations of the measures, and how many pictures this prior is worth: medians
# over development episodes.
_TARGET = (np.array([3.2, -2.6, 14.0, 58.0, 10.0]), np.array([0.8, 1.0, 8.0, 18.0, 8.0]), 6.0)
_REST = (np.array([0.4, -2.4, 30.0, 25.0, 15.0]), np.array([1.3, 1.1, 14.0, 20.0, 12.0]), 40.0)
_TARGET_FLOOR = np.array([0.6, 0.8, 8.0, 15.0, 10.0])
_REST_FLOOR = np.array([0.8, 0.8, 10.0, 15.0, 8.0])
_LONGEST_MEMORY = 150.0
# A normal's tails would make one odd measure decide; beyond so many deviations squared, more says no more.
# Colour may decide alone.
_TAILS = np.array([14.0, 6.0, 8.0, 6.0, 3.0])
_LEAST, _MOST = -6.0, 6.0
# How much each measure is to be believed: logistic regression of "is the target, just back in view" on the
# differences of log-densities, over development episodes. What surrounds the car changes with the place,
# and says nothing.
_WORTH = np.array([1.2, 0.0, 1.0, 2.0, 0.3])
_MOSTLY_KNOWN = 0.5


class _Class:
    """Running mean and deviation of the features of one class, begun from a prior."""

    def __init__(
        self, prior: tuple[NDArray[np.float64], NDArray[np.float64], float], floor: NDArray[np.float64]
    ) -> None:
        self._mean = prior[0].copy()
        self._square = prior[1] ** 2
        self._count = np.full(len(_FEATURES), prior[2])
        self._floor = floor

    def learn(self, features: NDArray[np.float64]) -> None:
        """Take in features (F,); NaN = not measured."""
        given = np.isfinite(features)
        self._count[given] = np.minimum(self._count[given] + 1, _LONGEST_MEMORY)
        surprise = np.where(given, features - self._mean, 0.0)
        rate = 1.0 / self._count
        self._mean += rate * surprise
        self._square += rate * np.where(given, surprise**2 - self._square, 0.0)

    def recentre(self, features: NDArray[np.float64]) -> None:
        """Put the means at features (F,), where they are given."""
        self._mean = np.where(np.isfinite(features), features, self._mean)

    def log_density(self, features: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the log of a heavy-tailed normal density at each feature (F,)."""
        deviation = np.maximum(np.sqrt(self._square), self._floor)
        return -0.5 * np.minimum(((features - self._mean) / deviation) ** 2, _TAILS) - np.log(deviation)


class Likeness:
    """Two naive Bayes classes over the measures of ``trackers.mosaic_graph.kernels.oriented_box``: the target, and all
    else.
    """

    def __init__(self) -> None:
        self._target = _Class(_TARGET, _TARGET_FLOOR)
        self._rest = _Class(_REST, _REST_FLOOR)

    def log_ratio(self, measures: NDArray[np.float64]) -> float:
        """Return ``log p(measures | target) - log p(measures | rest)`` of measures (MEASURES,), within [-6,
        6].
        """
        features = _features(measures)
        difference = self._target.log_density(features) - self._rest.log_density(features)
        return float(np.clip(np.nansum(_WORTH * difference), _LEAST, _MOST))

    def start(self, measures: NDArray[np.float64]) -> None:
        """Take the measures (MEASURES,) of the first picture, where the target is known, in the place of
        the target's prior means.

        Its difference from the background is there one from the ground around it.
        """
        features = _features(measures)
        # The ground next to the car is what the ring sees: it hardly differs from itself.
        features[_FEATURES.index(ob.MOVED_AROUND)] = np.nan
        self._target.recentre(features)

    def learn_target(self, measures: NDArray[np.float64]) -> None:
        """Take measures (MEASURES,) as the target's."""
        self._target.learn(_features(measures))

    def learn_rest(self, measures: NDArray[np.float64]) -> None:
        """Take measures (MEASURES,) as those of something else that was found in its place."""
        self._rest.learn(_features(measures))


def _features(measures: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the features (F,) with NaN where there was no template, or the background was not known."""
    features = measures[list(_FEATURES)]
    if measures[ob.MISMATCH] == 0.0:
        features[_FEATURES.index(ob.MISMATCH)] = np.nan
    if measures[ob.KNOWN] < _MOSTLY_KNOWN:
        features[[_FEATURES.index(ob.MOVED), _FEATURES.index(ob.MOVED_AROUND)]] = np.nan
    return features
