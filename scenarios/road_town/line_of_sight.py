"""Whether houses, trees or overpasses of a layout stand between the helicopter and the car."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenarios.road_town.layout import Layout
from scenarios.road_town.overpasses import deck_boxes
from scenarios.visibility import MOSTLY_SEEN

_ROOF_SHARE = 0.2
"""Height of a sloping roof above the eaves as a box, as a share of the house's width."""
_CROWN_HEIGHT, _CROWN_RADIUS = 1.7, 0.85
"""Height of the middle of a crown, and radius of the sphere that hides what is behind it, in radii of the tree."""
_TARGET_POINTS = np.array([[x, y, 0.6] for x in (-0.35, 0.35) for y in (-0.3, 0.3)] + [[0.0, 0.0, 1.0]])
"""Points of the car, in shares of its length, width and height."""
_CAR_REACH_M = 2.5
"""Largest distance of these points from the car's place."""


class LineOfSight:
    """The houses of a town and the decks over its streets as boxes, the crowns of its trees as spheres."""

    def __init__(self, layout: Layout) -> None:
        houses, trees, decks = layout.buildings, layout.trees, deck_boxes(layout.overpasses)
        grounds = [(house.centre_m, house.size_m[:2], house.yaw_rad) for house in houses] + [each[0] for each in decks]
        self._box_m = np.array([centre_m for centre_m, _, _ in grounds]).reshape(-1, 2)
        self._half_m = 0.5 * np.array([size_m for _, size_m, _ in grounds]).reshape(-1, 2)
        roofs = [0.0 if house.roof == "flat" else _ROOF_SHARE * min(house.size_m[:2]) for house in houses]
        tops = [house.size_m[2] + roof_m for house, roof_m in zip(houses, roofs, strict=True)]
        self._low_m = np.array([0.0] * len(houses) + [low_m for _, low_m, _ in decks])
        self._top_m = np.array(tops + [top_m for _, _, top_m in decks])
        yaws = np.array([yaw_rad for _, _, yaw_rad in grounds])
        self._axis = np.column_stack([np.cos(yaws), np.sin(yaws)])
        radius_m = np.array([tree.radius_m for tree in trees])
        places_m = np.array([tree.centre_m for tree in trees]).reshape(-1, 2)
        self._crown_m = np.column_stack([places_m, _CROWN_HEIGHT * radius_m])
        self._crown_radius_m = _CROWN_RADIUS * radius_m
        self._places_m = np.concatenate([self._box_m, places_m])
        self._reach_m = np.concatenate([np.hypot(*self._half_m.T), radius_m]) + _CAR_REACH_M

    def is_hidden(
        self,
        camera_m: NDArray[np.float64],
        place_m: NDArray[np.float64],
        heading_rad: float,
        size_m: NDArray[np.float64],
    ) -> bool:
        """Return whether less than ``MOSTLY_SEEN`` of a car can be seen.

        Args:
            camera_m: (3,). place_m: (2,) of the car. size_m: (3,) its length, width, height.
        """
        near = self._near(camera_m[:2], place_m)
        if len(near) == 0:
            return False
        local = _TARGET_POINTS * size_m
        c, s = np.cos(heading_rad), np.sin(heading_rad)
        points = np.column_stack(
            [
                place_m[0] + c * local[:, 0] - s * local[:, 1],
                place_m[1] + s * local[:, 0] + c * local[:, 1],
                local[:, 2],
            ]
        )
        boxes, crowns = near[near < len(self._box_m)], near[near >= len(self._box_m)] - len(self._box_m)
        behind = self._behind_boxes(boxes, camera_m, points) | self._behind_crowns(crowns, camera_m, points)
        return bool(behind.mean() > 1.0 - MOSTLY_SEEN)

    def _near(self, camera_m: NDArray[np.float64], place_m: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return the indices of the boxes, and after them trees, that the line of sight may touch in the plan."""
        line, to_places = place_m - camera_m, self._places_m - camera_m
        along = np.clip(to_places @ line / max(float(line @ line), 1e-9), 0.0, 1.0)
        miss_m = to_places - along[:, None] * line
        return np.flatnonzero((miss_m**2).sum(axis=1) < self._reach_m**2)

    def _behind_boxes(
        self, boxes: NDArray[np.int64], camera_m: NDArray[np.float64], points_m: NDArray[np.float64]
    ) -> NDArray[np.bool_]:
        """Return whether a box stands between the camera and each point (P,): the slab test of rays and boxes."""
        axis, half_m, low_m, top_m = (each[boxes] for each in (self._axis, self._half_m, self._low_m, self._top_m))
        start = _in_boxes(camera_m[None], self._box_m[boxes], axis)
        ray = _in_boxes(points_m, self._box_m[boxes], axis) - start
        low = np.column_stack([-half_m, low_m])
        high = np.column_stack([half_m, top_m])
        with np.errstate(divide="ignore", invalid="ignore"):
            one, other = (low - start) / ray, (high - start) / ray
        enter = np.minimum(one, other).max(axis=2)
        leave = np.maximum(one, other).min(axis=2)
        return ((enter < leave) & (enter < 1.0) & (leave > 0.0)).any(axis=1)

    def _behind_crowns(
        self, crowns: NDArray[np.int64], camera_m: NDArray[np.float64], points_m: NDArray[np.float64]
    ) -> NDArray[np.bool_]:
        """Return whether a sphere stands between the camera and each point (P,)."""
        ray = points_m - camera_m
        to_crown = self._crown_m[crowns] - camera_m
        along = np.clip(ray @ to_crown.T / (ray**2).sum(axis=1)[:, None], 0.0, 1.0)
        miss_m = np.linalg.norm(along[..., None] * ray[:, None] - to_crown, axis=2)
        return (miss_m < self._crown_radius_m[crowns]).any(axis=1)


def _in_boxes(
    points_m: NDArray[np.float64], centre_m: NDArray[np.float64], axis: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return points (P, 3) in the frames of N boxes: (P, N, 3)."""
    offset = points_m[:, None, :2] - centre_m
    along = (offset * axis).sum(axis=2)
    across = offset[..., 1] * axis[:, 0] - offset[..., 0] * axis[:, 1]
    return np.stack([along, across, np.broadcast_to(points_m[:, None, 2], along.shape)], axis=2)
