"""Methods that bridge gaps in a target's track: their inputs and outputs, the check of these, and ends of tracks.

Pixels are those of ``trackers.types``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from trackers.types import CameraModel, Observation, Track


@dataclass(frozen=True, slots=True)
class Piece:
    """A piece of one target's track: T frames without a pause, of which some may lack a measurement.

    Attributes:
        first_frame: index of its first frame.
        position_px: (T, 2) measured centre; NaN where it was not measured.
        interval_s: time between frames, > 0.
        heading_rad: (T,) direction of the head in the picture, from +x towards +y; NaN where unknown. None without.
        centre_line_px: (T, K, 2) points from head to tail at equal distances; NaN where unknown. None without.
    """

    first_frame: int
    position_px: NDArray[np.float64]
    interval_s: float
    heading_rad: NDArray[np.float64] | None = None
    centre_line_px: NDArray[np.float64] | None = None

    @property
    def end_frame(self) -> int:
        """Index of the frame after its last one."""
        return self.first_frame + len(self.position_px)


@dataclass(frozen=True, slots=True)
class Surroundings:
    """What else is known when a gap is bridged.

    Attributes:
        bounds_xyxy: (4,) the region that targets can reach, e.g. of all positions so far; None if it is unknown.
        mates: tracks of other targets during the past and the gap, where they were measured.
    """

    bounds_xyxy: NDArray[np.float64] | None = None
    mates: Sequence[Piece] = ()


@dataclass(frozen=True, slots=True)
class Bridge:
    """Predicted positions on the G lost frames of a gap.

    Attributes:
        position_px: (G, 2).
        covariance_px: (G, 2, 2) of a Gaussian about the position; None without.
    """

    position_px: NDArray[np.float64]
    covariance_px: NDArray[np.float64] | None = None


class GapMethod(Protocol):
    """Predicts where a target was, or will be, while it is not measured."""

    def learn(self, pieces: Sequence[Piece]) -> None:
        """Learn from tracks of the same kind of target under the same camera, from before the gap."""
        ...

    def extrapolate(self, past: Piece, count: int, around: Surroundings) -> Bridge | None:
        """Return the ``count`` frames after ``past``; None if the method needs both ends."""
        ...

    def interpolate(self, past: Piece, future: Piece, around: Surroundings) -> Bridge | None:
        """Return the frames between ``past`` and ``future``; None if the method only extrapolates."""
        ...


def check_bridge(bridge: Bridge, count: int) -> Bridge:
    """Return a bridge over ``count`` frames with arrays of its own.

    Positions and covariances must be finite: a method without an answer returns None.

    Raises:
        ValueError: if it breaks its contract; names the field, what was expected and what came.
    """
    if not isinstance(bridge, Bridge):
        raise ValueError(f"bridge: expected a Bridge or None, got {type(bridge).__name__}")
    position = _array("position_px", bridge.position_px, (count, 2))
    if bridge.covariance_px is None:
        return Bridge(position)
    covariance = _array("covariance_px", bridge.covariance_px, (count, 2, 2))
    scale = 1e-6 * np.maximum(np.abs(covariance).max(axis=(1, 2), initial=0.0), 1e-12)
    skew = np.abs(covariance[:, 0, 1] - covariance[:, 1, 0])
    if (skew > scale).any() or (np.linalg.eigvalsh(covariance)[:, 0] < -scale).any():
        raise ValueError("covariance_px: expected symmetric matrices without negative eigenvalues, got others")
    return Bridge(position, covariance)


def _array(name: str, value: object, shape: tuple[int, ...]) -> NDArray[np.float64]:
    array = np.array(value)
    if array.shape != shape or array.dtype.kind != "f":
        raise ValueError(f"{name}: expected floating-point numbers of shape {shape}, got {array.dtype} {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError(f"{name}: expected finite numbers, got {int((~np.isfinite(array)).sum())} that are not")
    return array


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
