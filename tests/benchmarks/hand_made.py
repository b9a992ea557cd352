"""Truth and estimates made by hand, a few frames long."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray

from benchmarks.judges.frame_out.metrics.series import EstimateSeries, TruthSeries
from sim.optics import intersect_plane, look_down_pose, project
from trackers.types import CameraModel

CAMERA = CameraModel(100, 80, 100.0)
CAR_M = np.array([4.0, 2.0, 1.5])
IN_VIEW_OR_NOT = st.lists(st.booleans(), min_size=2, max_size=80).map(lambda flags: np.array([True, *flags]))
POSE = look_down_pose(np.array([0.0, 0.0, 50.0]), 0.0, 0.0, 0.0)


def truth_of(
    states: Sequence[str],
    places_m: NDArray[np.float64] | None = None,
    *,
    on_road: Sequence[bool] | None = None,
    turning: Sequence[bool] | None = None,
    visible: Sequence[float] | None = None,
) -> TruthSeries:
    """Return a truth with these states; cars at ``places_m`` (F, N, 2), the target first, all heading along world x."""
    count = len(states)
    places = np.zeros((count, 1, 2)) if places_m is None else places_m
    centres = np.concatenate([places, np.full((*places.shape[:2], 1), 0.5 * CAR_M[2])], axis=-1)
    position_px, _ = project(CAMERA, POSE, centres)
    # Seen from straight above, a box about the car's middle is close enough for these tests.
    half = 0.5 * CAR_M[[1, 0]] * CAMERA.focal_px / (50.0 - 0.5 * CAR_M[2])
    return TruthSeries(
        rate_hz=15.0,
        size_px=(CAMERA.width_px, CAMERA.height_px),
        target=0,
        ground_m=places,
        object_size_m=np.tile(CAR_M, (places.shape[1], 1)),
        position_px=position_px,
        box_xyxy=np.concatenate([position_px - half, position_px + half], axis=-1),
        visible_fraction=np.array([0.0 if s == "out" else 1.0 for s in states] if visible is None else visible),
        state=np.array(states),
        side=np.array(["left" if s == "out" else "" for s in states]),
        on_road=np.ones(count, dtype=bool) if on_road is None else np.array(on_road),
        turning=np.zeros(count, dtype=bool) if turning is None else np.array(turning),
    )


def estimate_at(
    position_px: NDArray[np.float64],
    in_view: Sequence[float] | None = None,
    half_px: tuple[float, float] = (2.03, 4.06),
) -> EstimateSeries:
    """Return estimates at these pixels (F, 2) with boxes of the car's size."""
    count = len(position_px)
    half = np.array(half_px)
    return EstimateSeries(
        position_px=position_px,
        position_m=intersect_plane(CAMERA, POSE, position_px, 0.5 * CAR_M[2]),
        box_xyxy=np.concatenate([position_px - half, position_px + half], axis=1),
        in_view_probability=np.full(count, np.nan) if in_view is None else np.array(in_view, dtype=float),
        has_posterior=np.zeros(count, dtype=bool),
        credible_level=np.full(count, np.nan),
        nees=np.full(count, np.nan),
        has_box=np.ones(count, dtype=bool),
    )


def pixels_of(places_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return where places (F, 2) on the ground, at half a car's height, are in the picture (F, 2)."""
    return project(CAMERA, POSE, np.column_stack([places_m, np.full(len(places_m), 0.5 * CAR_M[2])]))[0]


def view(*stretches: tuple[bool, int]) -> NDArray[np.bool_]:
    """Return frames in view or not, by stretches."""
    return np.concatenate([np.full(length, seen) for seen, length in stretches])
