"""What stands between the streets: houses that face them, car parks, trees along kerbs and in gardens."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from scenarios.road_town.layout import Building, CarPark, Layout, RoadGraph, Tree
from scenarios.road_town.palette import FLAT_ROOFS, ROOFS, WALLS, pick

PAVEMENT_WIDTH_M = 2.0
BAY_SIZE_M = (5.0, 2.5)
_CELL_M = 0.5
_CAR_PARKS = 3
_HOUSES = 112
_STREET_TREES, _GARDEN_TREES = 45, 60
_PARKED_SHARE = 0.35
_MOST_PARKED = 30


def fill_blocks(graph: RoadGraph, rng: np.random.Generator, extent_m: float) -> Layout:
    """Return the town of a road graph: nothing overlaps a road, a pavement or anything else that stands.

    Args:
        extent_m: side of the square ground.
    """
    ground = _FreeGround(graph, extent_m)
    car_parks = _place_car_parks(graph, ground, rng)
    buildings = _place_houses(graph, ground, rng)
    trees = _place_trees(graph, ground, rng)
    return Layout(extent_m, graph, tuple(buildings), tuple(trees), tuple(car_parks))


class _FreeGround:
    """Which places are still free, on a grid of ``_CELL_M``."""

    def __init__(self, graph: RoadGraph, extent_m: float) -> None:
        self.half_m = 0.5 * extent_m
        side = round(extent_m / _CELL_M)
        self._taken = np.zeros((side, side), dtype=np.uint8)
        for street in graph.streets:
            line = self._cells(street.centre_m)
            width = street.width_m + 2 * PAVEMENT_WIDTH_M
            cv2.polylines(self._taken, [line], False, 1, round(width / _CELL_M) + 1)

    def take(self, centre_m: NDArray[np.float64], size_m: tuple[float, float], yaw_rad: float, margin_m: float) -> bool:
        """Take a rectangle if it is free and inside the town, with a margin; return whether it was."""
        corners = _rectangle(centre_m, (size_m[0] + 2 * margin_m, size_m[1] + 2 * margin_m), yaw_rad)
        if np.abs(corners).max() > self.half_m - 2.0:
            return False
        cells = self._cells(corners)
        low, high = cells.min(axis=0), cells.max(axis=0) + 1
        window = self._taken[low[1] : high[1], low[0] : high[0]]
        shape = np.zeros_like(window)
        cv2.fillConvexPoly(shape, cells - low, 1)
        if (window & shape).any():
            return False
        window |= shape
        return True

    def _cells(self, points_m: NDArray[np.float64]) -> NDArray[np.int32]:
        return np.floor((points_m + self.half_m) / _CELL_M).astype(np.int32)


def _rectangle(centre_m: NDArray[np.float64], size_m: tuple[float, float], yaw_rad: float) -> NDArray[np.float64]:
    c, s = np.cos(yaw_rad), np.sin(yaw_rad)
    half = 0.5 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * size_m
    return np.asarray(centre_m) + half @ np.array([[c, s], [-s, c]])


def _beside(
    graph: RoadGraph, rng: np.random.Generator, depth_m: float, setback_m: float
) -> tuple[NDArray[np.float64], float]:
    """Return a random place beside a street: centre of a thing ``depth_m`` deep, and the yaw of its front.

    The front is along the street; its left normal points to the street.
    """
    street = graph.streets[int(rng.integers(len(graph.streets)))]
    index = int(rng.integers(1, len(street.centre_m) - 1))
    along = street.centre_m[index + 1] - street.centre_m[index - 1]
    if rng.integers(2):
        along = -along
    along = along / np.linalg.norm(along)
    right = np.array([along[1], -along[0]])
    distance = 0.5 * street.width_m + PAVEMENT_WIDTH_M + setback_m + 0.5 * depth_m
    return street.centre_m[index] + distance * right, float(np.arctan2(along[1], along[0]))


def _place_houses(graph: RoadGraph, ground: _FreeGround, rng: np.random.Generator) -> list[Building]:
    buildings: list[Building] = []
    for _ in range(40 * _HOUSES):
        if len(buildings) == _HOUSES:
            break
        flat = rng.random() < 0.25
        length = float(rng.uniform(14, 24) if flat else rng.uniform(9, 17))
        width = float(rng.uniform(10, 15) if flat else rng.uniform(8, 11))
        centre, yaw = _beside(graph, rng, width, float(rng.uniform(2.5, 9.0)))
        yaw += float(rng.normal(0.0, 0.03))
        if not ground.take(centre, (length, width), yaw, 2.0):
            continue
        central = max(0.0, 1.0 - float(np.linalg.norm(centre)) / (0.8 * ground.half_m))
        height = float(rng.uniform(3.2, 6.5) + central * rng.uniform(0, 6.0) + (flat and rng.uniform(0, 4.0)))
        roof = "flat" if flat else ("hip" if rng.random() < 0.3 else "gable")
        roof_rgb = pick(FLAT_ROOFS if flat else ROOFS, rng)
        x, y = map(float, centre)
        buildings.append(Building((x, y), (length, width, height), yaw, roof, pick(WALLS, rng), roof_rgb))
    return buildings


def _place_car_parks(graph: RoadGraph, ground: _FreeGround, rng: np.random.Generator) -> list[CarPark]:
    """Place car parks with two rows of bays and a lane between them."""
    car_parks: list[CarPark] = []
    parked = 0
    for _ in range(200):
        if len(car_parks) == _CAR_PARKS:
            break
        columns = int(rng.integers(6, 11))
        size = (columns * BAY_SIZE_M[1] + 2.0, 2 * BAY_SIZE_M[0] + 7.0)
        centre, yaw = _beside(graph, rng, size[1], 2.5)
        if not ground.take(centre, size, yaw, 1.0):
            continue
        c, s = np.cos(yaw), np.sin(yaw)
        bays: list[tuple[float, float, float]] = []
        for row in (-1, 1):
            for column in range(columns):
                along = (column - 0.5 * (columns - 1)) * BAY_SIZE_M[1]
                across = row * 0.5 * (size[1] - BAY_SIZE_M[0])
                facing = yaw + row * 0.5 * np.pi
                bays.append(
                    (float(centre[0] + c * along - s * across), float(centre[1] + s * along + c * across), facing)
                )
        taken = []
        for _ in bays:
            taken.append(bool(rng.random() < _PARKED_SHARE) and parked < _MOST_PARKED)
            parked += taken[-1]
        x, y = map(float, centre)
        car_parks.append(CarPark((x, y), size, yaw, tuple(bays), tuple(taken)))
    return car_parks


def _place_trees(graph: RoadGraph, ground: _FreeGround, rng: np.random.Generator) -> list[Tree]:
    trees: list[Tree] = []
    for k in range(12 * (_STREET_TREES + _GARDEN_TREES)):
        if len(trees) == _STREET_TREES + _GARDEN_TREES:
            break
        beside_street = k % 2 == 0 and len(trees) < 2 * _STREET_TREES
        radius = float(rng.uniform(1.3, 2.2) if beside_street else rng.uniform(1.5, 3.6))
        if beside_street:
            centre, _ = _beside(graph, rng, 0.0, float(rng.uniform(0.9, 1.6)))
        else:
            centre = rng.uniform(-ground.half_m + 5, ground.half_m - 5, 2)
        # The trunk must stand free; the crown may reach over pavement and lawn.
        if ground.take(centre, (1.0, 1.0), 0.0, 0.2 if beside_street else 0.45 * radius):
            x, y = map(float, centre)
            trees.append(Tree((x, y), radius))
    return trees
