"""Paints the ground of a town: one picture of meadows, gardens, asphalt, markings, pavements and car parks.

Painted with OpenCV at the texture's resolution, coarse things first, each layer with grain of its own: trackers that
estimate motion from pixels need corners everywhere, and real ground has them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenarios.road_town.blocks import PAVEMENT_WIDTH_M
from scenarios.road_town.canvas import Canvas
from scenarios.road_town.layout import BUILDING, OTHER, ROAD, Building, CarPark, Layout, Street
from scenarios.road_town.palette import ASPHALT, LAWNS, MARKING, MEADOW, PAVEMENT, YARDS, Rgb, pick

TEXTURE_PX = 4096
_KERB_RGB: Rgb = (178, 175, 168)
_EDGE_LINE_INSET_M = 0.35
_CROSSING_CLEAR_M = 9.0
"""Markings end so far before the middle of a crossing."""


def paint_ground(layout: Layout, rng: np.random.Generator, size_px: int = TEXTURE_PX) -> NDArray[np.uint8]:
    """Return the ground's picture (size_px, size_px, 3) sRGB; its top is +y, its left -x."""
    canvas = Canvas(layout.extent_m, size_px)
    canvas.fill_with_noise(MEADOW, rng, {128: 10.0, 512: 9.0, 2048: 7.0})
    for building in layout.buildings:
        _paint_plot(canvas, building, rng)
    canvas.grain(rng, 7.0)
    for building in layout.buildings:
        _paint_driveway(canvas, building, layout, rng)
    _paint_streets(canvas, layout, rng)
    for car_park in layout.car_parks:
        _paint_car_park(canvas, car_park, rng)
    canvas.grain(rng, 4.0)
    return canvas.rgb


def class_map(layout: Layout, resolution_m: float) -> NDArray[np.uint8]:
    """Return ROAD, OTHER or BUILDING (paper A.3) for each cell (n, n) of ``resolution_m``; top is +y, left is -x."""
    canvas = Canvas(layout.extent_m, round(layout.extent_m / resolution_m), channels=1)
    canvas.rgb[:] = OTHER
    for building in layout.buildings:
        canvas.polygon(canvas.rectangle(building.centre_m, building.size_m[:2], building.yaw_rad), BUILDING)
    for street in layout.graph.streets:
        canvas.line(street.centre_m, street.width_m, ROAD)
    return canvas.rgb[..., 0]


def _paint_plot(canvas: Canvas, building: Building, rng: np.random.Generator) -> None:
    """Paint a house's garden: lawn or yard, beds, a hedge or fence about it, a path to the street."""
    size = (building.size_m[0] + rng.uniform(5, 9), building.size_m[1] + rng.uniform(8, 16))
    plot = canvas.rectangle(building.centre_m, size, building.yaw_rad)
    canvas.polygon(plot, pick(LAWNS if rng.random() < 0.72 else YARDS, rng))
    for _ in range(int(rng.integers(2, 6))):
        place = _inside(building, size, rng)
        bed = canvas.rectangle(place, tuple(rng.uniform(0.8, 3.5, 2)), building.yaw_rad)
        canvas.polygon(bed, pick((*YARDS, (72, 88, 48), (96, 78, 58), (120, 96, 88)), rng, 14.0))
    if rng.random() < 0.7:
        hedge = pick(((58, 78, 42), (66, 84, 46), (128, 118, 100)), rng)
        canvas.line(np.concatenate([plot, plot[:1]]), float(rng.uniform(0.3, 0.9)), hedge)


def _inside(building: Building, size_m: tuple[float, float], rng: np.random.Generator) -> tuple[float, float]:
    c, s = np.cos(building.yaw_rad), np.sin(building.yaw_rad)
    along, across = (rng.uniform(-0.46, 0.46) * side for side in size_m)
    return building.centre_m[0] + c * along - s * across, building.centre_m[1] + s * along + c * across


def _paint_driveway(canvas: Canvas, building: Building, layout: Layout, rng: np.random.Generator) -> None:
    """Paint a drive from beside the house to the street that it faces (its left side)."""
    if rng.random() < 0.35:
        return
    c, s = np.cos(building.yaw_rad), np.sin(building.yaw_rad)
    along = float(rng.choice([-1, 1])) * (0.5 * building.size_m[0] - 1.5)
    reach = 0.5 * building.size_m[1] + 11.0
    start = np.array(building.centre_m) + along * np.array([c, s])
    drive = np.stack([start, start + reach * np.array([-s, c])])
    canvas.line(drive, float(rng.uniform(2.4, 3.4)), pick((*ASPHALT, *YARDS, PAVEMENT), rng))


def _paint_streets(canvas: Canvas, layout: Layout, rng: np.random.Generator) -> None:
    streets = layout.graph.streets
    for street in streets:
        canvas.line(street.centre_m, street.width_m + 2 * PAVEMENT_WIDTH_M, pick((PAVEMENT,), rng, 4.0))
    for street in streets:
        _paint_slabs(canvas, street)
    for street in streets:
        canvas.line(street.centre_m, street.width_m + 0.4, _KERB_RGB)
    shades = [pick(ASPHALT, rng, 4.0) for _ in streets]
    for street, shade in zip(streets, shades, strict=True):
        canvas.line(street.centre_m, street.width_m, shade)
    for street, shade in zip(streets, shades, strict=True):
        _paint_wear(canvas, street, shade, rng)
    for street in streets:
        _paint_markings(canvas, street, rng)


def _paint_slabs(canvas: Canvas, street: Street) -> None:
    """Paint the joints between the pavement's slabs."""
    normal = _left_normals(street.centre_m)
    for k in range(0, len(street.centre_m), 2):
        for side in (-1, 1):
            edge = street.centre_m[k] + side * 0.5 * street.width_m * normal[k]
            canvas.line(np.stack([edge, edge + side * PAVEMENT_WIDTH_M * normal[k]]), 0.08, (132, 128, 122))


def _paint_wear(canvas: Canvas, street: Street, shade: Rgb, rng: np.random.Generator) -> None:
    """Paint wheel tracks, repaired patches, cracks and manholes."""
    normal = _left_normals(street.centre_m)
    darker: Rgb = (shade[0] - 7, shade[1] - 7, shade[2] - 7)
    for lane in (-0.25, 0.25):
        for track in (-0.85, 0.85):
            canvas.line(street.centre_m + (lane * street.width_m + track) * normal, 0.5, darker)
    for _ in range(max(2, len(street.centre_m) // 9)):
        k = int(rng.integers(len(street.centre_m)))
        aside = float(rng.uniform(-0.42, 0.42)) * street.width_m
        place = street.centre_m[k] + aside * normal[k]
        yaw = float(np.arctan2(-normal[k, 0], normal[k, 1]))
        kind = rng.random()
        if kind < 0.45:
            tone = int(rng.normal(0, 12))
            patch: Rgb = (shade[0] + tone, shade[1] + tone, shade[2] + tone)
            canvas.polygon(canvas.rectangle(place, tuple(rng.uniform(0.6, 3.0, 2)), yaw), patch)
        elif kind < 0.8:
            steps = rng.normal(0, 0.45, (9, 2)) + rng.normal(0, 0.6, 2)
            canvas.line(place + np.cumsum(steps, axis=0), 0.07, (58, 58, 60))
        else:
            canvas.disc(place, 0.35, (52, 52, 54))


def _paint_markings(canvas: Canvas, street: Street, rng: np.random.Generator) -> None:
    """Paint edge lines, the dashed centre line, stop lines and some zebra crossings."""
    points = street.centre_m
    spacing = float(np.linalg.norm(np.diff(points, axis=0), axis=1).mean())
    clear = round(_CROSSING_CLEAR_M / spacing)
    if len(points) < 2 * clear + 6:
        return
    normal = _left_normals(points)
    inner, inner_normal = points[clear:-clear], normal[clear:-clear]
    for side in (-1, 1):
        canvas.line(inner + side * (0.5 * street.width_m - _EDGE_LINE_INSET_M) * inner_normal, 0.16, MARKING)
    dash = max(2, round(3.0 / spacing))
    for k in range(0, len(inner) - dash, 2 * dash):
        canvas.line(inner[k : k + dash + 1], 0.14, MARKING)
    for end, sign in ((0, -1.0), (-1, 1.0)):
        at, across = inner[end], inner_normal[end]
        # Right-hand traffic: the lane that leads up to the crossing is on the side of -sign.
        stop = np.stack([at, at + sign * -1.0 * (0.5 * street.width_m - _EDGE_LINE_INSET_M) * across])
        canvas.line(stop, 0.4, MARKING)
        if rng.random() < 0.3:
            _paint_zebra(canvas, at, across, street.width_m, sign)


def _paint_zebra(
    canvas: Canvas, at: NDArray[np.float64], across: NDArray[np.float64], width_m: float, sign: float
) -> None:
    along = np.array([across[1], -across[0]]) * sign
    for place in np.arange(-0.5 * width_m + 0.7, 0.5 * width_m - 0.4, 1.0):
        start = at + place * across + 0.8 * along
        canvas.line(np.stack([start, start + 2.4 * along]), 0.5, MARKING)


def _paint_car_park(canvas: Canvas, car_park: CarPark, rng: np.random.Generator) -> None:
    canvas.polygon(canvas.rectangle(car_park.centre_m, car_park.size_m, car_park.yaw_rad), pick(ASPHALT, rng, 5.0))
    for x, y, facing in car_park.bays:
        direction = np.array([np.cos(facing), np.sin(facing)])
        across = np.array([-direction[1], direction[0]])
        for side in (-1.25, 1.25):
            edge = np.array([x, y]) + side * across
            canvas.line(np.stack([edge - 2.4 * direction, edge + 2.4 * direction]), 0.12, MARKING)
        if rng.random() < 0.5:
            canvas.disc(np.array([x, y]) + rng.normal(0, 0.5, 2), float(rng.uniform(0.2, 0.6)), (60, 60, 62))


def _left_normals(points_m: NDArray[np.float64]) -> NDArray[np.float64]:
    tangent = np.gradient(points_m, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    return np.column_stack([-tangent[:, 1], tangent[:, 0]])
