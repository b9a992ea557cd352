"""What is really so. It is scored with; no tracker, controller or observation space ever gets it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

VisibilityState = Literal["in", "partial", "occluded", "out"]
Side = Literal["left", "right", "top", "bottom"]
TruthExtent = Literal["all", "target"]
"""How much of it an episode's frames have, see ``Truth``."""


@dataclass(frozen=True, slots=True)
class Truth:
    """Truth of one frame, of N objects; ``target`` is the one that matters. Each scenario adds what it alone knows.

    Boxes are amodal: of the whole object, also where it is hidden or outside the picture.

    Most of the work goes into what scores of following the target do not look at. An episode that is asked for
    ``truth="target"`` leaves it out: ``visible_fraction`` of all others is NaN, and so on as each scenario says of what
    it alone knows. All else, pictures above all, is the same byte for byte.

    Attributes:
        frame: index from 0.
        time_s: seconds since frame 0.
        T_world_camera: (4, 4), the true pose.
        target: index of the target among the N objects.
        names: (N,) e.g. ``target``, ``traffic-3``.
        kinds: (N,) kind of each, e.g. the vehicle's model.
        T_world_object: (N, 4, 4), origin on the ground under the object's centre, x forward, z up.
        size_m: (N, 3) length, width, height.
        speed_mps: (N,).
        position_px: (N, 2) projection of the objects' centres (half their height up), also outside the
            picture; NaN behind the camera.
        box_xyxy: (N, 4) amodal box in pixels, also outside; NaN where any corner is behind the camera.
        instance_id: (N,) id of each object in ``instance_map``.
        visible_fraction: (N,) share of the object's own pixels (drawn alone on an unbounded picture) that
            are seen; NaN for all but the target if that is all that is asked for.
        state: ``in`` (whole and seen), ``partial`` (cut by the border), ``occluded`` (inside, less than
            half of it seen), ``out`` (nothing of its box inside).
        side: side the target left by, while it is out or since its last exit; None before the first.
        frames_since_exit: 0 on the first frame that the target is out; -1 while it is not out.
        instance_map: (H, W) int32, ``instance_id`` of the object seen, others for what is no object.
        depth_m: (H, W) float32.
        exposure_s, gain: the camera's settings for this picture.
    """

    frame: int
    time_s: float
    T_world_camera: NDArray[np.float64]
    target: int
    names: tuple[str, ...]
    kinds: tuple[str, ...]
    T_world_object: NDArray[np.float64]
    size_m: NDArray[np.float64]
    speed_mps: NDArray[np.float64]
    position_px: NDArray[np.float64]
    box_xyxy: NDArray[np.float64]
    instance_id: NDArray[np.int64]
    visible_fraction: NDArray[np.float64]
    state: VisibilityState
    side: Side | None
    frames_since_exit: int
    instance_map: NDArray[np.int32]
    depth_m: NDArray[np.float32]
    exposure_s: float
    gain: float
