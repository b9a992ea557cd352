"""The target's truth in a picture that is not rendered, and the sighting from a tracker's answer."""

from __future__ import annotations

from typing import Any

import numpy as np

from scenarios.envs.pictureless.poses import ground_depth_m, in_camera, on_ground
from scenarios.visibility import shortest_length_px
from trackers.belief.sighting import ASSUMED_DISTANCE_M, FARTHEST_M
from trackers.kernels.records import record_kernel

_NEAREST_M = 1e-6


@record_kernel()
def place_target(state: Any, target_m: Any, target_rad: Any) -> None:
    """Set the target's place and heading from those of all episodes, (E, T, 2) on the ground or (E, T, 3), (E, T)."""
    episode, frame = state.episode, state.frame
    state.target_m[2] = 0.0
    for axis in range(target_m.shape[2]):
        state.target_m[axis] = target_m[episode, frame, axis]
    state.target_rad = target_rad[episode, frame]


@record_kernel()
def look(state: Any, size_m: Any, camera: Any, covered: float) -> None:
    """Write where the target's centre and its box lie in the picture.

    Args:
        size_m: (3,) length, width, height of the target. camera: focal length, half width, half height, pixels.
        covered: share of the target that is hidden.
    """
    focal_px, half_right_px, half_down_px = camera[0], camera[1], camera[2]
    x_m, y_m, z_m = state.target_m[0], state.target_m[1], state.target_m[2]
    right, down, ahead = in_camera(state.R, state.camera_m, x_m, y_m, z_m + 0.5 * size_m[2])
    state.centring, state.length_px, state.visible, state.in_view = 0.0, 0.0, 0.0, 0.0
    state.target_px[0] = state.target_px[1] = np.nan
    if ahead > _NEAREST_M:
        state.target_px[0] = half_right_px + focal_px * right / ahead
        state.target_px[1] = half_down_px + focal_px * down / ahead
        share = max(abs(state.target_px[0] / half_right_px - 1.0), abs(state.target_px[1] / half_down_px - 1.0))
        state.centring = 1.0 - share if share < 1.0 else 0.0
        _box(state, size_m, camera, covered)
    if state.centring > 0.0 and state.length_px >= shortest_length_px(2.0 * half_right_px):
        state.in_view = 1.0


@record_kernel()
def count_out(state: Any) -> None:
    """Count the frames for which the target has been out of view."""
    state.frames_out = 0 if state.in_view > 0.0 else state.frames_out + 1


@record_kernel()
def _box(state: Any, size_m: Any, camera: Any, covered: float) -> None:
    """Write the longer side of the target's box, and the target's visible share."""
    focal_px, half_right_px, half_down_px = camera[0], camera[1], camera[2]
    c, s = np.cos(state.target_rad), np.sin(state.target_rad)
    left, top, right, bottom = np.inf, np.inf, -np.inf, -np.inf
    for corner in range(8):
        along = (0.5 if corner & 1 else -0.5) * size_m[0]
        across = (0.5 if corner & 2 else -0.5) * size_m[1]
        x_m, y_m = state.target_m[0] + c * along - s * across, state.target_m[1] + s * along + c * across
        z_m = state.target_m[2] + (size_m[2] if corner & 4 else 0.0)
        x, y, z = in_camera(state.R, state.camera_m, x_m, y_m, z_m)
        if z <= _NEAREST_M:
            return
        x_px, y_px = half_right_px + focal_px * x / z, half_down_px + focal_px * y / z
        left, right = min(left, x_px), max(right, x_px)
        top, bottom = min(top, y_px), max(bottom, y_px)
    state.length_px = max(right - left, bottom - top)
    wide = min(right, 2.0 * half_right_px) - max(left, 0.0)
    high = min(bottom, 2.0 * half_down_px) - max(top, 0.0)
    shown = max(wide, 0.0) * max(high, 0.0) / max((right - left) * (bottom - top), 1e-9)
    state.visible = shown * (1.0 - covered)


@record_kernel()
def write_sighting_down(state: Any, camera: Any, sighting: Any) -> None:
    """Write the record ``SIGHTING`` for a camera that looks down, as in ``trackers.belief.sighting``."""
    c, s = _write_camera(
        state, camera, sighting, state.camera_measured_m[2], -state.R_measured[0, 1], -state.R_measured[1, 1]
    )
    height_m = sighting.height_m
    east_m, north_m = on_ground(state.R_measured, height_m, 0.0, 0.0, FARTHEST_M)
    sighting.axis_ahead_m, sighting.axis_right_m = c * east_m + s * north_m, s * east_m - c * north_m
    sighting.axis_depth_m = ground_depth_m(state.R_measured, height_m, 0.0, 0.0)
    if state.known > 0.0:
        right, down = (state.estimate_px[0] - camera[1]) / camera[0], (state.estimate_px[1] - camera[2]) / camera[0]
        east_m, north_m = on_ground(state.R_measured, height_m, right, down, FARTHEST_M)
        _write_target(state, camera, sighting, east_m, north_m)
        sighting.depth_m = ground_depth_m(state.R_measured, height_m, right, down)
        sighting.spread_m, sighting.densest_share = state.spread_m, state.densest_share
        sighting.densest_x_m = sighting.x_m + state.densest_offset_m[0]
        sighting.densest_y_m = sighting.y_m + state.densest_offset_m[1]


@record_kernel()
def write_sighting_ahead(state: Any, camera: Any, sighting: Any) -> None:
    """Write the record ``SIGHTING`` for a camera that looks ahead."""
    _write_camera(state, camera, sighting, 1.0, state.R_measured[0, 2], state.R_measured[1, 2])
    sighting.axis_ahead_m, sighting.axis_right_m, sighting.axis_depth_m = ASSUMED_DISTANCE_M, 0.0, ASSUMED_DISTANCE_M
    if state.known > 0.0:
        right = state.depth_m * (state.estimate_px[0] - camera[1]) / camera[0]
        down = state.depth_m * (state.estimate_px[1] - camera[2]) / camera[0]
        R, ahead = state.R_measured, state.depth_m
        east_m = R[0, 0] * right + R[0, 1] * down + R[0, 2] * ahead
        north_m = R[1, 0] * right + R[1, 1] * down + R[1, 2] * ahead
        _write_target(state, camera, sighting, east_m, north_m)
        sighting.depth_m, sighting.spread_m, sighting.densest_share = state.depth_m, 0.0, 1.0
        sighting.densest_x_m, sighting.densest_y_m = sighting.x_m, sighting.y_m


@record_kernel()
def _write_camera(
    state: Any, camera: Any, sighting: Any, reach_m: float, forward_x: float, forward_y: float
) -> tuple[float, float]:
    """Write the camera's part of a sighting; return cosine and sine of its heading."""
    sighting.carrier_x_m, sighting.carrier_y_m = state.camera_measured_m[0], state.camera_measured_m[1]
    sighting.height_m = state.camera_measured_m[2]
    sighting.heading_rad = np.arctan2(forward_y, forward_x)
    sighting.half_right_m, sighting.half_ahead_m = reach_m * camera[1] / camera[0], reach_m * camera[2] / camera[0]
    sighting.known = state.known
    sighting.x_m = sighting.y_m = sighting.spread_m = sighting.densest_x_m = sighting.densest_y_m = (
        sighting.densest_share
    ) = 0.0
    sighting.in_view_probability = sighting.picture_x = sighting.picture_y = sighting.length_share = 0.0
    sighting.depth_m = 0.0
    return np.cos(sighting.heading_rad), np.sin(sighting.heading_rad)


@record_kernel()
def _write_target(state: Any, camera: Any, sighting: Any, east_m: float, north_m: float) -> None:
    sighting.x_m, sighting.y_m = sighting.carrier_x_m + east_m, sighting.carrier_y_m + north_m
    sighting.in_view_probability, sighting.length_share = state.probability, state.length_share
    sighting.picture_x = (state.estimate_px[0] - camera[1]) / camera[1]
    sighting.picture_y = (state.estimate_px[1] - camera[2]) / camera[2]
