"""Poses of what stands on level ground."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def pose_on_ground(x_m: float, y_m: float, yaw_rad: float) -> NDArray[np.float64]:
    """Return the pose (4, 4) of a thing that stands on the ground."""
    c, s = np.cos(yaw_rad), np.sin(yaw_rad)
    return np.array([[c, -s, 0, x_m], [s, c, 0, y_m], [0, 0, 1, 0], [0, 0, 0, 1.0]])
