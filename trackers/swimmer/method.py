"""Our gap method: regressions of where swimmers go, shipped with weights and learnt anew from the tracks at hand.

A past that one slight curve explains goes on along it: regressions over all kinds of swimming shrink a way and take its
end from few frames, but a slow fish that is measured with noise needs all of its past.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from importlib import resources
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline, PchipInterpolator

from trackers.gaps import Bridge, Piece, Surroundings
from trackers.swimmer.features import (
    PAST,
    POSTURE_FEATURES,
    Pasts,
    Recording,
    activity,
    features,
    fitted_motion,
    jitter_px,
    lengths,
    postures_of,
    smoothness,
    whole_past,
)
from trackers.swimmer.regression import Regression, Samples, fitted

_STEADY = 6.0
"""Root mean square distance of a past to its curve, over the noise of a coordinate, at which it counts half as steady.

Below 5 for the slow fish of preset ``paper-c`` on development seeds, above 14 for 99 % of the zebrafish's pasts.
"""
_DRIFT = 0.02
"""Standard deviation of the way, as a share of what its square in pasts makes of a past's way: how steadiness ends."""
_RADIUS_SIGMAS = float(np.sqrt(-2.0 * np.log(0.05)))


class SteadyWay(NamedTuple):
    """How a past goes on if it is steady.

    Attributes:
        weight: in [0, 1], 1 where the past is steady: where its noise explains how far it is off its curve.
        place_px: (G, 2). radius_px: (G,) of the circles that hold 95 %.
    """

    weight: float
    place_px: NDArray[np.float64]
    radius_px: NDArray[np.float64]


def steady_way(x: NDArray[np.float64], ahead: NDArray[np.float64], noise_px: float) -> SteadyWay:
    """Return the places ``ahead`` (G,) frames after a past (T, 2), px, of one frame after the other.

    The curve is of least squares: of constant speed along the past's direction, a parabola across it.

    Args:
        noise_px: standard deviation of a measured coordinate, > 0.
    """
    t = np.linspace(-1.0, 0.0, len(x))
    s = ahead / (len(x) - 1)
    past, future = (np.stack([np.ones_like(at), at + 0.5, (at + 0.5) ** 2], axis=1) for at in (t, s))
    straight, *_ = np.linalg.lstsq(past[:, :2], x, rcond=None)
    way_px = float(np.linalg.norm(straight[1]))
    along = straight[1] / max(way_px, 1e-9)
    across = np.array([-along[1], along[0]])
    curved, *_ = np.linalg.lstsq(past, x @ across, rcond=None)
    bend = curved - np.concatenate([straight @ across, [0.0]])
    fitted, place = (at[:, :2] @ straight + np.outer(at @ bend, across) for at in (past, future))
    rest_px = float(np.sqrt(((x - fitted) ** 2).sum(axis=1).mean()))
    leverage = np.einsum("gi,ij,gj->g", future, np.linalg.inv(past.T @ past), future)
    spread_px = np.sqrt(rest_px**2 * (1.0 + leverage) + (_DRIFT * way_px * s**2) ** 2)
    weight = 1.0 / (1.0 + (rest_px / (_STEADY * noise_px)) ** 4)
    return SteadyWay(weight, place, _RADIUS_SIGMAS * spread_px)


KNOTS = (2, 5, 12, 25, 50, 100, 200)
"""Numbers of frames ahead for which a regression is learnt; between them the way is interpolated, then it stands."""


def samples_ahead(recording: Recording, ahead: int) -> Samples:
    """Return the steps within ``ahead`` frames that a recording shows."""
    windows = recording.windows(ahead, 0)
    pasts = windows.pasts
    step = (windows.gap_px[:, -1] - pasts.last_px) / pasts.unit_px
    scales = scales_ahead(pasts)
    features_ahead = features(pasts, np.array([float(ahead)]))[0]
    return Samples(features_ahead, step, scales, windows.weight, windows.fold, windows.independent, POSTURE_FEATURES)


def scales_ahead(pasts: Pasts) -> NDArray[np.float64]:
    """Return (M, 6) scales of the error: constant, and with the way and the speed, of rough and smooth pasts."""
    x, unit = pasts.position_px, pasts.unit_px[:, 0]
    smooth, active = smoothness(x), activity(pasts)
    swift = np.linalg.norm(x[:, -1] - x[:, -7], axis=1) / unit
    rough = 1.0 - smooth
    return np.stack([rough, rough * active, rough * swift, smooth * active, smooth * swift, 1.0 / unit], axis=1)


def way_ahead(
    regression: Callable[[int], Regression], pasts: Pasts, count: int, noise_px: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the places (count, 2) on the frames after one past, and the radii (count,) that hold 95 %, in pixels.

    Places outside the bounds are moved onto them as far as the past is rough: a smooth one shows where it will go
    better than the bounds do. As far as it is steady, it goes on along its own curve.

    Args:
        regression: takes one of ``KNOTS`` to its regression.
        noise_px: standard deviation of a measured coordinate, > 0.
    """
    last, unit = pasts.last_px[0], float(pasts.unit_px[0, 0])
    knots = KNOTS[: int(np.searchsorted(KNOTS, count)) + 1]
    scales, seen = scales_ahead(pasts), features(pasts, np.array(knots, dtype=float))
    places, radii, frames = [last], [0.0], [0, *knots]
    for ahead, each in zip(knots, seen, strict=True):
        places.append(last + regression(ahead).step(each)[0] * unit)
        radii.append(float(regression(ahead).radius(scales)[0]) * unit)
    at = np.minimum(np.arange(1, count + 1), frames[-1])
    way = PchipInterpolator(frames, np.array(places))(at)
    within = np.clip(way, pasts.bounds_xyxy[0, :2], pasts.bounds_xyxy[0, 2:])
    smooth = float(smoothness(pasts.position_px)[0])
    way = within + smooth * (way - within)
    steady, curve, reach = steady_way(pasts.position_px[0], at, noise_px)
    return way + steady * (curve - way), (1 - steady) * np.interp(
        at, frames, np.maximum.accumulate(radii)
    ) + steady * reach


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


_LEAST_NOISE_PX = 0.1
_UNKNOWN = np.zeros(3)
PRIOR_FILE = "prior.json"
"""Radius of the circle that holds 95 % of a round Gaussian, in standard deviations."""


class SwimGaps:
    """A ``GapMethod`` for targets that swim in a tank.

    Extrapolation and interpolation are regressions on the motion at the ends, the walls and the place where targets
    have been of late. They are shipped with weights from simulated swims and are learnt anew, with those as prior, by
    ``learn``. Time is counted in frames: the weights that are shipped suit about 30 frames per second.
    """

    def __init__(self, posture: bool = True, learns: bool = True) -> None:
        """Start with the shipped weights.

        Args:
            posture: whether headings and centre lines are used where they are given.
            learns: if False, ``learn`` is without effect.
        """
        self._posture, self._learns = posture, learns
        self.learn(())

    def learn(self, pieces: Sequence[Piece]) -> None:
        """Learn from all pieces; what was learnt before is forgotten."""
        self._recording = Recording([self._allowed(piece) for piece in pieces] if self._learns else [])
        # Fitted at their first use: most users need few of them.
        self._ahead = cache(lambda ahead: _learnt(samples_ahead(self._recording, ahead), shipped()[0][ahead]))
        self._between = cache(
            lambda gap, share: _learnt(samples_between(self._recording, gap, share), shipped()[1][gap, share])
        )

    def extrapolate(self, past: Piece, count: int, around: Surroundings) -> Bridge:
        """See ``GapMethod``."""
        x, pause = whole_past(past)
        posture = postures_of(self._allowed(past))[len(past.position_px) - 1 - pause]
        noise_px = max(jitter_px(x), _LEAST_NOISE_PX)
        places, radii = way_ahead(self._ahead, self._pasts(x, around, posture), pause + count, noise_px)
        return _bridge(places[pause:], radii[pause:], noise_px)

    def interpolate(self, past: Piece, future: Piece, around: Surroundings) -> Bridge:
        """See ``GapMethod``."""
        x, pause = whole_past(past)
        back = Piece(0, future.position_px[::-1], future.interval_s)
        y, later = whole_past(back)
        count = future.first_frame - past.end_frame
        ends = Ends(self._pasts(x, around, _UNKNOWN), self._pasts(y, around, _UNKNOWN))
        places, radii = way_between(self._between, ends, pause + count + later)
        return _bridge(places[pause : pause + count], radii[pause : pause + count], max(jitter_px(x), _LEAST_NOISE_PX))

    def _allowed(self, piece: Piece) -> Piece:
        return piece if self._posture else replace(piece, heading_rad=None, centre_line_px=None)

    def _pasts(self, x: NDArray[np.float64], around: Surroundings, posture: NDArray[np.float64]) -> Pasts:
        bounds = around.bounds_xyxy
        if bounds is None:
            bounds = np.concatenate([x.min(axis=0), x.max(axis=0)])
        home = 0.5 * (bounds[:2] + bounds[2:]) if self._recording.home_px is None else self._recording.home_px
        return Pasts(x[None], bounds[None], home[None], posture[None])


def _learnt(samples: Samples, prior: Regression) -> Regression:
    return fitted(samples, prior) if len(samples.step) else prior


def _bridge(places: NDArray[np.float64], radii: NDArray[np.float64], noise_px: float) -> Bridge:
    variance = (radii / _RADIUS_SIGMAS) ** 2 + noise_px**2
    return Bridge(places, variance[:, None, None] * np.eye(2))


@cache
def shipped() -> tuple[dict[int, Regression], dict[tuple[int, float], Regression]]:
    """Return the shipped regressions, by frames ahead, and by length of the gap and share of it."""
    content: Mapping[str, Any] = json.loads(resources.files("trackers.swimmer").joinpath(PRIOR_FILE).read_text())
    ahead = {each["ahead"]: _read(each) for each in content["ahead"]}
    return ahead, {(each["gap"], each["share"]): _read(each) for each in content["between"]}


def _read(content: Mapping[str, Any]) -> Regression:
    return Regression(np.array(content["weights"]), np.array(content["spread"]))
