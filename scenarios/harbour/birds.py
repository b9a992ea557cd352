"""Gulls: they fly over, and rest on water, quay and roofs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from scenarios.harbour.layout import BOLLARD_X_M, BOLLARDS_Y_M, SHED_X_M, SHEDS, WALL_X_M
from scenarios.harbour.sea import Tide, float_poses

FLYING, RESTING = 5, 6
"""Most at a time."""
AWAY_M = -1000.0
"""Height of bodies that are not in the world."""
_SPEED_MPS = (7.0, 11.0)
_FLIGHTS_PER_H, _RESTS_PER_H = 70.0, 22.0
_REST_S = (60.0, 1200.0)


class Birds(NamedTuple):
    """Poses of gulls at F times: (F, FLYING, 4, 4) and (F, RESTING, 4, 4)."""

    flying: NDArray[np.float64]
    resting: NDArray[np.float64]


def birds(time_s: NDArray[np.float64], tide: Tide, rng: np.random.Generator) -> Birds:
    """Draw the gulls at ascending times (F,)."""
    flying, resting = (np.tile(np.eye(4), (len(time_s), count, 1, 1)) for count in (FLYING, RESTING))
    flying[..., 2, 3] = resting[..., 2, 3] = AWAY_M
    span_h = (time_s[-1] - time_s[0]) / 3600.0
    for k, begin in enumerate(_moments(time_s, _FLIGHTS_PER_H * span_h, rng)):
        _fly(flying[:, k % FLYING], time_s, begin, rng)
    level_m = tide.level_m(time_s)
    for k, begin in enumerate(_moments(time_s, _RESTS_PER_H * span_h, rng, before_s=_REST_S[1])):
        _rest(resting[:, k % RESTING], time_s, begin, level_m, rng)
    return Birds(flying, resting)


def _moments(
    time_s: NDArray[np.float64], mean: float, rng: np.random.Generator, before_s: float = 0.0
) -> NDArray[np.float64]:
    span_s = time_s[-1] - time_s[0]
    count = rng.poisson(mean * (1.0 + before_s / span_s))
    return np.sort(rng.uniform(time_s[0] - before_s, time_s[-1], count))


def _fly(poses: NDArray[np.float64], time_s: NDArray[np.float64], begin_s: float, rng: np.random.Generator) -> None:
    """Write a straight flight across the picture, level or in a shallow dive."""
    x, height = rng.uniform(-50.0, 55.0), rng.uniform(1.5, 13.0)
    side = float(rng.choice([-1.0, 1.0]))
    heading = side * 0.5 * np.pi + rng.normal(0.0, 0.5)
    speed, half = rng.uniform(*_SPEED_MPS), 0.27 * (x + 100.0) + 4.0
    roll, dive = rng.normal(0.0, 0.35), rng.normal(0.0, 0.03)
    first, last = np.searchsorted(time_s, (begin_s, begin_s + 2.0 * half / speed))
    if first == last:
        return
    since = time_s[first:last] - begin_s
    along = speed * since - half
    place = np.column_stack([x + along * np.cos(heading), along * np.sin(heading), height - dive * along])
    zero = np.zeros(len(since))
    poses[first:last] = float_poses(place, zero + heading, zero + roll, zero)


def _rest(
    poses: NDArray[np.float64],
    time_s: NDArray[np.float64],
    begin_s: float,
    level_m: NDArray[np.float64],
    rng: np.random.Generator,
) -> None:
    """Write a rest: on the water, where the gull drifts, on the edge of the quay, a bollard, the apron, or a roof."""
    first, last = np.searchsorted(time_s, (begin_s, begin_s + np.exp(rng.uniform(*np.log(_REST_S)))))
    since, heading = time_s[first:last] - begin_s, rng.uniform(-np.pi, np.pi)
    shed = SHEDS[int(rng.integers(len(SHEDS)))]
    ridge = (SHED_X_M + 0.5 * shed.depth_m, shed.eaves_m + shed.rise_m + 0.15)
    y = rng.uniform(-22.0, 22.0)
    where = int(rng.choice(5, p=[0.4, 0.2, 0.15, 0.15, 0.1]))
    spots = (
        (rng.uniform(-46.0, -20.0), 0.6 * y, 0.0),
        (WALL_X_M + 0.3, y, 0.0),
        (BOLLARD_X_M, float(rng.choice(BOLLARDS_Y_M[2:-2])), 0.6),
        (rng.uniform(-12.0, 10.0), y, 0.0),
        (ridge[0], shed.y_m + rng.uniform(-0.4, 0.4) * shed.length_m, ridge[1]),
    )
    place = np.tile(spots[where], (len(since), 1))
    if where == 0:
        drift = rng.normal(0.0, 0.03, 2)
        place[:, :2] += since[:, None] * drift
        place[:, 2] = level_m[first:last] - 0.05
    turns = 0.4 * np.sin(since / 37.0) if where == 0 else np.zeros(len(since))
    zero = np.zeros(len(since))
    poses[first:last] = float_poses(place, heading + turns, zero, zero)
