"""Geometry of the swings of a view: smooth motion from rest to rest, and where a pitched camera looks."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from trackers.types import CameraModel

PEAK_SPEED = 1.875
"""Largest speed of a smooth step, in steps per duration."""


def smooth_step(t: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return 0 before t = 0, 1 after t = 1 and between them ``10 t^3 - 15 t^4 + 6 t^5``, as an array like ``t``.

    Speed and acceleration are zero at both ends.
    """
    t = np.clip(t, 0.0, 1.0)
    return t * t * t * (10 - 15 * t + 6 * t * t)


SHORT_OF_NADIR_RAD = 0.01
"""A gust stops this far before the view points straight down: beyond it, the nose would point backwards."""
_LARGEST_YAW_RAD = 0.5 * np.pi
_YAWS_RAD = np.linspace(0.0, _LARGEST_YAW_RAD, 181)


def pitched_forward(T_world_camera: NDArray[np.float64], mount_rad: float) -> NDArray[np.float64]:
    """Return the pose of a camera turned by ``mount_rad`` about its x axis, so that it looks further ahead."""
    if mount_rad == 0.0:
        return T_world_camera
    c, s = math.cos(mount_rad), math.sin(mount_rad)
    pitched = T_world_camera.copy()
    pitched[:3, :3] @= np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
    return pitched


def gust_out(
    camera: CameraModel, altitude_m: float, mount_rad: float, direction_rad: float, margin_m: float
) -> tuple[float, float]:
    """Return the aim's displacement (ahead, left) that puts a centred car ``margin_m`` outside the border.

    The nose turns aside by at most a right angle, or goes down until the view points almost straight down; the car
    is then outside by less. ``direction_rad`` is that of the displacement, 0 = ahead, counter-clockwise; one
    ahead is taken backwards, for with the nose up the horizon would be seen.
    """
    back, aside = abs(math.cos(direction_rad)), math.sin(direction_rad)
    slant_m = altitude_m / math.cos(mount_rad)
    half_high_rad = math.atan(0.5 * camera.height_px / camera.focal_px)
    to_left_rad = _yaw_to_border(camera, mount_rad) + margin_m / (altitude_m * math.tan(mount_rad))
    whole_yaw_rad = min(to_left_rad, _LARGEST_YAW_RAD)
    whole_pitch_rad = min(half_high_rad + margin_m / slant_m, mount_rad - SHORT_OF_NADIR_RAD)
    scale = min(whole_pitch_rad / max(back, 1e-6), whole_yaw_rad / max(abs(aside), 1e-6))
    aim_m = altitude_m * math.tan(mount_rad - scale * back)
    yaw_rad = scale * aside
    return aim_m * math.cos(yaw_rad) - altitude_m * math.tan(mount_rad), aim_m * math.sin(yaw_rad)


def drift_out(
    camera: CameraModel, altitude_m: float, mount_rad: float, direction_rad: float, margin_m: float
) -> tuple[float, float]:
    """Return the helicopter's displacement (ahead, left) that puts a centred car ``margin_m`` outside the border.

    ``direction_rad`` as in ``gust_out``; a displacement backwards is taken ahead, over the car, for the ground in the
    upper half of the picture reaches too far.
    """
    ahead, left = abs(math.cos(direction_rad)), math.sin(direction_rad)
    half_high_rad = math.atan(0.5 * camera.height_px / camera.focal_px)
    border_ahead_m = altitude_m * (math.tan(mount_rad) - math.tan(mount_rad - half_high_rad))
    border_left_m = 0.5 * camera.width_px / camera.focal_px * altitude_m / math.cos(mount_rad)
    distance_m = min(border_ahead_m / max(ahead, 1e-6), border_left_m / max(abs(left), 1e-6)) + margin_m
    return distance_m * ahead, distance_m * left


def gust_angles_rad(offset_m: tuple[float, float], altitude_m: float, mount_rad: float) -> tuple[float, float]:
    """Return (pitch, yaw) of the helicopter that displace the aim by ``offset_m`` (ahead, left)."""
    aim_m = altitude_m * math.tan(mount_rad)
    ahead_m, left_m = aim_m + offset_m[0], offset_m[1]
    return math.atan(math.hypot(ahead_m, left_m) / altitude_m) - mount_rad, math.atan2(left_m, ahead_m)


def _yaw_to_border(camera: CameraModel, mount_rad: float) -> float:
    """Return the yaw that moves the middle of the picture to its left or right border.

    A point on the axis is seen, after a yaw y, at the tangent ``sin(a) sin(y) / (sin(a)^2 cos(y) + cos(a)^2)``.
    """
    s, c = math.sin(mount_rad), math.cos(mount_rad)
    tangent = s * np.sin(_YAWS_RAD) / (s * s * np.cos(_YAWS_RAD) + c * c)
    return float(np.interp(0.5 * camera.width_px / camera.focal_px, tangent, _YAWS_RAD))
