"""Odds that a match of the correlation filter is the target: learnt from the target, and from other places."""

from __future__ import annotations

import numpy as np

_TARGET = (np.log(0.3), 0.5, 2.0, 0.5)
_OTHERS = (np.log(0.07), 0.4, 8.0, 0.3)
"""Mean and deviation of the log of the peak, the number of pictures that this prior is worth, and the least deviation:
of a filter whose peak is about 1 where the target looks as it was learnt.
"""
_LONGEST_MEMORY = 60.0
_TAIL, _LEAST, _MOST = 4.0, -6.0, 3.5
"""Others that look like the target are rare, but not as rare as the tail of a normal distribution."""
_UNUSUAL = 0.6
_LEAST_PEAK = 1e-3


class _Class:
    """Running mean and deviation of the log of the peaks of one class, starting from a prior."""

    def __init__(self, mean: float, deviation: float, count: float, least: float) -> None:
        self.mean, self._square, self._count, self._least = mean, deviation**2, count, least

    def learn(self, value: float) -> None:
        self._count = min(self._count + 1.0, _LONGEST_MEMORY)
        surprise = value - self.mean
        self.mean += surprise / self._count
        self._square += (surprise**2 - self._square) / self._count

    def log_density(self, value: float) -> float:
        deviation = max(float(np.sqrt(self._square)), self._least)
        return -0.5 * min(abs(value - self.mean) / deviation, _TAIL) ** 2 - float(np.log(deviation))


class MatchOdds:
    """A normal distribution of the log of the peak for the target, and one for the best match without it."""

    def __init__(self) -> None:
        self._target, self._others = _Class(*_TARGET), _Class(*_OTHERS)

    def learn_target(self, peak: float) -> None:
        """Learn the peak of a match that is the target."""
        self._target.learn(_log(peak))

    def learn_other(self, peak: float) -> None:
        """Learn the peak of the best match in a place without the target."""
        self._others.learn(_log(peak))

    def is_usual(self, peak: float) -> bool:
        """Return whether a peak is more than half of the usual one: below that the target is partly hidden."""
        return _log(peak) > self._target.mean - _UNUSUAL

    def log_ratio(self, peak: float) -> float:
        """Return ``log p(peak | target) / p(peak | something else)``, in [-6, 3.5].

        A peak above the target's mean is as good as the mean, one below the mean of others as bad as that.
        """
        value = _log(peak)
        target = self._target.log_density(min(value, self._target.mean))
        return float(np.clip(target - self._others.log_density(max(value, self._others.mean)), _LEAST, _MOST))


def _log(peak: float) -> float:
    return float(np.log(max(peak, _LEAST_PEAK)))
