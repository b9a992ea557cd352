"""Registration of each picture on the ground: frame to frame first, then to the mosaic, which does not drift."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.kernels.ground_camera import GroundCamera, fit_pose, looking_down
from trackers.mosaic_graph.mosaic import Mosaic, shrink, to_full, to_small
from trackers.types import CameraModel, EgoPose, Observation

_CORNERS = 160
_CORNER_DISTANCE_PX = 11
_ENOUGH_SUPPORT = 12.0
_FRAME_SCALES_PX = (16.0, 8.0, 4.0, 3.0)
_MOSAIC_SCALES_PX = (3.0, 2.0, 1.5)
_FIRST_TILT_RAD = 0.12
_MEASURED_TILT_RAD = 0.015
# Consecutive pictures share corners and errors: their information on the bend is far from independent.
_BEND_LEARNING = 0.02
_CHAIN_TRUST = 0.1
_GAIN_STEP, _GAIN_PIXELS = 6, 100


@dataclass(frozen=True, slots=True)
class Registered:
    """A registered picture.

    Attributes:
        camera: pose of the camera on the map.
        small_rgb: (H, W, 3) the picture shrunk by ``SHRINK``, as bright as the mosaic.
        background_rgb: (H, W, 3) the same view of the mosaic before this picture.
        seen: (H, W) earlier pictures of each pixel's ground.
    """

    camera: GroundCamera
    small_rgb: NDArray[np.uint8]
    background_rgb: NDArray[np.uint8]
    seen: NDArray[np.uint8]


class Registration:
    """Estimates the pose of every picture over the ground."""

    def __init__(
        self,
        observation: Observation,
        target_px: NDArray[np.float64],
        metres_per_pixel: float,
        *,
        use_ego: bool,
        use_mosaic: bool,
    ) -> None:
        """Begin with the first picture.

        Args:
            target_px: (2,) place of the target.
            metres_per_pixel: guess in its middle, for a picture without a usable measured pose.
            use_mosaic: if False, pictures are chained frame to frame only.
        """
        self._use_ego, self._use_mosaic = use_ego, use_mosaic
        self._ego = observation.ego if use_ego and shows_ground(observation, target_px) else None
        tilt_rad = _FIRST_TILT_RAD
        self.camera = looking_down(observation.camera, metres_per_pixel)
        if self._ego is not None:
            self.camera = _posed(observation.camera, self._ego)
            tilt_rad = _MEASURED_TILT_RAD
        height_m = float(self.camera.T_world_camera[2, 3])
        self._bend_information = np.eye(2) * (height_m / tilt_rad) ** 2
        small_rgb = shrink(observation.image_rgb)
        self._grey = cv2.cvtColor(small_rgb, cv2.COLOR_RGB2GRAY)
        self._corners = _find_corners(self._grey)
        self._gain = 1.0
        black = np.zeros_like(small_rgb)
        self.first = Registered(self.camera, small_rgb, black, black[..., 0])

    def register(self, observation: Observation, mosaic: Mosaic) -> Registered | None:
        """Return the next picture, registered to ``mosaic`` of the earlier ones; None if it shows no ground.

        Whether it does follows from its corners, or from the measured pose if these are too few. After None the next
        picture is registered to the latest one that shows ground.
        """
        ego = self._measured(observation)
        predicted = self._predict(ego)
        is_off = not predicted.shows_ground() or (self._use_ego and observation.ego is not None and ego is None)
        predicted = predicted if predicted.shows_ground() else self.camera
        small_rgb = shrink(observation.image_rgb)
        grey = cv2.cvtColor(small_rgb, cv2.COLOR_RGB2GRAY)
        corners, map_m = self._follow_corners(grey, predicted)
        prior = self._prior()
        fit = fit_pose(predicted, map_m, corners, prior, _FRAME_SCALES_PX)
        if is_off if fit.support < _ENOUGH_SUPPORT else not fit.camera.shows_ground():
            return None
        if fit.support < _ENOUGH_SUPPORT:
            fit = replace(fit, camera=predicted, support=0.0)
        background_rgb, seen = mosaic.render(fit.camera)
        if self._use_mosaic and fit.support > 0:
            found, map_m = _match_to_mosaic(grey, corners, background_rgb, seen, fit.camera)
            corrected = fit_pose(fit.camera, map_m, found, prior + _CHAIN_TRUST * fit.information, _MOSAIC_SCALES_PX)
            if corrected.support >= _ENOUGH_SUPPORT and corrected.camera.shows_ground():
                self._learn_bend(corrected.information)
                fit = corrected
                background_rgb, seen = mosaic.render(fit.camera)
        self.camera, self._ego, self._grey, self._corners = fit.camera, ego, grey, _find_corners(grey)
        self._gain = _gain(small_rgb, background_rgb, seen, self._gain)
        adapted_rgb = cv2.convertScaleAbs(small_rgb, alpha=self._gain)
        return Registered(fit.camera, adapted_rgb, background_rgb, seen)

    def _measured(self, observation: Observation) -> EgoPose | None:
        """Return the measured pose; None if it is not used, or shows no ground."""
        ego = observation.ego if self._use_ego else None
        return ego if ego is not None and _posed(observation.camera, ego).shows_ground() else None

    def _predict(self, ego: EgoPose | None) -> GroundCamera:
        """Return the camera moved by the measured motion since the last picture, in which slow errors cancel."""
        before = self._ego
        if before is None or ego is None:
            return self.camera
        T, T_before, T_now = self.camera.T_world_camera.copy(), before.T_world_camera, ego.T_world_camera
        T[:3, :3] = T[:3, :3] @ T_before[:3, :3].T @ T_now[:3, :3]
        T[:3, 3] += T_now[:3, 3] - T_before[:3, 3]
        return replace(self.camera, T_world_camera=T)

    def _prior(self) -> NDArray[np.float64]:
        """Return the information (8, 8) of the prediction: little on the pose, all so far on the bend."""
        prior = np.diag([0.2**-2] * 3 + [5.0**-2] * 3 + [0.0] * 2)
        prior[6:, 6:] = self._bend_information
        return prior

    def _follow_corners(
        self, grey: NDArray[np.uint8], predicted: GroundCamera
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the last picture's corners found again: full-size pixels (N, 2) and map positions (N, 2)."""
        map_m = self.camera.to_map(to_full(self._corners))
        guess = to_small(predicted.to_picture(map_m)).astype(np.float32)
        found, matched = _track(self._grey, grey, self._corners, guess, levels=3)
        return to_full(found[matched]), map_m[matched]

    def _learn_bend(self, information: NDArray[np.float64]) -> None:
        pose, bend = slice(0, 6), slice(6, 8)
        given_pose = np.linalg.solve(information[pose, pose] + 1e-9 * np.eye(6), information[pose, bend])
        marginal = information[bend, bend] - information[bend, pose] @ given_pose
        self._bend_information = self._bend_information + _BEND_LEARNING * 0.5 * (marginal + marginal.T)


def shows_ground(observation: Observation, pixel: NDArray[np.float64]) -> bool:
    """Return whether a picture has a measured pose that shows ground in its middle and at a pixel (2,)."""
    if observation.ego is None:
        return False
    camera = _posed(observation.camera, observation.ego)
    return camera.shows_ground() and camera.shows_ground(pixel)


def _posed(model: CameraModel, ego: EgoPose) -> GroundCamera:
    return GroundCamera(model, ego.T_world_camera.copy(), np.zeros(2))


def _gain(rgb: NDArray[np.uint8], background_rgb: NDArray[np.uint8], seen: NDArray[np.uint8], before: float) -> float:
    """Return the factor from a picture's brightness to the mosaic's, the median over pixels seen before; ``before`` if
    these are below 100.
    """
    step = (slice(None, None, _GAIN_STEP), slice(None, None, _GAIN_STEP))
    picture, background = rgb[step][..., 1].astype(np.float64), background_rgb[step][..., 1].astype(np.float64)
    usable = (seen[step] > 1) & (picture > 10) & (picture < 240) & (background > 10) & (background < 240)
    if np.count_nonzero(usable) < _GAIN_PIXELS:
        return before
    return float(np.median(background[usable] / picture[usable]))


def _match_to_mosaic(
    grey: NDArray[np.uint8],
    corners: NDArray[np.float64],
    background_rgb: NDArray[np.uint8],
    seen: NDArray[np.uint8],
    camera: GroundCamera,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Find ``corners`` (N, 2) of the picture in ``camera``'s view of the mosaic; return the pixels (M, 2) and map
    positions (M, 2) of those found.
    """
    small = to_small(corners)
    column, row = np.round(small).astype(int).T
    height, width = seen.shape
    inside = (column >= 0) & (row >= 0) & (column < width) & (row < height)
    inside[inside] = seen[row[inside], column[inside]] > 1
    small = small[inside].astype(np.float32)
    background = cv2.cvtColor(background_rgb, cv2.COLOR_RGB2GRAY)
    found, matched = _track(grey, background, small, small.copy(), levels=1)
    return to_full(small[matched]), camera.to_map(to_full(found[matched]))


def _track(
    before: NDArray[np.uint8],
    after: NDArray[np.uint8],
    points: NDArray[np.float32],
    guess: NDArray[np.float32],
    levels: int,
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Return positions (N, 2) of points in ``after`` by pyramidal Lucas-Kanade, and whether each was found."""
    if len(points) == 0:
        return points, np.zeros(0, bool)
    found, status, _ = cv2.calcOpticalFlowPyrLK(
        before,
        after,
        points[:, None],
        guess[:, None].copy(),
        winSize=(13, 13),
        maxLevel=levels,
        criteria=(cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 12, 0.02),
        flags=cv2.OPTFLOW_USE_INITIAL_FLOW,
    )
    return found[:, 0], status.ravel().astype(bool)


def _find_corners(grey: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Return the strongest corners (N, 2) of a shrunk picture."""
    corners = cv2.goodFeaturesToTrack(grey, _CORNERS, 0.005, _CORNER_DISTANCE_PX, blockSize=5)
    return np.empty((0, 2), np.float32) if corners is None else corners[:, 0]
