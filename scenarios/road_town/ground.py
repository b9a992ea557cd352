"""The ground of a town: its texture, and its map of road, building and other ground.

OpenCV paints the texture from coarse to fine, each layer with its own grain: trackers that estimate motion from pixels
need corners everywhere, and real ground has them.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from scenarios.road_town.canvas import Canvas, rectangle
from scenarios.road_town.land_paint import furnish_gardens, paint_land
from scenarios.road_town.layout import BUILDING, OTHER, ROAD, Layout
from scenarios.road_town.pools import paint_pool, place_pools
from scenarios.road_town.road_map import road_area
from scenarios.road_town.street_paint import paint_car_park, paint_streets

TEXTURE_PX = 4096
_LAND_GRAIN, _PAVED_GRAIN = 8.0, 4.5


def paint_ground(layout: Layout, rng: np.random.Generator, size_px: int = TEXTURE_PX) -> NDArray[np.uint8]:
    """Return the ground's picture (size_px, size_px, 3) sRGB; its top is +y, its left -x."""
    land = paint_land(layout, rng, size_px // 2)
    picture = np.asarray(cv2.resize(land, (size_px, size_px), interpolation=cv2.INTER_LINEAR), dtype=np.uint8)
    canvas = Canvas(picture, layout.extent_m)
    canvas.grain(rng, _LAND_GRAIN)
    furnish_gardens(canvas, layout, rng)
    for pool in place_pools(layout, rng):
        paint_pool(canvas, pool, rng)
    paint_streets(canvas, layout.graph, rng)
    for car_park in layout.car_parks:
        paint_car_park(canvas, car_park, rng)
    canvas.grain(rng, _PAVED_GRAIN)
    return canvas.picture


def class_map(layout: Layout, resolution_m: float) -> NDArray[np.uint8]:
    """Return ROAD, OTHER or BUILDING (paper A.3) for each cell (n, n) of ``resolution_m``; top is +y, left is -x.

    Raises:
        ValueError: if the resolution is not positive or coarser than the town.
    """
    if not 0.0 < resolution_m <= layout.extent_m:
        raise ValueError(f"resolution_m: expected more than 0 and at most {layout.extent_m:g}, got {resolution_m}")
    size_px = round(layout.extent_m / resolution_m)
    canvas = Canvas(np.full((size_px, size_px, 1), OTHER, dtype=np.uint8), layout.extent_m)
    for building in layout.buildings:
        canvas.polygon(rectangle(building.centre_m, building.size_m[:2], building.yaw_rad), BUILDING)
    canvas.area(road_area(layout.graph), ROAD)
    return canvas.picture[..., 0]
