"""Poses on level ground, and rotations."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray


def pose_on_ground(x_m: float, y_m: float, yaw_rad: float) -> NDArray[np.float64]:
    """Return the pose (4, 4) of an object on the ground."""
    c, s = np.cos(yaw_rad), np.sin(yaw_rad)
    return np.array([[c, -s, 0, x_m], [s, c, 0, y_m], [0, 0, 1, 0], [0, 0, 0, 1.0]])


def rotation_by(turn_rad: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the rotation matrix (3, 3) of a rotation vector (3,).

    From the unit quaternion ``(sin(a / 2) v / a, cos(a / 2))``: bit-equal to SciPy's
    ``Rotation.from_rotvec(v).as_matrix()`` in a fifth of the time, as instruments rotate a pose for every picture.
    """
    x, y, z = turn_rad.tolist()
    angle = math.sqrt(x * x + y * y + z * z)
    if angle <= 1e-3:
        scale = 0.5 - angle * angle / 48 + angle * angle * angle * angle / 3840
    else:
        scale = math.sin(angle / 2) / angle
    x, y, z, w = scale * x, scale * y, scale * z, math.cos(angle / 2)
    xx, yy, zz, ww, xy, zw, xz, yw, yz, xw = x * x, y * y, z * z, w * w, x * y, z * w, x * z, y * w, y * z, x * w
    return np.array(
        [
            [xx - yy - zz + ww, 2 * (xy - zw), 2 * (xz + yw)],
            [2 * (xy + zw), -xx + yy - zz + ww, 2 * (yz - xw)],
            [2 * (xz - yw), 2 * (yz + xw), -xx - yy + zz + ww],
        ]
    )
