"""What is so of the target in a picture that is not drawn, and what a picture and a tracker's answer say together."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

from scenarios.envs.pictureless.poses import in_camera, on_ground
from scenarios.in_view import SHORTEST_LENGTH_PX
from trackers.belief.sighting import ASSUMED_DISTANCE_M, FARTHEST_M

_NEAREST_M = 1e-6


@njit(cache=True)
def look(life: Any, size_m: Any, camera: Any, covered: float) -> None:
    """Write what is so: where the target's centre and the box around it lie in the picture.

    Args:
        size_m: (3,) length, width, height of the target. camera: focal length, half width, half height, pixels.
        covered: share of it that something stands before.
    """
    focal_px, half_right_px, half_down_px = camera[0], camera[1], camera[2]
    x_m, y_m = life.target_m[0], life.target_m[1]
    right, down, ahead = in_camera(life.R, life.camera_m, x_m, y_m, 0.5 * size_m[2])
    life.centring, life.length_px, life.visible, life.in_view = 0.0, 0.0, 0.0, 0.0
    life.target_px[0] = life.target_px[1] = np.nan
    if ahead > _NEAREST_M:
        life.target_px[0] = half_right_px + focal_px * right / ahead
        life.target_px[1] = half_down_px + focal_px * down / ahead
        share = max(abs(life.target_px[0] / half_right_px - 1.0), abs(life.target_px[1] / half_down_px - 1.0))
        life.centring = 1.0 - share if share < 1.0 else 0.0
        _box(life, size_m, camera, covered)
    if life.centring > 0.0 and life.length_px >= SHORTEST_LENGTH_PX:
        life.in_view = 1.0
    life.frames_out = 0 if life.in_view > 0.0 else life.frames_out + 1


@njit(cache=True)
def _box(life: Any, size_m: Any, camera: Any, covered: float) -> None:
    """Write the longer side of the box around the target, and which share of the box the picture shows."""
    focal_px, half_right_px, half_down_px = camera[0], camera[1], camera[2]
    c, s = np.cos(life.target_rad), np.sin(life.target_rad)
    left, top, right, bottom = np.inf, np.inf, -np.inf, -np.inf
    for corner in range(8):
        along = (0.5 if corner & 1 else -0.5) * size_m[0]
        across = (0.5 if corner & 2 else -0.5) * size_m[1]
        x_m, y_m = life.target_m[0] + c * along - s * across, life.target_m[1] + s * along + c * across
        x, y, z = in_camera(life.R, life.camera_m, x_m, y_m, size_m[2] if corner & 4 else 0.0)
        if z <= _NEAREST_M:
            return
        x_px, y_px = half_right_px + focal_px * x / z, half_down_px + focal_px * y / z
        left, right = min(left, x_px), max(right, x_px)
        top, bottom = min(top, y_px), max(bottom, y_px)
    life.length_px = max(right - left, bottom - top)
    wide = min(right, 2.0 * half_right_px) - max(left, 0.0)
    high = min(bottom, 2.0 * half_down_px) - max(top, 0.0)
    shown = max(wide, 0.0) * max(high, 0.0) / max((right - left) * (bottom - top), 1e-9)
    life.visible = shown * (1.0 - covered)


@njit(cache=True)
def tell_down(life: Any, camera: Any, said: Any) -> None:
    """Write the record ``SIGHTING`` of a camera that looks down; as ``trackers.belief.sighting``."""
    c, s = _tell_camera(life, camera, said, life.camera_measured_m[2], -life.R_measured[0, 1], -life.R_measured[1, 1])
    height_m = said.height_m
    east_m, north_m = on_ground(life.R_measured, height_m, 0.0, 0.0, FARTHEST_M)
    said.axis_ahead_m, said.axis_right_m = c * east_m + s * north_m, s * east_m - c * north_m
    if life.known > 0.0:
        right, down = (life.estimate_px[0] - camera[1]) / camera[0], (life.estimate_px[1] - camera[2]) / camera[0]
        east_m, north_m = on_ground(life.R_measured, height_m, right, down, FARTHEST_M)
        _tell_target(life, camera, said, east_m, north_m)
        said.spread_m, said.densest_share = life.spread_m, life.densest_share
        said.densest_x_m = said.x_m + life.densest_offset_m[0]
        said.densest_y_m = said.y_m + life.densest_offset_m[1]


@njit(cache=True)
def tell_ahead(life: Any, camera: Any, said: Any) -> None:
    """Write the record ``SIGHTING`` of a camera that looks ahead."""
    _tell_camera(life, camera, said, 1.0, life.R_measured[0, 2], life.R_measured[1, 2])
    said.axis_ahead_m, said.axis_right_m = ASSUMED_DISTANCE_M, 0.0
    if life.known > 0.0:
        right = life.depth_m * (life.estimate_px[0] - camera[1]) / camera[0]
        down = life.depth_m * (life.estimate_px[1] - camera[2]) / camera[0]
        R, ahead = life.R_measured, life.depth_m
        east_m = R[0, 0] * right + R[0, 1] * down + R[0, 2] * ahead
        north_m = R[1, 0] * right + R[1, 1] * down + R[1, 2] * ahead
        _tell_target(life, camera, said, east_m, north_m)
        said.spread_m, said.densest_share = 0.0, 1.0
        said.densest_x_m, said.densest_y_m = said.x_m, said.y_m


@njit(cache=True)
def _tell_camera(
    life: Any, camera: Any, said: Any, reach_m: float, forward_x: float, forward_y: float
) -> tuple[float, float]:
    """Write where the camera is; return cosine and sine of its heading."""
    said.carrier_x_m, said.carrier_y_m = life.camera_measured_m[0], life.camera_measured_m[1]
    said.height_m = life.camera_measured_m[2]
    said.heading_rad = np.arctan2(forward_y, forward_x)
    said.half_right_m, said.half_ahead_m = reach_m * camera[1] / camera[0], reach_m * camera[2] / camera[0]
    said.known = life.known
    said.x_m = said.y_m = said.spread_m = said.densest_x_m = said.densest_y_m = said.densest_share = 0.0
    said.in_view_probability = said.picture_x = said.picture_y = said.length_share = 0.0
    return np.cos(said.heading_rad), np.sin(said.heading_rad)


@njit(cache=True)
def _tell_target(life: Any, camera: Any, said: Any, east_m: float, north_m: float) -> None:
    said.x_m, said.y_m = said.carrier_x_m + east_m, said.carrier_y_m + north_m
    said.in_view_probability, said.length_share = life.probability, life.length_share
    said.picture_x = (life.estimate_px[0] - camera[1]) / camera[1]
    said.picture_y = (life.estimate_px[1] - camera[2]) / camera[2]
