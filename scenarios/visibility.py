"""How an object is seen, by its box and what of it shows: the same words in every scenario."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenarios.truth import Side, VisibilityState
from sim.optics import PinholeCamera, project

MOSTLY_SEEN = 0.5
"""Share of an object that shows from which it counts as seen; one inside the picture with less is ``occluded``."""


class Exits:
    """Follows when and where the target leaves the picture."""

    def __init__(self, camera: PinholeCamera) -> None:
        self._camera = camera
        self._side: Side | None = None
        self._frames_since_exit = -1

    def follow(self, state: VisibilityState, box_xyxy: NDArray[np.float64]) -> tuple[Side | None, int]:
        """Take in the next frame; return ``Truth.side`` and ``Truth.frames_since_exit``."""
        if state == "out":
            self._frames_since_exit += 1
            if self._frames_since_exit == 0:
                self._side = _side_of(self._camera, box_xyxy)
        else:
            self._frames_since_exit = -1
        return self._side, self._frames_since_exit


def state_of(camera: PinholeCamera, box_xyxy: NDArray[np.float64], visible: float) -> VisibilityState:
    """Return the state of an object by its amodal box and the share of it that is seen."""
    left, top, right, bottom = box_xyxy.tolist()
    # Comparisons with NaN are false.
    if not (right > 0 and bottom > 0 and left < camera.width_px and top < camera.height_px):
        return "out"
    if left < 0 or top < 0 or right > camera.width_px or bottom > camera.height_px:
        return "partial"
    return "occluded" if visible < MOSTLY_SEEN else "in"


def centres_px(
    camera: PinholeCamera,
    T_world_camera: NDArray[np.float64],
    poses: NDArray[np.float64],
    sizes_m: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return where objects' centres are seen (N, 2), by poses (N, 4, 4) on the ground and sizes (N, 3); NaN behind."""
    centres = poses[:, :3, 3] + 0.5 * sizes_m[:, 2:] * poses[:, :3, 2]
    return project(camera, T_world_camera, centres)[0]


def _side_of(camera: PinholeCamera, box_xyxy: NDArray[np.float64]) -> Side:
    """Return the border that the box is furthest beyond; the bottom for one behind the camera."""
    beyond: dict[Side, float] = {
        "left": -box_xyxy[2],
        "right": box_xyxy[0] - camera.width_px,
        "top": -box_xyxy[3],
        "bottom": box_xyxy[1] - camera.height_px,
    }
    if np.isnan(box_xyxy).any():
        return "bottom"
    return max(beyond, key=lambda side: beyond[side])
