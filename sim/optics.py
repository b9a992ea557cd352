"""Camera geometry: intrinsics, projection, rays and where they meet a horizontal plane.

Frames: *world* is in metres, z up. *camera* follows OpenCV: x right, y down, z forward.
``T_world_camera`` (4, 4) takes camera coordinates to world coordinates.
Pixels: pixel (row i, column j) covers ``[j, j+1) x [i, i+1)``; its centre is at ``(j + 0.5, i + 0.5)``
and the picture's centre at ``(width / 2, height / 2)``. Pixel coordinates go on beyond the borders.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple, Protocol

import numpy as np
from numba import njit
from numpy.typing import NDArray


class CameraMotion(NamedTuple):
    """Motion of a camera from one picture to the next.

    Attributes:
        homography: (3, 3) from this picture's pixels to the next one's.
        interval_s: time between the two.
    """

    homography: NDArray[np.float64]
    interval_s: float


class Camera(Protocol):
    """Intrinsics of a camera with square pixels and its principal point in the middle; equal ones have equal hashes.

    Attributes:
        width_px, height_px: size of the picture.
        focal_px: focal length in pixels, > 0.
    """

    @property
    def width_px(self) -> int: ...

    @property
    def height_px(self) -> int: ...

    @property
    def focal_px(self) -> float: ...

    def __hash__(self) -> int: ...


class Intrinsics(NamedTuple):
    """The plain ``Camera`` of inner pictures: what water bends or mirrors is drawn on one."""

    width_px: int
    height_px: int
    focal_px: float


def principal_point(camera: Camera) -> NDArray[np.float64]:
    """Return the principal point (2,), pixels."""
    return np.array([0.5 * camera.width_px, 0.5 * camera.height_px])


def intrinsic_matrix(camera: Camera) -> NDArray[np.float64]:
    """Return K (3, 3) with ``pixel ~ K @ point_camera``."""
    cx, cy = 0.5 * camera.width_px, 0.5 * camera.height_px
    return np.array([[camera.focal_px, 0.0, cx], [0.0, camera.focal_px, cy], [0.0, 0.0, 1.0]])


_IDENTITY = np.eye(4)


@lru_cache(maxsize=16)
def ray_of_pixel(camera: Camera) -> NDArray[np.float64]:
    """Return the inverse of the intrinsic matrix (3, 3), not to be written to."""
    return np.linalg.inv(intrinsic_matrix(camera)).astype(float)


def invert_pose(T_a_b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return T_b_a of a rigid T_a_b (4, 4)."""
    T_b_a = _IDENTITY.copy()
    T_b_a[:3, :3] = T_a_b[:3, :3].T
    T_b_a[:3, 3] = -T_a_b[:3, :3].T @ T_a_b[:3, 3]
    return T_b_a


def project(
    camera: Camera, T_world_camera: NDArray[np.float64], points_world_m: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Project world points into the (unbounded) picture.

    Args:
        points_world_m: (..., 3).

    Returns:
        pixels (..., 2), NaN for points not in front of the camera, and depth_m (...), the z coordinate in the
        camera frame.
    """
    points_camera = (points_world_m - T_world_camera[:3, 3]) @ T_world_camera[:3, :3]
    pixels = np.empty((*points_camera.shape[:-1], 2))
    centre_x, centre_y = 0.5 * camera.width_px, 0.5 * camera.height_px
    _pixels_of(points_camera.reshape(-1, 3), camera.focal_px, centre_x, centre_y, pixels.reshape(-1, 2))
    return pixels, points_camera[..., 2]


@njit(cache=True)
def _pixels_of(
    points_camera: NDArray[np.float64],
    focal_px: float,
    centre_x: float,
    centre_y: float,
    pixels: NDArray[np.float64],
) -> None:
    """Write the pixels (N, 2) of points (N, 3) of the camera frame; NaN for those not in front of it."""
    for n in range(len(points_camera)):
        x, y, z = points_camera[n]
        scale = focal_px / z if z > 1e-6 else np.nan
        pixels[n, 0], pixels[n, 1] = x * scale + centre_x, y * scale + centre_y


def rays(camera: Camera, T_world_camera: NDArray[np.float64], pixels: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return world directions (..., 3) of the given pixels (..., 2), scaled to unit camera depth."""
    xy = (np.asarray(pixels, dtype=float) - principal_point(camera)) / camera.focal_px
    return np.concatenate([xy, np.ones_like(xy[..., :1])], axis=-1) @ T_world_camera[:3, :3].T


def intersect_plane(
    camera: Camera, T_world_camera: NDArray[np.float64], pixels: NDArray[np.float64], plane_height_m: float
) -> NDArray[np.float64]:
    """Return where the rays of ``pixels`` (..., 2) meet the plane z = ``plane_height_m``: (..., 2) world metres.

    NaN where a ray does not meet the plane in front of the camera (at or above the horizon).
    """
    directions = rays(camera, T_world_camera, pixels)
    drop = plane_height_m - T_world_camera[2, 3]
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = drop / directions[..., 2]
    depth = np.where(depth > 0, depth, np.nan)
    return T_world_camera[:2, 3] + directions[..., :2] * depth[..., None]


def may_show(
    camera: Camera, T_world_camera: NDArray[np.float64], centres_m: NDArray[np.float64], radius_m: float
) -> NDArray[np.bool_]:
    """Return whether any point of spheres around world places (N, 3) may be in the picture."""
    x, y, z = ((centres_m - T_world_camera[:3, 3]) @ T_world_camera[:3, :3]).T
    shown = z > -radius_m
    for aside, half_px in ((x, 0.5 * camera.width_px), (y, 0.5 * camera.height_px)):
        slope = half_px / camera.focal_px
        shown &= np.abs(aside) < slope * z + radius_m * math.hypot(1.0, slope)
    return np.asarray(shown)


def look_down_pose(
    position_m: NDArray[np.float64], yaw_rad: float, pitch_rad: float, roll_rad: float
) -> NDArray[np.float64]:
    """Return T_world_camera (4, 4) of a camera strapped under an aircraft, looking down.

    With pitch = roll = 0 the camera looks straight down; the top of the picture points along the heading
    ``yaw_rad`` (counter-clockwise from world x). Positive pitch (nose up) swings the view ahead, positive roll
    (right side down) swings it to the left.
    """
    cy, sy, cp, sp, cr, sr = (f(a) for a in (yaw_rad, pitch_rad, roll_rad) for f in (math.cos, math.sin))
    # Body frame: x ahead, y left, z up; R_yaw @ R_pitch. Positive pitch here turns x towards z (nose up).
    R_world_body = np.array([[cy * cp, -sy, -cy * sp], [sy * cp, cy, -sy * sp], [sp, 0.0, cp]])
    # R_roll, of a camera whose right, down and forward are the body's right, back and down.
    R_body_camera = np.array([[0.0, -1.0, 0.0], [-cr, 0.0, sr], [-sr, 0.0, -cr]])
    T = _IDENTITY.copy()
    T[:3, :3] = R_world_body @ R_body_camera
    T[:3, 3] = position_m
    return T
