"""One instant as the tracker sees it: sightings of people, in the frame of odometry."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.kernels.boxes import box_centre, box_size
from trackers.paper_b.candidates import Candidate, CandidateParameters, StereoView
from trackers.paper_b.robot_frame import Mounting
from trackers.stereo_people.look import Look, LookParameters, look_at
from trackers.stereo_people.tracks import Sighting
from trackers.types import Observation

_SURFACE_TO_AXIS_M = 0.1
"""What is seen of a person is so much nearer than his middle."""
_BOX_INSET = 0.2
"""At the sides of a box there is less of the person than of what is behind him."""


@dataclass(frozen=True)
class Scene:
    """One observation, with what is needed to make sightings of it.

    Attributes:
        observation: the pair. levels: (H', W', 3) logarithmic levels of the left picture, made smaller.
        mounting: of the camera. candidates: who may be a person. look: how people look.
        use_odometry: False: places are those in the robot's frame.
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
        """Return the sighting of what is seen of somebody of a height: pixels (N,) of the depth picture."""
        own = view.points_m.reshape(-1, 3)[pixels]
        return self._at(np.median(own[:, :2], axis=0).astype(float), np.nan, self._look(view, pixels, height_m))

    def in_box(self, box_xyxy: NDArray[np.float64]) -> Sighting:
        """Return the sighting of who fills a box (4,), if no distance is known: it is told by the box's height."""
        camera, usual_m = self.observation.camera, self.candidates.usual_height_m
        depth_m = camera.focal_px * usual_m / box_size(box_xyxy)[1]
        place_m = self.mounting.place_at(box_centre(box_xyxy), depth_m, camera)[:2]
        rows, columns = self.levels.shape[:2]
        x_min, y_min, x_max, y_max = box_xyxy * columns / camera.width_px
        inset = _BOX_INSET * (x_max - x_min)
        row, column = np.mgrid[0:rows, 0:columns] + 0.5
        inside = (column > x_min + inset) & (column < x_max - inset) & (row > y_min) & (row < y_max)
        # How far up the box a pixel lies stands for its height.
        heights_m = (usual_m * (y_max - row) / (y_max - y_min)).astype(np.float32)
        look = look_at(self.levels, heights_m, np.flatnonzero(inside), usual_m, self.look)
        return self._at(place_m, np.nan, look)

    def to_ground(self, place_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Take a place (2,) from the robot's frame to that of odometry."""
        if self.observation.ego is None or not self.use_odometry:
            return place_m
        T = self.observation.ego.T_world_camera
        return _rotation(T) @ place_m + T[:2, 3]

    def to_robot(self, place_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Take a place (2,) from the frame of odometry to the robot's."""
        if self.observation.ego is None or not self.use_odometry:
            return place_m
        T = self.observation.ego.T_world_camera
        return _rotation(T).T @ (place_m - T[:2, 3])

    def _look(self, view: StereoView, pixels: NDArray[np.int64], height_m: float) -> Look:
        usual_m = height_m if np.isfinite(height_m) else self.candidates.usual_height_m
        return look_at(self.levels, view.points_m[..., 2], pixels, usual_m, self.look)

    def _at(self, surface_m: NDArray[np.float64], height_m: float, look: Look) -> Sighting:
        """Return a sighting by the place (2,) of the surface in the robot's frame."""
        distance_m = max(float(np.hypot(*surface_m)), 1e-6)
        middle_m = surface_m * (1.0 + _SURFACE_TO_AXIS_M / distance_m)
        return Sighting(self.to_ground(middle_m), distance_m, height_m, look)


def _rotation(T_world_camera: NDArray[np.float64]) -> NDArray[np.float64]:
    cosine, sine = T_world_camera[:2, 2] / max(float(np.hypot(*T_world_camera[:2, 2])), 1e-9)
    return np.array([[cosine, -sine], [sine, cosine]])
