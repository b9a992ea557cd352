"""Each picture's projection of flat ground, from the measured pose or, without one, from the picture's own motion."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.kernels.boxes import apparent_length_px, box_centre
from trackers.kernels.ground_camera import (
    CENTRE_HEIGHT_M,
    TYPICAL_LENGTH_M,
    GroundCamera,
    apply_homography,
    looking_down,
)
from trackers.kernels.picture_motion import picture_motion
from trackers.types import Observation

_NEAREST_M = 0.05
"""Least depth of a projected point; points nearer to the camera's plane or behind it count as at this depth."""
_SHORTEST_PX, _LEAST_SCALE = 2.0, 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class GroundView:
    """The plane at half the height of cars, as one picture shows it.

    Attributes:
        H_picture_ground: (3, 3) homography from metres on the plane to pixels; its third row gives the depth in m.
        size_px: (2,) width and height of the picture.
    """

    H_picture_ground: NDArray[np.float64]
    size_px: NDArray[np.float64]

    def to_picture(self, points_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the pixels (N, 2) of points (N, 2), finite for all, and far outside for points behind the camera."""
        homogeneous = np.column_stack([points_m, np.ones(len(points_m))]) @ self.H_picture_ground.T
        return homogeneous[:, :2] / np.maximum(homogeneous[:, 2:], _NEAREST_M)

    def to_ground(self, pixels: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the points (N, 2) at pixels (N, 2); NaN at and above the horizon."""
        H = np.asarray(np.linalg.inv(self.H_picture_ground), dtype=np.float64)
        return apply_homography(H if H[2] @ self._middle > 0 else -H, np.ascontiguousarray(pixels, dtype=float))

    def derivative(self, point_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the derivative (2, 2) of the pixel by the point (2,)."""
        pixels = self.to_picture(point_m + np.array([[-0.5, 0.0], [0.5, 0.0], [0.0, -0.5], [0.0, 0.5]]))
        return np.column_stack([pixels[1] - pixels[0], pixels[3] - pixels[2]])

    def scale(self, point_m: NDArray[np.float64]) -> float:
        """Return the pixels per metre around a point (2,), the mean of all directions by area; at least 1e-6."""
        return max(float(np.sqrt(abs(np.linalg.det(self.derivative(point_m))))), _LEAST_SCALE)

    def footprint_m(self) -> NDArray[np.float64]:
        """Return the points (4, 2) at the picture's corners, clockwise from the top left; NaN above the horizon."""
        width, height = self.size_px
        return self.to_ground(np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]]))

    def rectified(
        self, image_rgb: NDArray[np.uint8], corner_m: NDArray[np.float64], size: tuple[int, int], cell_m: float
    ) -> NDArray[np.uint8]:
        """Return the ground seen from straight above, (rows, columns, 3): x to the right, y down, black where the
        picture ends.

        Args:
            corner_m: (2,) least x and y. size: columns and rows, of ``cell_m``.
        """
        cells = np.array(
            [[cell_m, 0.0, corner_m[0] + 0.5 * cell_m], [0.0, cell_m, corner_m[1] + 0.5 * cell_m], [0.0, 0.0, 1.0]]
        )
        centres = np.array([[1.0, 0.0, -0.5], [0.0, 1.0, -0.5], [0.0, 0.0, 1.0]])
        H = centres @ self.H_picture_ground @ cells
        return cv2.warpPerspective(image_rgb, H, size, flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP)

    @property
    def _middle(self) -> NDArray[np.float64]:
        return np.append(0.5 * self.size_px, 1.0)


class GroundViews:
    """Gives the views of consecutive pictures over one ground.

    With a measured pose in the first picture the ground is that of the navigation frame, and a picture's view follows
    from its own measured pose alone; pictures without one are chained to the one before. Without a pose in the first
    picture, it looks straight down on a car of typical length, and all others are chained.
    """

    def __init__(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        self._grey = cv2.cvtColor(observation.image_rgb, cv2.COLOR_RGB2GRAY)
        camera = _measured(observation, box_centre(box_xyxy))
        self._is_measured = camera is not None
        if camera is None:
            length_px = max(apparent_length_px(box_xyxy), _SHORTEST_PX)
            camera = looking_down(observation.camera, TYPICAL_LENGTH_M / length_px)
        self.view = _view_of(camera, observation)

    def next(self, observation: Observation) -> GroundView | None:
        """Return the next picture's view; None if its measured pose shows no ground."""
        before, self._grey = self._grey, cv2.cvtColor(observation.image_rgb, cv2.COLOR_RGB2GRAY)
        if self._is_measured and observation.ego is not None:
            camera = _measured(observation, None)
            if camera is None:
                return None
            self.view = _view_of(camera, observation)
        else:
            H = picture_motion(before, self._grey) @ self.view.H_picture_ground
            self.view = GroundView(H, _size_px(observation))
        return self.view


def _measured(observation: Observation, pixel: NDArray[np.float64] | None) -> GroundCamera | None:
    """Return the camera at its measured pose, or None if there is none that shows ground at a pixel (None = middle).

    The optical axis must point down: the rays of a camera that looks up meet the ground behind it.
    """
    if observation.ego is None or not observation.ego.T_world_camera[2, 2] < 0.0:
        return None
    camera = GroundCamera(observation.camera, observation.ego.T_world_camera, np.zeros(2))
    return camera if camera.shows_ground(pixel) else None


def _view_of(camera: GroundCamera, observation: Observation) -> GroundView:
    return GroundView(camera.H_picture_map(CENTRE_HEIGHT_M), _size_px(observation))


def _size_px(observation: Observation) -> NDArray[np.float64]:
    return np.array(observation.image_rgb.shape[1::-1], dtype=float)
