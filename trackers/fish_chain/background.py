"""The picture of a tank without fish, learnt per pixel: mean and spread of its brightness as ripples and light move."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.types import Observation

Grey = NDArray[np.float32]

_SMOOTHING_PX = 0.8
_SPREAD_SMOOTHING_PX = 6.0
"""Ripples wander, so a pixel will see what its neighbours saw."""
_LEAST_SPREAD = 1.5
"""Grey levels; rounding to whole levels and the camera's noise, after smoothing."""
_SAMPLES, _SAMPLE_EVERY = 25, 6
_ESTIMATE_AT = (3, 6, 12, _SAMPLES)
_SATURATED = 250
_RIM = np.ones((5, 5), np.uint8)
_FILL_PX, _FILL_WEIGHT = (3.0, 6.0, 12.0, 24.0, 48.0), 0.02
_SHRINK, _MEDIAN_CELLS = 8, 9
_RATE, _RELEARN_RATE = 0.02, 0.3
_CHANGED_SHARE = 0.35
"""A picture that differs over a larger share is not one with fish in it: the light or the camera changed."""


def grey_of(image_rgb: NDArray[np.uint8]) -> Grey:
    """Return the brightness (H, W), smoothed against the camera's noise, 0 to 255."""
    grey = cv2.cvtColor(image_rgb, cv2.COLOR_RGB2GRAY).astype(np.float32)
    smooth: Grey = cv2.GaussianBlur(grey, (0, 0), _SMOOTHING_PX)
    return smooth


def glare_of(image_rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return (H, W) 1 where the picture is saturated, as by lamps in the water's surface, and at the rim of that."""
    saturated = (cv2.max(cv2.max(image_rgb[..., 0], image_rgb[..., 1]), image_rgb[..., 2]) >= _SATURATED).view(np.uint8)
    glare: NDArray[np.uint8] = cv2.dilate(saturated, _RIM)
    return glare


class Background:
    """Mean and spread of every pixel without fish, where the picture is not saturated.

    Learnt from pictures without fish if there are any; otherwise from the first pictures with fish: a wide spatial
    median at first, then the temporal quantile that fish, darker or brighter than the floor, disturb least.

    Attributes:
        mean: (H, W) grey levels. spread: (H, W) standard deviation, grey levels.
    """

    def __init__(self, pictures: Sequence[Observation], first: Grey) -> None:
        """``pictures``: without fish, possibly none; those of another size than ``first`` are left out."""
        shown = [each.image_rgb for each in pictures if each.image_rgb.shape[:2] == first.shape]
        self._samples: list[NDArray[np.uint8]] | None = None
        self._frames = 0
        if shown:
            self.mean, variance = _moments([grey_of(each) for each in shown], [glare_of(each) == 0 for each in shown])
            self._variance = _smoothed(variance)
        else:
            self._samples = []
            self.mean = _wide_median(first)
            self._variance = _smoothed(np.minimum(np.abs(first - self.mean), 3 * _typical(first - self.mean)) ** 2)
        self._set_spread()

    def difference(self, grey: Grey) -> Grey:
        """Return grey levels (H, W) above the background, after a change of the light as a whole is taken out."""
        before, now = self.mean[::_SHRINK, ::_SHRINK], grey[::_SHRINK, ::_SHRINK]
        gain = float(np.median((now + 1.0) / (before + 1.0)))
        return cv2.addWeighted(grey, 1.0 / max(gain, 0.05), self.mean, -1.0, 0.0)  # type: ignore[no-any-return]

    def learn(
        self, grey: Grey, glare: NDArray[np.uint8], difference: Grey, occupied: NDArray[np.uint8], sign: int
    ) -> None:
        """Take in a picture.

        Args:
            glare: (H, W) see ``glare_of``. occupied: (H, W) 1 where fish are.
            sign: -1 if these are darker than the floor, +1 if brighter.
        """
        if float(np.count_nonzero(occupied)) > _CHANGED_SHARE * occupied.size:
            self.mean += _RELEARN_RATE * (grey - self.mean)
            return
        free = (cv2.dilate(occupied, np.ones((3, 3), np.uint8)) | glare) ^ 1
        if self._samples is not None:
            self._sample(grey, glare, sign)
        cv2.accumulateWeighted(self.mean + difference, self.mean, _RATE, free)
        if self._frames % 4 == 0:
            cv2.accumulateWeighted(difference**2, self._variance, 4 * _RATE, free)
            self._set_spread()
        self._frames += 1

    def _sample(self, grey: Grey, glare: NDArray[np.uint8], sign: int) -> None:
        assert self._samples is not None
        if self._frames % _SAMPLE_EVERY == 0:
            self._samples.append(np.where(glare, self.mean, grey).astype(np.uint8))
            if len(self._samples) in _ESTIMATE_AT:
                # Fish darker than the floor lower the lower quantiles alone.
                quantile = int((0.5 - 0.2 * sign) * (len(self._samples) - 1))
                self.mean = np.partition(self._samples, quantile, axis=0)[quantile].astype(np.float32)
            if len(self._samples) == _SAMPLES:
                self._samples = None

    def _set_spread(self) -> None:
        self.spread: Grey = np.maximum(np.sqrt(_smoothed(self._variance)), _LEAST_SPREAD)


def _moments(greys: Sequence[Grey], seen: Sequence[NDArray[np.bool_]]) -> tuple[Grey, Grey]:
    """Return mean and variance (H, W) of the pixels that are seen; of their neighbours, where one is never seen."""
    count: Grey = np.array(seen, dtype=np.float32).sum(axis=0)
    mean: Grey = np.sum([grey * mask for grey, mask in zip(greys, seen, strict=True)], axis=0) / np.maximum(count, 1)
    squares = [(grey - mean) ** 2 * mask for grey, mask in zip(greys, seen, strict=True)]
    variance: Grey = np.sum(squares, axis=0) / np.maximum(count, 1)
    return _filled(mean, count), _filled(variance, count)


def _filled(values: Grey, count: NDArray[np.float32]) -> Grey:
    """Return values with those of count 0 replaced by the mean of others near them, as near as there are any."""
    known = (count > 0).astype(np.float32)
    result = values.astype(np.float32)
    for radius_px in _FILL_PX:
        if known.all():
            break
        weight = cv2.GaussianBlur(known, (0, 0), radius_px)
        near = cv2.GaussianBlur(result * known, (0, 0), radius_px) / np.maximum(weight, 1e-6)
        reached = (known == 0) & (weight > _FILL_WEIGHT)
        result[reached] = near[reached]
        known[reached] = 1.0
    return result


def _smoothed(variance: Grey) -> Grey:
    small = (
        cv2.resize(variance, None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA)
        if min(variance.shape) >= 8
        else variance
    )
    blurred = cv2.GaussianBlur(small, (0, 0), _SPREAD_SMOOTHING_PX / 4)
    smooth: Grey = cv2.resize(blurred, variance.shape[::-1], interpolation=cv2.INTER_LINEAR)
    return smooth


def _wide_median(grey: Grey) -> Grey:
    size = (max(grey.shape[1] // _SHRINK, 1), max(grey.shape[0] // _SHRINK, 1))
    small = cv2.medianBlur(cv2.resize(grey, size, interpolation=cv2.INTER_AREA).astype(np.uint8), _MEDIAN_CELLS)
    wide: Grey = cv2.resize(small, grey.shape[::-1], interpolation=cv2.INTER_LINEAR).astype(np.float32)
    return wide


def _typical(difference: Grey) -> float:
    """Return a robust standard deviation (1.48 times the median absolute value), at least the least spread."""
    return max(1.48 * float(np.median(np.abs(difference))), _LEAST_SPREAD)
