"""The robot's frame: x ahead, y to the left, z up, metres; its origin lies on the ground under the camera."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from trackers.types import CameraModel

_LEVEL = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
"""Columns: the camera's axes (right, down, forward) in the robot's frame."""


@dataclass(frozen=True)
class Mounting:
    """Pose of the camera on the robot.

    Attributes:
        height_m: height of the camera above the ground.
        R_robot_camera: (3, 3), camera frame (x right, y down, z forward) to the robot's.
    """

    height_m: float
    R_robot_camera: NDArray[np.float64]

    @classmethod
    def level(cls, height_m: float) -> Mounting:
        """Return the mounting of a camera that looks straight ahead."""
        return cls(height_m, _LEVEL)

    @classmethod
    def from_pose(cls, T_world_camera: NDArray[np.float64]) -> Mounting:
        """Return the mounting of a camera with a pose (4, 4) above the ground z = 0: its tilt and height."""
        ahead = T_world_camera[:2, 2]
        cosine, sine = ahead / max(float(np.hypot(*ahead)), 1e-9)
        R_robot_world = np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])
        return cls(float(T_world_camera[2, 3]), R_robot_world @ T_world_camera[:3, :3])

    def pixels(self, points_m: NDArray[np.float64], camera: CameraModel) -> NDArray[np.float64]:
        """Return the pixels (..., 2) in the left picture, inside it or not, of points (..., 3) in the robot's frame.

        The depth of a point is at least 5 cm, also behind the camera.
        """
        in_camera_m = (points_m - np.array([0.0, 0.0, self.height_m])) @ self.R_robot_camera
        ahead_m = np.maximum(in_camera_m[..., 2:], 0.05)
        middle_px = 0.5 * np.array([camera.width_px, camera.height_px])
        return middle_px + camera.focal_px * in_camera_m[..., :2] / ahead_m

    def place_at(self, pixel_px: NDArray[np.float64], depth_m: float, camera: CameraModel) -> NDArray[np.float64]:
        """Return the point (3,) in the robot's frame at a pixel (2,) and a distance along the camera's axis."""
        middle_px = 0.5 * np.array([camera.width_px, camera.height_px])
        in_camera_m = depth_m * np.append((pixel_px - middle_px) / camera.focal_px, 1.0)
        return self.R_robot_camera @ in_camera_m + np.array([0.0, 0.0, self.height_m])

    def depth_m(self, point_m: NDArray[np.float64]) -> float:
        """Return the distance of a point (3,) along the camera's axis."""
        return float((point_m - np.array([0.0, 0.0, self.height_m])) @ self.R_robot_camera[:, 2])

    def standing_box(
        self, place_m: NDArray[np.float64], width_m: float, height_m: float, camera: CameraModel
    ) -> tuple[NDArray[np.float64], float]:
        """Return the box (4,) in the left picture, inside it or not, of a person who stands at a place (2,), and the
        distance of the person's middle along the camera's axis.

        The box is centred on the top of the head; it is as wide as at a distance of 5 cm or more.
        """
        depth_m = self.depth_m(np.append(place_m, 0.5 * height_m))
        ends_m = np.column_stack([np.tile(place_m, (2, 1)), [0.0, height_m]])
        (_, bottom), (x, top) = self.pixels(ends_m, camera)
        half_px = 0.5 * width_m * camera.focal_px / max(depth_m, 0.05)
        return np.array([x - half_px, top, x + half_px, bottom]), depth_m


def points_m(depth_m: NDArray[np.float32], camera: CameraModel, mounting: Mounting) -> NDArray[np.float32]:
    """Return the point cloud (H', W', 3) of a depth picture (H', W') in the robot's frame; NaN where unknown.

    The depth picture may be smaller than the camera's.
    """
    shrink = camera.width_px / depth_m.shape[1]
    return _points(depth_m, camera.focal_px / shrink, np.ascontiguousarray(mounting.R_robot_camera), mounting.height_m)


@njit(cache=True)
def _points(depth_m, focal_px, rotation, height_m):  # type: ignore[no-untyped-def]
    rows, columns = depth_m.shape
    points = np.empty((rows, columns, 3), np.float32)
    for i in range(rows):
        down = (i + 0.5 - 0.5 * rows) / focal_px
        for j in range(columns):
            right = (j + 0.5 - 0.5 * columns) / focal_px
            z = depth_m[i, j]
            for axis in range(3):
                points[i, j, axis] = z * (rotation[axis, 0] * right + rotation[axis, 1] * down + rotation[axis, 2])
            points[i, j, 2] += height_m
    return points
