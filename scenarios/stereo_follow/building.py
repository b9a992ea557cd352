"""A building and its yard on a floor plan: panels, lights, trees and the sky."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenarios.stereo_follow.floor_plan import WALL_M, Area, FloorPlan
from scenarios.stereo_follow.panels import (
    RGB,
    SHINING,
    Panel,
    box,
    door_leaf,
    grained,
    leafy,
    new_panel,
    pane,
    plain,
    poster,
    stained,
    tiled,
    wall,
)
from sim.mesh import Texture, TexturedMesh
from sim.meshes.tree import tree
from sim.pose import pose_on_ground

CORRIDOR_LIGHTS, HALL_LIGHTS, WINDOWS, SUN, SKY = "corridor lights", "hall lights", "windows", "sun", "sky"
LIGHT_GROUPS = (CORRIDOR_LIGHTS, HALL_LIGHTS, WINDOWS, SUN, SKY)
"""Groups of lights that are switched together, or change together behind a cloud."""

_SKIRTING = plain((84, 78, 72))
_DOOR_M = (0.9, 2.05)
_PROUD_M = 0.012
"""Distance from a wall to the objects that hang on it."""
_WALLS_RGB: tuple[RGB, ...] = ((214, 208, 194), (222, 220, 214), (206, 212, 206), (220, 206, 186))
_FLOORS_RGB: tuple[RGB, ...] = ((128, 120, 110), (150, 140, 126), (104, 108, 112), (142, 118, 98))
_FACADES_RGB: tuple[RGB, ...] = ((170, 122, 100), (186, 176, 158), (164, 160, 154), (196, 182, 150))
_DOORS_RGB: tuple[RGB, ...] = ((122, 84, 56), (96, 110, 120), (150, 118, 84))
_FURNITURE_RGB: tuple[RGB, ...] = ((120, 84, 58), (70, 82, 100), (140, 60, 52), (92, 100, 84))
_HEDGE_RGB: RGB = (66, 88, 46)
_BRICK_M, _SLAB_M, _TILE_M = (0.25, 0.075), (0.6, 0.4), (0.6, 0.6)


@dataclass(frozen=True, slots=True)
class Sky:
    """Light from outdoors at full strength.

    Attributes:
        sun_direction: (3,) unit vector towards the sun.
        sun_illuminance_lx: on a surface square to it. sun_temperature_k: its colour temperature.
        luminance_nit: of the sky, uniform. temperature_k: its colour temperature.
    """

    sun_direction: NDArray[np.float64]
    sun_illuminance_lx: float
    sun_temperature_k: float
    luminance_nit: float
    temperature_k: float


Blocker = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]
"""Corner and two sides (3,) of a rectangle that faces ``side_a x side_b``."""


@dataclass(frozen=True, slots=True, eq=False)
class Building:
    """All static objects.

    Attributes:
        plan: where people and the robot can go.
        panels: walls, floors, windows, lights …
        trees: meshes with their poses.
        sky: light from outdoors.
        furniture: names and meshes with their poses. blockers: faces of it that stand in the way of light.
    """

    plan: FloorPlan
    panels: tuple[Panel, ...]
    trees: tuple[tuple[TexturedMesh, NDArray[np.float64]], ...]
    sky: Sky
    furniture: tuple[tuple[str, TexturedMesh, NDArray[np.float64]], ...] = ()
    blockers: tuple[Blocker, ...] = ()


def draw_building(plan: FloorPlan, rng: np.random.Generator) -> Building:
    """Draw a building on a floor plan."""
    sky = draw_sky(rng)
    panels = [*_corridor(plan, sky, rng), *_hall(plan, sky, rng), *_doorway(plan, rng), *_yard(plan, rng)]
    return Building(plan, tuple(panels), tuple(_trees(plan.yard, rng)), sky)


def draw_sky(rng: np.random.Generator) -> Sky:
    """Draw a clear sky with its sun."""
    elevation, azimuth = np.deg2rad(rng.uniform(28.0, 60.0)), rng.uniform(-np.pi, np.pi)
    level = np.cos(elevation)
    direction = np.array([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)])
    sun_lx, sun_k = rng.uniform(22e3, 45e3), rng.uniform(4800.0, 5800.0)
    return Sky(direction, sun_lx, sun_k, rng.uniform(1.6e3, 3.2e3), rng.uniform(7e3, 10e3))


def _choice(options: tuple[RGB, ...], rng: np.random.Generator) -> RGB:
    return options[rng.integers(len(options))]


def _corridor(plan: FloorPlan, sky: Sky, rng: np.random.Generator) -> Iterator[Panel]:
    area, height_m = plan.corridor, plan.corridor_height_m
    colour = _choice(_WALLS_RGB, rng)
    plaster = grained(colour, rng)
    yield from _floor_and_ceiling("corridor", area, height_m, grained(_choice(_FLOORS_RGB, rng), rng), rng)
    right, left = ((area.x1, area.y0), (area.x0, area.y0)), ((area.x0, area.y1), (area.x1, area.y1))
    for name, (start_m, end_m) in (("corridor right wall", right), ("corridor left wall", left)):
        yield from wall(name, start_m, end_m, height_m, plaster)
        yield from wall(f"{name} skirting", start_m, end_m, 0.09, _SKIRTING, offset_m=0.01)
        yield from _along_corridor(name, start_m, end_m, rng)
    yield from wall("corridor end wall", (area.x0, area.y0), (area.x0, area.y1), height_m, plaster)
    width_m = area.y1 - area.y0
    passage = (area.y1 - plan.passage.y1, area.y1 - plan.passage.y0, plan.opening_height_m)
    yield from wall("corridor front wall", (area.x1, area.y1), (area.x1, area.y0), height_m, plaster, passage)
    window_m = rng.uniform(0.5, 0.75) * width_m
    yield new_panel(
        "corridor window",
        (area.x0 + _PROUD_M, area.y0 + 0.5 * (width_m - window_m), 0.85),
        (0.0, window_m, 0.0),
        (0.0, 0.0, 1.35),
        SHINING,
        luminance_nit=rng.uniform(0.3, 0.9) * sky.luminance_nit,
        temperature_k=sky.temperature_k,
        group=WINDOWS,
    )
    nit, temperature_k = rng.uniform(900.0, 3500.0), rng.uniform(2400.0, 4500.0)
    step_m = rng.uniform(3.0, 4.5)
    for x_m in np.arange(area.x0 + 0.5 * step_m, area.x1 - 0.7, step_m):
        middle_m = (x_m, 0.5 * (area.y0 + area.y1))
        yield _ceiling_light("corridor light", middle_m, (1.2, 0.3), height_m, nit, temperature_k, CORRIDOR_LIGHTS)


def _along_corridor(
    name: str, start_m: tuple[float, float], end_m: tuple[float, float], rng: np.random.Generator
) -> Iterator[Panel]:
    """Yield doors and posters on a corridor's wall."""
    length_m = abs(end_m[0] - start_m[0])
    sign = np.sign(end_m[0] - start_m[0])
    doors_rgb, at_m = _choice(_DOORS_RGB, rng), rng.uniform(0.8, 2.5)
    while at_m < length_m - 1.5:
        is_door = rng.random() < 0.6
        size_m = _DOOR_M if is_door else (rng.uniform(0.5, 1.3), rng.uniform(0.5, 0.95))
        texture = door_leaf(doors_rgb, rng) if is_door else poster(size_m, rng)
        low_m = 0.0 if is_door else rng.uniform(1.0, 1.3)
        corner_m = (start_m[0] + sign * at_m, start_m[1] + sign * _PROUD_M * -1.0, low_m)
        yield new_panel(
            f"{name} {'door' if is_door else 'poster'}",
            corner_m,
            (sign * size_m[0], 0.0, 0.0),
            (0.0, 0.0, size_m[1]),
            texture,
        )
        at_m += size_m[0] + rng.uniform(0.8, 3.0)


def _hall(plan: FloorPlan, sky: Sky, rng: np.random.Generator) -> Iterator[Panel]:
    area, height_m = plan.hall, plan.hall_height_m
    plaster = grained(_choice(_WALLS_RGB, rng), rng)
    floor = tiled(_choice(_FLOORS_RGB, rng), (area.x1, area.y1), _TILE_M, rng, unlike=0.015)
    yield from _floor_and_ceiling("hall", area, height_m, floor, rng)
    sides = (
        ("hall right wall", (area.x1, 0.0), (0.0, 0.0), None),
        ("hall left wall", (0.0, area.y1), (area.x1, area.y1), None),
        ("hall back wall", (0.0, 0.0), (0.0, area.y1), (plan.passage.y0, plan.passage.y1, plan.opening_height_m)),
        (
            "hall front wall",
            (area.x1, area.y1),
            (area.x1, 0.0),
            (area.y1 - plan.door.y1, area.y1 - plan.door.y0, plan.opening_height_m),
        ),
    )
    for name, start_m, end_m, opening in sides:
        yield from wall(name, start_m, end_m, height_m, plaster, opening)
        low_opening = None if opening is None else (opening[0], opening[1], 0.09)
        yield from wall(f"{name} skirting", start_m, end_m, 0.09, _SKIRTING, low_opening, offset_m=0.01)
    windowed_left = rng.random() < 0.5
    yield from _hall_windows(area, height_m, windowed_left, sky, rng)
    yield from _hall_furniture(area, windowed_left, rng)
    nit, temperature_k = rng.uniform(1200.0, 4500.0), rng.uniform(3000.0, 6500.0)
    for x_m in np.arange(1.5, area.x1 - 0.8, 3.0):
        for y_m in np.arange(1.5, area.y1 - 0.8, 3.0):
            yield _ceiling_light("hall light", (x_m, y_m), (0.6, 0.6), height_m, nit, temperature_k, HALL_LIGHTS)


def _hall_windows(
    area: Area, height_m: float, on_the_left: bool, sky: Sky, rng: np.random.Generator
) -> Iterator[Panel]:
    y_m, sign = (area.y1 - _PROUD_M, 1.0) if on_the_left else (_PROUD_M, -1.0)
    width_m, tall_m, nit = rng.uniform(1.2, 2.0), height_m - 1.6, rng.uniform(0.4, 1.0) * sky.luminance_nit
    for middle_m in np.arange(2.0, area.x1 - 1.5, rng.uniform(2.6, 3.5)):
        yield new_panel(
            "hall window",
            (middle_m - 0.5 * sign * width_m, y_m, 0.9),
            (sign * width_m, 0.0, 0.0),
            (0.0, 0.0, tall_m),
            SHINING,
            luminance_nit=nit,
            temperature_k=sky.temperature_k,
            group=WINDOWS,
        )


def _hall_furniture(area: Area, windowed_left: bool, rng: np.random.Generator) -> Iterator[Panel]:
    """Yield benches below the windows, machines and boards on the wall across."""
    window_y_m, other_y_m = (area.y1 - 0.32, 0.4) if windowed_left else (0.32, area.y1 - 0.4)
    wood = grained(_choice(_FURNITURE_RGB, rng), rng)
    for x_m in np.arange(2.2, area.x1 - 2.0, rng.uniform(2.8, 4.0)):
        yield from box("bench", (x_m, window_y_m), (1.6, 0.45, 0.45), wood)
    for x_m in np.arange(1.6, area.x1 - 1.2, rng.uniform(2.5, 4.0)):
        if rng.random() < 0.4:
            yield from box("machine", (x_m, other_y_m), (0.9, 0.75, 1.8), poster((0.9, 1.8), rng))
        else:
            size_m = (rng.uniform(0.9, 1.6), rng.uniform(0.8, 1.1))
            sign = -1.0 if windowed_left else 1.0
            y_m = _PROUD_M if windowed_left else area.y1 - _PROUD_M
            yield new_panel(
                "notice board",
                (x_m - 0.5 * sign * size_m[0], y_m, 1.05),
                (sign * size_m[0], 0.0, 0.0),
                (0.0, 0.0, size_m[1]),
                poster(size_m, rng),
            )


def _doorway(plan: FloorPlan, rng: np.random.Generator) -> Iterator[Panel]:
    """Yield the visible sides of the wall in the door: jambs, lintel, sill."""
    door, top_m = plan.door, plan.opening_height_m
    jamb = grained((150, 146, 140), rng)
    yield new_panel("jamb", (door.x1, door.y0, 0.0), (-WALL_M, 0.0, 0.0), (0.0, 0.0, top_m), jamb)
    yield new_panel("jamb", (door.x0, door.y1, 0.0), (WALL_M, 0.0, 0.0), (0.0, 0.0, top_m), jamb)
    width_m = door.y1 - door.y0
    yield new_panel("lintel", (door.x0, door.y0, top_m), (0.0, width_m, 0.0), (WALL_M, 0.0, 0.0), jamb)
    yield new_panel("sill", (door.x0, door.y0, 0.0), (WALL_M, 0.0, 0.0), (0.0, width_m, 0.0), jamb)


def _yard(plan: FloorPlan, rng: np.random.Generator) -> Iterator[Panel]:
    area = plan.yard
    size_m = (area.x1 - area.x0, area.y1 - area.y0)
    paving = tiled((150, 146, 138), size_m, _SLAB_M, rng)
    yield new_panel("paving", (area.x0, area.y0, 0.0), (size_m[0], 0.0, 0.0), (0.0, size_m[1], 0.0), paving)
    near_size_m, far_size_m = (size_m[1], plan.facade_height_m), (size_m[1], plan.far_height_m)
    bricks = tiled(_choice(_FACADES_RGB, rng), near_size_m, _BRICK_M, rng, unlike=0.06)
    door = (plan.door.y0 - area.y0, plan.door.y1 - area.y0, plan.opening_height_m)
    yield from wall("facade", (area.x0, area.y0), (area.x0, area.y1), plan.facade_height_m, bricks, door)
    yield from _facade_windows("facade", (area.x0, area.y0), 1.0, size_m[1], plan.facade_height_m, door, rng)
    across = stained(_choice(_FACADES_RGB, rng), far_size_m, rng)
    yield from wall("far facade", (area.x1, area.y1), (area.x1, area.y0), plan.far_height_m, across)
    yield from _facade_windows("far facade", (area.x1, area.y1), -1.0, size_m[1], plan.far_height_m, None, rng)
    for name, start_m, end_m in (
        ("right hedge", (area.x1, area.y0), (area.x0, area.y0)),
        ("left hedge", (area.x0, area.y1), (area.x1, area.y1)),
    ):
        height_m = rng.uniform(1.6, 3.0)
        green = leafy(_HEDGE_RGB, (size_m[0], height_m), rng)
        yield from wall(name, start_m, end_m, height_m, green)
    wood = grained(_choice(_FURNITURE_RGB, rng), rng)
    for x_m in np.arange(area.x0 + 3.0, area.x1 - 2.0, rng.uniform(3.5, 6.0)):
        yield from box("yard bench", (x_m, area.y0 + 0.8), (1.7, 0.5, 0.45), wood)


def _facade_windows(
    name: str,
    start_m: tuple[float, float],
    sign: float,
    length_m: float,
    height_m: float,
    door: tuple[float, float, float] | None,
    rng: np.random.Generator,
) -> Iterator[Panel]:
    """Yield dark panes on a facade along y that faces the right of ``sign * y``."""
    glass, width_m = pane(rng), rng.uniform(1.1, 1.6)
    for low_m in np.arange(1.0, height_m - 1.6, 2.9):
        for at_m in np.arange(1.2, length_m - 2.5, rng.uniform(2.6, 3.4)):
            beside_door = door is None or low_m > door[2] or at_m + width_m < door[0] - 0.2 or at_m > door[1] + 0.2
            if beside_door:
                corner_m = (start_m[0] + sign * _PROUD_M, start_m[1] + sign * at_m, low_m)
                yield new_panel(f"{name} window", corner_m, (0.0, sign * width_m, 0.0), (0.0, 0.0, 1.4), glass)


def _trees(yard: Area, rng: np.random.Generator) -> Iterator[tuple[TexturedMesh, NDArray[np.float64]]]:
    """Yield trees along the hedges; their crowns reach over the paths."""
    for y_m, first_m in ((yard.y0 + 1.0, 5.0), (yard.y1 - 1.0, 3.5)):
        for x_m in np.arange(yard.x0 + first_m, yard.x1 - 1.5, rng.uniform(5.0, 8.0)):
            yield tree(rng.uniform(1.2, 2.0), rng.uniform(4.0, 6.0), rng), pose_on_ground(x_m, y_m, rng.uniform(0, 6.3))


def _floor_and_ceiling(
    name: str, area: Area, height_m: float, floor: Texture, rng: np.random.Generator
) -> Iterator[Panel]:
    along, across = (area.x1 - area.x0, 0.0, 0.0), (0.0, area.y1 - area.y0, 0.0)
    yield new_panel(f"{name} floor", (area.x0, area.y0, 0.0), along, across, floor)
    ceiling = grained((232, 232, 228), rng)
    yield new_panel(f"{name} ceiling", (area.x0, area.y0, height_m), across, along, ceiling)


def _ceiling_light(
    name: str,
    middle_m: tuple[float, float],
    size_m: tuple[float, float],
    ceiling_m: float,
    luminance_nit: float,
    temperature_k: float,
    group: str,
) -> Panel:
    corner_m = (middle_m[0] - 0.5 * size_m[0], middle_m[1] - 0.5 * size_m[1], ceiling_m - _PROUD_M)
    light: dict[str, float | str] = {"luminance_nit": luminance_nit, "temperature_k": temperature_k, "group": group}
    return new_panel(name, corner_m, (0.0, size_m[1], 0.0), (size_m[0], 0.0, 0.0), SHINING, **light)
