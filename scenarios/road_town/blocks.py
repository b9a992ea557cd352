"""Houses along the streets, car parks, and trees along kerbs and in gardens."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from scenarios.road_town.canvas import FLAT_ROOFS, ROOFS, WALLS, pick, rectangle, rings_of
from scenarios.road_town.layout import Building, CarPark, Layout, Rectangle, RoadGraph, Tree
from scenarios.road_town.road_map import road_area
from sim.meshes.file import mesh_of_file

PAVEMENT_WIDTH_M = 2.0
CAR_PARK_SETBACK_M = 2.5
BAY_SIZE_M = (5.0, 2.5)
_CELL_M = 0.5
_CAR_PARKS = 3
_HOUSES = 112
_STREET_TREES, _GARDEN_TREES, _COPSE_TREES = 40, 40, 30
_PARKED_SHARE = 0.5
_MOST_PARKED = 30
BUILDING_SIDES_M = (1.0, 120.0)
"""Longest side of a building from a file."""


def fill_blocks(
    graph: RoadGraph,
    rng: np.random.Generator,
    extent_m: float,
    models: Sequence[str] = ("house",),
    own: np.random.Generator | None = None,
) -> Layout:
    """Return the town of a road graph; its objects overlap no road, no pavement and not each other.

    Args:
        extent_m: side of the square ground.
        models: of buildings, each as often: ``house``, or files, which are placed before the houses.
        own: places files; None if there are none.
    """
    ground = FreeGround(graph, extent_m)
    car_parks = _place_car_parks(graph, ground, rng)
    files = [model for model in models if model != "house"]
    buildings = [] if own is None else _place_files(graph, ground, own, files, len(models))
    buildings = _place_houses(graph, ground, rng, buildings)
    trees = _place_trees(graph, buildings, ground, rng)
    return Layout(extent_m, graph, tuple(buildings), tuple(trees), tuple(car_parks))


class FreeGround:
    """A grid of ``_CELL_M`` that marks occupied ground."""

    def __init__(self, graph: RoadGraph, extent_m: float) -> None:
        self.half_m = 0.5 * extent_m
        side = round(extent_m / _CELL_M)
        self._taken = np.zeros((side, side), dtype=np.uint8)
        for street in graph.streets:
            line = self._cells(street.centre_m)
            width = street.width_m + 2 * PAVEMENT_WIDTH_M
            cv2.polylines(self._taken, [line], False, 1, round(width / _CELL_M) + 1)

    @classmethod
    def of(cls, layout: Layout) -> FreeGround:
        """Return the ground that a finished town leaves free."""
        ground = cls(layout.graph, layout.extent_m)
        pavements = road_area(layout.graph).buffer(PAVEMENT_WIDTH_M)
        rings = [ground._cells(shapely.get_coordinates(ring)) for ring in rings_of(pavements)]
        cv2.fillPoly(ground._taken, rings, 1)
        taken = [(each.centre_m, each.size_m[:2], each.yaw_rad) for each in layout.buildings]
        taken += [(each.centre_m, each.size_m, each.yaw_rad) for each in layout.car_parks]
        taken += [(each.centre_m, (1.0, 1.0), 0.0) for each in layout.trees]
        taken += [each.rectangle for each in layout.props]
        taken += [solid for each in layout.overpasses for solid in each.solids]
        for centre_m, size_m, yaw_rad in taken:
            ground.occupy((centre_m, (size_m[0] + 1.0, size_m[1] + 1.0), yaw_rad))
        return ground

    def take(self, centre_m: NDArray[np.float64], size_m: tuple[float, float], yaw_rad: float, margin_m: float) -> bool:
        """Occupy a rectangle with a margin if it is free and inside the town; return whether it was."""
        found = self._window(centre_m, (size_m[0] + 2 * margin_m, size_m[1] + 2 * margin_m), yaw_rad)
        if found is None:
            return False
        window, shape = found
        window |= shape
        return True

    def occupy(self, place: Rectangle) -> None:
        """Occupy a rectangle, free or not."""
        cv2.fillConvexPoly(self._taken, self._cells(rectangle(*place)), 1)

    def is_free(self, centre_m: NDArray[np.float64], size_m: tuple[float, float], yaw_rad: float) -> bool:
        """Return whether a rectangle is free and inside the town."""
        return self._window(centre_m, size_m, yaw_rad) is not None

    def _window(
        self, centre_m: NDArray[np.float64], size_m: tuple[float, float], yaw_rad: float
    ) -> tuple[NDArray[np.uint8], NDArray[np.uint8]] | None:
        """Return the part of the grid around a rectangle, and the rectangle in it; None if it is not free."""
        corners = rectangle(centre_m, size_m, yaw_rad)
        if np.abs(corners).max() > self.half_m - 2.0:
            return None
        cells = self._cells(corners)
        low, high = cells.min(axis=0), cells.max(axis=0) + 1
        window = self._taken[low[1] : high[1], low[0] : high[0]]
        shape = np.zeros_like(window)
        cv2.fillConvexPoly(shape, cells - low, 1)
        return None if (window & shape).any() else (window, shape)

    def _cells(self, points_m: NDArray[np.float64]) -> NDArray[np.int32]:
        return np.floor((points_m + self.half_m) / _CELL_M).astype(np.int32)


def _beside(
    graph: RoadGraph, rng: np.random.Generator, depth_m: float, setback_m: float
) -> tuple[NDArray[np.float64], float]:
    """Return a random place beside a street: centre of an object ``depth_m`` deep, and the yaw of its front.

    The front runs along the street; its left normal points to the street.
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


def _place_files(
    graph: RoadGraph, ground: FreeGround, rng: np.random.Generator, files: Sequence[str], of: int
) -> list[Building]:
    """Place buildings from ``files``, each on one plot ``of`` so many, where there is room; they face the street."""
    buildings: list[Building] = []
    for model in files:
        length, width, height = map(float, mesh_of_file(model, BUILDING_SIDES_M).size_m)
        wanted = len(buildings) + round(_HOUSES / of)
        for _ in range(40 * _HOUSES):
            if len(buildings) == wanted:
                break
            centre, yaw = _beside(graph, rng, length, float(rng.uniform(2.5, 9.0)))
            yaw += 0.5 * np.pi
            if ground.take(centre, (length, width), yaw, 2.0):
                x, y = map(float, centre)
                grey = (128, 128, 128)
                buildings.append(Building((x, y), (length, width, height), yaw, "flat", grey, grey, model=model))
    return buildings


def _place_houses(
    graph: RoadGraph, ground: FreeGround, rng: np.random.Generator, placed: list[Building]
) -> list[Building]:
    buildings = list(placed)
    for _ in range(40 * _HOUSES):
        if len(buildings) >= _HOUSES:
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


def _place_car_parks(graph: RoadGraph, ground: FreeGround, rng: np.random.Generator) -> list[CarPark]:
    """Place car parks: two rows of bays, and between them a lane along the length axis to the street."""
    car_parks: list[CarPark] = []
    parked = 0
    for _ in range(200):
        if len(car_parks) == _CAR_PARKS:
            break
        columns = int(rng.integers(6, 11))
        size = (columns * BAY_SIZE_M[1] + 2.0, 2 * BAY_SIZE_M[0] + 7.0)
        centre, front_yaw = _beside(graph, rng, size[0], CAR_PARK_SETBACK_M)
        yaw = front_yaw + 0.5 * np.pi
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


def _place_trees(
    graph: RoadGraph, buildings: list[Building], ground: FreeGround, rng: np.random.Generator
) -> list[Tree]:
    """Plant rows along streets, single trees in gardens, and copses where there is room."""
    trees: list[Tree] = []
    for wanted, propose in (
        (_STREET_TREES, lambda: (_row_beside_street(graph, rng), 1.5, 2.5)),
        (_STREET_TREES + _GARDEN_TREES, lambda: (_in_a_garden(buildings, rng), 1.6, 4.2)),
        (_STREET_TREES + _GARDEN_TREES + _COPSE_TREES, lambda: (_copse(ground, rng), 2.2, 4.6)),
    ):
        for _ in range(400):
            places, least_m, most_m = propose()
            for place in places:
                if len(trees) < wanted:
                    _plant(trees, ground, place, float(rng.uniform(least_m, most_m)))
    return trees


def _row_beside_street(graph: RoadGraph, rng: np.random.Generator) -> list[NDArray[np.float64]]:
    """Return places just behind a pavement, 8 to 14 m apart."""
    street = graph.streets[int(rng.integers(len(graph.streets)))]
    side, apart_m = rng.choice([-1.0, 1.0]), rng.uniform(8.0, 14.0)
    along = np.gradient(street.centre_m, axis=0)
    left = np.column_stack([-along[:, 1], along[:, 0]]) / np.linalg.norm(along, axis=1, keepdims=True)
    distance = 0.5 * street.width_m + PAVEMENT_WIDTH_M + rng.uniform(0.9, 1.6)
    return list((street.centre_m + side * distance * left)[14 : -14 : round(apart_m)])


def _in_a_garden(buildings: list[Building], rng: np.random.Generator) -> list[NDArray[np.float64]]:
    house = np.array(buildings[int(rng.integers(len(buildings)))].centre_m)
    return [house + rng.normal(0.0, 13.0, 2)]


def _copse(ground: FreeGround, rng: np.random.Generator) -> list[NDArray[np.float64]]:
    middle = rng.uniform(-ground.half_m + 12, ground.half_m - 12, 2)
    return list(middle + rng.normal(0.0, 7.0, (int(rng.integers(1, 9)), 2)))


def _plant(trees: list[Tree], ground: FreeGround, centre: NDArray[np.float64], radius_m: float) -> None:
    # The trunk must stand free; the crown may reach over pavement and lawn.
    if ground.take(centre, (1.0, 1.0), 0.0, max(0.3, 0.5 * (radius_m - 2.0))):
        x, y = map(float, centre)
        trees.append(Tree((x, y), radius_m))
