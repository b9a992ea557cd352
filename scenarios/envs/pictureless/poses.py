"""Poses and projections of one camera at a time, for kernels; the equations of ``sim.optics``."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from trackers.types import CameraModel


def camera_numbers(camera: CameraModel) -> NDArray[np.float64]:
    """Return focal length, half width, half height (3,), pixels."""
    return np.array([camera.focal_px, 0.5 * camera.width_px, 0.5 * camera.height_px])


@njit(cache=True)
def turn_down(R: NDArray[np.float64], yaw_rad: float, pitch_rad: float, roll_rad: float) -> None:
    """Write R_world_camera (3, 3) as in ``sim.optics.look_down_pose``."""
    cy, sy = np.cos(yaw_rad), np.sin(yaw_rad)
    cp, sp = np.cos(pitch_rad), np.sin(pitch_rad)
    cr, sr = np.cos(roll_rad), np.sin(roll_rad)
    # Yaw times the product of pitch, roll and mounting.
    R[0, 0], R[0, 1], R[0, 2] = cy * sp * sr + sy * cr, -cy * cp, cy * sp * cr - sy * sr
    R[1, 0], R[1, 1], R[1, 2] = sy * sp * sr - cy * cr, -sy * cp, sy * sp * cr + cy * sr
    R[2, 0], R[2, 1], R[2, 2] = -cp * sr, -sp, -cp * cr


@njit(cache=True)
def pitch_forward(R: NDArray[np.float64], mount_rad: float) -> None:
    """Turn R_world_camera (3, 3) about the camera's x axis, so that it looks further ahead, in place."""
    c, s = np.cos(mount_rad), np.sin(mount_rad)
    for i in range(3):
        down, axis = R[i, 1], R[i, 2]
        R[i, 1], R[i, 2] = c * down + s * axis, c * axis - s * down


@njit(cache=True)
def turned(R: NDArray[np.float64], vector: NDArray[np.float64], out: NDArray[np.float64]) -> None:
    """Write R times the rotation by ``vector`` (3,), small angles about the camera's axes (Rodrigues' formula)."""
    angle = np.sqrt(vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2)
    a = np.sin(angle) / angle if angle > 1e-12 else 1.0
    b = (1.0 - np.cos(angle)) / angle**2 if angle > 1e-12 else 0.5
    x, y, z = vector[0], vector[1], vector[2]
    for i in range(3):
        p, q, r = R[i, 0], R[i, 1], R[i, 2]
        out[i, 0] = p * (1 - b * (y * y + z * z)) + q * (a * z + b * x * y) + r * (b * x * z - a * y)
        out[i, 1] = p * (b * x * y - a * z) + q * (1 - b * (x * x + z * z)) + r * (a * x + b * y * z)
        out[i, 2] = p * (a * y + b * x * z) + q * (b * y * z - a * x) + r * (1 - b * (x * x + y * y))


@njit(cache=True)
def in_camera(
    R: NDArray[np.float64], t: NDArray[np.float64], x_m: float, y_m: float, z_m: float
) -> tuple[float, float, float]:
    """Return a world point in camera coordinates: right, down, ahead."""
    x, y, z = x_m - t[0], y_m - t[1], z_m - t[2]
    return (
        R[0, 0] * x + R[1, 0] * y + R[2, 0] * z,
        R[0, 1] * x + R[1, 1] * y + R[2, 1] * z,
        R[0, 2] * x + R[1, 2] * y + R[2, 2] * z,
    )


@njit(cache=True)
def on_ground(
    R: NDArray[np.float64], height_m: float, right: float, down: float, farthest_m: float
) -> tuple[float, float]:
    """Return where a ray meets the ground, relative to the point below the camera.

    ``right`` and ``down`` are the tangents of the ray's angles.
    """
    x = R[0, 0] * right + R[0, 1] * down + R[0, 2]
    y = R[1, 0] * right + R[1, 1] * down + R[1, 2]
    z = R[2, 0] * right + R[2, 1] * down + R[2, 2]
    steep = max(-z, height_m / farthest_m)
    return x * height_m / steep, y * height_m / steep


@njit(cache=True)
def ground_depth_m(R: NDArray[np.float64], height_m: float, right: float, down: float) -> float:
    """Return the distance along the camera's axis at which the same ray meets the ground; infinite if it does not."""
    z = R[2, 0] * right + R[2, 1] * down + R[2, 2]
    return height_m / -z if z < 0.0 else np.inf
