"""Baselines: the last position seen, constant velocity, and OpenCV's general tracker."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.kernels.boxes import box_around, box_centre, box_size
from trackers.kernels.histogram import ColourTemplate, hs_bins
from trackers.registry import NoParameters, register, tunable
from trackers.types import CameraModel, Estimate, Observation

_FINER = 16.0
_ALIKE = 1e-9
"""Difference of similarities that rounding makes."""


def best_match(
    template: ColourTemplate, image_rgb: NDArray[np.uint8], near_px: NDArray[np.float64], reach_px: float
) -> tuple[NDArray[np.float64], float]:
    """Return the position (2,) in the picture near a point whose rectangle is most similar to the template.

    The first grid spans ``reach_px`` in steps of a third of the rectangle; each next one spans a step around the best
    position, at most 16 times as fine, down to one pixel. A grid whose places are all alike, as on a grey picture,
    leaves the position where it is. Also returns the similarity, 0 if the picture is out of reach.
    """
    bins = hs_bins(image_rgb)
    picture = np.array([image_rgb.shape[1], image_rgb.shape[0]])
    step_px = max(1.0, float(template.size_px.min()) / 3)
    grids = [(reach_px, step_px), (step_px, max(1.0, step_px / _FINER))]
    while grids[-1][1] > 1.0:
        grids.append((grids[-1][1], max(1.0, grids[-1][1] / _FINER)))
    best_px, similarity = near_px, 0.0
    for reach, step in grids:
        # The grid is limited to the picture.
        low, high = np.maximum(best_px - reach, 0.0), np.minimum(best_px + reach, picture - 1e-3)
        x, y = (np.arange(low[axis], high[axis] + 1e-6, step) for axis in (0, 1))
        grid_px = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        if len(grid_px) == 0:
            break
        similarities = template.similarities(bins, grid_px)
        best = int(np.argmax(similarities))
        similarity = float(similarities[best])
        are_alike = similarity - similarities.min() <= _ALIKE
        best_px = np.clip(best_px, low, high) if are_alike else grid_px[best]
    return best_px, similarity


def _estimate(position_px: NDArray[np.float64], size_px: NDArray[np.float64], in_view: bool) -> Estimate:
    return Estimate(position_px, box_around(position_px, size_px), in_view_probability=float(in_view))


@dataclass(frozen=True)
class HoldParameters:
    """Settings of ``hold``.

    Attributes:
        reach_boxes: search radius around the last position, in lengths of the box.
        least_similarity: a match below this similarity is rejected.
    """

    reach_boxes: float = tunable(0.7, 0.2, 3.0, log=True)
    least_similarity: float = tunable(0.8, 0.4, 0.98)


@register("hold", role="baseline", summary="keeps the position in the picture where the car was last matched")
class Hold:
    """Returns the best match of the car's HS histogram, or the last matched position if there is none.

    Positions are pixels: without a match the estimate moves with the camera, even if its motion is measured.
    """

    Parameters = HoldParameters

    def __init__(self, parameters: HoldParameters, rng: np.random.Generator) -> None:
        self._parameters = parameters

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """Take the template from the box."""
        self._template = ColourTemplate.from_box(observation.image_rgb, box_xyxy)
        self._position_px = box_centre(box_xyxy)

    def update(self, observation: Observation) -> Estimate:
        """Return the best match near the last position, or that position."""
        reach_px = self._parameters.reach_boxes * float(self._template.size_px.max())
        match_px, similarity = best_match(self._template, observation.image_rgb, self._position_px, reach_px)
        seen = similarity >= self._parameters.least_similarity
        if seen:
            self._position_px = match_px
        return _estimate(self._position_px, self._template.size_px, seen)


@dataclass(frozen=True)
class ConstantVelocityParameters:
    """Settings of ``constant_velocity``.

    Attributes:
        acceleration_px: standard deviation of the acceleration, pixels a frame².
        match_noise_px: standard deviation of a match.
        reach_boxes: search radius around the prediction, in lengths of the box; two standard deviations of the
            prediction are added.
        least_similarity: a match below this similarity is rejected.
    """

    acceleration_px: float = tunable(3.0, 0.1, 20.0, log=True)
    match_noise_px: float = tunable(2.0, 0.3, 10.0, log=True)
    reach_boxes: float = tunable(0.5, 0.2, 3.0, log=True)
    least_similarity: float = tunable(0.8, 0.4, 0.98)


@register("constant_velocity", role="baseline", summary="Kalman filter of constant velocity in the picture")
class ConstantVelocity:
    """State (x, y, vx, vy) in pixels and pixels a frame, white acceleration; matches as ``hold`` does.

    ``x' = F x, P' = F P Fᵀ + Q``; ``K = P Hᵀ (H P Hᵀ + R)⁻¹, x += K (z - H x), P -= K H P``. Camera motion is not
    compensated.
    """

    Parameters = ConstantVelocityParameters
    _F = np.array([[1, 0, 1, 0], [0, 1, 0, 1], [0, 0, 1, 0], [0, 0, 0, 1.0]])
    _G = np.array([[0.5, 0], [0, 0.5], [1, 0], [0, 1.0]])

    def __init__(self, parameters: ConstantVelocityParameters, rng: np.random.Generator) -> None:
        self._parameters = parameters

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """Start at the box with velocity zero."""
        p = self._parameters
        self._template = ColourTemplate.from_box(observation.image_rgb, box_xyxy)
        self._x = np.concatenate([box_centre(box_xyxy), np.zeros(2)])
        self._P = np.diag([p.match_noise_px**2] * 2 + [float(self._template.size_px.max() / 4) ** 2] * 2)

    def update(self, observation: Observation) -> Estimate:
        """Predict, search near the prediction, correct by the match."""
        p = self._parameters
        self._x = self._F @ self._x
        self._P = self._F @ self._P @ self._F.T + p.acceleration_px**2 * self._G @ self._G.T
        length_px = float(self._template.size_px.max())
        reach_px = p.reach_boxes * length_px + 2.0 * float(np.sqrt(self._P[:2, :2].trace() / 2))
        match_px, similarity = best_match(self._template, observation.image_rgb, self._x[:2], reach_px)
        seen = similarity >= p.least_similarity
        if seen:
            self._correct(match_px)
        estimate = _estimate(self._x[:2].copy(), self._template.size_px, seen)
        heading_rad = float(np.arctan2(self._x[3], self._x[2]))
        return replace(estimate, heading_rad=heading_rad, covariance_px=self._P[:2, :2].copy())

    def _correct(self, match_px: NDArray[np.float64]) -> None:
        gain = self._P[:, :2] @ np.linalg.inv(self._P[:2, :2] + self._parameters.match_noise_px**2 * np.eye(2))
        self._x = self._x + gain @ (match_px - self._x[:2])
        self._P = self._P - gain @ self._P[:2]


_LEAST_SIDE_PX, _LEAST_ROOM_PX = 5, 10
"""OpenCV compares the target's box with others at least 4.5 pixels away, inside the picture."""


@register(
    "opencv_mil",
    role="baseline",
    summary="OpenCV's MIL, a general tracker",
    reproducible=False,
    suites=("frame-out", "stereo"),
)
class OpenCvMil:
    """``cv2.TrackerMIL``.

    Its estimate is always inside the picture, it has no in-view probability, and it draws random numbers without a
    seed.
    """

    Parameters = NoParameters

    def __init__(self, parameters: NoParameters, rng: np.random.Generator) -> None:
        self._tracker = cv2.TrackerMIL.create()

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """Start on the part of the box that is inside the picture."""
        box_size(box_xyxy)
        size = np.array([observation.camera.width_px, observation.camera.height_px])
        self._box_xyxy = visible_part(box_xyxy, observation.camera)
        x, y, right, bottom = (int(value) for value in self._box_xyxy)
        # OpenCV tries no box that ends at the last row or column.
        width, height = (np.minimum([right - x, bottom - y], size - 1)).tolist()
        self._has_room = (size > _LEAST_SIDE_PX).all() and (size - [width, height] > _LEAST_ROOM_PX).any()
        if self._has_room:
            self._tracker.init(np.ascontiguousarray(observation.image_rgb[..., ::-1]), (x, y, width, height))

    def update(self, observation: Observation) -> Estimate:
        """Return OpenCV's box, or the last one where it fails; NaN if the first box filled the picture."""
        if not self._has_room:
            return Estimate(np.full(2, np.nan))
        found, (x, y, width, height) = self._tracker.update(np.ascontiguousarray(observation.image_rgb[..., ::-1]))
        if found:
            self._box_xyxy = np.array([x, y, x + width, y + height], dtype=float)
        return Estimate(box_centre(self._box_xyxy), self._box_xyxy.copy())


def visible_part(box_xyxy: NDArray[np.float64], camera: CameraModel) -> NDArray[np.float64]:
    """Return the part of a box inside the picture, in whole pixels, at least 5 x 5; with 4 x 4 OpenCV does not
    terminate.
    """
    size = np.array([camera.width_px, camera.height_px])
    low = np.clip(np.floor(box_xyxy[:2]), 0, size - _LEAST_SIDE_PX)
    high = np.maximum(np.clip(np.ceil(box_xyxy[2:]), _LEAST_SIDE_PX, size), low + _LEAST_SIDE_PX)
    return np.concatenate([low, high])
