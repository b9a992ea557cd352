"""Inputs and outputs of methods that bridge the gaps in a target's track. Pixels as in ``trackers.types``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray


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
