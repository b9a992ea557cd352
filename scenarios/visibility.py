"""Visibility states of objects from their boxes and visible shares, the same in every scenario."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numba.extending import register_jitable
from numpy.typing import NDArray

from scenarios.truth import Side, Truth
from sim.optics import project
from trackers.types import CameraModel

_STATES = np.array(["out", "partial", "occluded", "in"])
MOSTLY_SEEN = 0.5
"""An object inside the picture is ``occluded`` if its visible share is less."""
_SIDES: tuple[Side, ...] = ("left", "right", "top", "bottom")


class Exits:
    """Records when and where each of N objects leaves the picture."""

    def __init__(self, camera: CameraModel, count: int) -> None:
        self._camera = camera
        self._side = np.full(count, "", dtype="<U6")
        self._frames_since_exit = np.full(count, -1)

    def follow(
        self, state: NDArray[np.str_], box_xyxy: NDArray[np.float64]
    ) -> tuple[NDArray[np.str_], NDArray[np.int64]]:
        """Add the next frame's states (N,) and boxes (N, 4); return ``Truth.side`` and ``frames_since_exit``."""
        out = state == "out"
        self._frames_since_exit = np.where(out, self._frames_since_exit + 1, -1)
        left = self._frames_since_exit == 0
        if left.any():
            self._side = self._side.copy()
            self._side[left] = [_side_of(self._camera, box) for box in box_xyxy[left]]
        return self._side, self._frames_since_exit


def states_of(
    camera: CameraModel, box_xyxy: NDArray[np.float64], visible_fraction: NDArray[np.float64]
) -> NDArray[np.str_]:
    """Return the states (N,) of objects from their amodal boxes (N, 4) and visible shares (N,)."""
    return _STATES[_states(box_xyxy, camera.width_px, camera.height_px, visible_fraction)]


@njit(cache=True)
def _states(
    box_xyxy: NDArray[np.float64], width: int, height: int, visible_fraction: NDArray[np.float64]
) -> NDArray[np.int64]:
    """Return the numbers (N,) of states in ``_STATES``. Comparisons with NaN are false."""
    states = np.zeros(len(box_xyxy), np.int64)
    for n in range(len(box_xyxy)):
        left, top, right, bottom = box_xyxy[n]
        if right > 0 and bottom > 0 and left < width and top < height:
            is_cut = left < 0 or top < 0 or right > width or bottom > height
            states[n] = 1 if is_cut else 2 if visible_fraction[n] < MOSTLY_SEEN else 3
    return states


def centres_px(
    camera: CameraModel,
    T_world_camera: NDArray[np.float64],
    poses: NDArray[np.float64],
    sizes_m: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return the pixels (N, 2) of objects' centres, from poses (N, 4, 4) on the ground and sizes (N, 3); NaN behind."""
    centres = poses[:, :3, 3] + 0.5 * sizes_m[:, 2:] * poses[:, :3, 2]
    return project(camera, T_world_camera, centres)[0]


def _side_of(camera: CameraModel, box_xyxy: NDArray[np.float64]) -> Side:
    """Return the border that the box is furthest beyond; ``bottom`` for a box behind the camera."""
    if np.isnan(box_xyxy).any():
        return "bottom"
    x_min, y_min, x_max, y_max = box_xyxy
    beyond = np.array([-x_max, x_min - camera.width_px, -y_max, y_min - camera.height_px])
    return _SIDES[int(np.argmax(beyond))]


SHORTEST_LENGTH_PX = 12.0
"""Shortest length of a target in view, in pictures that are at least ``WIDE_PX`` wide."""
WIDE_PX = 320


@register_jitable
def shortest_length_px(width_px: float) -> float:
    """Return the length of the shortest target that counts as in view, so that climbing and zooming out gain nothing.

    Args:
        width_px: of the picture; in one that is narrower than ``WIDE_PX`` it is the same share of the width as there.
    """
    return SHORTEST_LENGTH_PX * min(width_px / WIDE_PX, 1.0)


def length_px(truth: Truth, target: int) -> float:
    """Return the longer side of the target's amodal box; 0 if the target is behind the camera."""
    box = truth.box_xyxy[target].tolist()
    return 0.0 if any(map(math.isnan, box)) else max(box[2] - box[0], box[3] - box[1])


def centring(truth: Truth, target: int, camera: CameraModel) -> float:
    """Return how centred the target is: 1 in the middle, 0 on the border and outside (DAT's ``p``).

    It is one minus the target's distance from the picture's centre over the border's distance along the same ray.
    """
    x, y = truth.position_px[target].tolist()
    share = max(abs(2.0 * x / camera.width_px - 1.0), abs(2.0 * y / camera.height_px - 1.0))
    return 1.0 - share if share < 1.0 else 0.0


def view_width_m(truth: Truth, target: int, camera: CameraModel) -> float:
    """Return the width of what the picture shows at the target's place, across the line of sight, in metres."""
    T_world_camera = truth.T_world_camera
    depth_m = float((truth.T_world_object[target, :3, 3] - T_world_camera[:3, 3]) @ T_world_camera[:3, 2])
    return depth_m * camera.width_px / camera.focal_px


def is_in_view(truth: Truth, target: int, camera: CameraModel, widest_view_m: float = np.inf) -> bool:
    """Return whether the target's centre is inside the picture, hidden or not, and it is shown large enough.

    Args:
        widest_view_m: see ``Scenario``.
    """
    is_inside = centring(truth, target, camera) > 0.0 and length_px(truth, target) >= shortest_length_px(
        camera.width_px
    )
    return is_inside and (widest_view_m == np.inf or view_width_m(truth, target, camera) <= widest_view_m)
