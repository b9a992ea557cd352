"""Paints paved areas: pavements with kerbs, worn asphalt, road markings, car parks."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from scenarios.road_town.blocks import CAR_PARK_SETBACK_M, PAVEMENT_WIDTH_M
from scenarios.road_town.canvas import ASPHALT, KERB, MARKING, PAVEMENT, Canvas, Rgb, pick, rectangle
from scenarios.road_town.layout import CarPark, RoadGraph, Street
from scenarios.road_town.road_map import road_area

CROSSING_CLEAR_M = 10.0
"""Markings end at this distance from the middle of a crossing."""
EDGE_LINE_INSET_M = 0.5
_JOINT: Rgb = (132, 128, 122)
_SEAM: Rgb = (60, 60, 62)
_PIECE_M = 14.0
"""Length of road to which the density of small irregularities refers."""


def paint_streets(canvas: Canvas, graph: RoadGraph, rng: np.random.Generator) -> None:
    """Paint the whole network; the asphalt covers exactly ``road_area``."""
    area = road_area(graph)
    canvas.area(area.buffer(PAVEMENT_WIDTH_M), pick((PAVEMENT,), rng, 4.0))
    strips = [_Strip(canvas, street) for street in graph.streets]
    for strip in strips:
        _paint_slabs(strip, rng)
    canvas.area(area, pick(ASPHALT, rng, 3.0))
    for strip in strips:
        _paint_wear(strip, rng)
    canvas.outline(area, 0.22, KERB)
    for strip in strips:
        if strip.clear_m is not None:
            _paint_lines(strip, strip.clear_m)
            _paint_crossing_ends(strip, strip.clear_m, graph.right_sign, rng)


def paint_zebras(canvas: Canvas, graph: RoadGraph, zebras: Sequence[tuple[int, float]]) -> None:
    """Paint the places (street, arc_m) where people cross."""
    for street, arc_m in zebras:
        strip = _Strip(canvas, graph.streets[street])
        edge = strip.half_m - EDGE_LINE_INSET_M
        for left in np.arange(-edge + 0.2, edge, 1.0):
            bar = strip.at(arc_m + np.array([-1.3, 1.3]), left)
            canvas.bar(bar[0], bar[1], 0.5, MARKING)


def paint_car_park(canvas: Canvas, car_park: CarPark, rng: np.random.Generator) -> None:
    """Paint a car park: its entrance over the pavement, edge, asphalt, bays, oil and seams."""
    shade = pick(ASPHALT, rng, 6.0)
    length, width = car_park.size_m
    to_street = np.array([np.cos(car_park.yaw_rad), np.sin(car_park.yaw_rad)])
    middle = np.array(car_park.centre_m)
    canvas.polygon(rectangle(car_park.centre_m, (length + 0.5, width + 0.5), car_park.yaw_rad), KERB)
    corners = rectangle(car_park.centre_m, car_park.size_m, car_park.yaw_rad)
    canvas.polygon(corners, shade)
    canvas.bar(middle, middle + (0.5 * length + CAR_PARK_SETBACK_M + PAVEMENT_WIDTH_M) * to_street, 6.0, shade)
    for share in rng.uniform(0.15, 0.85, 2):
        ends = (
            corners[:2] * (1 - share) + corners[[3, 2]] * share,
            corners[[0, 3]] * (1 - share) + corners[1:3] * share,
        )
        canvas.line(ends[int(rng.integers(2))], 0.07, _SEAM)
    for x, y, facing in car_park.bays:
        ahead = np.array([np.cos(facing), np.sin(facing)])
        aside = 1.25 * np.array([-ahead[1], ahead[0]])
        for edge in (np.array([x, y]) - aside, np.array([x, y]) + aside):
            canvas.bar(edge - 2.4 * ahead, edge + 2.4 * ahead, 0.12, MARKING)
        if rng.random() < 0.5:
            canvas.disc(np.array([x, y]) + rng.normal(0, 0.5, 2), float(rng.uniform(0.15, 0.5)), _SEAM)


class _Strip:
    """A street with drawing functions along and across it.

    Attributes:
        length_m, half_m: length, and half the width.
        clear_m: distance from the ends to the markings, None if the street is too short for any.
    """

    def __init__(self, canvas: Canvas, street: Street) -> None:
        self.canvas = canvas
        self._centre_m = street.centre_m
        tangent = np.gradient(street.centre_m, axis=0)
        tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
        self._left = np.column_stack([-tangent[:, 1], tangent[:, 0]])
        # Contiguous copies, made once: ``at`` runs thousands of times.
        self._columns = [(self._centre_m[:, axis].copy(), self._left[:, axis].copy()) for axis in range(2)]
        self._places = np.arange(len(self._centre_m), dtype=float)
        self._step_m = float(np.linalg.norm(np.diff(street.centre_m, axis=0), axis=1).mean())
        self.length_m = self._step_m * (len(street.centre_m) - 1)
        self.half_m = 0.5 * street.width_m
        self.clear_m = CROSSING_CLEAR_M if self.length_m > 2 * CROSSING_CLEAR_M + 6.0 else None

    def at(self, along_m: NDArray[np.float64] | float, left_m: NDArray[np.float64] | float) -> NDArray[np.float64]:
        """Return world places (..., 2) of distances along the street and to the left of its centre line."""
        index = np.minimum(np.maximum(np.asarray(along_m) / self._step_m, 0), len(self._centre_m) - 1)
        left_m = np.asarray(left_m)
        world = np.empty((*np.broadcast_shapes(index.shape, left_m.shape), 2))
        for axis, (line, left) in enumerate(self._columns):
            world[..., axis] = np.interp(index, self._places, line) + np.interp(index, self._places, left) * left_m
        return world

    def along(self, start_m: float, end_m: float, left_m: float, width_m: float, colour: Rgb) -> None:
        """Draw a line along the street."""
        count = max(2, round(abs(end_m - start_m)) + 1)
        self.canvas.line(self.at(np.linspace(start_m, end_m, count), left_m), width_m, colour)

    def across(self, along_m: float, from_left_m: float, to_left_m: float, width_m: float, colour: Rgb) -> None:
        """Draw a square-ended bar across the street."""
        self.canvas.bar(self.at(along_m, from_left_m), self.at(along_m, to_left_m), width_m, colour)


def _paint_slabs(strip: _Strip, rng: np.random.Generator) -> None:
    """Paint the joints of the pavement's slabs, and a replaced slab here and there."""
    outer, middle = strip.half_m + PAVEMENT_WIDTH_M, strip.half_m + 0.5 * PAVEMENT_WIDTH_M
    for side in (-1, 1):
        for along in np.arange(0.5, strip.length_m, 1.9):
            if rng.random() < 0.05:
                slab = strip.at(
                    np.array([along, along + 1.9, along + 1.9, along]), side * np.array([middle, middle, outer, outer])
                )
                strip.canvas.polygon(slab, pick((PAVEMENT, _JOINT), rng, 9.0))
            strip.canvas.line(strip.at(np.array([along, along]), side * np.array([strip.half_m, outer])), 0.08, _JOINT)
        strip.along(0.0, strip.length_m, side * middle, 0.06, _JOINT)


def _paint_wear(strip: _Strip, rng: np.random.Generator) -> None:
    """Paint a street's surface with wheel tracks and a seam, then patches, cracks, manholes and gullies."""
    shade = pick(ASPHALT, rng, 4.0)
    if strip.clear_m is not None:
        start, end = strip.clear_m - 1.0, strip.length_m - strip.clear_m + 1.0
        corners = strip.at(np.linspace(start, end, max(2, round(end - start))), 0.0)
        strip.canvas.line(corners, 2 * strip.half_m - 0.1, shade)
        for lane in (-0.5, 0.5):
            strip.along(start, end, lane * strip.half_m, 0.5, _toned(shade, 4))
            for track in (-0.8, 0.8):
                strip.along(start, end, lane * strip.half_m + track, 0.55, _toned(shade, -7))
        strip.along(start, end, 0.25, 0.07, _toned(shade, -24))
    for _ in range(max(3, int(strip.length_m / _PIECE_M * rng.uniform(1.5, 3.0)))):
        along, left = float(rng.uniform(3.0, strip.length_m - 3.0)), float(rng.uniform(-0.85, 0.85)) * strip.half_m
        _WEAR[int(rng.choice(len(_WEAR), p=_WEAR_SHARES))](strip, along, left, shade, rng)


def _paint_patch(strip: _Strip, along_m: float, left_m: float, shade: Rgb, rng: np.random.Generator) -> None:
    length, width = rng.uniform(0.8, 4.5), rng.uniform(0.6, 1.8)
    left = np.clip(left_m + width * np.array([-0.5, -0.5, 0.5, 0.5]), -strip.half_m + 0.2, strip.half_m - 0.2)
    corners = strip.at(along_m + length * np.array([-0.5, 0.5, 0.5, -0.5]), left)
    strip.canvas.polygon(corners, _toned(shade, int(rng.normal(-4, 12))))
    strip.canvas.line(np.concatenate([corners, corners[:1]]), 0.08, _SEAM)


def _paint_trench(strip: _Strip, along_m: float, left_m: float, shade: Rgb, rng: np.random.Generator) -> None:
    far = float(np.sign(left_m)) * (strip.half_m - 0.25)
    strip.across(
        along_m, far, float(rng.uniform(-0.2, 0.2)) - 0.5 * far, float(rng.uniform(0.5, 1.1)), _toned(shade, -15)
    )


def _paint_crack(strip: _Strip, along_m: float, left_m: float, shade: Rgb, rng: np.random.Generator) -> None:
    walk = np.cumsum(rng.normal(0, 0.35, (10, 2)) + rng.normal(0, 0.4, 2), axis=0)
    left = np.clip(left_m + walk[:, 1], -strip.half_m + 0.2, strip.half_m - 0.2)
    strip.canvas.line(strip.at(np.clip(along_m + walk[:, 0], 0, strip.length_m), left), 0.06, _toned(shade, -26))


def _paint_manhole(strip: _Strip, along_m: float, left_m: float, shade: Rgb, rng: np.random.Generator) -> None:
    place = strip.at(along_m, 0.8 * left_m)
    strip.canvas.disc(place, 0.48, _toned(shade, int(rng.normal(8, 6))))
    strip.canvas.disc(place, 0.33, (58, 57, 56))


def _paint_gully(strip: _Strip, along_m: float, left_m: float, shade: Rgb, rng: np.random.Generator) -> None:
    side = float(np.sign(left_m))
    strip.across(along_m, side * (strip.half_m - 0.55), side * (strip.half_m - 0.1), 0.5, (46, 46, 47))
    strip.canvas.disc(strip.at(along_m, side * (strip.half_m - 0.9)), float(rng.uniform(0.3, 0.7)), _toned(shade, -9))


_WEAR = (_paint_patch, _paint_trench, _paint_crack, _paint_manhole, _paint_gully)
_WEAR_SHARES = (0.28, 0.12, 0.30, 0.14, 0.16)


def _paint_lines(strip: _Strip, clear_m: float) -> None:
    """Paint edge lines and the dashed centre line."""
    for side in (-1, 1):
        strip.along(clear_m, strip.length_m - clear_m, side * (strip.half_m - EDGE_LINE_INSET_M), 0.18, MARKING)
    for start in np.arange(clear_m + 1.0, strip.length_m - clear_m - 3.0, 6.0):
        strip.canvas.bar(strip.at(start, 0.0), strip.at(start + 3.0, 0.0), 0.15, MARKING)


def _paint_crossing_ends(strip: _Strip, clear_m: float, right_sign: float, rng: np.random.Generator) -> None:
    """Paint a stop line at each end on the arriving lane, and some zebra crossings."""
    edge = strip.half_m - EDGE_LINE_INSET_M
    for along, outward in ((clear_m, -1.0), (strip.length_m - clear_m, 1.0)):
        strip.across(along, 0.0, -right_sign * outward * edge, 0.4, MARKING)
        if rng.random() < 0.4:
            for left in np.arange(-edge + 0.2, edge, 1.0):
                bar = strip.at(along + outward * np.array([0.7, 3.3]), left)
                strip.canvas.bar(bar[0], bar[1], 0.5, MARKING)


def _toned(colour: Rgb, by: int) -> Rgb:
    r, g, b = (int(np.clip(c + by, 0, 255)) for c in colour)
    return r, g, b
