"""Where a swimmer was between two pieces of its track."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

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


def features_between(ends: Ends, count: int, shares: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (K, M, 2, D) features of the ways off the chord at ``shares`` (K,) of gaps of ``count`` frames."""
    time, chord = count + 1.0, ends.chord
    smooth = ends.smooth[:, None, None]
    at = shares[:, None, None]
    motions = [chord, *_motions(ends.before, chord, time), *_motions(ends.after, -chord, time)]
    smooth_part = [chord]
    for frames in _FITTED:
        leaving, _ = fitted_motion(ends.before.position_px, frames)
        coming, _ = fitted_motion(ends.after.position_px, frames)
        start, end = leaving * time / ends.before.unit_px, -coming * time / ends.before.unit_px
        smooth_part += [hermite_off_chord(chord, start, end, at), start, end]
    places = _places(ends, ends.before.last_px + at * (ends.after.last_px - ends.before.last_px))
    whole = [(1.0 - smooth) * np.stack(places, axis=-1)]
    for part, weight in ((motions, 1.0 - smooth), (smooth_part, smooth)):
        whole.append(weight * np.stack(np.broadcast_arrays(*part, places[0])[:-1], axis=-1))
    return np.concatenate(whole, axis=-1)


def hermite_off_chord(
    chord: NDArray[np.float64], start: NDArray[np.float64], end: NDArray[np.float64], share: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the cubic with these tangents at its ends, less the chord, at ``share``, all (..., 2) or numbers."""
    s = share
    return (3 * s**2 - 2 * s**3 - s) * chord + (s - 2 * s**2 + s**3) * start + (s**3 - s**2) * end


def _places(ends: Ends, point: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Where targets are mostly, seen from points (K, M, 2) on the chord."""
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
    ends = Ends(windows.pasts, replace(windows.pasts, position_px=windows.after_px[:, ::-1]))
    whole = np.concatenate([ends.before.position_px[:, -1:], windows.gap_px, windows.after_px[:, :1]], axis=1)
    parts = []
    for way, each in ((whole, ends), (whole[:, ::-1], ends.reversed())):
        point = way[:, 0] + share * (way[:, -1] - way[:, 0])
        off = (_at(way, share * (count + 1)) - point) / each.before.unit_px
        seen = features_between(each, count, np.array([share]))[0]
        parts.append((seen, off, scales_between(each, count)))
    features, off, scales = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
    return Samples(features, off, scales, np.tile(windows.weight, 2), np.tile(windows.fold, 2), windows.independent)


def _at(way: NDArray[np.float64], frame: float) -> NDArray[np.float64]:
    """Return the places (M, 2) of ways (M, T, 2) at a broken frame."""
    below = int(frame)
    rest = frame - below
    return way[:, below] if rest == 0.0 else (1 - rest) * way[:, below] + rest * way[:, below + 1]


def way_between(
    regression: Callable[[int, float], Regression], ends: Ends, count: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the places (count, 2) on the frames between two ends, and the radii (count,) that hold 95 %, in pixels.

    Args:
        regression: takes one of ``GAPS`` and one of ``SHARES`` to their regression.
    """
    above = int(np.searchsorted(GAPS, count))
    near = sorted({GAPS[max(above - 1, 0)], GAPS[min(above, len(GAPS) - 1)]})
    ways, radii = _at_shares(regression, ends, count, near)
    upper = 0.0 if len(near) == 1 else float(np.log(count / near[0]) / np.log(near[1] / near[0]))
    blend = np.array([1.0 - upper, upper])[: len(near)]
    at = np.arange(1, count + 1) / (count + 1.0)
    chord = ends.before.last_px[0] + at[:, None] * (ends.after.last_px[0] - ends.before.last_px[0])
    knots = np.array([0.0, *SHARES, *(1.0 - share for share in SHARES[-2::-1]), 1.0])
    way = CubicSpline(knots, np.einsum("g,gki->ki", blend, ways))(at)
    return chord + way, np.interp(at, knots, blend @ radii)


def _at_shares(
    regression: Callable[[int, float], Regression], ends: Ends, count: int, gaps: Sequence[int]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the ways off the chord (G, K, 2) and radii (G, K), px, at the ends, all shares and the mirrored ones."""
    unit, shares, scales = float(ends.before.unit_px[0, 0]), np.array(SHARES), scales_between(ends, count)
    forth, back = (features_between(each, count, shares) for each in (ends, ends.reversed()))
    ways, radii = np.zeros((len(gaps), 2 * len(SHARES) + 1, 2)), np.zeros((len(gaps), 2 * len(SHARES) + 1))
    for row, gap in enumerate(gaps):
        for k, share in enumerate(SHARES):
            found = regression(gap, share)
            # The half of the gap is reached from both sides.
            ways[row, 1 + k] += found.step(forth[k])[0] * unit * (0.5 if share == 0.5 else 1.0)
            ways[row, -2 - k] += found.step(back[k])[0] * unit * (0.5 if share == 0.5 else 1.0)
            radii[row, 1 + k] = radii[row, -2 - k] = float(found.radius(scales)[0]) * unit
    return ways, radii
