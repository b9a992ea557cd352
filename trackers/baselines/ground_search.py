"""Search for a car on the ground: around its expected place, in a radius that grows while the car is missed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackers.baselines.ground_looks import Look, Patch
from trackers.baselines.ground_view import GroundViews
from trackers.kernels.boxes import apparent_length_px, box_around, box_centre, box_size
from trackers.registry import tunable
from trackers.types import Observation

CELLS = 20
"""Cells of a patch along the car."""
_FARTHEST_M = 120.0
"""Largest search radius. Chosen: it bounds the patch of a view that shows the horizon, which has no end of its own."""
_FIRST_PATCH = 3 * CELLS
_SHORTEST_M, _LONGEST_M = 1.0, 30.0
_LEAST_SCALE, _LARGEST_SCALE = 0.1, 10.0
_INSIDE_LEVEL = 127


@dataclass(frozen=True)
class SearchParameters:
    """Settings of a search.

    Attributes:
        reach_lengths: search radius around the expected place, in lengths of the car.
        least_similarity: a match below this similarity is rejected.
        least_similarity_lost: the same once the car is lost.
        lost_frames: number of frames without a match after which the car is lost.
    """

    reach_lengths: float = tunable(0.6, 0.2, 2.0, log=True)
    least_similarity: float = tunable(0.85, 0.3, 0.98)
    least_similarity_lost: float = tunable(0.92, 0.3, 0.99)
    lost_frames: int = tunable(4, 1, 30)


class Match(NamedTuple):
    """A match: place (2,) in metres, and whether the car was lost before."""

    place_m: NDArray[np.float64]
    was_lost: bool


class GroundSearch:
    """Looks for the car of the first picture in each next one.

    Attributes:
        start_m: (2,) its place in the first picture.
        view: the latest picture's view of the ground.
        missed_s: time since the last match.
    """

    def __init__(
        self,
        observation: Observation,
        box_xyxy: NDArray[np.float64],
        look: Callable[[Patch], Look],
        parameters: SearchParameters,
    ) -> None:
        """Start on the box (4,) of the first picture.

        Args:
            look: makes a look from a patch around the car, three of its lengths wide.

        Raises:
            ValueError: for a box that is none, or does not overlap the picture.
        """
        self._size_px = box_size(box_xyxy)
        _check_overlap(box_xyxy, observation)
        self._parameters = parameters
        self._views = GroundViews(observation, box_xyxy)
        self.view = self._views.view
        self.start_m = self.view.to_ground(box_centre(box_xyxy)[None])[0]
        self._first_scale = self.view.scale(self.start_m)
        self._length_m = float(np.clip(apparent_length_px(box_xyxy) / self._first_scale, _SHORTEST_M, _LONGEST_M))
        self._cell_m = self._length_m / CELLS
        corner_m = self.start_m - 0.5 * _FIRST_PATCH * self._cell_m
        first = self.view.rectified(observation.image_rgb, corner_m, (_FIRST_PATCH, _FIRST_PATCH), self._cell_m)
        self._look = look(first)
        self._turn_rad, self._missed_frames, self.missed_s = 0.0, 0, 0.0

    @property
    def is_lost(self) -> bool:
        """Whether the car was not matched for ``lost_frames``."""
        return self._missed_frames >= self._parameters.lost_frames

    def follow(self, observation: Observation, seconds: float) -> bool:
        """Take the view of the next picture, ``seconds`` after the one before; return whether it shows ground."""
        self.missed_s += seconds
        view = self._views.next(observation)
        self.view = self.view if view is None else view
        return view is not None

    def match(self, image_rgb: NDArray[np.uint8], expected_m: NDArray[np.float64], slack_m: float) -> Match | None:
        """Return where in the latest picture the car is, within the search radius plus ``slack_m`` of a place (2,).

        The radius is 120 m at most.
        """
        is_lost = self.is_lost
        radius_m = min(self._parameters.reach_lengths * self._length_m + slack_m, _FARTHEST_M)
        found = self._find(image_rgb, expected_m, radius_m, is_lost)
        self._missed_frames += 1
        if found is None:
            return None
        self._missed_frames, self.missed_s = 0, 0.0
        return Match(found, is_lost)

    def box_xyxy(self, place_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the first box (4,) at a place (2,), larger or smaller with the scale there."""
        scale = float(np.clip(self.view.scale(place_m) / self._first_scale, _LEAST_SCALE, _LARGEST_SCALE))
        return box_around(self.view.to_picture(place_m[None])[0], scale * self._size_px)

    def _find(
        self, image_rgb: NDArray[np.uint8], centre_m: NDArray[np.float64], radius_m: float, is_lost: bool
    ) -> NDArray[np.float64] | None:
        """Return the place (2,) of a good enough match in the square around a place, inside the picture."""
        p = self._parameters
        window = self._window(centre_m, radius_m)
        if window is None:
            return None
        corner_m, size = window
        patch = self.view.rectified(image_rgb, corner_m, size, self._cell_m)
        allowed = self._allowed(image_rgb, corner_m, size)
        spot = self._look.anywhere(patch, allowed) if is_lost else self._look.near(patch, allowed, self._turn_rad)
        if spot is None or spot.similarity < (p.least_similarity_lost if is_lost else p.least_similarity):
            return None
        self._turn_rad = spot.turn_rad
        return corner_m + self._cell_m * spot.centre

    def _window(
        self, centre_m: NDArray[np.float64], radius_m: float
    ) -> tuple[NDArray[np.float64], tuple[int, int]] | None:
        """Return corner (2,) and size (columns, rows) of the patch that covers a square on the ground, as far as the
        picture shows it, with the look's margin; None if it shows nothing of it.
        """
        low_m, high_m = centre_m - radius_m, centre_m + radius_m
        corners_m = self.view.footprint_m()
        if np.isfinite(corners_m).all():
            low_m, high_m = np.maximum(low_m, corners_m.min(axis=0)), np.minimum(high_m, corners_m.max(axis=0))
        if not (low_m < high_m).all():
            return None
        margin = self._look.margin_cells
        columns, rows = (np.ceil((high_m - low_m) / self._cell_m).astype(int) + 2 * margin).tolist()
        return low_m - margin * self._cell_m, (columns, rows)

    def _allowed(
        self, image_rgb: NDArray[np.uint8], corner_m: NDArray[np.float64], size: tuple[int, int]
    ) -> NDArray[np.bool_]:
        """Return which cells (rows, columns) of a patch may hold the car's centre: inside picture and margin."""
        (columns, rows), margin = size, self._look.margin_cells
        inside = np.full(image_rgb.shape[:2], 255, np.uint8)
        allowed = self.view.rectified(inside, corner_m, size, self._cell_m) > _INSIDE_LEVEL
        allowed[:margin] = allowed[rows - margin :] = False
        allowed[:, :margin] = allowed[:, columns - margin :] = False
        return allowed


def _check_overlap(box_xyxy: NDArray[np.float64], observation: Observation) -> None:
    width, height = observation.camera.width_px, observation.camera.height_px
    if not ((box_xyxy[2:] > 0.0).all() and (box_xyxy[:2] < [width, height]).all()):
        raise ValueError(
            f"box_xyxy: expected a box that overlaps the picture of {width} x {height} pixels, got "
            f"{np.asarray(box_xyxy).tolist()}"
        )
