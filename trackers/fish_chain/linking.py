"""Which tracklet continues which, by motion and by looks: the best set of links, and a probability for each.

A look is ``x = μ + b + w``: b ~ N(0, B) differs between fish, w ~ N(0, W) between chunks of frames of one fish. The
log-likelihood ratio of *same fish* against *two fish* follows in closed form (Brümmer & de Villiers, The speaker
partitioning problem, Odyssey 2010); it tends to 0 for fish that look alike.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh
from scipy.optimize import linear_sum_assignment
from scipy.special import ive

from trackers.fish_chain.posture import headings
from trackers.fish_chain.tracklets import Tracklet
from trackers.gaps import GapMethod, Piece, Surroundings
from trackers.registry import tunable

_LEAST_PIECES, _LEAST_CHUNKS = 4, 3
_PRIOR_CHUNKS = 20.0
_LASTING = 0.3
"""Share of W that does not average out over chunks: light, depth and posture change slowly."""
_MOST = 3.0
"""Limit of a single feature's log-likelihood ratio; real looks have heavier tails than Gaussians."""


class Appearance:
    """The model; ratios are 0 until enough tracklets are known."""

    def __init__(self) -> None:
        self._axes: NDArray[np.float64] | None = None

    def learn(self, pieces: Sequence[NDArray[np.float64]]) -> None:
        """Learn from the looks (C, D) of tracklets, each of one fish."""
        long = [looks for looks in pieces if len(looks) >= _LEAST_CHUNKS]
        if len(long) < _LEAST_PIECES:
            return
        means = np.array([looks.mean(axis=0) for looks in long])
        counts = np.array([len(looks) for looks in long], dtype=float)
        centred = np.concatenate([looks - mean for looks, mean in zip(long, means, strict=True)])
        freedom = counts.sum() - len(long)
        all_variance = np.var(np.concatenate(long), axis=0) + 1e-9
        prior = _PRIOR_CHUNKS * np.diag(all_variance)
        within = (centred.T @ centred + prior) / (freedom + _PRIOR_CHUNKS)
        mean = np.average(means, axis=0, weights=np.sqrt(counts))
        # Axes on which W = I and the means of pieces scatter by diag(scatter).
        scatter, axes = eigh(np.cov(means.T, aweights=np.sqrt(counts)), within)
        noise = float(np.mean(_noise(counts)))
        # Means of one and the same fish would scatter by up to so much (Marchenko & Pastur, 1967).
        edge = noise * (1 + np.sqrt(len(mean) / len(long))) ** 2
        kept = scatter > edge
        self._mean, self._spread, self._axes = mean, scatter[kept] - noise, axes[:, kept]

    def log_ratios(
        self, first: Sequence[NDArray[np.float64]], second: Sequence[NDArray[np.float64]]
    ) -> NDArray[np.float64]:
        """Return the log-likelihood ratios (N, M), same against different, of N pieces' looks (C, D) with M others'.

        0 for pieces without looks (C = 0).
        """
        if self._axes is None or not len(first) or not len(second):
            return np.zeros((len(first), len(second)))
        x, u = self._projected(first)
        y, v = self._projected(second)
        seen = np.logical_and.outer(*([len(looks) > 0 for looks in pieces] for pieces in (first, second)))
        x, u, y, v = x[:, None], u[:, None, None], y[None], v[None, :, None]
        spread = self._spread
        same_xx, same_yy = spread + u, spread + v
        determinant = same_xx * same_yy - spread**2
        same = (x**2 * same_yy - 2 * spread * x * y + y**2 * same_xx) / determinant + np.log(determinant)
        different = x**2 / same_xx + y**2 / same_yy + np.log(same_xx * same_yy)
        ratios = np.clip(0.5 * (different - same), -_MOST, _MOST)
        return np.where(seen, ratios.sum(axis=-1), 0.0)

    def _projected(self, pieces: Sequence[NDArray[np.float64]]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        assert self._axes is not None
        means = np.array([looks.mean(axis=0) if len(looks) else self._mean for looks in pieces])
        counts = np.array([max(len(looks), 1) for looks in pieces], dtype=float)
        return (means - self._mean) @ self._axes, _noise(counts)


def _noise(counts: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the variance of the mean of so many chunks, as a share of W."""
    return _LASTING + (1 - _LASTING) / counts


PAST_FRAMES = 100
"""Frames of a tracklet that a gap method is given."""
_LAGS = (1, 2, 4, 8, 16, 32, 64, 128, 256)
_LEAST_PAIRS = 20
_LEAST_STEP_PX = 1.0
_MOST_KEPT = 0.97
_GHOST_FRAMES = 3
"""A fish that was followed inside a blob is expected where it was last for so many more frames."""


@dataclass(frozen=True)
class MotionParameters:
    """Parameters of ``MotionModel``; lengths are in lengths of the usual body.

    Attributes:
        followed: standard deviation of the place of a fish that was followed inside a blob, on the first frame.
        followed_growth: its growth a frame.
        inflation: factor on the standard deviation that the gap method claims.
        outliers: share of gaps whose end has nothing to do with the prediction.
        use_posture: if False, headings and places inside blobs are left out.
    """

    followed: float = tunable(0.12, 0.03, 0.5, log=True)
    followed_growth: float = tunable(0.015, 0.003, 0.1, log=True)
    inflation: float = tunable(1.2, 0.7, 3.0, log=True)
    outliers: float = tunable(0.01, 0.001, 0.1, log=True)
    use_posture: bool = True


@dataclass(frozen=True)
class Starts:
    """Where tracklets begin: first_frame (M,), place_px (M, 2), heading_rad (M,)."""

    first_frame: NDArray[np.int64]
    place_px: NDArray[np.float64]
    heading_rad: NDArray[np.float64]

    @staticmethod
    def of(tracklets: Sequence[Tracklet]) -> Starts:
        """Return the starts of tracklets, at least one."""
        lines = np.array([each.line_px(each.first_frame) for each in tracklets])
        frames = np.array([each.first_frame for each in tracklets])
        return Starts(frames, lines[:, lines.shape[1] // 2], headings(lines))


class MotionModel:
    """Log-densities of places and headings after gaps.

    Attributes:
        interval_s: time between frames. length_px: of the usual body. around: input of the gap method.
    """

    def __init__(self, parameters: MotionParameters, gap_method: GapMethod) -> None:
        self._parameters = parameters
        self._gap_method = gap_method
        self._heading_kept = np.zeros(len(_LAGS))
        self._bridges: dict[int, tuple[NDArray[np.float64], NDArray[np.float64]]] = {}
        self._between: dict[tuple[int, int], tuple[int, NDArray[np.float64], NDArray[np.float64]]] = {}
        self.interval_s = 1 / 30
        self.length_px = 1.0
        self.around = Surroundings()

    def learn(self, pieces: Sequence[Piece]) -> None:
        """Learn from tracklets: the gap method, and how headings are kept over time."""
        self._gap_method.learn(pieces)
        angles = [each.heading_rad for each in pieces if each.heading_rad is not None]
        for index, lag in enumerate(_LAGS):
            cosines = np.cos(np.concatenate([np.zeros(0), *(each[lag:] - each[:-lag] for each in angles)]))
            enough = len(cosines) >= _LEAST_PAIRS
            self._heading_kept[index] = max(float(cosines.mean()), 0.0) if enough else self._heading_kept[index - 1] / 2
        self._bridges.clear()
        self._between.clear()

    def log_ratios(self, tail: Tracklet, starts: Starts) -> NDArray[np.float64]:
        """Return how much likelier (M,) the starts, all after the tracklet's end, are after it than anywhere at all.

        Logarithms of densities of place and heading over uniform ones.
        """
        p = self._parameters
        lost = starts.first_frame - tail.end_frame
        expected, covariance = self.bridge(tail, int(lost.max()) + 1)
        expected, covariance = expected[lost], covariance[lost]
        last = max(tail.ghosts, default=tail.end_frame - 1)
        pose = tail.ghosts.get(last)
        line = tail.line_px(tail.end_frame - 1)[None]
        heading = float(headings(line)[0] if pose is None else pose[2] + 0.5 * pose[3])
        if p.use_posture:
            followed = starts.first_frame - last <= (1 if pose is None else _GHOST_FRAMES)
            moved = np.array([tail.place_on(int(frame)) for frame in starts.first_frame])
            covariances = np.array([self.followed(int(count)) for count in lost])
            expected = np.where(followed[:, None], moved, expected)
            covariance = np.where(followed[:, None, None], covariances, covariance)
        inside = _log_gaussian(starts.place_px - expected, covariance) + self._log_reach()
        ratios = np.logaddexp(math.log1p(-p.outliers) + inside, math.log(p.outliers))
        return ratios + (self._heading_ratios(starts.heading_rad - heading, lost + 1) if p.use_posture else 0.0)

    def bridge(self, tail: Tracklet, count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return where a fish is expected on at least ``count`` frames after its tracklet's last: (G, 2), (G, 2, 2)."""
        known = self._bridges.get(tail.number)
        if known is None or len(known[0]) < count:
            known = self._extrapolated(tail, max(count, 16) if known is None else 2 * count)
            self._bridges[tail.number] = known
        return known

    def between(self, tail: Tracklet, start: Tracklet) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the places (G, 2) with covariances (G, 2, 2) on the frames between two tracklets of one fish."""
        known = self._between.get((tail.number, start.number))
        if known is None or known[0] != len(start):
            known = len(start), *self._interpolated(tail, start)
            self._between[tail.number, start.number] = known
        return known[1:]

    def _interpolated(self, tail: Tracklet, start: Tracklet) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        past = tail.piece(self.interval_s, slice(-PAST_FRAMES, None))
        future = start.piece(self.interval_s, slice(PAST_FRAMES))
        count = start.first_frame - tail.end_frame
        bridge = self._gap_method.interpolate(past, future, self.around)
        if bridge is not None and np.isfinite(bridge.position_px).all() and bridge.covariance_px is not None:
            return bridge.position_px, self._parameters.inflation**2 * bridge.covariance_px
        share = np.arange(1, count + 1) / (count + 1)
        line = past.position_px[-1] + share[:, None] * (future.position_px[0] - past.position_px[-1])
        nearer = np.minimum(np.arange(count), np.arange(count)[::-1])
        return line, hold(past, count, self.length_px)[1][nearer]

    def followed(self, lost: int) -> NDArray[np.float64]:
        """Return the covariance (2, 2) of a place that was followed inside a blob for ``lost`` frames."""
        spread = self.length_px * (self._parameters.followed + self._parameters.followed_growth * lost)
        return spread**2 * np.eye(2)

    def _log_reach(self) -> float:
        """Return the logarithm of the area in px² that fish may begin in."""
        bounds = self.around.bounds_xyxy
        return 0.0 if bounds is None else math.log(max(float(np.prod(bounds[2:] - bounds[:2])), 1.0))

    def _extrapolated(self, tail: Tracklet, count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        past = tail.piece(self.interval_s, slice(-PAST_FRAMES, None))
        bridge = self._gap_method.extrapolate(past, count, self.around)
        held = hold(past, count, self.length_px)
        if bridge is None or not np.isfinite(bridge.position_px).all():
            return held
        if bridge.covariance_px is None:
            return bridge.position_px, held[1]
        floor = (self._parameters.followed * self.length_px) ** 2 * np.eye(2)
        return bridge.position_px, self._parameters.inflation**2 * bridge.covariance_px + floor

    def _heading_ratios(self, turned_rad: NDArray[np.float64], age: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return log-densities over the uniform one, von Mises with the mean cosine seen at that age."""
        kept = np.minimum(np.interp(np.log(np.maximum(age, 1)), np.log(_LAGS), self._heading_kept), _MOST_KEPT)
        # Concentration from the mean cosine (Banerjee et al., JMLR 6, 2005, with two dimensions).
        kappa = kept * (2 - kept**2) / (1 - kept**2)
        ratios: NDArray[np.float64] = kappa * (np.cos(turned_rad) - 1) - np.log(ive(0, kappa))
        return ratios


def hold(past: Piece, count: int, length_px: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the last place, kept, with covariances between those of a straight and of a random walk of its steps."""
    steps = np.diff(past.position_px, axis=0)
    variance = float(np.mean(np.sum(steps**2, axis=1))) / 2 if len(steps) else (0.1 * length_px) ** 2
    growth = (variance + _LEAST_STEP_PX**2) * np.arange(1, count + 1, dtype=float) ** 1.7
    return np.tile(past.position_px[-1], (count, 1)), growth[:, None, None] * np.eye(2)


def _log_gaussian(offset: NDArray[np.float64], covariance: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return log-densities (M,) of offsets (M, 2) under Gaussians (M, 2, 2)."""
    solved = np.linalg.solve(covariance, offset[..., None])[..., 0]
    densities: NDArray[np.float64] = (
        -0.5 * (offset * solved).sum(axis=-1) - 0.5 * np.log(np.linalg.det(covariance)) - math.log(2 * math.pi)
    )
    return densities


IMPOSSIBLE = 1e6


@dataclass(frozen=True, slots=True)
class Match:
    """Row ``tail`` continues as column ``start``, with a probability against all alternatives."""

    tail: int
    start: int
    probability: float


def best_links(costs: NDArray[np.float64]) -> list[Match]:
    """Return the set of links with the least sum of costs, each tail and start at most once.

    Args:
        costs: (N, M) negative log-odds of each link against none; a link with a cost >= 0 is never in the set.

    The probability of a link is a softmax over the set and those without the link that differ from it by one step: its
    tail and its start are linked to others that are free, or not at all, or two links are exchanged. So two fish that
    go into a blob and come out of it are decided together.
    """
    gains = np.minimum(costs, 0.0)
    if not gains.any():
        return []
    rows, columns = linear_sum_assignment(gains)
    chosen = gains[rows, columns] < 0
    rows, columns = rows[chosen], columns[chosen]
    own = gains[rows, columns]
    exchanged = gains[np.ix_(rows, columns)] + gains[np.ix_(rows, columns)].T - own[:, None] - own[None, :]
    np.fill_diagonal(exchanged, np.inf)
    free_columns = np.setdiff1d(np.arange(costs.shape[1]), columns)
    free_rows = np.setdiff1d(np.arange(costs.shape[0]), rows)
    worth = np.where(gains < 0, -gains, -np.inf)
    left = _log_sum(worth[np.ix_(rows, free_columns)]) + _log_sum(worth[np.ix_(free_rows, columns)].T) + own
    # No alternative is better than the best set, so no exponent overflows.
    alternatives = np.exp(left) + np.exp(-np.maximum(exchanged, 0.0)).sum(axis=1)
    return [
        Match(int(row), int(column), float(probability))
        for row, column, probability in zip(rows, columns, 1.0 / (1.0 + alternatives), strict=True)
    ]


def _log_sum(worth: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return for each row the logarithm of the sum of one, for no link, and of the exponentials of all its links."""
    none = np.zeros((len(worth), 1))
    return np.logaddexp.reduce(np.concatenate([none, worth], axis=1), axis=1)  # type: ignore[no-any-return]
