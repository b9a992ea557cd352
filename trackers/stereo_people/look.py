"""How a person looks, apart from the light: colours of the parts of his body, and what light can do to them.

A look is the logarithm of linear R, G and B of five parts, from head to shins. Light and the camera's settings
multiply colours, so a change of either *adds* the same three numbers to all five parts (von Kries). A Kalman filter
whose process noise is such a common shift then does what is wanted by itself: while the light is steady colours are
compared as they are; after a change, until the new light is learnt, only what is left of them when the common shift is
taken out: the top against the trousers against the hair.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

PARTS = ((0.89, 1.02), (0.66, 0.83), (0.53, 0.66), (0.32, 0.48), (0.08, 0.28))
"""Head, chest, waist, thighs, shins: shares of the person's height."""
SIZE = 3 * len(PARTS)
_LEAST_PIXELS = 12
_PIXELS_ALIKE = 25.0
"""So many neighbouring pixels tell as much as one: folds and shading are alike in them."""
_DARK = 0.004
"""Added to linear levels before their logarithm: below it a picture is noise."""
_FAR_OFF, _ODD_FRAMES, _MOST_ODD = 3.0, 8, 2
_PART_LEFT_OUT = 3.0
_EVERY_PART = np.tile(np.eye(3), (len(PARTS), 1))
_BRIGHTER = np.ones((SIZE, 1))
_FROM_ABOVE = np.repeat(np.linspace(1.0, -1.0, len(PARTS)), 3)[:, None]
_CODES = np.arange(256) / 255.0
_LOG_LEVEL = np.log(np.where(_CODES <= 0.04045, _CODES / 12.92, ((_CODES + 0.055) / 1.055) ** 2.4) + _DARK)


@dataclass(frozen=True)
class LookParameters:
    """What changes how a person looks, standard deviations of natural logarithms.

    Attributes:
        brightness, colour, from_above: a frame's change of the light on him: of all, of each channel by itself, of the
            upper parts against the lower ones.
        own: a frame's change of each part by itself: he turns, an arm swings.
        shift_error: of a change of the whole picture's level, what of it may not be his.
        part_noise: of one look at a part, however many pixels it has.
        unlike_people: how much people's clothes differ.
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
    """One look at a person.

    Attributes:
        log_rgb: (15,) medians of the parts, NaN where too little is seen. variance: (15,) of their errors.
    """

    log_rgb: NDArray[np.float64]
    variance: NDArray[np.float64]

    @property
    def known(self) -> NDArray[np.bool_]:
        """(15,) what is seen."""
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
        levels: (H, W, 3), see ``log_levels``. heights_m: (H, W) over the ground.
        pixels: (N,) his own, indices of the flattened pictures.
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
    """What is known of a person's look: mean (15,) and covariance (15, 15)."""

    def __init__(self, look: Look, parameters: LookParameters) -> None:
        self._parameters = parameters
        self._odd_frames = np.zeros(len(PARTS), dtype=np.int64)
        self._anybody = population_covariance(parameters)
        self.mean, self.covariance = population_mean(look), self._anybody
        self.correct(look)

    def copy(self) -> LookModel:
        """Return the same knowledge, to go on by itself."""
        return copy(self)

    def predict(self, shift: NDArray[np.float64], loosened: float, *, is_lost: bool) -> None:
        """Go on by a frame.

        Args:
            shift: (3,) by which the whole picture's logarithmic level has changed.
            loosened: further standard deviation of the light on him: by what the camera reports.
            is_lost: he has not been seen for a while: he has turned as far as he can, only the light goes on changing.
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
        """Take in a look. A part far off what was expected is not his, or half of it is not: it is left out; if that
        lasts, it was not as well known as was thought.
        """
        known = look.known
        residual = np.zeros(SIZE)
        residual[known] = look.log_rgb[known] - self.mean[known]
        expected = np.diag(self.covariance) + np.where(known, look.variance, np.inf)
        is_far = (residual**2 > _FAR_OFF**2 * expected).reshape(-1, 3).any(axis=1)
        self._odd_frames = np.where(is_far, self._odd_frames + 1, 0)
        # When most of him is unlike himself there is nothing left to tell which part is not his.
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
        """Return the log-likelihood ratio of a look: of this person to anybody.

        One part may be somebody else's, or what is behind him: the ratio without it counts, less what that costs.
        """
        known = look.known
        if not known.any():
            return 0.0
        ratios = [self._ratio(look, known)]
        parts = np.flatnonzero(known.reshape(-1, 3).all(axis=1))
        if len(parts) > 2:
            for part in parts:
                without = known.copy()
                without[3 * part : 3 * part + 3] = False
                ratios.append(self._ratio(look, without) - _PART_LEFT_OUT)
        return max(ratios)

    def _ratio(self, look: Look, known: NDArray[np.bool_]) -> float:
        noise = np.diag(look.variance[known])
        anybody = self._anybody[np.ix_(known, known)] + noise
        return _log_density(look.log_rgb[known] - self.mean[known], self.covariance[np.ix_(known, known)] + noise) - (
            _log_density(look.log_rgb[known] - population_mean(look)[known], anybody)
        )


def population_mean(look: Look) -> NDArray[np.float64]:
    """Return the mean look (15,) of anybody under the light of a look: grey, as bright as he is."""
    known = look.known
    level = float(np.mean(look.log_rgb[known])) if known.any() else -2.0
    return np.full(SIZE, level)


def population_covariance(parameters: LookParameters) -> NDArray[np.float64]:
    """Return how anybody's look differs (15, 15): parts in brightness, and a third as much in colour."""
    part = parameters.unlike_people**2 * np.ones((3, 3)) + (parameters.unlike_people / 3.0) ** 2 * np.eye(3)
    return np.kron(np.eye(len(PARTS)), part) + 0.25 * _BRIGHTER @ _BRIGHTER.T + 0.02 * _EVERY_PART @ _EVERY_PART.T


def _log_density(residual: NDArray[np.float64], covariance: NDArray[np.float64]) -> float:
    _, log_determinant = np.linalg.slogdet(2 * np.pi * covariance)
    return -0.5 * (float(residual @ np.linalg.solve(covariance, residual)) + float(log_determinant))
