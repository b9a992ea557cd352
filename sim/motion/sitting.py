"""Someone who sits on a bench, with hands on the thighs, in the parts of ``sim.motion.skeleton``."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.checks import check
from sim.motion.gait import part_poses
from sim.motion.skeleton import PART_NAMES, Skeleton

_HIP_OVER_SEAT = 0.055
"""Height of the hip joints over the seat, share of stature."""
_ELBOW_RAD = np.deg2rad(62.0)
_STEEPEST = 0.9
"""Greatest share of a thigh's length by which the knee is higher or lower than the hip."""
_LEGS = tuple(PART_NAMES.index(f"{side}_thigh") for side in ("left", "right"))
_FOREARMS = tuple(PART_NAMES.index(f"{side}_forearm") for side in ("left", "right"))


def seated_poses(bones: Skeleton, T_world_person: NDArray[np.float64], seat_m: float) -> NDArray[np.float64]:
    """Return T_world_part (P, 4, 4) of someone who sits, in the order of ``PART_NAMES``.

    Shins are upright and soles flat on the floor; thighs lead from the hips to the knees.

    Args:
        T_world_person: (4, 4) on the floor under the pelvis, x ahead, y left, z up.
        seat_m: height of the seat over the floor.

    Raises:
        ValueError: for a seat that these legs do not sit on.
    """
    poses = part_poses(bones, np.eye(4), 0.0, 0.0)
    hip_m = seat_m + _HIP_OVER_SEAT * bones.stature
    rise_m = bones.ankle + bones.shin - hip_m
    fits = abs(rise_m) <= _STEEPEST * bones.thigh and seat_m >= 0.0
    check("seat_m", fits, f"a height that a person of {bones.stature:.2f} m sits on", seat_m)
    poses[:, 2, 3] += hip_m - poses[list(_LEGS), 2, 3].mean()
    ahead_m = float(np.sqrt(bones.thigh**2 - rise_m**2))
    c, s = -rise_m / bones.thigh, -ahead_m / bones.thigh
    for first in _LEGS:
        thigh, shin, foot = poses[first : first + 3]
        knee_m = np.array([thigh[0, 3] + ahead_m, thigh[1, 3], bones.ankle + bones.shin])
        thigh[:3, :3] = _about_y(c, s)
        thigh[2, 3] = hip_m
        shin[:3, :3] = foot[:3, :3] = np.eye(3)
        shin[:3, 3] = knee_m
        foot[:3, 3] = knee_m - (0.0, 0.0, bones.shin)
    for arm in _FOREARMS:
        poses[arm, :3, :3] = poses[arm, :3, :3] @ _about_y(float(np.cos(_ELBOW_RAD)), -float(np.sin(_ELBOW_RAD)))
    return np.asarray(T_world_person, dtype=float) @ poses


def _about_y(c: float, s: float) -> NDArray[np.float64]:
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
