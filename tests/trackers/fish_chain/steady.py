"""A small gap method for tests: constant velocity that dies out, with a region that widens."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from trackers.gaps import Bridge, Piece, Surroundings

_KEPT = 0.93


class Steady:
    """Extrapolates the last steps; between two ends it weighs both by their distance."""

    def learn(self, pieces: Sequence[Piece]) -> None:
        """See ``GapMethod``."""
        steps = [np.diff(each.position_px, axis=0) for each in pieces]
        self._step_px = float(np.sqrt(np.mean(np.sum(np.concatenate(steps) ** 2, axis=1)))) if steps else 3.0

    _step_px = 3.0

    def extrapolate(self, past: Piece, count: int, around: Surroundings) -> Bridge:
        """See ``GapMethod``."""
        steps = np.diff(past.position_px[-5:], axis=0)
        velocity = steps.mean(axis=0) if len(steps) else np.zeros(2)
        ahead = np.arange(1, count + 1)
        travelled = np.cumsum(_KEPT**ahead)
        spread = 0.25 * self._step_px * ahead
        return Bridge(past.position_px[-1] + travelled[:, None] * velocity, spread[:, None, None] ** 2 * np.eye(2))

    def interpolate(self, past: Piece, future: Piece, around: Surroundings) -> Bridge:
        """See ``GapMethod``."""
        count = future.first_frame - past.end_frame
        share = np.arange(1, count + 1) / (count + 1)
        line = past.position_px[-1] + share[:, None] * (future.position_px[0] - past.position_px[-1])
        nearer = 1 + np.minimum(np.arange(count), np.arange(count)[::-1])
        spread = 0.25 * self._step_px * nearer
        return Bridge(line, spread[:, None, None] ** 2 * np.eye(2))
