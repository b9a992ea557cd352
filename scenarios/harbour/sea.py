"""Tide and swell: the level of the sea at any time, and how bodies that float on it move."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenarios.harbour.layout import MEAN_SEA_M

_HOUR_S = 3600.0
_PERIODS_H = np.array([12.4206, 12.0, 23.9345, 25.8193])
"""Of the constituents M2, S2, K1 and O1 (Pugh and Woodworth, "Sea-Level Science", 2014, table 4.1)."""
_AMPLITUDES_M = np.array([0.62, 0.17, 0.07, 0.05])
"""Of a coast with a range of 1 to 1.6 m: the semi-diurnal ones are the larger."""


@dataclass(frozen=True, slots=True)
class Tide:
    """Four constituents with phases (4,) at time 0."""

    phases_rad: NDArray[np.float64]

    def above_mean_m(self, time_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the level (...) over the mean at times (...), within 0.91 m."""
        turns = np.asarray(time_s)[..., None] / (_PERIODS_H * _HOUR_S)
        return (_AMPLITUDES_M * np.cos(2.0 * np.pi * turns + self.phases_rad)).sum(axis=-1)

    def level_m(self, time_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the height (...) of the sea over the quay's surface, negative."""
        return MEAN_SEA_M + self.above_mean_m(time_s)


LOWEST_M = MEAN_SEA_M - float(_AMPLITUDES_M.sum())
"""Of all tides."""


def draw_tide(rng: np.random.Generator) -> Tide:
    """Draw a tide that turns neither at the start nor within two hours, so that it moves while the episode lasts."""
    phases = rng.uniform(0.0, 2.0 * np.pi, 4)
    # A quarter of a period from a turn is where the level moves fastest.
    phases[0] = rng.choice([0.5, 1.5]) * np.pi + rng.uniform(-0.7, 0.2)
    return Tide(phases)


def sway(
    time_s: NDArray[np.float64], periods_s: tuple[float, float], rng: np.random.Generator, waves: int = 4
) -> NDArray[np.float64]:
    """Return a smooth random motion (...) of unit standard deviation with periods within a range, at times (...)."""
    period = np.exp(rng.uniform(np.log(periods_s[0]), np.log(periods_s[1]), waves))
    phase = rng.uniform(0.0, 2.0 * np.pi, waves)
    return np.cos(2.0 * np.pi * np.asarray(time_s)[..., None] / period + phase).sum(axis=-1) / np.sqrt(0.5 * waves)


def float_poses(
    place_m: NDArray[np.float64],
    heading_rad: NDArray[np.float64],
    roll_rad: NDArray[np.float64],
    pitch_rad: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return poses (..., 4, 4), x ahead and y left, at places (..., 3): turned about z, then y, then x."""
    cz, sz, cy, sy = np.cos(heading_rad), np.sin(heading_rad), np.cos(pitch_rad), np.sin(pitch_rad)
    cx, sx = np.cos(roll_rad), np.sin(roll_rad)
    T = np.zeros((*np.shape(heading_rad), 4, 4))
    T[..., 0, 0], T[..., 0, 1], T[..., 0, 2] = cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx
    T[..., 1, 0], T[..., 1, 1], T[..., 1, 2] = sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx
    T[..., 2, 0], T[..., 2, 1], T[..., 2, 2] = -sy, cy * sx, cy * cx
    T[..., :3, 3] = place_m
    T[..., 3, 3] = 1.0
    return T


@dataclass(frozen=True, slots=True)
class Rocking:
    """How a boat moves on waves: heave (...), roll (...), pitch (...)."""

    heave_m: NDArray[np.float64]
    roll_rad: NDArray[np.float64]
    pitch_rad: NDArray[np.float64]


def rocking(
    time_s: NDArray[np.float64], wave_height_m: NDArray[np.float64], length_m: float, rng: np.random.Generator
) -> Rocking:
    """Return the motion at times (...) in waves of a significant height (...).

    A significant height is four standard deviations of the surface. A short boat follows the surface, a long one
    averages it; it rolls at its own period of some seconds.
    """
    follows = 1.0 / (1.0 + (length_m / 14.0) ** 2)
    surface = 0.25 * np.asarray(wave_height_m) * follows
    return Rocking(
        surface * sway(time_s, (2.5, 6.0), rng),
        1.1 * surface / (0.15 * length_m) * sway(time_s, (2.4, 3.8), rng),
        0.8 * surface / (0.3 * length_m) * sway(time_s, (2.5, 6.0), rng),
    )
