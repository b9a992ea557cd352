"""Truth and a tracker's estimates of an episode with one target, as arrays over its frames."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class TruthSeries:
    """Truth of F frames with N objects, without its pictures.

    Attributes:
        rate_hz: frames a second.
        size_px: (width, height) of the picture.
        target: index of the target among the objects.
        ground_m: (F, N, 2) world positions.
        object_size_m: (N, 3) length, width, height.
        position_px: (F, N, 2), box_xyxy: (F, N, 4); amodal, also outside the picture.
        visible_fraction: (F,) of the target.
        state, side: (F,) str; side is "" before the first exit. ``state`` of a real sequence, see ``SequenceTruth``.
        on_road, turning: (F,) bool; None where there are no roads.
        outside: (F,) bool, of a real sequence, see ``SequenceTruth``; None of others.
        longest_frames: of a frame-out that the preset draws; None where it draws none, e.g. in closed loop.
    """

    rate_hz: float
    size_px: tuple[int, int]
    target: int
    ground_m: NDArray[np.float64]
    object_size_m: NDArray[np.float64]
    position_px: NDArray[np.float64]
    box_xyxy: NDArray[np.float64]
    visible_fraction: NDArray[np.float64]
    state: NDArray[np.str_]
    side: NDArray[np.str_]
    on_road: NDArray[np.bool_] | None = None
    turning: NDArray[np.bool_] | None = None
    outside: NDArray[np.bool_] | None = None
    longest_frames: int | None = None


@dataclass(frozen=True, eq=False)
class EstimateSeries:
    """A tracker's estimates on F frames.

    Attributes:
        position_px: (F, 2), NaN without an answer.
        position_m: (F, 2), the same on the ground, through the true camera; NaN also above the horizon.
        box_xyxy: (F, 4); one of the first frame's size about the position if the estimate has none, for scores of
            overlap. has_box: (F,) bool, it is the estimate's own.
        in_view_probability: (F,), NaN if the estimate has none.
        has_posterior: (F,) bool.
        credible_level: (F,) level of the posterior's smallest region that holds the truth; NaN without a posterior,
            and on frames that are not judged.
        nees: (F,) normalised estimation error squared; NaN likewise.
    """

    position_px: NDArray[np.float64]
    position_m: NDArray[np.float64]
    box_xyxy: NDArray[np.float64]
    in_view_probability: NDArray[np.float64]
    has_posterior: NDArray[np.bool_]
    credible_level: NDArray[np.float64]
    nees: NDArray[np.float64]
    has_box: NDArray[np.bool_]

    def inside(self, size_px: tuple[int, int]) -> NDArray[np.bool_]:
        """(F,) the position is inside the picture."""
        return np.all((self.position_px >= 0) & (self.position_px < np.array(size_px)), axis=1)

    def confidence(self, size_px: tuple[int, int]) -> NDArray[np.float64]:
        """(F,) probability in [0, 1] of being in view; without one, 1 if the position is inside the picture, else 0."""
        given = np.isfinite(self.in_view_probability)
        return np.where(given, self.in_view_probability, self.inside(size_px).astype(float))
