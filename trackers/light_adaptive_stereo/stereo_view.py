"""How the camera stands on the robot, from the first picture, and what a stereo pair shows."""

from __future__ import annotations

import time
from collections.abc import Hashable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.kernels.boxes import box_centre, box_size
from trackers.light_adaptive_stereo.candidates import Candidate, CandidateParameters, find_candidates
from trackers.light_adaptive_stereo.matching import StereoMatcher
from trackers.light_adaptive_stereo.robot_frame import Mounting, points_m
from trackers.types import CameraModel, Observation


def first_mounting(
    observation: Observation, box_xyxy: NDArray[np.float64], matcher: StereoMatcher, usual_height_m: float
) -> Mounting:
    """Return the mounting of the measured pose; without one, of a level camera that shows feet at a box's lower edge.

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


@dataclass(frozen=True)
class StereoView:
    """Depth, points and candidates of one stereo pair.

    Attributes:
        depth_m: (H', W') float32, NaN where unknown.
        points_m: (H', W', 3) float32 in the robot's frame.
        candidates: in order of distance.
    """

    depth_m: NDArray[np.float32]
    points_m: NDArray[np.float32]
    candidates: list[Candidate]


def see(
    observation: Observation, matcher: StereoMatcher, mounting: Mounting, parameters: CandidateParameters
) -> tuple[StereoView | None, float]:
    """Match the stereo pair of an observation and find its candidates.

    The latest view is kept: trackers that run side by side on the same pictures share one, whose arrays are read-only.

    Returns:
        The view, None without the right picture; and the CPU time in seconds that another tracker spent on it, 0 if it
        was made now (see ``OutsourcingTracker``).
    """
    global _latest
    if observation.right_rgb is None:
        return None, 0.0
    way = (matcher.parameters, mounting.height_m, mounting.R_robot_camera.tobytes(), parameters)
    # Read once: another thread may replace it in between.
    latest = _latest
    if latest is not None and latest.observation is observation and latest.way == way:
        return latest.view, latest.cpu_s
    began_s = time.thread_time()
    depth_m = matcher.depth_m(observation.image_rgb, observation.right_rgb, observation.camera)
    points = points_m(depth_m, observation.camera, mounting)
    view = StereoView(depth_m, points, find_candidates(points, observation.camera, mounting, parameters))
    own = (array for each in view.candidates for array in (each.place_m, each.box_xyxy, each.pixels))
    for array in (depth_m, points, *own):
        array.flags.writeable = False
    _latest = _Made(observation, way, view, time.thread_time() - began_s)
    return view, 0.0


@dataclass(frozen=True)
class _Made:
    """A view, what it was made from and how, and the CPU time that it took."""

    observation: Observation
    way: tuple[Hashable, ...]
    view: StereoView
    cpu_s: float


_latest: _Made | None = None
"""Of this process."""
