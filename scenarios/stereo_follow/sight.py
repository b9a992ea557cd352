"""Sight on the floor plan, without pictures: walls, people in the line of sight, and the borders of the picture."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scenarios.stereo_follow.camera import HALF_VIEW_RAD

_HALF_WIDTH_M = 0.25
"""Half width of people as occluders and as targets."""
_COVERED = 0.8
"""A person who is covered to this share is hidden."""


@njit(cache=True)
def is_walled(from_x_m: float, from_y_m: float, to_x_m: float, to_y_m: float, openings_m: NDArray[np.float64]) -> bool:
    """Return whether a wall blocks the line between two places; its only gaps are (W, 4), x0, y0, x1, y1."""
    for k in range(len(openings_m)):
        for side in (0, 2):
            wall_x_m = openings_m[k, side]
            if (wall_x_m - from_x_m) * (wall_x_m - to_x_m) < 0.0:
                y_m = from_y_m + (to_y_m - from_y_m) * (wall_x_m - from_x_m) / (to_x_m - from_x_m)
                if not openings_m[k, 1] < y_m < openings_m[k, 3]:
                    return True
    return False


@njit(cache=True)
def covered_share(
    from_m: NDArray[np.float64],
    target_m: NDArray[np.float64],
    others_m: NDArray[np.float64],
    openings_m: NDArray[np.float64],
) -> float:
    """Return the share of a person at ``target_m`` that is hidden from ``from_m``.

    He is hidden by walls, see ``is_walled``, or by the person of ``others_m`` (N, 2) who hides most of him. Of places
    only x and y count.
    """
    from_x_m, from_y_m = from_m[0], from_m[1]
    if is_walled(from_x_m, from_y_m, target_m[0], target_m[1], openings_m):
        return 1.0
    to_x_m, to_y_m = target_m[0] - from_x_m, target_m[1] - from_y_m
    most, distance_m = 0.0, max(np.hypot(to_x_m, to_y_m), 1e-6)
    for n in range(len(others_m)):
        x_m, y_m = others_m[n, 0] - from_x_m, others_m[n, 1] - from_y_m
        share = (x_m * to_x_m + y_m * to_y_m) / distance_m**2
        if 0.02 < share < 1.0:
            # The person's shadow on the plane of the target.
            aside_m = (x_m * to_y_m - y_m * to_x_m) / distance_m / share
            shadow_m = _HALF_WIDTH_M / share
            both_m = min(_HALF_WIDTH_M, aside_m + shadow_m) - max(-_HALF_WIDTH_M, aside_m - shadow_m)
            most = max(most, both_m / (2.0 * _HALF_WIDTH_M))
    return most


@njit(cache=True)
def is_in_sight(
    from_m: NDArray[np.float64],
    heading_rad: float,
    target_m: NDArray[np.float64],
    others_m: NDArray[np.float64],
    openings_m: NDArray[np.float64],
) -> bool:
    """Return whether the camera at ``from_m`` shows a person's middle, at least a fifth of him uncovered.

    Args:
        heading_rad: of the camera. others_m, openings_m: see ``covered_share``.
    """
    bearing_rad = np.arctan2(target_m[1] - from_m[1], target_m[0] - from_m[0]) - heading_rad
    if abs((bearing_rad + np.pi) % (2.0 * np.pi) - np.pi) > HALF_VIEW_RAD:
        return False
    return covered_share(from_m, target_m, others_m, openings_m) < _COVERED


def seen_frames(
    robot_m: NDArray[np.float64],
    heading_rad: NDArray[np.float64],
    target_m: NDArray[np.float64],
    others_m: NDArray[np.float64],
    openings_m: NDArray[np.float64],
) -> NDArray[np.bool_]:
    """Return the frames (F,) on which a person is in sight of a robot; all places are (F, 2), others (N, F, 2)."""
    return np.array(
        [
            is_in_sight(robot_m[frame], heading_rad[frame], target_m[frame], others_m[:, frame], openings_m)
            for frame in range(len(robot_m))
        ],
        dtype=np.bool_,
    )
