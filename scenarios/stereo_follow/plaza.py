"""A square between the facades of a town: paving and a street, houses, rows of trees, benches and parked cars.

It takes the place of building and yard: nobody leaves the yard's area, and what is seen beyond it are the houses.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from scenarios.stereo_follow.building import Blocker, Building, draw_sky
from scenarios.stereo_follow.floor_plan import Area, FloorPlan
from scenarios.stereo_follow.panels import RGB, Panel, box, grained, new_panel, plain, stained, tiled, wall
from sim.mesh import Texture, TexturedMesh
from sim.meshes.tree import tree
from sim.meshes.vehicle import vehicle
from sim.pose import pose_on_ground

_SIZE_M = (24.0, 30.0)
_STREET_M = 4.2
"""Width of the strip along one side of the square on which cars are parked."""
_PARKING_M = 1.2
"""What the square reaches beyond the floor plan there, so that people keep off the cars."""
_HOUSES_M, _HEIGHTS_M = (6.0, 11.0), (6.0, 11.0)
_HOUSES_RGB: tuple[RGB, ...] = (
    (204, 186, 150),
    (170, 122, 100),
    (196, 200, 196),
    (214, 178, 140),
    (150, 158, 166),
    (186, 146, 110),
    (222, 214, 200),
)
_SHOPS_RGB: tuple[RGB, ...] = ((60, 70, 66), (96, 48, 44), (40, 56, 88), (112, 96, 72))
_CARS_RGB: tuple[RGB, ...] = ((40, 42, 46), (150, 152, 156), (206, 206, 202), (120, 30, 34), (36, 60, 110))
_MODELS = ("sedan", "hatchback", "estate", "suv", "van")
_PAVINGS_RGB: tuple[RGB, ...] = ((150, 146, 138), (164, 150, 132), (132, 130, 128))
_ASPHALT_RGB, _WOOD_RGB, _LINE_RGB = (84, 84, 86), (120, 90, 62), (206, 206, 200)


def outdoors(plan: FloorPlan, rng: np.random.Generator) -> FloorPlan:
    """Return a floor plan on which people walk on a square alone, in the place of the yard."""
    x_m, y_m = rng.uniform(*_SIZE_M, 2)
    yard = plan.yard
    square = Area(yard.x0, yard.y0, yard.x0 + float(x_m), yard.y0 + float(y_m))
    return replace(plan, yard=square, walked=("yard",))


def draw_plaza(plan: FloorPlan, rng: np.random.Generator) -> Building:
    """Draw a square on a floor plan of ``outdoors``."""
    sky, yard = draw_sky(rng), plan.yard
    area = Area(yard.x0, yard.y0 - _PARKING_M, yard.x1, yard.y1)
    panels = [*_ground(area, rng), *_houses(area, rng), *_benches(area, rng)]
    trees, blockers = _trees(area, rng)
    return Building(plan, tuple(panels), trees, sky, _parked_cars(area, rng), tuple(blockers))


def _ground(area: Area, rng: np.random.Generator) -> Iterator[Panel]:
    x_m, y_m = area.x1 - area.x0, area.y1 - area.y0
    slabs = float(rng.choice((0.3, 0.5, 0.8)))
    paving = tiled(_one(_PAVINGS_RGB, rng), (x_m, y_m - _STREET_M), (slabs, 0.6 * slabs), rng)
    low_y = area.y0 + _STREET_M
    yield new_panel("paving", (area.x0, low_y, 0.0), (x_m, 0.0, 0.0), (0.0, y_m - _STREET_M, 0.0), paving)
    asphalt = stained(_ASPHALT_RGB, (x_m, _STREET_M), rng, strength=0.03)
    yield new_panel("street", (area.x0, area.y0, 0.0), (x_m, 0.0, 0.0), (0.0, _STREET_M, 0.0), asphalt)
    for at_m in np.arange(area.x0 + 2.0, area.x1 - 2.0, 5.5):
        yield new_panel("line", (at_m, area.y0 + 0.2, 0.004), (0.1, 0.0, 0.0), (0.0, 1.9, 0.0), plain(_LINE_RGB))


def _houses(area: Area, rng: np.random.Generator) -> Iterator[Panel]:
    """Yield rows of houses along all four sides, each with a colour, a height and windows of its own."""
    corners = [np.array(each) for each in area.corners]
    for k in range(4):
        # Seen from inside, walls run clockwise.
        start, end = corners[(k + 1) % 4], corners[k]
        length_m = float(np.linalg.norm(end - start))
        along = (end - start) / length_m
        at_m = 0.0
        while at_m < length_m - 1e-6:
            wide_m = float(rng.uniform(*_HOUSES_M))
            wide_m = length_m - at_m if length_m - at_m - wide_m < _HOUSES_M[0] else wide_m
            here, there = start + at_m * along, start + (at_m + wide_m) * along
            yield from _house((here[0], here[1]), (there[0], there[1]), wide_m, rng)
            at_m += wide_m


def _house(
    start_m: tuple[float, float], end_m: tuple[float, float], wide_m: float, rng: np.random.Generator
) -> Iterator[Panel]:
    """Yield a front: all of it but its plinth is in one texture, as each panel costs time where light is baked."""
    high_m = float(rng.uniform(*_HEIGHTS_M))
    yield from wall("house", start_m, end_m, high_m, _front((wide_m, high_m), rng))
    yield from wall("plinth", start_m, end_m, 0.35, grained((110, 106, 100), rng), offset_m=0.03)


def _front(size_m: tuple[float, float], rng: np.random.Generator) -> Texture:
    """Return a front with rows of windows, and a door and a shop's window on the ground floor."""
    rgb, shop = _one(_HOUSES_RGB, rng), _one(_SHOPS_RGB, rng)
    bricks = rng.random() < 0.3
    ground = tiled(rgb, size_m, (0.25, 0.075), rng, unlike=0.05) if bricks else stained(rgb, size_m, rng)
    picture = ground.rgb.astype(float)
    wide_m, tall_m, step_m = rng.uniform(0.9, 1.3), rng.uniform(1.3, 1.8), rng.uniform(1.9, 2.7)
    count = max(int((size_m[0] - 0.8) / step_m), 1)
    first_m = 0.5 * (size_m[0] - (count - 1) * step_m - wide_m)
    for sill_m in np.arange(3.5, size_m[1] - tall_m - 0.4, rng.uniform(2.8, 3.3)).tolist():
        for k in range(count):
            left_m = first_m + k * step_m
            _paint(
                picture, size_m, (left_m - 0.1, sill_m - 0.1, left_m + wide_m + 0.1, sill_m + tall_m + 0.1), 0.9 * _PALE
            )
            _paint(picture, size_m, (left_m, sill_m, left_m + wide_m, sill_m + tall_m), _GLASS * rng.uniform(0.7, 1.3))
            middle_m = left_m + 0.5 * wide_m
            _paint(picture, size_m, (middle_m - 0.03, sill_m, middle_m + 0.03, sill_m + tall_m), _PALE)
    dark = np.array(shop, dtype=float)
    door_m = float(rng.uniform(0.5, 0.9))
    _paint(picture, size_m, (0.3, 2.6, size_m[0] - 0.3, 3.1), dark)
    _paint(picture, size_m, (door_m, 0.0, door_m + 1.0, 2.25), 0.8 * dark)
    _paint(picture, size_m, (door_m + 0.15, 1.1, door_m + 0.85, 2.1), _GLASS)
    _paint(picture, size_m, (door_m + 1.5, 0.5, size_m[0] - 0.7, 2.4), 0.9 * dark)
    _paint(picture, size_m, (door_m + 1.6, 0.6, size_m[0] - 0.8, 2.3), 1.2 * _GLASS)
    return Texture(np.clip(picture, 0, 255).astype(np.uint8), smooth=True)


_GLASS, _PALE = np.array([52.0, 60.0, 70.0]), np.array([206.0, 204.0, 196.0])


def _paint(
    picture: NDArray[np.float64],
    size_m: tuple[float, float],
    window_m: tuple[float, float, float, float],
    rgb: NDArray[np.float64],
) -> None:
    """Paint a rectangle, left, lower, right and upper edge in metres from the lower left, lighter towards its top."""
    rows, columns = picture.shape[:2]
    left, right = (round(at_m / size_m[0] * columns) for at_m in window_m[::2])
    low, high = (rows - round(at_m / size_m[1] * rows) for at_m in window_m[1::2])
    if high < low and left < right:
        picture[high:low, left:right] = rgb * np.linspace(1.12, 0.92, low - high)[:, None, None]


def _benches(area: Area, rng: np.random.Generator) -> Iterator[Panel]:
    wood = grained(_WOOD_RGB, rng)
    for x_m in np.arange(area.x0 + 3.5, area.x1 - 3.0, rng.uniform(4.5, 7.0)):
        yield from box("bench", (x_m, area.y1 - 1.0), (1.7, 0.5, 0.45), wood)


Placed = tuple[TexturedMesh, NDArray[np.float64]]


def _trees(area: Area, rng: np.random.Generator) -> tuple[tuple[Placed, ...], list[Blocker]]:
    """Return trees along the houses, and squares in their crowns that shade the ground."""
    trees, blockers = [], []
    for y_m, step_m in ((area.y1 - 1.3, rng.uniform(5.0, 7.0)), (area.y0 + _STREET_M - 0.9, rng.uniform(6.0, 9.0))):
        for x_m in np.arange(area.x0 + rng.uniform(2.0, 4.0), area.x1 - 2.0, step_m).tolist():
            radius_m, high_m = float(rng.uniform(1.4, 2.3)), float(rng.uniform(4.5, 7.0))
            trees.append((tree(radius_m, high_m, rng), pose_on_ground(x_m, y_m, float(rng.uniform(0, 6.3)))))
            side_m = 1.45 * radius_m
            for share, size_m in ((0.5, side_m), (0.72, 0.8 * side_m)):
                corner = np.array([x_m - 0.5 * size_m, y_m - 0.5 * size_m, share * high_m])
                x_side, y_side = np.array([size_m, 0.0, 0.0]), np.array([0.0, size_m, 0.0])
                blockers += [(corner, x_side, y_side), (corner - [0.0, 0.0, 0.05], y_side, x_side)]
    return tuple(trees), blockers


def _parked_cars(area: Area, rng: np.random.Generator) -> tuple[tuple[str, TexturedMesh, NDArray[np.float64]], ...]:
    """Return cars along the houses of the street, in the margin where nobody walks."""
    cars = []
    for x_m in np.arange(area.x0 + 4.75, area.x1 - 4.0, 5.5).tolist():
        if rng.random() < 0.7:
            mesh = vehicle(_MODELS[int(rng.integers(len(_MODELS)))], _one(_CARS_RGB, rng))
            heading = float(rng.choice((0.0, np.pi)) + rng.normal(0.0, 0.02))
            cars.append(("car", mesh, pose_on_ground(x_m + rng.normal(0.0, 0.15), area.y0 + 1.15, heading)))
    return tuple(cars)


def _one(options: tuple[RGB, ...], rng: np.random.Generator) -> RGB:
    return options[int(rng.integers(len(options)))]
