"""What snow and rain leave on a town's ground: how readily each place is covered, for ``sim.shaders.ground_map``.

Snow lies longest on roofs and open land; streets are cleared but for their edges, and tyres leave bare tracks. Water
stands in the gutters, in the tracks of tyres and in hollows of the asphalt; soil takes it in.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from scenarios.road_town.blocks import PAVEMENT_WIDTH_M
from scenarios.road_town.canvas import Canvas, rectangle, smooth_noise
from scenarios.road_town.layout import Layout
from scenarios.road_town.road_map import road_area

CoverKind = Literal["none", "snow", "rain"]
_PLACES: dict[CoverKind, dict[str, float]] = {
    # p of each kind of place, see ``sim.shaders.all_weather``.
    "snow": {
        "land": 0.62,
        "pavement": 0.30,
        "road": 0.15,
        "track": 0.03,
        "edge": 0.34,
        "car park": 0.30,
        "roof": 0.95,
        "crown": 0.36,
    },
    "rain": {
        "land": 0.06,
        "pavement": 0.22,
        "road": 0.20,
        "track": 0.30,
        "edge": 0.46,
        "car park": 0.24,
        "roof": 0.24,
        "crown": 0.0,
    },
}
_NOISE: dict[CoverKind, dict[float, float]] = {
    "snow": {0.6: 0.05, 2.5: 0.07, 11.0: 0.07},
    "rain": {0.8: 0.04, 2.2: 0.11, 7.0: 0.12},
}
"""Size in metres of lumps -> standard deviation of p."""
_TRACK_M, _TRACK_WIDTH_M, _EDGE_WIDTH_M = 0.8, 0.5, 0.7
_SLACK = 2
"""A margin of texels that show what lies beyond the town."""


def paint_cover(
    layout: Layout, kind: CoverKind, size_px: int, side_m: float, rng: np.random.Generator
) -> NDArray[np.uint8]:
    """Return p of 255 (size_px, size_px) on a square of ``side_m`` around the town's middle; 0 without snow or rain."""
    if kind == "none":
        return np.zeros((size_px, size_px), np.uint8)
    p = {name: round(255 * share) for name, share in _PLACES[kind].items()}
    canvas = Canvas(np.full((size_px, size_px, 1), p["land"], dtype=np.uint8), side_m)
    area = road_area(layout.graph)
    canvas.area(area.buffer(PAVEMENT_WIDTH_M), p["pavement"])
    canvas.area(area, p["road"])
    canvas.outline(area.buffer(-0.5 * _EDGE_WIDTH_M), _EDGE_WIDTH_M, p["edge"])
    for street in layout.graph.streets:
        along = np.gradient(street.centre_m, axis=0)
        left = np.column_stack([-along[:, 1], along[:, 0]]) / np.linalg.norm(along, axis=1, keepdims=True)
        for lane in (-0.25, 0.25):
            for track in (-_TRACK_M, _TRACK_M):
                line = street.centre_m + (lane * street.width_m + track) * left
                canvas.line(line, _TRACK_WIDTH_M, p["track"])
    for park in layout.car_parks:
        canvas.polygon(rectangle(park.centre_m, park.size_m, park.yaw_rad), p["car park"])
    for building in layout.buildings:
        grown = building.size_m[0] + 0.8, building.size_m[1] + 0.8
        canvas.polygon(rectangle(building.centre_m, grown, building.yaw_rad), p["roof"])
    for tree in layout.trees:
        canvas.disc(np.array(tree.centre_m), tree.radius_m, p["crown"])
    lumps = {max(round(side_m / lump), 2): 255.0 * deviation for lump, deviation in _NOISE[kind].items()}
    noise = smooth_noise(rng, size_px, lumps)
    covered = np.clip(canvas.picture[..., 0] + noise, 0, 255).astype(np.uint8)
    # Bare tracks stay bare.
    low = canvas.picture[..., 0] < 30
    covered[low] = np.minimum(covered[low], 2 * canvas.picture[..., 0][low] + 10)
    covered[:_SLACK], covered[-_SLACK:] = p["land"], p["land"]
    covered[:, :_SLACK], covered[:, -_SLACK:] = p["land"], p["land"]
    return covered
