"""Log-likelihood ratio of a candidate's measures, target against anything else; both are learnt while tracking."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from trackers.mosaic_graph.kernels import oriented_box as ob

_FEATURES = (ob.INSIDE, ob.AROUND, ob.MISMATCH, ob.MOVED, ob.MOVED_AROUND)
# Means and deviations of the measures, and the number of pictures this prior is worth: medians over development
# episodes. Below: least deviations.
_TARGET = (np.array([3.2, -2.6, 14.0, 58.0, 10.0]), np.array([0.8, 1.0, 8.0, 18.0, 8.0]), 6.0)
_REST = (np.array([0.4, -2.4, 30.0, 25.0, 15.0]), np.array([1.3, 1.1, 14.0, 20.0, 12.0]), 40.0)
_TARGET_FLOOR = np.array([0.6, 0.8, 8.0, 15.0, 10.0])
_REST_FLOOR = np.array([0.8, 0.8, 10.0, 15.0, 8.0])
_LONGEST_MEMORY = 150.0
# Greatest squared deviations: with the tails of a normal distribution one outlier would decide. Colour may.
_TAILS = np.array([14.0, 6.0, 8.0, 6.0, 3.0])
_LEAST, _MOST = -6.0, 6.0
# Weight of each measure: logistic regression of "is the target, just back in view" on the differences of
# log-densities, over development episodes. The surroundings change with the place: their weight is 0.
_WORTH = np.array([1.2, 0.0, 1.0, 2.0, 0.3])
_MOSTLY_KNOWN = 0.5


class _Class:
    """Running mean and deviation of the features of one class, starting from a prior."""

    def __init__(
        self, prior: tuple[NDArray[np.float64], NDArray[np.float64], float], floor: NDArray[np.float64]
    ) -> None:
        self._mean = prior[0].copy()
        self._square = prior[1] ** 2
        self._count = np.full(len(_FEATURES), prior[2])
        self._floor = floor

    def learn(self, features: NDArray[np.float64]) -> None:
        """Update the class with features (F,); NaN = not measured."""
        given = np.isfinite(features)
        self._count[given] = np.minimum(self._count[given] + 1, _LONGEST_MEMORY)
        surprise = np.where(given, features - self._mean, 0.0)
        rate = 1.0 / self._count
        self._mean += rate * surprise
        self._square += rate * np.where(given, surprise**2 - self._square, 0.0)

    def recentre(self, features: NDArray[np.float64]) -> None:
        """Set the means to features (F,), where these are given."""
        self._mean = np.where(np.isfinite(features), features, self._mean)

    def log_density(self, features: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the log of a heavy-tailed normal density at each feature (F,)."""
        deviation = np.maximum(np.sqrt(self._square), self._floor)
        return -0.5 * np.minimum(((features - self._mean) / deviation) ** 2, _TAILS) - np.log(deviation)


class Likeness:
    """Naive Bayes classifier of the measures of ``kernels.oriented_box``, with the classes target and rest."""

    def __init__(self) -> None:
        self._target = _Class(_TARGET, _TARGET_FLOOR)
        self._rest = _Class(_REST, _REST_FLOOR)

    def log_ratio(self, measures: NDArray[np.float64]) -> float:
        """Return ``log p(measures | target) - log p(measures | rest)`` of measures (MEASURES,), in [-6, 6]."""
        features = _features(measures)
        difference = self._target.log_density(features) - self._rest.log_density(features)
        return float(np.clip(np.nansum(_WORTH * difference), _LEAST, _MOST))

    def start(self, measures: NDArray[np.float64]) -> None:
        """Replace the target's prior means by the measures (MEASURES,) of the first picture.

        There the background is the ground around the target.
        """
        features = _features(measures)
        # The frame around the box lies on that ground: its difference is no measurement.
        features[_FEATURES.index(ob.MOVED_AROUND)] = np.nan
        self._target.recentre(features)

    def learn_target(self, measures: NDArray[np.float64]) -> None:
        """Update the target's class with measures (MEASURES,)."""
        self._target.learn(_features(measures))

    def learn_rest(self, measures: NDArray[np.float64]) -> None:
        """Update the class of the rest with measures (MEASURES,) of another candidate."""
        self._rest.learn(_features(measures))


def _features(measures: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the features (F,), with NaN where the template or the background is unknown."""
    features = measures[list(_FEATURES)]
    if measures[ob.MISMATCH] == 0.0:
        features[_FEATURES.index(ob.MISMATCH)] = np.nan
    if measures[ob.KNOWN] < _MOSTLY_KNOWN:
        features[[_FEATURES.index(ob.MOVED), _FEATURES.index(ob.MOVED_AROUND)]] = np.nan
    return features
