"""Where everything of the harbour lies: quay, sheds, parking, berths; metres, see ``VOLUME_M`` for the frame.

The world frame has z up from the quay's surface. The overview camera is 20 m above it and looks along +x at the origin:
first comes the sea, then the quay's wall, the quay, parked cars, a lane, sheds and the town. y grows to the left.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackers.types import CameraModel, SiteSurvey

CAMERA = CameraModel(384, 288, 770.0, band="thermal")
CAMERA_M, AIM_M = (-100.0, 0.0, 20.0), (0.0, 0.0, 0.0)
VOLUME_M = (90.0, 33.0, 6.0)
"""Watched volume about the origin: along x, y and z."""
VOLUME_BOTTOM_M = -2.5
MEAN_SEA_M = -1.8
WALL_X_M = -15.0
SURVEY = SiteSurvey((WALL_X_M, 0.0), (-1.0, 0.0), MEAN_SEA_M, VOLUME_M, VOLUME_BOTTOM_M)
"""Survey of the site, an input of trackers."""
COPING_M = 0.6
"""Width of the stones along the edge of the quay."""
APRON_END_M = 12.0
PARKING_X_M = 16.5
PARKING_Y_M = tuple(float(y) for y in np.arange(-24.0, 25.0, 3.0))
"""Middles of the bays, whose cars stand along x."""
OPEN_BAYS_Y_M = (0.0, 12.0)
"""Bays that stay empty: through them cars drive onto the apron."""
LANE_X_M = 27.0
SHED_X_M = 46.0


class Shed(NamedTuple):
    """A shed: middle of its front along y, length, depth, height of eaves, rise of the ridge, doors along y."""

    y_m: float
    length_m: float
    depth_m: float
    eaves_m: float
    rise_m: float
    doors_y_m: tuple[float, ...]


SHEDS = (
    Shed(-22.0, 28.0, 13.0, 4.6, 2.2, (-30.0, -19.0, -12.0)),
    Shed(21.5, 29.0, 12.0, 4.2, 2.6, (12.0, 22.0, 31.0)),
)
GAP_Y_M = 0.0
"""Middle of the road between the sheds, through which people and cars come from behind."""


class Berth(NamedTuple):
    """Where a boat lies along the wall: its middle, and its heading.

    Attributes:
        is_free: no boat lies there; visitors may.
    """

    y_m: float
    heading_rad: float
    is_free: bool


BERTHS = (
    Berth(-15.5, 0.5 * np.pi, False),
    Berth(-3.0, 0.5 * np.pi, True),
    Berth(8.5, -0.5 * np.pi, False),
    Berth(20.0, 0.5 * np.pi, False),
)
BUOYS_M = ((-37.5, 6.0), (-41.0, -8.0))
"""Moorings off the wall, about which boats swing."""
FAIRWAY_X_M = (-26.0, -22.5)
"""Boats that pass keep between these."""
BOLLARDS_Y_M = tuple(float(y) for y in np.arange(-38.0, 39.0, 6.0))
BOLLARD_X_M = -14.0
LAMP_POSTS_M = ((11.0, -17.0), (11.0, 14.0), (38.0, 3.5))


def border_y_m(x_m: float, beyond_m: float = 6.0) -> float:
    """Return how far to either side something at x is ``beyond_m`` outside the picture's left and right border."""
    return (x_m - CAMERA_M[0]) * 0.5 * CAMERA.width_px / CAMERA.focal_px + beyond_m


def overview_pose() -> NDArray[np.float64]:
    """Return T_world_camera (4, 4) of the overview camera."""
    ahead = np.subtract(AIM_M, CAMERA_M) / np.linalg.norm(np.subtract(AIM_M, CAMERA_M))
    right = np.cross(ahead, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    T = np.eye(4)
    T[:3, :3] = np.stack([right, np.cross(ahead, right), ahead], axis=1)
    T[:3, 3] = CAMERA_M
    return T


def is_watched(points_m: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return whether points (..., 3) lie in the watched volume."""
    half = 0.5 * np.array(VOLUME_M)
    middle = (AIM_M[0], AIM_M[1], VOLUME_BOTTOM_M + half[2])
    return np.asarray((np.abs(points_m - middle) <= half).all(axis=-1))
