"""A calibrated camera at rest over a site: points of the world in the picture, and pixels on horizontal planes.

World: the camera's navigation frame, metres, z up, ground at z = 0. Camera frame: x right, y down, z forward.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from trackers.types import CameraModel, Estimate

_CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
_ROTATION_TOLERANCE = 1e-6
_LEAST_DEPTH_M = 0.1
"""Nearer points are taken as behind the camera: their pixels would run to infinity."""


class SiteView:
    """Pinhole geometry of one camera in one pose.

    Attributes:
        camera: intrinsics.
        T_world_camera: (4, 4) pose.
        place_m: (3,) the camera's place.
    """

    def __init__(self, camera: CameraModel, T_world_camera: NDArray[np.float64]) -> None:
        """Raise ValueError for a matrix that is no pose: other than (4, 4), not finite, or without a rotation."""
        pose = np.array(T_world_camera, dtype=np.float64)
        if pose.shape != (4, 4) or not np.isfinite(pose).all():
            raise ValueError(f"T_world_camera: expected a (4, 4) matrix of finite numbers, got {pose.tolist()}")
        R = pose[:3, :3]
        if np.abs(R).max() > 2.0 or np.abs(R @ R.T - np.eye(3)).max() > _ROTATION_TOLERANCE or np.linalg.det(R) < 0:
            raise ValueError(
                f"T_world_camera: expected a rotation in its first three rows and columns, got {R.tolist()}"
            )
        pose.flags.writeable = False
        self.camera, self.T_world_camera, self.place_m = camera, pose, pose[:3, 3]
        self._middle_px = 0.5 * np.array([camera.width_px, camera.height_px])

    def project(self, points_m: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return pixels (N, 2) and depths (N,) along the optical axis of world points (N, 3).

        ``p = Rᵀ (X − C)``; ``u = f p_x / p_z + W / 2``, ``v = f p_y / p_z + H / 2``; depth ``p_z``. Both are NaN for
        points behind the camera or nearer than 0.1 m.
        """
        seen = (np.asarray(points_m, dtype=np.float64) - self.place_m) @ self.T_world_camera[:3, :3]
        depth_m = np.where(seen[:, 2] >= _LEAST_DEPTH_M, seen[:, 2], np.nan)
        return self.camera.focal_px * seen[:, :2] / depth_m[:, None] + self._middle_px, depth_m

    def rays(self, px: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the directions (N, 3) in the world, 1 long along the optical axis, seen at pixels (N, 2)."""
        offsets = (np.asarray(px, dtype=np.float64) - self._middle_px) / self.camera.focal_px
        return np.column_stack([offsets, np.ones(len(offsets))]) @ self.T_world_camera[:3, :3].T

    def on_plane(self, px: NDArray[np.float64], z_m: float) -> NDArray[np.float64]:
        """Return the points (N, 3) of the horizontal plane at ``z_m`` seen at pixels (N, 2); NaN where it is not."""
        rays = self.rays(px)
        towards = np.where(rays[:, 2] == 0.0, np.nan, rays[:, 2])
        depth_m = (z_m - self.place_m[2]) / towards
        return self.place_m + rays * np.where(depth_m >= _LEAST_DEPTH_M, depth_m, np.nan)[:, None]

    def place_of(self, estimate: Estimate) -> NDArray[np.float64]:
        """Return the place (3,) of an estimate in the world; NaN if it has no position or no depth."""
        if estimate.depth_m is None:
            return np.full(3, np.nan)
        ray: NDArray[np.float64] = self.rays(estimate.position_px[None])[0]
        return self.place_m + ray * estimate.depth_m

    def estimate_of(
        self, centre_m: NDArray[np.float64], size_m: NDArray[np.float64], heading_rad: float
    ) -> Estimate | None:
        """Return the estimate of an upright box: projected centre and region, depth of the centre.

        Args:
            centre_m: (3,) its centre in the world.
            size_m: (3,) length, width and height.
            heading_rad: direction of its length in the world's XY plane, from +x towards +y.

        Returns:
            None if a part of it lies behind the camera.
        """
        c, s = np.cos(heading_rad), np.sin(heading_rad)
        corners_m = (_CORNERS * size_m) @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) + centre_m
        px, depth_m = self.project(np.vstack([centre_m, corners_m]))
        if not np.isfinite(px).all():
            return None
        box_xyxy = np.concatenate([px[1:].min(axis=0), px[1:].max(axis=0)])
        return Estimate(px[0], box_xyxy, depth_m=float(depth_m[0]))
