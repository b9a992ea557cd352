"""Appearance of a person, separate from the light: colours of the parts of the body.

A look is the logarithm of linear R, G and B of five parts, from head to shins. Light and the camera's settings
multiply colours, so a change of either *adds* the same three numbers to all five parts (von Kries). That common shift
is the main process noise of a Kalman filter: while the light is steady, colours are compared directly; after a change,
until the filter has learnt the new light, only differences between the parts count.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

PARTS = ((0.89, 1.02), (0.66, 0.83), (0.53, 0.66), (0.32, 0.48), (0.08, 0.28))
"""Head, chest, waist, thighs, shins: shares of the person's height."""
SIZE = 3 * len(PARTS)
_LEAST_PIXELS = 12
_PIXELS_ALIKE = 25.0
"""Neighbouring pixels that count as one independent measurement: they share folds and shading."""
_DARK = 0.004
"""Added to linear levels before the logarithm: darker levels are noise."""
_FAR_OFF, _ODD_FRAMES, _MOST_ODD = 3.0, 8, 2
_PART_LEFT_OUT = 3.0
_EVERY_PART = np.tile(np.eye(3), (len(PARTS), 1))
_BRIGHTER = np.ones((SIZE, 1))
_FROM_ABOVE = np.repeat(np.linspace(1.0, -1.0, len(PARTS)), 3)[:, None]
_CODES = np.arange(256) / 255.0
_LOG_LEVEL = np.log(np.where(_CODES <= 0.04045, _CODES / 12.92, ((_CODES + 0.055) / 1.055) ** 2.4) + _DARK)


@dataclass(frozen=True)
class LookParameters:
    """Variation of a person's look: standard deviations of natural logarithms.

    Attributes:
        brightness, colour, from_above: change of the light on the person in one frame: common to all values, of each
            channel, of the upper parts against the lower ones.
        own: change of each value in one frame, as the person turns or swings an arm.
        shift_error: share of a change of the whole picture's level that may not apply to the person.
        part_noise: least error of a part's colour, however many pixels it has.
        unlike_people: of clothes between people.
    """

    brightness: float = 0.08
    colour: float = 0.02
    from_above: float = 0.04
    own: float = 0.03
    shift_error: float = 0.7
    part_noise: float = 0.12
    unlike_people: float = 0.9


@dataclass(frozen=True)
class Look:
    """A person's look, measured on one frame.

    Attributes:
        log_rgb: (15,) medians of the parts, NaN where too few pixels are visible. variance: (15,) of their errors.
    """

    log_rgb: NDArray[np.float64]
    variance: NDArray[np.float64]

    @property
    def known(self) -> NDArray[np.bool_]:
        """(15,) whether each value is measured."""
        return np.isfinite(self.log_rgb)


def log_levels(image_rgb: NDArray[np.uint8]) -> NDArray[np.float64]:
    """Return the logarithm of the linear levels (H, W, 3) of a picture, sRGB encoded."""
    levels: NDArray[np.float64] = _LOG_LEVEL[image_rgb]
    return levels


def look_at(
    levels: NDArray[np.float64],
    heights_m: NDArray[np.float32],
    pixels: NDArray[np.int64],
    height_m: float,
    parameters: LookParameters,
) -> Look:
    """Return the look of a person.

    Args:
        levels: (H, W, 3), see ``log_levels``. heights_m: (H, W) above the ground.
        pixels: (N,) of the person, indices into the flattened pictures. height_m: of the person.
    """
    own, share = levels.reshape(-1, 3)[pixels], heights_m.ravel()[pixels] / height_m
    log_rgb, variance = np.full((len(PARTS), 3), np.nan), np.full((len(PARTS), 3), np.inf)
    for part, (low, high) in enumerate(PARTS):
        inside = own[(share >= low) & (share < high)]
        if len(inside) >= _LEAST_PIXELS:
            log_rgb[part] = np.median(inside, axis=0)
            spread = inside.var(axis=0) * _PIXELS_ALIKE / len(inside)
            variance[part] = parameters.part_noise**2 + np.minimum(spread, 1.0)
    return Look(log_rgb.ravel(), variance.ravel())


class LookModel:
    """Estimates a person's look: mean (15,) and covariance (15, 15)."""

    def __init__(self, look: Look, parameters: LookParameters) -> None:
        self._parameters = parameters
        self._odd_frames = np.zeros(len(PARTS), dtype=np.int64)
        self._population = population_covariance(parameters)
        self.mean, self.covariance = population_mean(look), self._population
        self.correct(look)

    def predict(self, shift: NDArray[np.float64], loosened: float, *, is_lost: bool) -> None:
        """Advance the estimate by one frame.

        Args:
            shift: (3,) change of the whole picture's logarithmic level.
            loosened: additional standard deviation of the light on the person, from the camera's registers.
            is_lost: the person has been out of sight for a while: only the light can change the look further.
        """
        p = self._parameters
        self.mean = self.mean + _EVERY_PART @ shift
        bright = p.brightness**2 + (p.shift_error * float(np.abs(shift.mean()))) ** 2 + loosened**2
        tint = shift - shift.mean()
        colour = p.colour**2 + (p.shift_error * float(np.abs(tint).max())) ** 2 + (0.3 * loosened) ** 2
        self.covariance = self.covariance + bright * _BRIGHTER @ _BRIGHTER.T + colour * _EVERY_PART @ _EVERY_PART.T
        if not is_lost:
            self.covariance = self.covariance + p.from_above**2 * _FROM_ABOVE @ _FROM_ABOVE.T + p.own**2 * np.eye(SIZE)

    def correct(self, look: Look) -> None:
        """Update the estimate with a look.

        Up to two parts far from the expected colours are left out, as they may show something else. From the eighth
        such frame in a row on a part is used, with a larger covariance.
        """
        known = look.known
        residual = np.zeros(SIZE)
        residual[known] = look.log_rgb[known] - self.mean[known]
        expected = np.diag(self.covariance) + np.where(known, look.variance, np.inf)
        is_far = (residual**2 > _FAR_OFF**2 * expected).reshape(-1, 3).any(axis=1)
        self._odd_frames = np.where(is_far, self._odd_frames + 1, 0)
        # If more parts are far off, it is unknown which of them show something else.
        left_out = is_far & (self._odd_frames < _ODD_FRAMES) & (is_far.sum() <= _MOST_ODD)
        known = known & ~np.repeat(left_out, 3)
        if not known.any():
            return
        far = known & np.repeat(is_far, 3)
        self.covariance = self.covariance + np.diag(np.where(far, residual**2, 0.0))
        innovation = self.covariance[np.ix_(known, known)] + np.diag(look.variance[known])
        gain = np.linalg.solve(innovation, self.covariance[known]).T
        self.mean = self.mean + gain @ residual[known]
        self.covariance = self.covariance - gain @ self.covariance[known]
        self.covariance = 0.5 * (self.covariance + self.covariance.T)

    def likeness(self, look: Look) -> float:
        """Return the log-likelihood ratio of a look: of this person to the population.

        One part may show another person or the background: it may be left out, at a cost of 3.
        """
        known = look.known
        if not known.any():
            return 0.0
        parts = np.flatnonzero(known.reshape(-1, 3).all(axis=1))
        left_out = parts if len(parts) > 2 else parts[:0]
        # (N, 15): all that is known, then without one part each.
        used = known & ~np.vstack(
            [np.zeros((1, SIZE), dtype=bool), np.repeat(np.eye(len(PARTS)), 3, axis=1)[left_out] > 0]
        )
        ratios = _log_density(look, self.mean, self.covariance, used)
        ratios -= _log_density(look, population_mean(look), self._population, used)
        ratios[1:] -= _PART_LEFT_OUT
        return float(ratios.max())


def population_mean(look: Look) -> NDArray[np.float64]:
    """Return the population's mean look (15,) under the light of a look: grey, as bright as the look."""
    known = look.known
    level = float(np.mean(look.log_rgb[known])) if known.any() else -2.0
    return np.full(SIZE, level)


def population_covariance(parameters: LookParameters) -> NDArray[np.float64]:
    """Return the covariance (15, 15) of looks between people: of parts in brightness, a third of it in colour."""
    part = parameters.unlike_people**2 * np.ones((3, 3)) + (parameters.unlike_people / 3.0) ** 2 * np.eye(3)
    return np.kron(np.eye(len(PARTS)), part) + 0.25 * _BRIGHTER @ _BRIGHTER.T + 0.02 * _EVERY_PART @ _EVERY_PART.T


def _log_density(
    look: Look, mean: NDArray[np.float64], covariance: NDArray[np.float64], used: NDArray[np.bool_]
) -> NDArray[np.float64]:
    """Return the logarithmic normal density (N,) of those values of a look that each of the masks (N, 15) uses.

    Unused values become independent ones with the residual 0 and the variance 1 / 2 pi, whose density is 1.
    """
    residual = np.where(used, look.log_rgb - mean, 0.0)
    measured = covariance + np.diag(np.where(look.known, look.variance, 0.0))
    both = used[:, :, None] & used[:, None, :]
    masked = np.where(both, measured, np.eye(SIZE) / (2.0 * np.pi))
    _, log_determinant = np.linalg.slogdet(2.0 * np.pi * masked)
    distance = np.sum(residual * np.linalg.solve(masked, residual[:, :, None])[:, :, 0], axis=1)
    return -0.5 * (distance + log_determinant)
