"""Where a swimmer was between two pieces of its track."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from trackers.swimmer.features import PAST, Pasts, activity, fitted_motion, lengths, smoothness
from trackers.swimmer.regression import Regression, Samples
from trackers.swimmer.windows import Recording

GAPS = (6, 12, 25, 50, 100, 200)
"""Lengths of gaps for which regressions are learnt; those of other lengths are blended."""
SHARES = (0.1, 0.25, 0.5)
"""Shares of a gap at which the place is predicted; the other half is the same with time reversed."""
_LAGS = (3, 6, 12, 25)
_FITTED = (6, 12, 25)
"""Frames over which velocities at the ends are fitted."""


@dataclass(frozen=True, eq=False)
class Ends:
    """Both ends of M gaps.

    Attributes:
        before: pasts. after: the same with time reversed: their last position is the first one after the gap.
    """

    before: Pasts
    after: Pasts

    def reversed(self) -> Ends:
        """Return the gaps with time reversed."""
        return Ends(self.after, self.before)

    @property
    def chord(self) -> NDArray[np.float64]:
        """(M, 2) from the last position before to the first after, in units."""
        return (self.after.last_px - self.before.last_px) / self.before.unit_px

    @property
    def smooth(self) -> NDArray[np.float64]:
        """(M,) smoothness of the less smooth end."""
        return np.minimum(smoothness(self.before.position_px), smoothness(self.after.position_px))


def features_between(ends: Ends, count: int, share: float) -> NDArray[np.float64]:
    """Return (M, 2, D) features of the way off the chord at ``share`` of a gap of ``count`` frames."""
    time, chord = count + 1.0, ends.chord
    smooth = ends.smooth[:, None, None]
    point = ends.before.last_px + share * (ends.after.last_px - ends.before.last_px)
    rough_part = [chord, *_places(ends, point)]
    for side, end in ((1.0, ends.before), (-1.0, ends.after)):
        rough_part += _motions(end, side * chord, time)
    smooth_part = []
    for frames in _FITTED:
        leaving, _ = fitted_motion(ends.before.position_px, frames)
        coming, _ = fitted_motion(ends.after.position_px, frames)
        start, end = leaving * time / ends.before.unit_px, -coming * time / ends.before.unit_px
        smooth_part += [hermite_off_chord(chord, start, end, share), start, end]
    smooth_part.append(chord)
    return np.concatenate(
        [(1.0 - smooth) * np.stack(rough_part, axis=-1), smooth * np.stack(smooth_part, axis=-1)], axis=-1
    )


def hermite_off_chord(
    chord: NDArray[np.float64], start: NDArray[np.float64], end: NDArray[np.float64], share: float
) -> NDArray[np.float64]:
    """Return the cubic with these tangents (M, 2) at its ends, less the chord, at ``share``."""
    s = share
    return (3 * s**2 - 2 * s**3 - s) * chord + (s - 2 * s**2 + s**3) * start + (s**3 - s**2) * end


def _places(ends: Ends, point: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Where targets are mostly, seen from the point on the chord."""
    unit, bounds = ends.before.unit_px, ends.before.bounds_xyxy
    low, high = bounds[:, :2], bounds[:, 2:]
    place = np.clip((2 * point - low - high) / np.maximum(high - low, 1.0), -1.0, 1.0)
    found = [place, place * np.abs(place) ** 3, (ends.before.home_px - point) / unit]
    return found + [(end.position_px.mean(axis=1) - point) / unit for end in (ends.before, ends.after)]


def _motions(end: Pasts, chord: NDArray[np.float64], time: float) -> list[NDArray[np.float64]]:
    """How a target moves at one end, away from it in the gap, and what the chord leaves for detours."""
    x, unit = end.position_px, end.unit_px
    slack = np.maximum(activity(end)[:, None] * time / PAST - lengths(chord), 0.0)
    found = []
    for lag in _LAGS:
        step = (x[:, -1] - x[:, -1 - lag]) / unit
        direction = step / (lengths(step) + 0.02)
        found += [step, direction * slack, direction * lengths(chord)]
    within = x[:, -1] + (x[:, -1] - x[:, -4]) / 3 * min(0.3 * time, 30.0)
    found.append((np.clip(within, end.bounds_xyxy[:, :2], end.bounds_xyxy[:, 2:]) - x[:, -1]) / unit)
    return found


def scales_between(ends: Ends, count: int) -> NDArray[np.float64]:
    """Return (M, 5) scales of the error: constant, and with the way and the chord, of rough and smooth ends."""
    smooth, chord = ends.smooth, np.linalg.norm(ends.chord, axis=1)
    active = 0.5 * (activity(ends.before) + activity(ends.after)) * (count + 1) / PAST
    rough = 1.0 - smooth
    return np.stack([rough, rough * active, rough * chord, smooth * active, 1.0 / ends.before.unit_px[:, 0]], axis=1)


def samples_between(recording: Recording, count: int, share: float) -> Samples:
    """Return the ways off the chord at ``share`` of gaps of ``count`` frames, forwards and backwards in time."""
    windows = recording.windows(count, PAST)
    bounds, home = windows.pasts.bounds_xyxy, windows.pasts.home_px
    ends = Ends(windows.pasts, Pasts(windows.after_px[:, ::-1], bounds, home))
    whole = np.concatenate([ends.before.position_px[:, -1:], windows.gap_px, windows.after_px[:, :1]], axis=1)
    parts = []
    for way, each in ((whole, ends), (whole[:, ::-1], ends.reversed())):
        point = way[:, 0] + share * (way[:, -1] - way[:, 0])
        off = (_at(way, share * (count + 1)) - point) / each.before.unit_px
        parts.append((features_between(each, count, share), off, scales_between(each, count)))
    features, off, scales = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
    return Samples(features, off, scales, np.tile(windows.weight, 2), np.tile(windows.fold, 2), windows.independent)


def _at(way: NDArray[np.float64], frame: float) -> NDArray[np.float64]:
    """Return the places (M, 2) of ways (M, T, 2) at a broken frame."""
    below = int(frame)
    rest = frame - below
    return way[:, below] if rest == 0.0 else (1 - rest) * way[:, below] + rest * way[:, below + 1]


def way_between(
    regressions: dict[tuple[int, float], Regression], ends: Ends, count: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the places (count, 2) on the frames between two ends, and the radii (count,) that hold 95 %, in pixels."""
    above = int(np.searchsorted(GAPS, count))
    near = sorted({GAPS[max(above - 1, 0)], GAPS[min(above, len(GAPS) - 1)]})
    ways = [_way(regressions, ends, count, gap) for gap in near]
    if len(near) == 1:
        return ways[0]
    upper = float(np.log(count / near[0]) / np.log(near[1] / near[0]))
    (low_px, low_radius), (high_px, high_radius) = ways
    return (1 - upper) * low_px + upper * high_px, (1 - upper) * low_radius + upper * high_radius


def _way(
    regressions: dict[tuple[int, float], Regression], ends: Ends, count: int, gap: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    unit = float(ends.before.unit_px[0, 0])
    shares, off, radii = [0.0, 1.0], [np.zeros(2), np.zeros(2)], [0.0, 0.0]
    scales = scales_between(ends, count)
    for way, each in ((0, ends), (1, ends.reversed())):
        for share in SHARES[: len(SHARES) - way]:
            regression = regressions[gap, share]
            shares.append(1.0 - share if way else share)
            off.append(regression.step(features_between(each, count, share))[0] * unit)
            radii.append(float(regression.radius(scales)[0]) * unit)
    order = np.argsort(shares)
    at = np.arange(1, count + 1) / (count + 1.0)
    chord = ends.before.last_px[0] + at[:, None] * (ends.after.last_px[0] - ends.before.last_px[0])
    knots = np.array(shares)[order]
    return chord + CubicSpline(knots, np.array(off)[order])(at), np.interp(at, knots, np.array(radii)[order])
