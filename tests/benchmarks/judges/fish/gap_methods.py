"""Gap methods for tests."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackers.gaps import Bridge, GapMethod, Piece, Surroundings


@dataclass
class Knows:
    """Knows the place (T, N, 2) of each target, found by its past, and misses it by ``off_px`` to the right."""

    position_px: NDArray[np.float64]
    off_px: float = 0.0
    deviation_px: float | None = 1.0
    both_ends: bool = True
    lessons: list[int] = field(default_factory=list)
    mates: list[int] = field(default_factory=list)

    def learn(self, pieces: Sequence[Piece]) -> None:
        self.lessons.append(max(piece.end_frame for piece in pieces))

    def extrapolate(self, past: Piece, count: int, around: Surroundings) -> Bridge | None:
        self.mates.append(len(around.mates))
        last = self.position_px[past.end_frame - 1]
        away_px = np.linalg.norm(last - past.position_px[-1], axis=1)
        target = int(np.nanargmin(away_px))
        places = np.nan_to_num(self.position_px[past.end_frame : past.end_frame + count, target])
        covariance = (
            None if self.deviation_px is None else np.tile(self.deviation_px**2 * np.eye(2), (len(places), 1, 1))
        )
        return Bridge(places + np.array([self.off_px, 0.0]), covariance)

    def interpolate(self, past: Piece, future: Piece, around: Surroundings) -> Bridge | None:
        count = future.first_frame - past.end_frame
        return self.extrapolate(past, count, around) if self.both_ends else None


class GivesUp(Knows):
    """Knows too, but returns None when asked for the k-th time, k in ``silent_at``."""

    def __init__(self, position_px: NDArray[np.float64], silent_at: Collection[int], **how: Any) -> None:
        super().__init__(position_px, **how)
        self._silent_at, self._asked = silent_at, 0

    def extrapolate(self, past: Piece, count: int, around: Surroundings) -> Bridge | None:
        self._asked += 1
        return None if self._asked - 1 in self._silent_at else super().extrapolate(past, count, around)


class Fails:
    """Raises at its first gap."""

    def learn(self, pieces: Sequence[Piece]) -> None:
        """Learn nothing."""

    def extrapolate(self, past: Piece, count: int, around: Surroundings) -> Bridge | None:
        raise RuntimeError("it fails")

    def interpolate(self, past: Piece, future: Piece, around: Surroundings) -> Bridge | None:
        raise RuntimeError("it fails")


def swimming(frames: int = 700, count: int = 3, seed: int = 0) -> NDArray[np.float64]:
    """Return places (T, N, 2) on smooth paths, each in its own corner of 400 x 300 pixels."""
    rng = np.random.default_rng(seed)
    t = np.arange(frames)[:, None]
    rate, turn = rng.uniform(0.02, 0.05, count), rng.uniform(0, 6, count)
    middle = np.array([[100 + 200 * (k % 2), 80 + 70 * (k // 2)] for k in range(count)], float)
    swing = np.stack([40 * np.sin(rate * t + turn), 25 * np.cos(0.7 * rate * t + turn)], axis=2)
    return np.asarray(middle + swing)


_: GapMethod = Fails()
