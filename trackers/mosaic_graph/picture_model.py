"""Motion model and likelihood of particles in the picture, for a target of any kind, in sizes of that target."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.kernels.boxes import inside_picture
from trackers.kernels.particles import detection_log_weights, spacing
from trackers.kernels.picture_motion import moved_points

X, Y, SPEED_X, SPEED_Y, VISIBLE, LOG_PRIOR = range(6)
COLUMNS = 6
"""Columns of a state: place (px), velocity over the background (px/s), 1 where the target can be seen in the picture,
0 where something hides it, and the log-prior of a newborn state.
"""

_SPEED_SIZES, _MEMORY_S = 2.0, 5.0
"""Standard deviation of the velocity in sizes of the target a second, and the time for which it lasts."""
_SHAKE_SIZES = 0.03
_HIDES_PER_S, _SHOWS_PER_S = 0.2, 1.0
_FOUND = 0.9
"""Probability that the best match in a searched square is the target, if the target is there and visible."""
_DEVIATION_SIZES = 0.1
_BORN_SHARE, _BORN_SIZES = 0.2, 0.05
_LEAP = 0.1
"""Prior probability in each picture that the target moves as no particle does."""
_LEAP_SIZES, _LEAP_SIZES_PER_S = 1.0, 3.0
"""Standard deviation of a leap, and its growth with the time since the target was last held."""
_FAR_PX = 1e5


@dataclass(frozen=True, eq=False)
class Glance:
    """Input of the filter for one picture.

    Attributes:
        dt_s: time since the previous picture.
        unheld_s: time since the target was last held.
        motion: (3, 3) homography of the background from the previous picture to this one.
        picture_px: width and height.
        side_px: size of the target, the geometric mean of its width and height.
        reach_px: half the side of the squares that were searched.
        searched_px: (K, 2) their middles.
        found_px: (K, 2) the best match in each.
        log_ratios: (K,) log p(match | target) / p(match | something else).
    """

    dt_s: float
    unheld_s: float
    motion: NDArray[np.float64]
    picture_px: tuple[int, int]
    side_px: float
    reach_px: float
    searched_px: NDArray[np.float64]
    found_px: NDArray[np.float64]
    log_ratios: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PictureModel:
    """Model of a target whose velocity over the background drifts, which may hide, and which may leap.

    Attributes:
        start_px: (2,) place at the start; the velocity is unknown.
        side_px: size at the start.
        miss_counts: if False, a missing match gives no information.
    """

    start_px: NDArray[np.float64]
    side_px: float
    miss_counts: bool

    def sample_initial(self, count: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """Draw states (N, COLUMNS)."""
        states = np.zeros((count, COLUMNS))
        states[:, :SPEED_X] = self.start_px + rng.normal(0, _SHAKE_SIZES * self.side_px, (count, 2))
        states[:, SPEED_X:VISIBLE] = rng.normal(0, _SPEED_SIZES * self.side_px, (count, 2))
        states[:, VISIBLE] = 1.0
        return states

    def carry(self, states: NDArray[np.float64], motion: NDArray[np.float64], dt_s: float) -> NDArray[np.float64]:
        """Return states (N, COLUMNS) after ``dt_s`` and a motion of the background (3, 3), without noise."""
        lasting = np.exp(-dt_s / _MEMORY_S)
        before = states[:, :SPEED_X]
        step = _MEMORY_S * (1.0 - lasting) * states[:, SPEED_X:VISIBLE]
        carried = states.copy()
        carried[:, :SPEED_X] = moved_points(motion, before + step)
        carried[:, SPEED_X:VISIBLE] = (carried[:, :SPEED_X] - moved_points(motion, before)) * (lasting / dt_s)
        carried[:, :VISIBLE] = np.clip(carried[:, :VISIBLE], -_FAR_PX, _FAR_PX)
        return carried

    def predict(self, states: NDArray[np.float64], observed: Glance, rng: np.random.Generator) -> NDArray[np.float64]:
        """Move all states on; replace some by births at the matches."""
        dt_s, count = observed.dt_s, len(states)
        states = self.carry(states, observed.motion, dt_s)
        states[:, LOG_PRIOR] = 0.0
        spread = _SPEED_SIZES * observed.side_px * np.sqrt(1.0 - np.exp(-2.0 * dt_s / _MEMORY_S))
        change = rng.normal(0, spread, (count, 2))
        states[:, SPEED_X:VISIBLE] += change
        states[:, :SPEED_X] += 0.5 * dt_s * change + rng.normal(0, _SHAKE_SIZES * observed.side_px, (count, 2))
        rates = np.where(states[:, VISIBLE] > 0, _HIDES_PER_S, _SHOWS_PER_S)
        changes = rng.random(count) < 1.0 - np.exp(-rates * dt_s)
        states[changes, VISIBLE] = 1.0 - states[changes, VISIBLE]
        self._give_birth(states, observed, rng)
        return states

    def log_weights(self, states: NDArray[np.float64], observed: Glance) -> NDArray[np.float64]:
        """Return log-weights (N,): the log-likelihood of the matches, and the log-prior of newborn states.

        The best match in a square without the target lies anywhere in it.
        """
        places, count = np.ascontiguousarray(states[:, :SPEED_X]), len(observed.found_px)
        deviation_px = _deviation_px(states, observed)
        from_anywhere = 2.0 * np.log(2.0 * observed.reach_px / deviation_px) - np.log(2.0 * np.pi)
        away_px = np.abs(places[:, None] - observed.searched_px).max(axis=-1)
        is_searched = inside_picture(places, *observed.picture_px) & (away_px < observed.reach_px).any(axis=1)
        return states[:, LOG_PRIOR] + detection_log_weights(
            places,
            np.zeros(len(states)),
            _FOUND * states[:, VISIBLE] * is_searched,
            self.miss_counts,
            observed.found_px,
            np.full(count, np.nan),
            observed.log_ratios + from_anywhere,
            np.full(count, deviation_px),
            1.0,
        )

    def _give_birth(self, states: NDArray[np.float64], observed: Glance, rng: np.random.Generator) -> None:
        """Replace randomly chosen states, in place, by leaps to the matches that are more like the target."""
        places_px = observed.found_px[observed.log_ratios > 0]
        if len(places_px) == 0:
            return
        each = max(1, int(_BORN_SHARE * len(states) / len(places_px)))
        chosen = rng.permutation(len(states))
        expected_px, velocity = states[:, :SPEED_X].mean(axis=0), states[:, SPEED_X:VISIBLE].mean(axis=0)
        leap_px = observed.side_px * (_LEAP_SIZES + _LEAP_SIZES_PER_S * observed.unheld_s)
        # The likelihood of a match is a density of this deviation: at the match the leap's density is relative to it.
        thinner = 2.0 * np.log(_deviation_px(states, observed) / leap_px)
        for k, place_px in enumerate(places_px):
            born = chosen[k * each : (k + 1) * each]
            count = len(born)
            states[born, :SPEED_X] = place_px + rng.normal(0, _BORN_SIZES * observed.side_px, (count, 2))
            # It has leapt since it was last held: had it moved so fast, it would be there.
            faster = velocity + (place_px - expected_px) / observed.unheld_s
            states[born, SPEED_X:VISIBLE] = faster + rng.normal(0, _SPEED_SIZES * observed.side_px, (count, 2))
            states[born, VISIBLE] = 1.0
            away = float(((place_px - expected_px) ** 2).sum()) / leap_px**2
            states[born, LOG_PRIOR] = np.log(_LEAP * len(states) / each) + thinner - 0.5 * away


def _deviation_px(states: NDArray[np.float64], observed: Glance) -> float:
    """Return the standard deviation of a match from the nearest state that is not newborn."""
    old = states[states[:, LOG_PRIOR] == 0, :SPEED_X]
    return float(np.hypot(_DEVIATION_SIZES * observed.side_px, spacing(old)))
