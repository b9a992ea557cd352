"""What is seen in a stereo pair: depth, points and candidates, made once for all trackers of the same pictures."""

from __future__ import annotations

import time
from collections.abc import Hashable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.light_adaptive_stereo.candidates import Candidate, CandidateParameters, find_candidates
from trackers.light_adaptive_stereo.matching import StereoMatcher
from trackers.light_adaptive_stereo.robot_frame import Mounting, points_m
from trackers.types import Observation


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
