"""Sightings of people on one frame, in the frame of odometry; at an expected place half-hidden people too."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.kernels.boxes import box_centre, box_size
from trackers.light_adaptive_stereo.candidates import Candidate, CandidateParameters
from trackers.light_adaptive_stereo.robot_frame import Mounting
from trackers.light_adaptive_stereo.stereo_view import StereoView
from trackers.stereo_people.look import Look, LookParameters, look_at
from trackers.stereo_people.tracks import Sighting
from trackers.types import Observation

_REACH_M, _LOW_M, _HIGH_M = 0.35, 0.35, 1.95
_STEPS = 3
_LEAST_POINTS = 60


def points_of_body(
    points_m: NDArray[np.float32], expected_m: NDArray[np.float64], taken: Sequence[NDArray[np.int64]]
) -> NDArray[np.int64] | None:
    """Return indices (N,) of the points (H, W, 3) around a place (2,) in the robot's frame; None if below 60.

    Three steps of mean shift with a radius of 0.35 m.

    Args:
        taken: indices of points that belong to other people.
    """
    flat = points_m.reshape(-1, 3)
    with np.errstate(invalid="ignore"):
        near = np.flatnonzero(
            (np.abs(flat[:, 0] - expected_m[0]) < 2 * _REACH_M)
            & (np.abs(flat[:, 1] - expected_m[1]) < 2 * _REACH_M)
            & (flat[:, 2] > _LOW_M)
            & (flat[:, 2] < _HIGH_M)
        )
    if taken:
        near = np.setdiff1d(near, np.concatenate(taken), assume_unique=True)
    middle_m, own = np.asarray(expected_m, dtype=float), near
    for _ in range(_STEPS):
        own = near[np.hypot(*(flat[near, :2] - middle_m).T) < _REACH_M]
        if len(own) < _LEAST_POINTS:
            return None
        middle_m = flat[own, :2].mean(axis=0).astype(float)
    return own


_SURFACE_TO_AXIS_M = 0.1
"""Distance from a person's visible surface to the body's axis."""
_BOX_INSET = 0.2
"""Share of a box's width left out at either side, which shows mostly background."""


@dataclass(frozen=True)
class Scene:
    """One observation and the parameters of its sightings.

    Attributes:
        observation: the stereo pair. levels: (H', W', 3) logarithmic levels of the reduced left picture.
        mounting: of the camera. candidates, look: parameters.
        use_odometry: if False, places stay in the robot's frame.
    """

    observation: Observation
    levels: NDArray[np.float64]
    mounting: Mounting
    candidates: CandidateParameters
    look: LookParameters
    use_odometry: bool

    def whole(self, view: StereoView, candidate: Candidate) -> Sighting:
        """Return the sighting of a candidate."""
        look = self._look(view, candidate.pixels, candidate.height_m)
        return self._at(candidate.place_m, np.nan if candidate.top_cut else candidate.height_m, look)

    def part(self, view: StereoView, pixels: NDArray[np.int64], height_m: float) -> Sighting:
        """Return the sighting of the visible part, pixels (N,) of the depth picture, of a person of a height."""
        own = view.points_m.reshape(-1, 3)[pixels]
        return self._at(np.median(own[:, :2], axis=0).astype(float), np.nan, self._look(view, pixels, height_m))

    def in_box(self, box_xyxy: NDArray[np.float64]) -> Sighting:
        """Return the sighting of a person who fills a box (4,), with the distance from the box's height."""
        camera, usual_m = self.observation.camera, self.candidates.usual_height_m
        depth_m = camera.focal_px * usual_m / box_size(box_xyxy)[1]
        place_m = self.mounting.place_at(box_centre(box_xyxy), depth_m, camera)[:2]
        rows, columns = self.levels.shape[:2]
        x_min, y_min, x_max, y_max = box_xyxy * columns / camera.width_px
        inset = _BOX_INSET * (x_max - x_min)
        row, column = np.mgrid[0:rows, 0:columns] + 0.5
        inside = (column > x_min + inset) & (column < x_max - inset) & (row > y_min) & (row < y_max)
        # No points are known: a pixel's height follows from its row in the box.
        heights_m = (usual_m * (y_max - row) / (y_max - y_min)).astype(np.float32)
        look = look_at(self.levels, heights_m, np.flatnonzero(inside), usual_m, self.look)
        return self._at(place_m, np.nan, look)

    def to_ground(self, place_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return a place (2,) of the robot's frame in the frame of odometry."""
        rotation, origin_m = self._robot_pose()
        return rotation @ place_m + origin_m

    def to_robot(self, place_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return a place (2,) of the frame of odometry in the robot's frame."""
        rotation, origin_m = self._robot_pose()
        return rotation.T @ (place_m - origin_m)

    def _robot_pose(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return rotation (2, 2) and origin (2,) of the robot's frame in the frame of odometry."""
        if self.observation.ego is None or not self.use_odometry:
            return np.eye(2), np.zeros(2)
        T = self.observation.ego.T_world_camera
        cosine, sine = T[:2, 2] / max(float(np.hypot(*T[:2, 2])), 1e-9)
        return np.array([[cosine, -sine], [sine, cosine]]), T[:2, 3]

    def _look(self, view: StereoView, pixels: NDArray[np.int64], height_m: float) -> Look:
        usual_m = height_m if np.isfinite(height_m) else self.candidates.usual_height_m
        return look_at(self.levels, view.points_m[..., 2], pixels, usual_m, self.look)

    def _at(self, surface_m: NDArray[np.float64], height_m: float, look: Look) -> Sighting:
        """Return a sighting from the place (2,) of the surface in the robot's frame."""
        distance_m = max(float(np.hypot(*surface_m)), 1e-6)
        middle_m = surface_m * (1.0 + _SURFACE_TO_AXIS_M / distance_m)
        return Sighting(self.to_ground(middle_m), distance_m, height_m, look)
