"""Semantic map of a town: the class of the surface that each pixel shows."""

from __future__ import annotations

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from scenarios.road_town.canvas import Canvas
from sim.world import World

CLASSES = ("sky", "road", "ground", "building", "vegetation", "vehicle", "person", "other")
"""Names of the classes, by code. ``road`` is the carriageway; that of a bridge is ``other``, as are kerbs, posts,
signs and what stands in gardens, their low hedges too. Cyclists are persons with what they ride.
"""
ROAD, GROUND = CLASSES.index("road"), CLASSES.index("ground")
_OF_CATEGORY = {
    "ground": "ground",
    "building": "building",
    "tree": "vegetation",
    "wood": "vegetation",
    "hedge": "vegetation",
    "vehicle": "vehicle",
    "passer-by": "person",
}
_CELL_M, _MOST_CELLS = 0.1, 8192


class Semantics:
    """Draws the semantic maps of a town's pictures."""

    def __init__(self, world: World, roads: shapely.Geometry, extent_m: float) -> None:
        """``roads``: outlines of the carriageways in a town of ``extent_m``."""
        classes = [CLASSES.index(_OF_CATEGORY.get(body.category, "other")) for body in world.bodies]
        # The sky's id is -1.
        self._of_body = np.array([*classes, CLASSES.index("sky")], np.uint8)
        size = min(round(extent_m / _CELL_M), _MOST_CELLS)
        canvas = Canvas(np.full((size, size, 1), GROUND, np.uint8), extent_m)
        canvas.area(roads, ROAD)
        self._ground = canvas.picture
        cell_m, half_m = extent_m / size, 0.5 * extent_m
        # From OpenCV's indices (column, row), whole numbers at centres, to places on the ground.
        self._ground_from_cells = np.array(
            [[cell_m, 0.0, 0.5 * cell_m - half_m], [0.0, -cell_m, half_m - 0.5 * cell_m], [0.0, 0.0, 1.0]]
        )

    def of(self, body_id: NDArray[np.int32], from_ground: NDArray[np.float64]) -> NDArray[np.uint8]:
        """Return the codes (H, W) of ``CLASSES``.

        Edges of roads are right to 0.1 m, in towns of more than 800 m along a side to an 8192th of it.

        Args:
            body_id: (H, W) index of the body seen; -1 for the sky.
            from_ground: see ``pixels_from_ground``.
        """
        codes = self._of_body[body_id]
        to_centres = np.array([[1.0, 0.0, -0.5], [0.0, 1.0, -0.5], [0.0, 0.0, 1.0]])
        H = to_centres @ from_ground @ self._ground_from_cells
        size = codes.shape[::-1]
        drawn = cv2.warpPerspective(self._ground, H, size, flags=cv2.INTER_NEAREST, borderValue=GROUND)
        codes[(codes == GROUND) & (drawn == ROAD)] = ROAD
        return codes
