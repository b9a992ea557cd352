"""Paths of people, and their walks along them, one place per frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

STEP_M = 0.05
"""Approximate spacing of a path's points."""
_ROUNDING_M = 0.3
"""Standard deviation of the Gaussian filter along a path that rounds its corners."""
_TURNING_FRAMES = 3.0
_STANDING_MPS = 0.08
"""A person who is slower than this keeps the heading."""


@dataclass(frozen=True, slots=True)
class Walk:
    """Motion of one person over F frames.

    Attributes:
        place_m: (F, 2). heading_rad: (F,) counter-clockwise from world x, unwrapped. speed_mps: (F,).
    """

    place_m: NDArray[np.float64]
    heading_rad: NDArray[np.float64]
    speed_mps: NDArray[np.float64]


def rounded_way(corners_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return points (S, 2), ``STEP_M`` apart, of a rounded path through corners (M, 2); its ends move in by 0.1 m."""
    dense_m = _evenly(corners_m)
    return _evenly(gaussian_filter1d(dense_m, _ROUNDING_M / STEP_M, axis=0, mode="nearest"))


def at_distance(way_m: NDArray[np.float64], along_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the points (F, 2) at distances (F,) along a path, clamped to its ends."""
    index = np.clip(along_m / STEP_M, 0.0, len(way_m) - 1.0)
    grid = np.arange(len(way_m))
    return np.column_stack([np.interp(index, grid, way_m[:, k]) for k in range(2)])


def sideways(way_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the unit vectors (S, 2) to the left of a path at each of its points."""
    along = np.gradient(way_m, axis=0)
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-9)
    return np.column_stack([-along[:, 1], along[:, 0]])


def walk_of(place_m: NDArray[np.float64], rate_hz: float, first_heading_rad: float | None = None) -> Walk:
    """Return the walk through places (F, 2): people look ahead, and turn within a few frames.

    Args:
        first_heading_rad: heading of a person who stands at first; None = the direction of the first step.
    """
    step_m = np.diff(place_m, axis=0, append=place_m[-1:])
    length_m = np.linalg.norm(step_m, axis=1)
    speed_mps = gaussian_filter1d(length_m * rate_hz, 1.0, mode="nearest")
    heading = np.where(length_m * rate_hz > _STANDING_MPS, np.arctan2(step_m[:, 1], step_m[:, 0]), np.nan)
    known = np.flatnonzero(np.isfinite(heading))
    if first_heading_rad is not None and not np.isfinite(heading[0]):
        heading[0], known = first_heading_rad, np.union1d([0], known)
    if len(known) == 0:
        heading[:] = 0.0
    else:
        latest = known[np.maximum(np.searchsorted(known, np.arange(len(heading)), side="right") - 1, 0)]
        heading = heading[latest]
    turned = gaussian_filter1d(np.unwrap(heading), _TURNING_FRAMES, mode="nearest")
    return Walk(place_m, turned, speed_mps)


def changing_pace(
    frames: int, rate_hz: float, speeds_mps: tuple[float, float], rng: np.random.Generator, pauses: int
) -> NDArray[np.float64]:
    """Return distances (F,) walked since frame 0 at speeds that are drawn anew every few seconds, with pauses.

    A pause takes one to two and a half seconds.
    """
    speed_mps = held_values(speeds_mps, (1.5, 4.0), frames, rate_hz, rng)
    for _ in range(pauses):
        begin = int(rng.uniform(0.15, 0.85) * frames)
        speed_mps[begin : begin + int(rng.uniform(1.0, 2.5) * rate_hz)] = 0.0
    speed_mps = gaussian_filter1d(speed_mps, 0.3 * rate_hz, mode="nearest")
    return np.concatenate([[0.0], np.cumsum(speed_mps)[:-1]]) / rate_hz


def held_values(
    values: tuple[float, float],
    lasting_s: tuple[float, float],
    frames: int,
    rate_hz: float,
    rng: np.random.Generator,
) -> NDArray[np.float64]:
    """Return (F,) values, each drawn between two and held for a time drawn between two."""
    held = np.empty(frames)
    begin = 0
    while begin < frames:
        end = begin + max(int(rng.uniform(*lasting_s) * rate_hz), 1)
        held[begin:end] = rng.uniform(*values)
        begin = end
    return held


def _evenly(points_m: NDArray[np.float64]) -> NDArray[np.float64]:
    length_m = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points_m, axis=0), axis=1))])
    count = max(int(np.ceil(length_m[-1] / STEP_M)), 1)
    wanted = np.linspace(0.0, length_m[-1], count + 1)
    return np.column_stack([np.interp(wanted, length_m, points_m[:, k]) for k in range(2)])


_REACTION_S = (0.2, 0.4)
_WISH_M, _WISH_S = (1.2, 3.7), (2.5, 5.0)
_BURST_MPS, _BURST_S = (1.0, 1.6), (0.8, 2.0)
_SLACK_M = (0.2, 0.7)
_AIM_RAD, _AIM_S = (-0.36, 0.36), (1.5, 3.5)
_TOLERANCE_RAD = (0.10, 0.26)
_ATTENDS_S, _LOOKS_AWAY_S = (2.0, 5.0), (0.4, 1.1)
_RANGE_ERROR, _BEARING_ERROR_RAD, _ERRORS_LAST_S = 0.08, 0.02, 0.8
_CARRY, _CARRY_RAD, _CARRY_LASTS_S = (0.5, 1.2), (-0.35, 0.35), (0.5, 1.5)
_UNSTEADY_MPS, _UNSTEADY_RAD_S, _UNSTEADY_S = 0.05, 0.06, 0.3


@dataclass(frozen=True, slots=True)
class Whims:
    """A driver over F frames; all but the first are (F,) arrays.

    Attributes:
        reaction_frames: from a picture to his hand.
        distance_m: that he wants to the target. slack_m: by which the target walks on before he drives off.
        burst_mps: speed at which he drives.
        aim_rad: bearing at which he leaves the target in the picture. tolerance_rad: around it, before he turns.
        attends: whether he looks at the picture.
        range_error, bearing_error_rad: of his judgement, the first as a share of the distance.
        carry, carry_rad: share of the target's speed, and turn of its direction, with which he imagines it to walk on
            while he does not see it.
        unsteady_mps, unsteady_rad_s: of his hand.
    """

    reaction_frames: int
    distance_m: NDArray[np.float64]
    slack_m: NDArray[np.float64]
    burst_mps: NDArray[np.float64]
    aim_rad: NDArray[np.float64]
    tolerance_rad: NDArray[np.float64]
    attends: NDArray[np.bool_]
    range_error: NDArray[np.float64]
    bearing_error_rad: NDArray[np.float64]
    carry: NDArray[np.float64]
    carry_rad: NDArray[np.float64]
    unsteady_mps: NDArray[np.float64]
    unsteady_rad_s: NDArray[np.float64]


def draw_whims(frames: int, rate_hz: float, rng: np.random.Generator) -> Whims:
    """Draw the whims of F frames."""

    def held(values: tuple[float, float], lasting_s: tuple[float, float]) -> NDArray[np.float64]:
        return held_values(values, lasting_s, frames, rate_hz, rng)

    def wandering(deviation: float, lasting_s: float) -> NDArray[np.float64]:
        noise = gaussian_filter1d(rng.normal(size=frames), lasting_s * rate_hz, mode="wrap")
        # The filter leaves this share of the deviation.
        return noise * deviation * np.sqrt(2.0 * np.sqrt(np.pi) * lasting_s * rate_hz)

    return Whims(
        reaction_frames=round(rng.uniform(*_REACTION_S) * rate_hz),
        distance_m=held(_WISH_M, _WISH_S),
        slack_m=held(_SLACK_M, _WISH_S),
        burst_mps=held(_BURST_MPS, _BURST_S),
        aim_rad=held(_AIM_RAD, _AIM_S),
        tolerance_rad=held(_TOLERANCE_RAD, _AIM_S),
        attends=_attention(frames, rate_hz, rng),
        range_error=wandering(_RANGE_ERROR, _ERRORS_LAST_S),
        bearing_error_rad=wandering(_BEARING_ERROR_RAD, _ERRORS_LAST_S),
        carry=held(_CARRY, _CARRY_LASTS_S),
        carry_rad=held(_CARRY_RAD, _CARRY_LASTS_S),
        unsteady_mps=wandering(_UNSTEADY_MPS, _UNSTEADY_S),
        unsteady_rad_s=wandering(_UNSTEADY_RAD_S, _UNSTEADY_S),
    )


def _attention(frames: int, rate_hz: float, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Return whether he looks at the picture on each frame (F,); he does so at first."""
    attends = np.ones(frames, dtype=np.bool_)
    begin = 0
    while begin < frames:
        begin += int(rng.uniform(*_ATTENDS_S) * rate_hz)
        end = begin + int(rng.uniform(*_LOOKS_AWAY_S) * rate_hz)
        attends[begin:end] = False
        # At few pictures a second both last less than one.
        begin = max(end, begin + 1)
    return attends
