"""Optical flow from a frame to the next one, from what is stored of both: depth, ids and poses."""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.data.sets.stored_episode import StoredEpisode
from scenarios.scenario import Frame
from scenarios.truth import meanings
from sim.checks import check
from sim.optics import intrinsic_matrix, invert_pose

READS = ("depth_m", "instance_map")
"""Channels that it needs."""
_BACKWARD = "flow_px"
_SAME_DEPTH = 0.01
"""Greatest difference of two depths of the same surface, of the nearer one."""
_PLACES = 3
"""Decimals of a pixel: a place that is the middle of one, but for rounding, has no other pixel about it."""


class ForwardFlow(NamedTuple):
    """Where the surface points of a picture go.

    Attributes:
        flow_px: (H, W, 2) float32, x right and y down: the place in the next picture of what a pixel shows, minus its
            place now, also where something hides it there or it is outside; NaN for sky, for what the next camera has
            behind it, for objects that are absent then, and for ``Truth.passing``.
        seen_next: (H, W) whether the next picture shows the point: one of the four pixels about its place shows the
            same body at a depth within 1 %.
    """

    flow_px: NDArray[np.float32]
    seen_next: NDArray[np.bool_]


def forward_flow(episode: StoredEpisode, index: int) -> ForwardFlow:
    """Return the flow from a frame to the next one.

    It is exact for rigid objects, as all are in scenes that have a backward flow, but people who walk by. A point X of
    an object with the poses T now and T' next, seen by cameras C and C', moves to ``X' = T' T^-1 X``; of what is no
    object, or stands about, X' is X.
    With depth d at pixel p, ``X = C (d K^-1 p)``, and its next place is ``K C'^-1 X'``.

    Raises:
        ValueError: for a scene without backward flow, or the last frame.
    """
    now, after = (episode.frame(k, READS) for k in (index, index + 1))
    check("data", _BACKWARD in meanings(now.truth), "a scene of rigid objects, with flow_px", "one without")
    places_m, unknown = _moved_places(now, after)
    camera_m = (places_m - after.truth.T_world_camera[:3, 3]) @ after.truth.T_world_camera[:3, :3]
    depth_m = np.where(unknown | (camera_m[..., 2] <= 0), np.nan, camera_m[..., 2])
    pixels = (camera_m / depth_m[..., None]) @ intrinsic_matrix(after.observation.camera).T
    height, width = depth_m.shape
    y, x = np.mgrid[:height, :width] + 0.5
    flow_px = pixels[..., :2] - np.stack([x, y], axis=2)
    flow_px[np.isnan(depth_m)] = np.nan
    return ForwardFlow(flow_px.astype(np.float32), _is_seen(pixels, depth_m, now, after))


def _moved_places(now: Frame, after: Frame) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Return where the points of all pixels are in the world on the next frame (H, W, 3), and for which that is not
    known, as they are absent then or pass by.
    """
    ids, depth_m = now.truth.instance_map, now.truth.depth_m.astype(float)
    height, width = ids.shape
    y, x = np.mgrid[:height, :width] + 0.5
    rays = np.stack([x, y, np.ones_like(x)], axis=2) @ np.linalg.inv(intrinsic_matrix(now.observation.camera)).T
    points_m = np.where(np.isfinite(depth_m), depth_m, np.nan)[..., None] * rays
    places_m = points_m @ now.truth.T_world_camera[:3, :3].T + now.truth.T_world_camera[:3, 3]
    passing = np.isin(now.truth.standing_kinds, now.truth.passing)
    unknown = np.isin(ids, now.truth.standing_id[passing]) | ~np.isfinite(depth_m)
    for k in np.flatnonzero(np.isin(now.truth.instance_id, ids)):
        own, then = ids == now.truth.instance_id[k], after.truth.index_of(now.truth.names[k])
        T = after.truth.T_world_object[then] @ invert_pose(now.truth.T_world_object[k])
        places_m[own] = places_m[own] @ T[:3, :3].T + T[:3, 3]
        unknown[own] |= after.truth.state[then] == "absent"
    return places_m, unknown


def _is_seen(pixels: NDArray[np.float64], depth_m: NDArray[np.float64], now: Frame, after: Frame) -> NDArray[np.bool_]:
    """Return ``ForwardFlow.seen_next`` of points with places (H, W, 3) and depths (H, W) in the next picture."""
    height, width = depth_m.shape
    places = pixels[..., :2]
    inside = np.isfinite(depth_m) & (places >= 0).all(axis=2) & (places < (width, height)).all(axis=2)
    (x, y), found_m = np.round(places[inside] - 0.5, _PLACES).T, depth_m[inside]
    ids = now.truth.instance_map[inside]
    seen = np.zeros(len(ids), np.bool_)
    for of_x, of_y in product((np.floor, np.ceil), repeat=2):
        column = np.clip(of_x(x).astype(int), 0, width - 1)
        row = np.clip(of_y(y).astype(int), 0, height - 1)
        is_same = after.truth.instance_map[row, column] == ids
        seen |= is_same & (np.abs(after.truth.depth_m[row, column] / found_m - 1.0) <= _SAME_DEPTH)
    inside[inside] = seen
    return inside
