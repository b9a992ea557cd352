"""How much the camera's motion tells of a car that is out of the picture: regression with and without it.

A regressor is trained on the car's true state at the exit and the time since, and a second one on the camera's true
motion as well. If the pilot knows nothing of the car, the second one is hardly better.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenarios.road_town.pilot import frame_out_spans, picture_states
from sim.optics import intersect_plane
from trackers.types import CameraModel

_RECENT_FRAMES = 5
_LAGS_FRAMES = (5, 15, 30)
_BINS, _DEPTH, _RATE, _SMALLEST_LEAF = 32, 4, 0.1, 60
_RIDGE = 1e-2
_WORST_ERROR_M = 100.0
_DRAWS = 1000
_EVERY = 3
_SHARES = (0.0, 0.25, 0.5, 0.75, 1.0)


@dataclass(frozen=True, eq=False)
class Rows:
    """Frames outside the picture, in the car's frame at its exit (x ahead, y left).

    Attributes:
        state: (R, A) the car's state at the exit, and the time since. camera: (R, B) the camera's motion.
        place_m: (R, 2) where the car is. episode: (R,) index of its episode.
    """

    state: NDArray[np.float64]
    camera: NDArray[np.float64]
    place_m: NDArray[np.float64]
    episode: NDArray[np.int64]


def rows_of(
    episode: int,
    camera: CameraModel,
    poses: NDArray[np.float64],
    position_m: NDArray[np.float64],
    corners_m: NDArray[np.float64],
    rate_hz: float,
) -> Rows:
    """Return the rows of one flight: ``poses`` (T, 4, 4); of the car ``position_m`` (T, 2), ``corners_m`` (T, 8, 3)."""
    spans = frame_out_spans(picture_states(camera, poses, corners_m))
    place = position_m @ np.array([1.0, 1j])
    below = poses[:, :2, 3] @ np.array([1.0, 1j])
    aim = np.array([complex(*intersect_plane(camera, pose, camera.centre_px, 0.0)) for pose in poses])
    nose = np.unwrap(np.arctan2(-poses[:, 1, 1], -poses[:, 0, 1]))
    made = [
        _rows_of_span(episode, start, end, place, below, aim, nose, poses[:, 2, 3], rate_hz)
        for start, end in spans
        if start > 2 * _RECENT_FRAMES
    ]
    return joined(made)


def joined(parts: list[Rows]) -> Rows:
    """Return the rows of all parts."""
    if not parts:
        return Rows(np.empty((0, 9)), np.empty((0, 27)), np.empty((0, 2)), np.empty(0, int))
    return Rows(*(np.concatenate([getattr(part, name) for part in parts]) for name in Rows.__dataclass_fields__))


def _rows_of_span(
    episode: int,
    start: int,
    end: int,
    place: NDArray[np.complex128],
    below: NDArray[np.complex128],
    aim: NDArray[np.complex128],
    nose: NDArray[np.float64],
    height_m: NDArray[np.float64],
    rate_hz: float,
) -> Rows:
    recent = np.diff(place[start - 2 * _RECENT_FRAMES : start + 1]) * rate_hz
    now, before = recent[_RECENT_FRAMES:].mean(), recent[:_RECENT_FRAMES].mean()
    speed = abs(now)
    ahead = now / speed if speed > 0.3 else np.exp(1j * nose[start])
    gain = (now - before) / ahead * rate_hz / _RECENT_FRAMES
    turn = np.clip(gain.imag / max(speed, 1.0), -1.5, 1.5)
    frames = np.arange(start, end)
    t = (frames - start) / rate_hz
    straight = speed * t
    rolled = straight * np.exp(0.5j * np.clip(turn * t, -1.5, 1.5))
    state = np.column_stack(
        [np.full((len(t), 3), [speed, gain.real, turn]), t, t**2, straight, rolled.real, rolled.imag, gain.real * t**2]
    )
    columns = [nose[frames] - nose[start], height_m[frames], height_m[frames] - height_m[start]]
    for track, origin in ((below, below[start]), (aim, place[start])):
        local = (track - origin) / ahead
        columns += [local[frames].real, local[frames].imag]
        for lag in _LAGS_FRAMES:
            moved = local[frames] - local[np.maximum(frames - lag, start)]
            columns += [moved.real, moved.imag]
    since = (below[start] - place[start]) / ahead
    velocity = (below[start] - below[start - 1]) * rate_hz / ahead
    at_exit = np.full(
        (len(t), 6),
        [
            since.real,
            since.imag,
            velocity.real,
            velocity.imag,
            *(np.sin(x := nose[start] - np.angle(ahead)), np.cos(x)),
        ],
    )
    where = (place[frames] - place[start]) / ahead
    return Rows(
        state,
        np.column_stack([*columns, at_exit]),
        np.column_stack([where.real, where.imag]),
        np.full(len(t), episode),
    )


class BoostedTrees:
    """Least-squares gradient boosting of oblivious-free binary trees on binned features, after a ridge regression."""

    def __init__(self, trees: int, rng: np.random.Generator) -> None:
        self._trees, self._rng = trees, rng

    def fit(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> BoostedTrees:
        """Fit to rows (R, F) and values (R,)."""
        self._mean, self._scale = x.mean(axis=0), x.std(axis=0) + 1e-9
        design = self._design(x)
        penalty = _RIDGE * len(x) * np.eye(design.shape[1])
        penalty[-1, -1] = 0.0
        self._weights = np.linalg.solve(design.T @ design + penalty, design.T @ y)
        self._edges = np.quantile(x, np.linspace(0, 1, _BINS + 1)[1:-1], axis=0)
        bins = self._binned(x)
        left = y - design @ self._weights
        self._grown = []
        for _ in range(self._trees):
            chosen = np.flatnonzero(self._rng.random(len(x)) < 0.5)
            tree = _grow(bins[chosen], left[chosen])
            self._grown.append(tree)
            left = left - _RATE * _walk(tree, bins)
        return self

    def predict(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the values (R,) of rows (R, F)."""
        bins = self._binned(x)
        return self._design(x) @ self._weights + _RATE * sum(_walk(tree, bins) for tree in self._grown)

    def _design(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        scaled = np.clip((x - self._mean) / self._scale, -4.0, 4.0)
        return np.column_stack([scaled, np.ones(len(x))])

    def _binned(self, x: NDArray[np.float64]) -> NDArray[np.int64]:
        return np.stack([np.searchsorted(self._edges[:, k], x[:, k]) for k in range(x.shape[1])], axis=1)


Tree = tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]
"""Features, thresholds and values of the nodes; node n has the children 2 n + 1 and 2 n + 2; feature -1 is a leaf."""


def _grow(bins: NDArray[np.int64], left: NDArray[np.float64]) -> Tree:
    size = 2 ** (_DEPTH + 1) - 1
    feature, threshold, value = np.full(size, -1), np.zeros(size, int), np.zeros(size)
    offsets = np.arange(bins.shape[1]) * _BINS
    members = {0: np.arange(len(left))}
    for node in range(size):
        rows = members.pop(node, None)
        if rows is None:
            continue
        value[node] = left[rows].mean() if len(rows) else 0.0
        if node >= size // 2 or len(rows) < 2 * _SMALLEST_LEAF:
            continue
        keys = (bins[rows] + offsets).ravel()
        total = bins.shape[1] * _BINS
        counts = np.bincount(keys, minlength=total).reshape(-1, _BINS).cumsum(axis=1)[:, :-1]
        sums = np.bincount(keys, np.repeat(left[rows], bins.shape[1]), total).reshape(-1, _BINS).cumsum(axis=1)[:, :-1]
        others, rest = len(rows) - counts, left[rows].sum() - sums
        gain = np.where(
            (counts >= _SMALLEST_LEAF) & (others >= _SMALLEST_LEAF),
            sums**2 / np.maximum(counts, 1) + rest**2 / np.maximum(others, 1),
            -np.inf,
        )
        best = int(np.argmax(gain))
        if not np.isfinite(gain.flat[best]):
            continue
        feature[node], threshold[node] = divmod(best, _BINS - 1)
        low = bins[rows, feature[node]] <= threshold[node]
        members[2 * node + 1], members[2 * node + 2] = rows[low], rows[~low]
    return feature, threshold, value


def _walk(tree: Tree, bins: NDArray[np.int64]) -> NDArray[np.float64]:
    feature, threshold, value = tree
    node = np.zeros(len(bins), int)
    rows = np.arange(len(bins))
    for _ in range(_DEPTH):
        inner = feature[node] >= 0
        high = bins[rows, np.maximum(feature[node], 0)] > threshold[node]
        node = np.where(inner, 2 * node + 1 + high, node)
    return value[node]


def errors_m(rows: Rows, folds: int, trees: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return each row's error (R, 2), without and with the camera's motion, of models of the other folds' episodes.

    One model predicts the car's place from its state at the exit, another one from the camera's motion as well. The
    second answer is the mixture of both that is best, on the training episodes, between two halves of them.
    """
    target, state = rows.place_m, rows.state
    both = np.column_stack([state, rows.camera])
    group = rng.permutation(rows.episode.max() + 1)[rows.episode]
    errors = np.zeros((len(target), 2))
    for held_out in range(folds):
        test, train = group % folds == held_out, group % folds != held_out
        half = train & (group // folds % 2 == 0)
        total_m = np.zeros(len(_SHARES))
        for learnt, other in ((half, train & ~half), (train & ~half, half)):
            total_m += _mixed_errors_m(state, both, target, learnt, other, trees, rng).sum(axis=1)
        mixed_m = _mixed_errors_m(state, both, target, train, test, trees, rng)
        errors[test] = mixed_m[[0, int(np.argmin(total_m))]].T
    return errors


def _mixed_errors_m(
    state: NDArray[np.float64],
    both: NDArray[np.float64],
    target: NDArray[np.float64],
    train: NDArray[np.bool_],
    test: NDArray[np.bool_],
    trees: int,
    rng: np.random.Generator,
) -> NDArray[np.float64]:
    """Return the errors (S, M) of the test rows for each share of the model with the camera's motion."""
    plain, more = (_predicted(x, target, train, test, trees, rng) for x in (state, both))
    mixed = plain + np.array(_SHARES)[:, None, None] * (more - plain)
    return np.minimum(np.linalg.norm(mixed - target[test], axis=2), _WORST_ERROR_M)


def _predicted(
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    train: NDArray[np.bool_],
    test: NDArray[np.bool_],
    trees: int,
    rng: np.random.Generator,
) -> NDArray[np.float64]:
    """Return the values (M, 2) of the test rows, learnt from every ``_EVERY``-th training row."""
    rows = np.flatnonzero(train)[::_EVERY]
    return np.column_stack([BoostedTrees(trees, rng).fit(x[rows], y[rows, k]).predict(x[test]) for k in (0, 1)])


def gain_and_upper_end(rows: Rows, *, trees: int, folds: int = 4, seed: int = 0) -> tuple[float, float]:
    """Return by how much the camera's motion lowers the error on held-out episodes, as a share of the error without.

    The second value is the upper end of its bootstrap interval over episodes (95 %, two-sided).
    """
    rng = np.random.default_rng(seed)
    errors = errors_m(rows, folds, trees, rng)
    count = rows.episode.max() + 1
    sums = np.stack([np.bincount(rows.episode, error, count) for error in errors.T])
    drawn = np.stack([sums[:, rng.integers(count, size=count)].sum(axis=1) for _ in range(_DRAWS)])
    gains = 1.0 - drawn[:, 1] / drawn[:, 0]
    return float(1.0 - sums[1].sum() / sums[0].sum()), float(np.quantile(gains, 0.975))
