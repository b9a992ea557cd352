"""How the camera stands on the robot, from the first picture: measured, or read from the target's box."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from trackers.kernels.boxes import box_centre, box_size
from trackers.light_adaptive_stereo.matching import StereoMatcher
from trackers.light_adaptive_stereo.robot_frame import Mounting
from trackers.types import CameraModel, Observation


def first_mounting(
    observation: Observation, box_xyxy: NDArray[np.float64], matcher: StereoMatcher, usual_height_m: float
) -> Mounting:
    """Return the mounting of the measured pose; without one, of a level camera that sees feet at a box's lower edge.

    The feet are as far away as what is in the middle of the box, by the pair's disparities, or by a person's usual
    height where these are unknown.

    Args:
        box_xyxy: (4,), of the target.
    """
    if observation.ego is not None:
        return Mounting.from_pose(observation.ego.T_world_camera)
    camera, depth_m = observation.camera, np.empty((0, 0), np.float32)
    if observation.right_rgb is not None:
        depth_m = _middle(matcher.depth_m(observation.image_rgb, observation.right_rgb, camera), box_xyxy, camera)
    known_m = depth_m[np.isfinite(depth_m)]
    feet_m = float(np.median(known_m)) if known_m.size else usual_depth_m(camera, box_xyxy, usual_height_m)
    return Mounting.level(max(feet_m * float(box_xyxy[3] - 0.5 * camera.height_px) / camera.focal_px, 0.0))


def usual_depth_m(camera: CameraModel, box_xyxy: NDArray[np.float64], usual_height_m: float) -> float:
    """Return the distance of a person of the usual height who fills a box (4,)."""
    return camera.focal_px * usual_height_m / float(box_size(box_xyxy)[1])


def _middle(depth_m: NDArray[np.float32], box_xyxy: NDArray[np.float64], camera: CameraModel) -> NDArray[np.float32]:
    """Return the middle half, each way, of a box (4,) of the left picture in a depth picture (H', W')."""
    shrink = camera.width_px / depth_m.shape[1]
    centre, quarter = box_centre(box_xyxy) / shrink, 0.25 * box_size(box_xyxy) / shrink
    low, high = (
        np.clip(np.round(end), 0, depth_m.shape[::-1]).astype(int) for end in (centre - quarter, centre + quarter)
    )
    return depth_m[low[1] : high[1], low[0] : high[0]]
