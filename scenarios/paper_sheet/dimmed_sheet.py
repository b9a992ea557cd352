"""A green sheet on a white wall under one dimmed lamp: the world of paper B's experiment I."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scenarios.paper_sheet.sheet import LOWER_EDGE_M, Rooms, illuminance_on_sheet_lx, sheet_mesh
from scenarios.scenario import check_size
from scenarios.stereo_follow.floor_plan import Area
from scenarios.stereo_follow.panels import add_panel, grained, new_panel
from sim.checks import check, check_types
from sim.rng import generator
from sim.shaders.lamps import Lamp, LampShader, Surroundings
from sim.world import World

_WALL_M = (6.0, 3.0)
_ROOM = Surroundings(surface_m2=100.0, reflectance=0.5)
_ROOM_AREA = Area(0.0, -0.5 * _WALL_M[0], 4.0, 0.5 * _WALL_M[0])
_BRIGHTEST_K, _TEMPERATURE_EXPONENT = 2850.0, 0.42 / 3.4
_SETTLING_FRAMES = 60
_LOOPS_HZ = 15.0
_WALL_RGB = (222, 220, 214)
_BEFORE_WALL_M = 0.001
BRIGHTEST_LX = 120_000.0
"""Of the sun at noon."""


@dataclass(frozen=True, slots=True)
class DimmedSheet:
    """Configuration of an episode: one picture per illuminance, after the camera's loops have settled.

    Attributes:
        summary: one line.
        illuminances_lx: means on the sheet, in order.
        width_px, height_px: of each picture.
        closed_loop: the camera is at rest.
    """

    summary: str
    illuminances_lx: tuple[float, ...] = (609.0, 533.0, 414.0, 311.0, 203.0, 122.0, 86.0, 38.0, 19.0)
    width_px: int = 640
    height_px: int = 480
    closed_loop: bool = False

    def __post_init__(self) -> None:
        came = self.illuminances_lx
        check_types(self)
        check_size(self)
        good = len(came) > 0 and min(came) > 0 and max(came) <= BRIGHTEST_LX
        check("illuminances_lx", good, f"one or more numbers in (0, {BRIGHTEST_LX:g}]", came)

    @property
    def frame_count(self) -> int:
        """One frame per illuminance."""
        return len(self.illuminances_lx)

    @property
    def rate_hz(self) -> float:
        """Rate of the pictures; the camera's loops run at 15 Hz in between."""
        return _LOOPS_HZ / _SETTLING_FRAMES

    def scene(self, seed: int) -> DimmedSheetScene:
        """Build the world of one episode."""
        return DimmedSheetScene(self, seed)


class DimmedSheetScene:
    """See ``sheet.SheetScene``.

    Distance, angle, the lamp's place and grain are drawn from the seed. The lamp is a bulb, redder when dimmed (flux ~
    V^3.4, temperature ~ V^0.42, the usual rule for tungsten). The room reflects light like a closed room of 100 m².
    """

    def __init__(self, preset: DimmedSheet, seed: int) -> None:
        self._illuminances_lx = preset.illuminances_lx
        self.settling_steps = _SETTLING_FRAMES
        self.place, self.plan = "room", Rooms({"room": _ROOM_AREA}, ())
        rng = generator(seed, "sheet")
        self.place_m = np.array([rng.uniform(1.1, 1.6), rng.uniform(-0.25, 0.25)])
        self.heading_rad = float(np.arctan2(-self.place_m[1], -self.place_m[0]))
        self._bulb_m = (rng.uniform(0.6, 1.1), rng.choice([-1.0, 1.0]) * rng.uniform(0.5, 0.9), rng.uniform(1.5, 1.9))
        self.T_world_sheet = np.eye(4)
        self.T_world_sheet[:3, 3] = (_BEFORE_WALL_M, 0.0, LOWER_EDGE_M)
        self.speed_mps = 0.0
        self.world = World()
        width_m, height_m = _WALL_M
        wall = grained(_WALL_RGB, rng)
        corner_m, along_m, up_m = (0.0, -0.5 * width_m, 0.0), (0.0, width_m, 0.0), (0.0, 0.0, height_m)
        add_panel(self.world, new_panel("wall", corner_m, along_m, up_m, wall))
        self.sheet = self.world.add(sheet_mesh(rng), self.T_world_sheet, name="sheet", category="sheet")
        self.move_to(0)

    def move_to(self, frame: int) -> None:
        """See ``SheetScene``. Only the bulb changes, to the flux that gives the sheet its mean illuminance."""
        illuminance_lx = self._illuminances_lx[frame]
        temperature_k = _BRIGHTEST_K * (illuminance_lx / self._illuminances_lx[0]) ** _TEMPERATURE_EXPONENT
        of_1_lm = LampShader([Lamp(self._bulb_m, 1.0, temperature_k)], _ROOM)
        flux_lm = illuminance_lx / illuminance_on_sheet_lx(of_1_lm, self.T_world_sheet)
        self.shader = LampShader([Lamp(self._bulb_m, flux_lm, temperature_k)], _ROOM)
