"""What the end of a track shows, and trackers that see no picture but bridge gaps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from trackers.gaps.types import Piece
from trackers.types import CameraModel, Observation, Track


class Pictureless:
    """A ``MultiTracker`` without tracks: it only offers its gap method."""

    def start(self, background: Sequence[Observation], camera: CameraModel) -> None:
        """See ``MultiTracker``."""

    def update(self, observation: Observation) -> list[Track]:
        """See ``MultiTracker``."""
        return []


def measured_frames(piece: Piece) -> NDArray[np.int64]:
    """Return the frames of a piece that were measured, counted from its first.

    Raises:
        ValueError: if there is none.
    """
    frames = np.flatnonzero(np.isfinite(piece.position_px).all(axis=1))
    if len(frames) == 0:
        raise ValueError("position_px: expected at least one measured position, got none")
    return frames


def last_state(piece: Piece, over_frames: int) -> tuple[NDArray[np.float64], NDArray[np.float64], int]:
    """Return the last measured position (2,), the velocity there (2,) in px a frame, and the frames since.

    The velocity is the mean over the last ``over_frames``, or over what was measured of them; zero from one position.
    """
    frames = measured_frames(piece)
    last = frames[-1]
    before = frames[frames >= last - over_frames][0]
    x = piece.position_px
    velocity = (x[last] - x[before]) / max(last - before, 1)
    return x[last], velocity, len(x) - 1 - int(last)


def reversed_in_time(piece: Piece) -> Piece:
    """Return a piece's positions in reversed order."""
    return Piece(0, piece.position_px[::-1], piece.interval_s)
