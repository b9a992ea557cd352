"""A tracker's answer on one frame, and the objects of that frame, as arrays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from scenarios.harbour.truth import HarbourTruth
from scenarios.visibility import MOSTLY_SEEN
from sim.optics import rays
from trackers.types import CameraModel, Track


class Answers(NamedTuple):
    """M tracks that say where they are.

    Attributes:
        identity: (M,). kind: (M,) class, "" for none.
        place_m: (M, 3) place in the world, from position and depth through the true camera; NaN without a depth.
        position_px: (M, 2). box_xyxy: (M, 4), of no extent for a track without one.
        size_m: (M, 3) length, width, height; NaN where they are not measured.
        confidence: (M,); 1 for a track that gives none.
    """

    identity: NDArray[np.int64]
    kind: NDArray[np.str_]
    place_m: NDArray[np.float64]
    position_px: NDArray[np.float64]
    box_xyxy: NDArray[np.float64]
    size_m: NDArray[np.float64]
    confidence: NDArray[np.float64]

    def only(self, kept: NDArray[np.bool_]) -> Answers:
        """Return the tracks that are ``kept`` (M,)."""
        return Answers._make(each[kept] for each in self)


class Objects(NamedTuple):
    """N intruders on one frame, or (T, N) on all frames.

    Attributes:
        place_m: (N, 3) centres. size_m: (N, 3). box_xyxy: (N, 4).
        present: (N,) whether it is in the world. watched: (N,) present, its centre inside the watched volume.
        seen: (N,) watched, and some of it is seen. judged: (N,) watched, in the picture and at least half of it seen.
        contrast_to_noise: (N,) 0 where nothing of it is seen.
        ahead: (N, 2) horizontal unit vector from the camera to it. distance_m: (N,) to it along that.
    """

    place_m: NDArray[np.float64]
    size_m: NDArray[np.float64]
    box_xyxy: NDArray[np.float64]
    present: NDArray[np.bool_]
    watched: NDArray[np.bool_]
    seen: NDArray[np.bool_]
    judged: NDArray[np.bool_]
    contrast_to_noise: NDArray[np.float64]
    ahead: NDArray[np.float64]
    distance_m: NDArray[np.float64]


def answers_of(tracks: Sequence[Track], camera: CameraModel, T_world_camera: NDArray[np.float64]) -> Answers:
    """Return the tracks whose position is not NaN, in their order."""
    answered = [track for track in tracks if np.isfinite(track.estimate.position_px).all()]
    estimates = [track.estimate for track in answered]
    position_px = np.array([each.position_px for each in estimates], float).reshape(-1, 2)
    depth_m = np.array([np.nan if each.depth_m is None else each.depth_m for each in estimates], float)
    boxes = [np.tile(each.position_px, 2) if each.box_xyxy is None else each.box_xyxy for each in estimates]
    sizes = [np.full(3, np.nan) if track.size_m is None else track.size_m for track in answered]
    return Answers(
        identity=np.array([track.identity for track in answered], int),
        kind=np.array([track.kind or "" for track in answered], str),
        place_m=T_world_camera[:3, 3] + rays(camera, T_world_camera, position_px) * depth_m[:, None],
        position_px=position_px,
        box_xyxy=np.array(boxes, float).reshape(-1, 4),
        size_m=np.array(sizes, float).reshape(-1, 3),
        confidence=np.array([1.0 if track.confidence is None else track.confidence for track in answered], float),
    )


def objects_of(truth: HarbourTruth) -> Objects:
    """Return the intruders of a frame's truth."""
    place_m = truth.T_world_object[:, :3, 3] + 0.5 * truth.size_m[:, 2:] * truth.T_world_object[:, :3, 2]
    sight_m = place_m[:, :2] - truth.T_world_camera[:2, 3]
    distance_m = np.linalg.norm(sight_m, axis=1)
    present = truth.state != "absent"
    watched = present & truth.watched
    mostly = np.isin(truth.state, ("in", "partial")) & (truth.visible_fraction >= MOSTLY_SEEN)
    return Objects(
        place_m=place_m,
        size_m=truth.size_m,
        box_xyxy=truth.box_xyxy,
        present=present,
        watched=watched,
        seen=watched & (truth.visible_fraction > 0) & (truth.state != "out"),
        judged=watched & mostly,
        contrast_to_noise=np.nan_to_num(truth.contrast_to_noise),
        ahead=sight_m / distance_m[:, None],
        distance_m=distance_m,
    )
