"""When a target counts as in view: the measure of following in every scenario."""

from __future__ import annotations

import numpy as np

from scenarios.truth import Truth
from trackers.types import CameraModel

SHORTEST_LENGTH_PX = 12.0
"""A target that appears smaller does not count as in view, so climbing and zooming out gain nothing."""


def length_px(truth: Truth, target: int) -> float:
    """Return the longer side of the target's amodal box; 0 if the target is behind the camera."""
    box = truth.box_xyxy[target]
    return 0.0 if np.isnan(box).any() else float(max(box[2] - box[0], box[3] - box[1]))


def centring(truth: Truth, target: int, camera: CameraModel) -> float:
    """Return how centred the target is: 1 in the middle, 0 on the border and outside (DAT's ``p``).

    It is one minus the target's distance from the picture's centre over the border's distance along the same ray.
    """
    x, y = truth.position_px[target]
    share = max(abs(2.0 * x / camera.width_px - 1.0), abs(2.0 * y / camera.height_px - 1.0))
    return float(1.0 - share) if share < 1.0 else 0.0


def is_in_view(truth: Truth, target: int, camera: CameraModel) -> bool:
    """Return whether the target's centre is inside the picture, hidden or not, and its box is long enough."""
    return centring(truth, target, camera) > 0.0 and length_px(truth, target) >= SHORTEST_LENGTH_PX
