"""A green sheet on a white wall under one lamp that is dimmed: the world of paper B's experiment I."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenarios.scenario import RendererName
from scenarios.stereo_follow.camera import CAMERA_HEIGHT_M, SENSOR, camera, camera_pose, registers
from scenarios.stereo_follow.indoors import add_panel, grained
from sim.optics import PinholeCamera, project
from sim.render.protocol import create_renderer
from sim.rng import generator
from sim.sensors.camera_sensor import CameraSensor
from sim.sensors.exposure import metered_radiance
from sim.shaders.colour import LUMINANCE_WEIGHTS
from sim.shaders.lamps import Lamp, LampShader, Surroundings
from sim.world import World
from trackers.types import CameraRegisters

ILLUMINANCES_LX = (609.0, 533.0, 414.0, 311.0, 203.0, 122.0, 86.0, 38.0, 19.0)
"""On the sheet, one after the other."""
_CAMERA = camera(640, 480)
_WALL_M = (6.0, 3.0)
_ROOM = Surroundings(surface_m2=100.0, reflectance=0.5)
_BRIGHTEST_K, _TEMPERATURE_EXPONENT = 2850.0, 0.42 / 3.4
_SETTLING_FRAMES = 60
_INNER = 0.8
_WALL_RGB = (222, 220, 214)

SHEET_M, SHEET_RGB = (0.54, 0.38), (62, 146, 92)
"""Green drawing paper."""


@dataclass(frozen=True, slots=True)
class Condition:
    """Which of the camera's loops stay as they were at the greatest illuminance (Table 2).

    Attributes:
        name: as the paper numbers it.
        fixed_exposure: shutter and gain. fixed_white_balance: red and blue gain.
    """

    name: str
    fixed_exposure: bool
    fixed_white_balance: bool


CONDITIONS = (Condition("I", False, False), Condition("II", True, False), Condition("III", False, True))


@dataclass(frozen=True, slots=True)
class SheetPicture:
    """One picture of the sheet, taken when the camera's loops had come to rest.

    Attributes:
        illuminance_lx: mean on the sheet.
        image_rgb: (480, 640, 3) uint8.
        registers: the camera's settings.
        region_xyxy: (4,) rectangle within the sheet whose colours are looked at, pixels.
    """

    illuminance_lx: float
    image_rgb: NDArray[np.uint8]
    registers: CameraRegisters
    region_xyxy: NDArray[np.float64]


def photograph(condition: Condition, seed: int, renderer: RendererName = "raster") -> Iterator[SheetPicture]:
    """Yield a picture for each illuminance, the brightest first.

    Distance, angle, the lamp's stand, grain and noise are drawn from the seed, the same for every condition. The lamp
    is a bulb: what it dims to glows redder (flux ~ V^3.4, temperature ~ V^0.42, the usual rule for tungsten). The room
    throws light back like a closed one of 100 m².

    Args:
        seed: of the episode, see ``sim.rng.episode_seed``.
    """
    rng = generator(seed, "sheet")
    place_m = np.array([rng.uniform(1.1, 1.6), rng.uniform(-0.25, 0.25)])
    T_world_camera = camera_pose(place_m, float(np.arctan2(-place_m[1], -place_m[0])))
    bulb_m = (rng.uniform(0.6, 1.1), rng.choice([-1.0, 1.0]) * rng.uniform(0.5, 0.9), rng.uniform(1.5, 1.9))
    sensor = CameraSensor(SENSOR, generator(seed, "sensor"))
    with World() as world:
        _hang(world, rng)
        gbuffer = create_renderer(renderer, world).gbuffer(_CAMERA, T_world_camera)
        for frame, illuminance_lx in enumerate(ILLUMINANCES_LX):
            shader = LampShader([_bulb(bulb_m, illuminance_lx)], _ROOM)
            radiance = shader.shade(gbuffer, _CAMERA, T_world_camera)
            for _ in range(_SETTLING_FRAMES):
                sensor.step(metered_radiance(radiance))
            picture = sensor.expose(radiance, _CAMERA, frame)
            yield SheetPicture(
                _mean_illuminance_lx(shader),
                picture.image_rgb,
                registers(picture.settings),
                region_of_sheet(_CAMERA, T_world_camera, np.eye(4)),
            )
            sensor.hold(exposure=condition.fixed_exposure, white_balance=condition.fixed_white_balance)


def _bulb(position_m: tuple[float, float, float], illuminance_lx: float) -> Lamp:
    """Return the bulb with the flux that brings the sheet to a mean illuminance."""
    temperature_k = _BRIGHTEST_K * (illuminance_lx / ILLUMINANCES_LX[0]) ** _TEMPERATURE_EXPONENT
    by_1_lm = _mean_illuminance_lx(LampShader([Lamp(position_m, 1.0, temperature_k)], _ROOM))
    return Lamp(position_m, illuminance_lx / by_1_lm, temperature_k)


def _mean_illuminance_lx(shader: LampShader) -> float:
    u, v = (g.ravel() for g in np.meshgrid(np.linspace(-0.5, 0.5, 9), np.linspace(-0.5, 0.5, 7)))
    points = np.column_stack([np.zeros_like(u), SHEET_M[0] * u, CAMERA_HEIGHT_M + SHEET_M[1] * v])
    return float((shader.illuminance_lx(points, np.tile([1.0, 0.0, 0.0], (len(u), 1))) @ LUMINANCE_WEIGHTS).mean())


def _hang(world: World, rng: np.random.Generator) -> None:
    """Put up the wall, in the plane x = 0 and facing +x, and the sheet a millimetre before it."""
    for name, x_m, (width_m, height_m), middle_m, rgb in (
        ("wall", 0.0, _WALL_M, 0.5 * _WALL_M[1], _WALL_RGB),
        ("sheet", 0.001, SHEET_M, CAMERA_HEIGHT_M, SHEET_RGB),
    ):
        corner_m = (x_m, -0.5 * width_m, middle_m - 0.5 * height_m)
        add_panel(world, name, corner_m, (0.0, width_m, 0.0), (0.0, 0.0, height_m), grained(rgb, rng))


def region_of_sheet(
    camera: PinholeCamera, T_world_camera: NDArray[np.float64], T_world_sheet: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the rectangle (4,) within the picture of the inner part of a sheet in the plane x = 0 of its frame, its
    middle at the camera's height.
    """
    y, z = 0.5 * _INNER * SHEET_M[0], 0.5 * _INNER * SHEET_M[1]
    corners = np.array([(0.0, a * y, CAMERA_HEIGHT_M + b * z) for a, b in ((-1, -1), (-1, 1), (1, -1), (1, 1))])
    corners = corners @ T_world_sheet[:3, :3].T + T_world_sheet[:3, 3]
    pixels = np.sort(project(camera, T_world_camera, corners)[0], axis=0)
    return np.concatenate([pixels[1], pixels[2]])
