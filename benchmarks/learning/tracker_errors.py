"""A tracker's errors in a run of the rendered env."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenarios.envs.pictureless.error_model import (
    CUT,
    LOST,
    PLAIN,
    PLAIN_SHARE,
    TRACKING,
    UNSEEN,
    UNSEEN_SHARE,
    WRONG,
)
from sim.checks import check
from trackers.belief.kernel import SEEN_PROBABILITY
from trackers.types import Carrier

_FARTHEST_M = 300.0
_LEAST_SPREAD_M = 0.05
_OFF_BORDER = 0.05


@dataclass(frozen=True, eq=False)
class TrackerErrors:
    """Modes and errors on N frames.

    Attributes:
        condition, condition_frames, mode, unsure_frames: see ``ErrorModel``.
        known, in_picture: whether there is an estimate, and whether it is in the picture.
        error_m: (N, 2) of the place, along and across the axis; NaN without an estimate.
        spread_m, share: (N, 1) of the posterior. densest_offset: (N, 2) over the spread.
        probability: (N,). length: (N, 1) of the box over the target's length at that place.
    """

    condition: NDArray[np.int64]
    condition_frames: NDArray[np.int64]
    mode: NDArray[np.int64]
    unsure_frames: NDArray[np.int64]
    known: NDArray[np.bool_]
    in_picture: NDArray[np.bool_]
    error_m: NDArray[np.float64]
    spread_m: NDArray[np.float64]
    share: NDArray[np.float64]
    densest_offset: NDArray[np.float64]
    probability: NDArray[np.float64]
    length: NDArray[np.float64]

    @staticmethod
    def joined(parts: Sequence[TrackerErrors]) -> TrackerErrors:
        """Return the frames of all parts, concatenated."""
        names = [field.name for field in dataclasses.fields(TrackerErrors)]
        return TrackerErrors(**{name: np.concatenate([getattr(part, name) for part in parts]) for name in names})


def errors_in(run: NDArray[np.void], carrier: Carrier, wrong_from_m: float) -> TrackerErrors:
    """Return the errors in a run (T,) of dtype ``RUN`` after its first frame (T - 1 frames).

    Args:
        wrong_from_m: see ``TrackerRuns``.
    """
    run = run[1:]
    sighting = run["sighting"]
    focal_px, half_px = _camera(run, carrier)
    place_m, depth_m = _places(run, carrier, focal_px, half_px)
    known = (sighting["known"] > 0) & np.isfinite(place_m).all(axis=1)
    error_m = place_m - run["place_m"]
    far = np.linalg.norm(error_m, axis=1)
    sure = known & (sighting["in_view_probability"] >= SEEN_PROBABILITY)
    mode = np.where(sure, np.where(far < wrong_from_m, TRACKING, WRONG), LOST)
    visible = run["visible_fraction"] * ~run["out"]
    condition = np.where(visible >= PLAIN_SHARE, PLAIN, np.where(visible < UNSEEN_SHARE, UNSEEN, CUT))
    unsure = _since(mode != TRACKING)
    axis_rad = _axes(run, carrier, mode)
    longest_m = np.maximum(run["size_m"][:, 0], run["size_m"][:, 2])
    unit_share = 0.5 * focal_px * longest_m / np.maximum(depth_m, 1e-3) / half_px[0]
    offset_m = np.column_stack([sighting["densest_x_m"] - sighting["x_m"], sighting["densest_y_m"] - sighting["y_m"]])
    nothing = ~known[:, None]
    spread_m = sighting["spread_m"][:, None]
    # The measured frame differs from the true one by a shift and a fraction of a degree: directions are equal.
    densest = _turned(offset_m, axis_rad) / np.maximum(spread_m, _LEAST_SPREAD_M)
    if carrier.looks == "ahead":
        densest = np.zeros_like(densest)
    return TrackerErrors(
        condition=condition,
        condition_frames=_run_lengths(condition),
        mode=mode,
        unsure_frames=unsure,
        known=known,
        in_picture=known & (np.abs(np.column_stack([sighting["picture_x"], sighting["picture_y"]])) < 1.0).all(axis=1),
        error_m=np.where(nothing, np.nan, np.clip(_turned(error_m, axis_rad), -_FARTHEST_M, _FARTHEST_M)),
        spread_m=np.where(nothing, np.nan, spread_m),
        share=np.where(nothing, np.nan, sighting["densest_share"][:, None]),
        densest_offset=np.where(nothing, np.nan, densest),
        probability=np.where(known, sighting["in_view_probability"], np.nan),
        length=np.where(nothing, np.nan, (sighting["length_share"] / unit_share)[:, None]),
    )


def _camera(run: NDArray[np.void], carrier: Carrier) -> tuple[float, NDArray[np.float64]]:
    """Return focal length and half the picture's size (2,), pixels, from sightings."""
    sighting = run["sighting"]
    # From the picture's corner, in halves of its width and height; near the border the quotient is undefined.
    shares = 1.0 + np.column_stack([sighting["picture_x"], sighting["picture_y"]])
    known = np.flatnonzero((sighting["known"] > 0) & (np.abs(shares) > _OFF_BORDER).all(axis=1))
    check("run", len(known) > 0, "one with estimates of the tracker", "none")
    half_px = np.median(run["estimate_px"][known] / shares[known], axis=0)
    first = known[0]
    reach_m = sighting["height_m"][first] if carrier.looks == "down" else 1.0
    return float(half_px[0] * reach_m / sighting["half_right_m"][first]), half_px


def _places(
    run: NDArray[np.void], carrier: Carrier, focal_px: float, half_px: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the tracker's places in the true world (T, 2) and their depths (T,); NaN without one."""
    R, camera_m = run["T_world_camera"][:, :, :3], run["T_world_camera"][:, :, 3]
    tangents = (run["estimate_px"] - half_px) / focal_px
    rays = np.einsum("tij,tj->ti", R, np.column_stack([tangents, np.ones(len(run))]))
    if carrier.looks == "down":
        drop_m = camera_m[:, 2] - 0.5 * run["size_m"][:, 2]
        depth_m = drop_m / np.maximum(-rays[:, 2], drop_m / _FARTHEST_M)
    else:
        sighting = run["sighting"]
        c, s = np.cos(sighting["heading_rad"]), np.sin(sighting["heading_rad"])
        # The measured camera is level: distance ahead is depth.
        depth_m = c * (sighting["x_m"] - sighting["carrier_x_m"]) + s * (sighting["y_m"] - sighting["carrier_y_m"])
    return camera_m[:, :2] + depth_m[:, None] * rays[:, :2], depth_m


def _axes(run: NDArray[np.void], carrier: Carrier, mode: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the axis (T,) of each frame: that of the latest frame on which the target was tracked."""
    axis_rad = run["heading_rad"]
    if carrier.looks == "ahead":
        sight_m = run["place_m"] - run["T_world_camera"][:, :2, 3]
        axis_rad = np.arctan2(sight_m[:, 1], sight_m[:, 0])
    tracked = np.maximum.accumulate(np.where(mode == TRACKING, np.arange(len(run)), 0))
    return np.asarray(axis_rad[tracked])


def _turned(vectors_m: NDArray[np.float64], axis_rad: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return vectors (T, 2) along and across axes (T,)."""
    c, s = np.cos(axis_rad), np.sin(axis_rad)
    return np.column_stack([c * vectors_m[:, 0] + s * vectors_m[:, 1], c * vectors_m[:, 1] - s * vectors_m[:, 0]])


def _since(flags: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return the number of frames since a flag was set, 0 where it is not."""
    places = np.arange(1, len(flags) + 1)
    return places - np.maximum.accumulate(np.where(flags, 0, places))


def _run_lengths(values: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the number of frames since each value changed, 0 on the first."""
    places = np.arange(len(values))
    return places - np.maximum.accumulate(np.where(np.r_[True, values[1:] != values[:-1]], places, 0))
