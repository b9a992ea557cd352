"""Truth and a tracker's estimates of an episode in a road town, as arrays over its frames."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.road_town.truth import RoadTruth
from trackers.types import CameraModel, Estimate


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
        state, side: (F,) str; side is "" before the first exit.
        on_road, turning: (F,) bool.
        longest_frames: of a frame-out that the preset draws; None where it draws none: in closed loop and in real
            sequences.
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
    on_road: NDArray[np.bool_]
    turning: NDArray[np.bool_]
    longest_frames: int | None = None

    @property
    def frame_count(self) -> int:
        """Number of frames F."""
        return len(self.state)

    @property
    def car_length_m(self) -> float:
        """Length of the target."""
        return float(self.object_size_m[self.target, 0])


@dataclass(frozen=True, eq=False)
class EstimateSeries:
    """A tracker's estimates on F frames.

    Attributes:
        position_px: (F, 2), NaN without an answer.
        position_m: (F, 2), the same on the ground, through the true camera; NaN also above the horizon.
        box_xyxy: (F, 4); one of the first frame's size about the position if the estimate has none.
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

    def inside(self, size_px: tuple[int, int]) -> NDArray[np.bool_]:
        """(F,) the position is inside the picture."""
        with np.errstate(invalid="ignore"):
            return np.all((self.position_px >= 0) & (self.position_px < np.array(size_px)), axis=1)

    def says_in_view(self, size_px: tuple[int, int]) -> NDArray[np.bool_]:
        """(F,) the probability of being in view is at least 0.5; without one, the position is inside the picture."""
        return self.confidence(size_px) >= 0.5

    def confidence(self, size_px: tuple[int, int]) -> NDArray[np.float64]:
        """(F,) probability in [0, 1] of being in view; without one, 1 if the position is inside the picture, else 0."""
        given = np.isfinite(self.in_view_probability)
        return np.where(given, self.in_view_probability, self.inside(size_px).astype(float))

    def confidence_inside(self, size_px: tuple[int, int]) -> NDArray[np.float64]:
        """(F,) the same, but 0 where the position is outside the picture: it predicts no box in it."""
        return np.where(self.inside(size_px), self.confidence(size_px), 0.0)


def truth_series(
    truths: Sequence[RoadTruth], target: int, rate_hz: float, camera: CameraModel, longest_frames: int | None
) -> TruthSeries:
    """Return the truth of an episode as arrays; the number of objects is constant."""
    first = truths[0]

    def stack(name: str) -> NDArray[Any]:
        return np.array([getattr(truth, name) for truth in truths])

    return TruthSeries(
        rate_hz=rate_hz,
        size_px=(camera.width_px, camera.height_px),
        target=target,
        ground_m=stack("T_world_object")[:, :, :2, 3],
        object_size_m=np.asarray(first.size_m),
        position_px=stack("position_px"),
        box_xyxy=stack("box_xyxy"),
        visible_fraction=stack("visible_fraction")[:, target],
        state=stack("state")[:, target],
        side=stack("side")[:, target],
        on_road=stack("on_road"),
        turning=stack("turning"),
        longest_frames=longest_frames,
    )


def estimated_box(estimate: Estimate, first_box_xyxy: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the estimate's box (4,), or one of the first frame's size about its position."""
    if estimate.box_xyxy is not None:
        return np.asarray(estimate.box_xyxy, dtype=float)
    half = 0.5 * (first_box_xyxy[2:] - first_box_xyxy[:2])
    return np.concatenate([estimate.position_px - half, estimate.position_px + half])
