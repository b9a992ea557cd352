"""View matrices from the world to pixels and nearness, as defined in ``sim.render.triangles``."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.optics import Camera, invert_pose, principal_point


def camera_view(camera: Camera, T_world_camera: NDArray[np.float64], pixel_offset: float) -> NDArray[np.float64]:
    """Return the (4, 4) view matrix of a camera that samples pixel (i, j) at ``(j, i) + pixel_offset``.

    ``q_x = f x + (c_x - offset) z``, ``q_y = f y + (c_y - offset) z``, ``q_w = z``, ``g = 1`` for a point
    (x, y, z) of the camera frame.
    """
    centre_x, centre_y = principal_point(camera) - pixel_offset
    matrix = np.array(
        [
            [camera.focal_px, 0.0, centre_x, 0.0],
            [0.0, camera.focal_px, centre_y, 0.0],
            [0.0, 0.0, 1.0, 0.0],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )
    return matrix @ invert_pose(np.asarray(T_world_camera, dtype=float))
