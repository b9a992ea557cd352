"""A robot carries a green sheet in front of its camera through corridors: the world of paper B's experiment II."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenarios.paper_sheet.sheet import LOWER_EDGE_M, Rooms, sheet_mesh
from scenarios.scenario import check_length, check_size
from scenarios.stereo_follow.camera import CAMERA_HEIGHT_M
from scenarios.stereo_follow.floor_plan import Area
from scenarios.stereo_follow.panels import SHINING, Panel, add_panel, bright_area, grained, new_panel, panel, plain
from sim.checks import check_types
from sim.pose import pose_on_ground
from sim.rng import generator
from sim.shaders.lamps import BrightArea, LampShader, Surroundings
from sim.world import Body, World

_SHEET_AHEAD_M = 1.6
_WIDTH_M, _HEIGHT_M = 2.6, 2.6
_FIRST_M, _SECOND_M = 18.0, 26.0
"""Lengths of the two corridors' centre lines: along +x to the corner, and from there along +y."""
_TURN_RADIUS_M = 0.8
_START_M, _END_M = 1.0, 23.5
_LIGHT_EVERY_M, _LIGHT_M = 4.0, (1.2, 0.3)
_DARK_M = 15.0
"""The second corridor has no lights before this place."""
_WALL_RGB, _FLOOR_RGB, _CEILING_RGB = (214, 208, 194), (128, 120, 110), (232, 232, 228)
_DOOR_RGB, _SKIRTING_RGB, _POLE_RGB = (122, 84, 56), (84, 78, 72), (60, 60, 64)
_ROOM = Surroundings(surface_m2=470.0, reflectance=0.3)
"""Closed corridors of these colours would reflect nearly 0.6. But the model's reflected light is uniform, and
would fill the dark stretch, which little light reaches round the corner.
"""
_HALF_M, _CORNER_X_M = 0.5 * _WIDTH_M, _FIRST_M + 0.5 * _WIDTH_M
_PLAN = Rooms(
    {
        "first corridor": Area(0.0, -_HALF_M, _CORNER_X_M, _HALF_M),
        "second corridor": Area(_CORNER_X_M - _WIDTH_M, _HALF_M, _CORNER_X_M, _SECOND_M),
    },
    openings=(Area(_CORNER_X_M - _WIDTH_M, _HALF_M, _CORNER_X_M, _HALF_M),),
)

_LONGEST_S = 3600.0


@dataclass(frozen=True, slots=True)
class CarriedSheet:
    """Configuration of an episode: a drive past lights and windows with the sheet in front of the camera.

    Attributes:
        summary: one line.
        frame_count, rate_hz: number of frames, evenly along the path, and frames per second.
        width_px, height_px: of each picture.
        closed_loop: False, since the path is set.
    """

    summary: str
    frame_count: int = 947
    rate_hz: float = 15.0
    width_px: int = 320
    height_px: int = 240
    closed_loop: bool = False

    def __post_init__(self) -> None:
        check_types(self)
        check_size(self)
        check_length(self, _LONGEST_S)

    def scene(self, seed: int) -> CarriedSheetScene:
        """Build the world of one episode."""
        return CarriedSheetScene(self, seed)


class CarriedSheetScene:
    """See ``sheet.SheetScene``.

    The robot drives along a corridor under ceiling lights towards the window at its end (back light), round the corner
    into a corridor without lights in its first part (shade), and on to warm lights and another window. Brightness and
    colour of lights and windows are drawn from the seed.
    """

    settling_steps = 0
    place, plan = "corridor", _PLAN

    def __init__(self, preset: CarriedSheet, seed: int) -> None:
        self._way = list(_way(preset.frame_count))
        sheet_m = [place_m + _SHEET_AHEAD_M * _ahead(heading_rad) for place_m, heading_rad in self._way]
        self._speed_mps = preset.rate_hz * np.linalg.norm(np.gradient(sheet_m, axis=0), axis=1)
        rng = generator(seed, "corridor")
        self.world = World()
        self.shader = LampShader([], _ROOM, _build(self.world, rng))
        self.sheet = self.world.add(sheet_mesh(rng), np.eye(4), name="sheet", category="sheet", movable=True)
        self._pole = _pole(self.world)
        self.move_to(0)

    def move_to(self, frame: int) -> None:
        """See ``SheetScene``."""
        self.place_m, self.heading_rad = self._way[frame]
        x_m, y_m = self.place_m + _SHEET_AHEAD_M * _ahead(self.heading_rad)
        T_world_pole = pose_on_ground(x_m, y_m, self.heading_rad + np.pi)
        self.T_world_sheet = T_world_pole.copy()
        self.T_world_sheet[2, 3] = LOWER_EDGE_M
        self.speed_mps = float(self._speed_mps[frame])
        self.world.move(self.sheet, self.T_world_sheet)
        self.world.move(self._pole, T_world_pole)


def _way(frame_count: int) -> Iterator[tuple[NDArray[np.float64], float]]:
    """Yield place (2,) and heading of each frame, at an even speed: straight, a quarter circle, straight."""
    radius = _TURN_RADIUS_M
    straight_m, turn_m = _FIRST_M - radius - _START_M, 0.5 * np.pi * radius
    total_m = straight_m + turn_m + _END_M - radius
    for driven_m in np.linspace(0.0, total_m, frame_count):
        turned = float(np.clip((driven_m - straight_m) / radius, 0.0, 0.5 * np.pi))
        beyond_m = max(driven_m - straight_m - turn_m, 0.0)
        x = _START_M + min(driven_m, straight_m) + radius * np.sin(turned)
        yield np.array([x, radius * (1 - np.cos(turned)) + beyond_m]), turned


def _ahead(heading_rad: float) -> NDArray[np.float64]:
    return np.array([np.cos(heading_rad), np.sin(heading_rad)])


def _pole(world: World) -> Body:
    """Add the sheet's pole, a centimetre behind the sheet; its frame is on the ground below the sheet's frame."""
    shape = panel((-0.01, -0.02, 0.0), (0.0, 0.04, 0.0), (0.0, 0.0, CAMERA_HEIGHT_M), plain(_POLE_RGB))
    return world.add(shape, np.eye(4), name="pole", category="furniture", movable=True)


def _build(world: World, rng: np.random.Generator) -> list[BrightArea]:
    """Build the two corridors and return their lights and windows."""
    bright = []
    for piece in (*_surfaces(rng), *_windows(rng), *_ceiling_lights(rng)):
        body = add_panel(world, piece)
        if piece.luminance_nit > 0:
            bright.append(bright_area(body.index, piece))
    return bright


def _surfaces(rng: np.random.Generator) -> Iterator[Panel]:
    """Yield walls, skirtings, floors, ceilings and doors."""
    half, corner_x, end_y = _HALF_M, _CORNER_X_M, _SECOND_M
    up = np.array([0.0, 0.0, _HEIGHT_M])
    wall, floor, ceiling = (grained(rgb, rng) for rgb in (_WALL_RGB, _FLOOR_RGB, _CEILING_RGB))
    walls = (
        ("right wall", (corner_x, -half, 0.0), (-corner_x, 0.0, 0.0)),
        ("left wall", (0.0, half, 0.0), (corner_x - _WIDTH_M, 0.0, 0.0)),
        ("back wall", (0.0, -half, 0.0), (0.0, _WIDTH_M, 0.0)),
        ("corner wall", (corner_x, end_y, 0.0), (0.0, -end_y - half, 0.0)),
        ("inner wall", (corner_x - _WIDTH_M, half, 0.0), (0.0, end_y - half, 0.0)),
        ("end wall", (corner_x - _WIDTH_M, end_y, 0.0), (_WIDTH_M, 0.0, 0.0)),
    )
    for name, corner_m, along_m in walls:
        yield new_panel(name, corner_m, along_m, up, wall)
        inward = np.cross(along_m, up) / np.linalg.norm(np.cross(along_m, up))
        skirting_m = np.array(corner_m) + 0.01 * inward
        yield new_panel(f"{name} skirting", skirting_m, along_m, (0.0, 0.0, 0.09), plain(_SKIRTING_RGB))
    for name, x_m, y_m, size_m in (
        ("first", 0.0, -half, (corner_x, _WIDTH_M)),
        ("second", corner_x - _WIDTH_M, half, (_WIDTH_M, end_y - half)),
    ):
        along, across = np.array([size_m[0], 0.0, 0.0]), np.array([0.0, size_m[1], 0.0])
        yield new_panel(f"{name} floor", (x_m, y_m, 0.0), along, across, floor)
        yield new_panel(f"{name} ceiling", (x_m, y_m, _HEIGHT_M), across, along, ceiling)
    for k, x_m in enumerate(np.arange(3.0, corner_x - _WIDTH_M - 1.5, 5.0)):
        yield new_panel(f"door {k}", (x_m, half - 0.02, 0.0), (0.9, 0.0, 0.0), (0.0, 0.0, 2.05), plain(_DOOR_RGB))


def _windows(rng: np.random.Generator) -> Iterator[Panel]:
    """Yield the windows at the corridors' ends; the first corridor faces the corner window."""
    sky_k = rng.uniform(5500.0, 7500.0)
    for name, corner_m, along_m, height_m, low_nit, high_nit in (
        ("corner window", (_CORNER_X_M - 0.01, 0.8, 0.7), (0.0, -1.6, 0.0), 1.5, 1500.0, 3000.0),
        ("end window", (_FIRST_M - 0.9, _SECOND_M - 0.01, 0.9), (1.8, 0.0, 0.0), 1.4, 600.0, 1500.0),
    ):
        light = {"luminance_nit": rng.uniform(low_nit, high_nit), "temperature_k": sky_k}
        yield new_panel(name, corner_m, along_m, (0.0, 0.0, height_m), SHINING, **light)


def _ceiling_lights(rng: np.random.Generator) -> Iterator[Panel]:
    """Yield ceiling lights: neutral ones in the first corridor, warm ones in the far part of the second."""
    length_m, width_m = _LIGHT_M
    neutral_k, warm_k = rng.uniform(3800.0, 5000.0), rng.uniform(2400.0, 3000.0)
    neutral_nit, warm_nit = rng.uniform(2500.0, 4500.0), rng.uniform(1500.0, 3000.0)
    for x_m in np.arange(0.5 * _LIGHT_EVERY_M, _FIRST_M - 1.0, _LIGHT_EVERY_M):
        yield _ceiling_light(f"light at {x_m:g} m", (x_m, 0.0), (length_m, width_m), neutral_nit, neutral_k)
    for y_m in np.arange(_DARK_M, _SECOND_M, _LIGHT_EVERY_M):
        yield _ceiling_light(f"warm light at {y_m:g} m", (_FIRST_M, y_m), (width_m, length_m), warm_nit, warm_k)


def _ceiling_light(
    name: str, middle_m: tuple[float, float], size_m: tuple[float, float], luminance_nit: float, temperature_k: float
) -> Panel:
    corner_m = (middle_m[0] - 0.5 * size_m[0], middle_m[1] - 0.5 * size_m[1], _HEIGHT_M - 0.01)
    light = {"luminance_nit": luminance_nit, "temperature_k": temperature_k}
    return new_panel(name, corner_m, (0.0, size_m[1], 0.0), (size_m[0], 0.0, 0.0), SHINING, **light)
