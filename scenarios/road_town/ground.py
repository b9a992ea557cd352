"""The ground of a town: its texture, and its map of road, building and other ground.

OpenCV paints the texture from coarse to fine, each layer with its own grain: trackers that estimate motion from pixels
need corners everywhere, and real ground has them.
"""

from __future__ import annotations

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import affinity

from scenarios.road_town.blocks import PAVEMENT_WIDTH_M
from scenarios.road_town.canvas import (
    BEDS,
    CROPS,
    HEDGES,
    LAWNS,
    MEADOW,
    PATHS,
    YARDS,
    Canvas,
    Rgb,
    pick,
    rectangle,
    smooth_noise,
)
from scenarios.road_town.layout import BUILDING, OTHER, ROAD, Building, Layout
from scenarios.road_town.road_map import road_area
from scenarios.road_town.street_paint import paint_car_park, paint_streets, paint_zebras

MARGIN_M = 1.5
"""Least free ground between a pool's deck and houses, pavements, car parks, trunks and other pools."""
_SHARE = 0.14
_TRIES = 8
_BEHIND_M = (6.0, 11.0)
"""Distance of a pool's middle behind its house: terraces reach less far."""
_RIM_M, DECK_M = 0.35, 0.9
_RIM: Rgb = (186, 180, 168)
_SHALLOW, _DEEP = np.array([128.0, 172.0, 172.0]), np.array([44.0, 104.0, 128.0])
_DEPTHS = 6


def place_pools(layout: Layout, rng: np.random.Generator) -> list[shapely.Polygon]:
    """Draw the outlines of pools behind some houses, where their decks fit with ``MARGIN_M`` around."""
    houses = [shapely.Polygon(rectangle(b.centre_m, b.size_m[:2], b.yaw_rad)) for b in layout.buildings]
    parks = [shapely.Polygon(rectangle(park.centre_m, park.size_m, park.yaw_rad)) for park in layout.car_parks]
    trunks = [shapely.Point(tree.centre_m).buffer(0.5) for tree in layout.trees]
    others = [each.rectangle for each in layout.props]
    others += [place for each in layout.overpasses for place in (each.rectangle, *each.solids)]
    things = [shapely.Polygon(rectangle(*place)) for place in others]
    taken = shapely.STRtree([*houses, *parks, *trunks, *things, road_area(layout.graph).buffer(PAVEMENT_WIDTH_M)])
    half_m = 0.5 * layout.extent_m - MARGIN_M
    inside = shapely.box(-half_m, -half_m, half_m, half_m)
    pools: list[shapely.Polygon] = []
    for building in layout.buildings:
        if rng.random() >= _SHARE:
            continue
        for _ in range(_TRIES):
            pool = _draw_pool(building, rng)
            around = pool.buffer(DECK_M + MARGIN_M)
            is_free = not len(taken.query(around, predicate="intersects"))
            if is_free and inside.contains(around) and not any(around.intersects(other) for other in pools):
                pools.append(pool)
                break
    return pools


def _draw_pool(building: Building, rng: np.random.Generator) -> shapely.Polygon:
    """Draw a pool behind a house: a rectangle with round corners, or two discs grown together."""
    length, width = float(rng.uniform(4.5, 7.5)), float(rng.uniform(2.6, 3.8))
    if rng.random() < 0.6:
        corner = float(rng.uniform(0.7, 0.5 * width - 0.1))
        shape = shapely.box(-0.5 * length + corner, -0.5 * width + corner, 0.5 * length - corner, 0.5 * width - corner)
        shape = shape.buffer(corner)
    else:
        ends = [shapely.Point(side * 0.25 * length, 0.12 * side * width).buffer(0.5 * width) for side in (-1.0, 1.0)]
        shape = shapely.union_all(ends).buffer(0.8).buffer(-0.8)
    c, s = np.cos(building.yaw_rad), np.sin(building.yaw_rad)
    along = float(rng.uniform(-0.4, 0.4)) * building.size_m[0]
    behind = -0.5 * building.size_m[1] - float(rng.uniform(*_BEHIND_M))
    x, y = building.centre_m[0] + c * along - s * behind, building.centre_m[1] + s * along + c * behind
    turn_deg = float(np.degrees(building.yaw_rad) + rng.normal(0.0, 6.0))
    return affinity.translate(affinity.rotate(shape, turn_deg, origin=(0.0, 0.0)), x, y)


def paint_pool(canvas: Canvas, pool: shapely.Polygon, rng: np.random.Generator) -> None:
    """Paint a deck, the rim, and water that grows darker towards the deep end."""
    canvas.area(pool.buffer(DECK_M), pick(PATHS, rng))
    canvas.area(pool.buffer(_RIM_M), pick((_RIM,), rng, 5.0))
    tint = rng.normal(0.0, 7.0, 3)
    turn = np.exp(2j * np.pi * rng.random())
    for step in range(_DEPTHS):
        share = step / (_DEPTHS - 1)
        deep = affinity.translate(pool.buffer(-0.2 * step), 0.12 * step * turn.real, 0.12 * step * turn.imag)
        canvas.area(deep.intersection(pool), _water(share, tint))


def _water(depth_share: float, tint: NDArray[np.float64]) -> Rgb:
    red, green, blue = np.clip(_SHALLOW + depth_share * (_DEEP - _SHALLOW) + tint, 0, 255).astype(int).tolist()
    return red, green, blue


_FIELDS = 9
_PATHS = 14
_HUE_CELLS = 96
_TUFT_GROUPS = 1500
_TUFTS: tuple[Rgb, ...] = ((62, 78, 42), (54, 66, 40), (126, 128, 84), (140, 124, 92), (112, 92, 68), (150, 152, 118))


def paint_land(layout: Layout, rng: np.random.Generator, size_px: int) -> NDArray[np.uint8]:
    """Return the land (size_px, size_px, 3) without paved areas: flat tones first, then variations of light and hue."""
    canvas = Canvas(np.full((size_px, size_px, 3), MEADOW, dtype=np.uint8), layout.extent_m)
    _paint_meadows(canvas, rng)
    _paint_fields(canvas, rng, _FIELDS)
    _paint_footpaths(canvas, rng)
    nearest = _nearest_building(layout, size_px)
    for index, building in enumerate(layout.buildings):
        _paint_plot(canvas, building, nearest, index, rng)
    _paint_tufts(canvas, rng)
    return _varied(canvas.picture, rng)


def paint_countryside(extent_m: float, rng: np.random.Generator, size_px: int, fields: int) -> NDArray[np.uint8]:
    """Return the picture (size_px, size_px, 3) of a square of land without houses and streets."""
    canvas = Canvas(np.full((size_px, size_px, 3), MEADOW, dtype=np.uint8), extent_m)
    _paint_meadows(canvas, rng)
    _paint_fields(canvas, rng, fields)
    _paint_footpaths(canvas, rng)
    _paint_tufts(canvas, rng)
    canvas.picture = _varied(canvas.picture, rng)
    canvas.grain(rng, 6.0)
    return canvas.picture


def furnish_gardens(canvas: Canvas, layout: Layout, rng: np.random.Generator) -> None:
    """Paint the details of gardens: terraces, beds, sheds' floors, garden paths, driveways."""
    for building in layout.buildings:
        frame = _HouseFrame(building)
        _paint_beds(canvas, frame, rng)
        if rng.random() < 0.6:
            _paint_terrace(canvas, frame, rng)
        if rng.random() < 0.7:
            side = float(rng.choice([-1.0, 1.0]))
            drive = (
                frame.place(0.5 * side, 0.0, (-2.0 * side, 0.0)),
                frame.place(0.5 * side, 0.5, (-2.0 * side, 13.0)),
            )
            canvas.bar(*drive, float(rng.uniform(2.4, 3.6)), pick((*PATHS, *YARDS), rng))
        path = (frame.place(0.0, 0.5, (0.0, -1.0)), frame.place(0.0, 0.5, (float(rng.normal(0, 1.0)), 12.0)))
        canvas.bar(*path, 1.1, pick(PATHS, rng))


def _varied(picture: NDArray[np.uint8], rng: np.random.Generator) -> NDArray[np.uint8]:
    """Return the picture with variations of lightness at several scales, and of hue at a large one."""
    size_px = len(picture)
    light = smooth_noise(rng, size_px, {24: 3.0, 128: 5.0, 400: 6.0, 1024: 7.0})
    hue = rng.normal(0.0, 3.5, (_HUE_CELLS, _HUE_CELLS, 3)).astype(np.float32)
    variation = cv2.resize(hue, (size_px, size_px))
    variation += light[..., None]
    return np.asarray(cv2.add(picture, variation, dtype=cv2.CV_8U))


class _HouseFrame:
    """Places beside a house; its street lies to its left (+y)."""

    def __init__(self, building: Building) -> None:
        c, s = np.cos(building.yaw_rad), np.sin(building.yaw_rad)
        self.building = building
        self._axes = np.array([[c, s], [-s, c]])

    def place(self, along: float, across: float, beyond_m: tuple[float, float]) -> NDArray[np.float64]:
        """Return a world place (2,) at fractions of the house's length and width, plus ``beyond_m`` along both."""
        size = np.array(self.building.size_m[:2])
        local = np.array([along, across]) * size + beyond_m
        world: NDArray[np.float64] = np.array(self.building.centre_m) + local @ self._axes
        return world


def _paint_meadows(canvas: Canvas, rng: np.random.Generator) -> None:
    """Paint soft patches of longer, drier or fresher grass."""
    half_m = 0.5 * canvas.extent_m
    for _ in range(260):
        centre, radius = rng.uniform(-half_m, half_m, 2), rng.uniform(2.0, 14.0)
        angles = np.sort(rng.uniform(0, 2 * np.pi, 9))
        reach = radius * rng.uniform(0.6, 1.2, 9)
        blob = centre + reach[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
        canvas.polygon(cv2.convexHull(blob.astype(np.float32))[:, 0], pick(LAWNS, rng, 10.0))
    cv2.blur(canvas.picture, (9, 9), dst=canvas.picture)


def _paint_tufts(canvas: Canvas, rng: np.random.Generator) -> None:
    """Paint weeds, bare spots, molehills, shrubs and their shade on the grass, in loose groups."""
    half_m = 0.5 * canvas.extent_m
    sizes = rng.integers(2, 9, _TUFT_GROUPS)
    middles = rng.uniform(-half_m, half_m, (_TUFT_GROUPS, 2))
    spreads = rng.uniform(1.0, 7.0, _TUFT_GROUPS)
    tones = [pick(_TUFTS, rng, 12.0) for _ in sizes]
    places = np.repeat(middles, sizes, axis=0)
    places += np.repeat(spreads, sizes)[:, None] * rng.normal(0.0, 1.0, places.shape)
    colours = [tone for tone, size in zip(tones, sizes, strict=True) for _ in range(size)]
    canvas.discs(places, rng.uniform(0.15, 0.55, len(places)), colours)


def _paint_fields(canvas: Canvas, rng: np.random.Generator, count: int) -> None:
    """Paint fields and allotments with rows, mostly near the edge of the land."""
    half_m = 0.5 * canvas.extent_m
    for _ in range(count):
        angle = rng.uniform(0, 2 * np.pi)
        centre = half_m * rng.uniform(0.5, 1.1) * np.array([np.cos(angle), np.sin(angle)])
        field = rectangle(centre, tuple(rng.uniform(22, 70, 2)), float(rng.uniform(0, np.pi)))
        _fill_striped(canvas, field, None, pick(CROPS, rng), float(rng.uniform(5, 14)), float(rng.uniform(1.0, 3.2)))


def _paint_footpaths(canvas: Canvas, rng: np.random.Generator) -> None:
    half_m = 0.5 * canvas.extent_m
    for _ in range(_PATHS):
        start, end = rng.uniform(-half_m, half_m, (2, 2))
        t = np.linspace(0, 1, 40)[:, None]
        swing = rng.normal(0, 12, (2, 2))
        line = start + (end - start) * t + swing[0] * np.sin(np.pi * t) + swing[1] * np.sin(2 * np.pi * t)
        canvas.line(line, float(rng.uniform(0.6, 1.7)), pick(PATHS, rng))


def _nearest_building(layout: Layout, size_px: int) -> NDArray[np.int32]:
    """Return the index of the nearest building for each pixel (size, size)."""
    footprints = Canvas(np.ones((size_px // 2, size_px // 2, 1), dtype=np.uint8), layout.extent_m)
    for building in layout.buildings:
        footprints.polygon(rectangle(building.centre_m, building.size_m[:2], building.yaw_rad), 0)
    _, labels = cv2.distanceTransformWithLabels(footprints.picture[..., 0], cv2.DIST_L2, cv2.DIST_MASK_5)
    index_of_label = np.full(labels.max() + 1, -1, dtype=np.int32)
    centres = np.array([building.centre_m for building in layout.buildings]).reshape(-1, 2)
    half_m = 0.5 * layout.extent_m
    cells = ((centres * (1, -1) + half_m) * len(labels) / layout.extent_m).astype(int)
    index_of_label[labels[cells[:, 1], cells[:, 0]]] = np.arange(len(centres))
    nearest = index_of_label[labels]
    return np.asarray(cv2.resize(nearest, (size_px, size_px), interpolation=cv2.INTER_NEAREST))


def _paint_plot(
    canvas: Canvas, building: Building, nearest: NDArray[np.int32], index: int, rng: np.random.Generator
) -> None:
    """Paint a plot up to the neighbours' plots: lawn, sometimes with mowing stripes, or yard; hedge or fence around it.

    Args:
        nearest: (size, size) index of the building that each pixel belongs to; ``index`` is this building's.
    """
    margin, depth = rng.uniform(4.0, 9.0), rng.uniform(6.0, 15.0)
    size = (building.size_m[0] + 2 * margin, building.size_m[1] + 12.0 + depth)
    frame = _HouseFrame(building)
    centre = frame.place(0.0, 0.0, (0.0, 0.5 * (12.0 - depth)))
    corners = rectangle(centre, size, building.yaw_rad)
    rows, columns, pixels = canvas.window(corners)
    mask = np.zeros((rows.stop - rows.start, columns.stop - columns.start), dtype=np.uint8)
    if not mask.size:
        return
    cv2.fillConvexPoly(mask, pixels, 1)
    mask &= nearest[rows, columns] == index
    kind = rng.random()
    tone = pick(LAWNS if kind < 0.75 else YARDS, rng, 10.0)
    stripes = float(rng.uniform(4, 8)) if kind < 0.25 else 0.0
    _fill_striped(canvas, corners, mask, tone, stripes, float(rng.uniform(1.0, 1.6)))
    if rng.random() < 0.75:
        outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        part = np.ascontiguousarray(canvas.picture[rows, columns])
        cv2.drawContours(part, outlines, -1, pick(HEDGES, rng), int(rng.integers(2, 6)), cv2.LINE_AA)
        canvas.picture[rows, columns] = part


def _fill_striped(
    canvas: Canvas,
    corners_m: NDArray[np.float64],
    mask: NDArray[np.uint8] | None,
    tone: Rgb,
    contrast: float,
    period_m: float,
) -> None:
    """Fill a rectangle, or its part in ``mask``, with rows along its first side."""
    rows, columns, pixels = canvas.window(corners_m)
    if rows.stop <= rows.start or columns.stop <= columns.start:
        return
    if mask is None:
        mask = np.zeros((rows.stop - rows.start, columns.stop - columns.start), dtype=np.uint8)
        cv2.fillConvexPoly(mask, pixels, 1)
    part, inside = canvas.picture[rows, columns], mask > 0
    if contrast == 0.0:
        part[inside] = tone
        return
    across = (pixels[3] - pixels[0]).astype(np.float32)
    across /= max(float(np.linalg.norm(across)), 1.0)
    period_px = period_m * len(canvas.picture) / canvas.extent_m
    y, x = np.mgrid[0 : mask.shape[0], 0 : mask.shape[1]].astype(np.float32)
    row = np.sign(np.sin((2 * np.pi / period_px) * (x * across[0] + y * across[1])))
    tones = np.array(tone, dtype=np.float32) + np.float32(contrast) * np.array([[-1], [0], [1]], dtype=np.float32)
    part[inside] = np.clip(tones, 0, 255).astype(np.uint8)[(row[inside] + 1).astype(np.intp)]


def _paint_beds(canvas: Canvas, frame: _HouseFrame, rng: np.random.Generator) -> None:
    for _ in range(int(rng.integers(2, 8))):
        place = frame.place(rng.uniform(-0.75, 0.75), rng.uniform(-0.6, 0.6), (0.0, float(rng.uniform(-7.0, 5.0))))
        if rng.random() < 0.5:
            size = (float(rng.uniform(0.8, 3.5)), float(rng.uniform(0.6, 1.6)))
            canvas.polygon(rectangle(place, size, frame.building.yaw_rad), pick(BEDS, rng, 14.0))
        else:
            canvas.disc(place, float(rng.uniform(0.3, 1.1)), pick((*HEDGES, *BEDS), rng, 12.0))


def _paint_terrace(canvas: Canvas, frame: _HouseFrame, rng: np.random.Generator) -> None:
    """Paint slabs behind the house, with joints."""
    along = float(rng.uniform(-0.25, 0.25))
    size = (float(rng.uniform(3.0, 6.0)), float(rng.uniform(2.5, 4.0)))
    tone = pick(PATHS, rng)
    centre = frame.place(along, -0.5, (0.0, -0.5 * size[1]))
    canvas.polygon(rectangle(centre, size, frame.building.yaw_rad), tone)
    joint: Rgb = (tone[0] - 22, tone[1] - 22, tone[2] - 22)
    for at in np.arange(-0.5 * size[0] + 0.6, 0.5 * size[0], 0.6):
        line = [frame.place(along, -0.5, (float(at), -depth)) for depth in (0.0, size[1])]
        canvas.line(np.array(line), 0.06, joint)


TEXTURE_PX = 4096
_LAND_GRAIN, _PAVED_GRAIN = 8.0, 4.5
_GRAVEL: Rgb = (128, 122, 112)
"""Ground under a viaduct."""


def paint_ground(layout: Layout, rng: np.random.Generator, size_px: int = TEXTURE_PX) -> NDArray[np.uint8]:
    """Return the ground's picture (size_px, size_px, 3) sRGB; its top is +y, its left -x."""
    land = paint_land(layout, rng, size_px // 2)
    picture = np.asarray(cv2.resize(land, (size_px, size_px), interpolation=cv2.INTER_LINEAR), dtype=np.uint8)
    canvas = Canvas(picture, layout.extent_m)
    canvas.grain(rng, _LAND_GRAIN)
    furnish_gardens(canvas, layout, rng)
    for pool in place_pools(layout, rng):
        paint_pool(canvas, pool, rng)
    for overpass in layout.overpasses:
        if overpass.piers_m:  # A viaduct, in whose shade no grass grows.
            canvas.polygon(rectangle(*overpass.rectangle), _GRAVEL)
    paint_streets(canvas, layout.graph, rng)
    paint_zebras(canvas, layout.graph, layout.zebras)
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
