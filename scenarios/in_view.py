"""When a target counts as in view: what following is scored by, in every scenario."""

from __future__ import annotations

import numpy as np

from scenarios.truth import Truth
from sim.optics import PinholeCamera

SHORTEST_LENGTH_PX = 12.0
"""A target that is seen smaller than this is not watched: climbing and zooming out win nothing."""


def length_px(truth: Truth, target: int) -> float:
    """Return the longer side of the target's amodal box; 0 where it is behind the camera."""
    box = truth.box_xyxy[target]
    return 0.0 if np.isnan(box).any() else float(max(box[2] - box[0], box[3] - box[1]))


def centring(truth: Truth, target: int, camera: PinholeCamera) -> float:
    """Return how centred the target is: 1 in the middle, 0 on the border and outside (DAT's ``p``).

    One minus its distance from the picture's centre over the distance from there to the border along the same ray.
    """
    x, y = truth.position_px[target]
    share = max(abs(2.0 * x / camera.width_px - 1.0), abs(2.0 * y / camera.height_px - 1.0))
    return float(1.0 - share) if share < 1.0 else 0.0


def is_in_view(truth: Truth, target: int, camera: PinholeCamera) -> bool:
    """Return whether the target's centre is inside the picture, hidden or not, and it is seen long enough."""
    return centring(truth, target, camera) > 0.0 and length_px(truth, target) >= SHORTEST_LENGTH_PX
