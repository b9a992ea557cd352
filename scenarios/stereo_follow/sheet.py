"""A green sheet on a white wall under one lamp that is dimmed: the world of paper B's experiment I."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from scenarios.scenario import RendererName
from sim.mesh import Texture, TexturedMesh
from sim.meshes.facets import Facets
from sim.optics import PinholeCamera, project
from sim.render.protocol import create_renderer
from sim.rng import generator
from sim.sensors.camera_sensor import CameraSensor
from sim.sensors.exposure import metered_radiance
from sim.sensors.registers import STEREO_SENSOR, registers
from sim.shaders.colour import LUMINANCE_WEIGHTS
from sim.shaders.lamps import Lamp, LampShader, Surroundings
from sim.world import World
from trackers.types import CameraRegisters

ILLUMINANCES_LX = (609.0, 533.0, 414.0, 311.0, 203.0, 122.0, 86.0, 38.0, 19.0)
"""On the sheet, one after the other."""
_CAMERA = PinholeCamera.from_field_of_view(640, 480, np.deg2rad(66.0))
_CAMERA_HEIGHT_M = 1.2
_WALL_M = (6.0, 3.0)
_SHEET_M = (0.54, 0.38)
_ROOM = Surroundings(surface_m2=100.0, reflectance=0.5)
_BRIGHTEST_K, _TEMPERATURE_EXPONENT = 2850.0, 0.42 / 3.4
_SETTLING_FRAMES = 60
_INNER = 0.8
_WALL_RGB, _SHEET_RGB = (222, 220, 214), (62, 146, 92)
_GRAIN_TEXELS = 512


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
    is a bulb: what it dims to glows redder (flux ~ V^3.4, temperature ~ V^0.42). The room throws light back like a
    closed one of 100 m².

    Args:
        seed: of the episode, see ``sim.rng.episode_seed``.
    """
    rng = generator(seed, "sheet")
    T_world_camera = _camera_pose(distance_m=rng.uniform(1.1, 1.6), aside_m=rng.uniform(-0.25, 0.25))
    bulb_m = (rng.uniform(0.6, 1.1), rng.choice([-1.0, 1.0]) * rng.uniform(0.5, 0.9), rng.uniform(1.5, 1.9))
    sensor = CameraSensor(STEREO_SENSOR, generator(seed, "sensor"))
    with World() as world:
        _hang(world, rng)
        gbuffer = create_renderer(renderer, world).gbuffer(_CAMERA, T_world_camera)
        for frame, illuminance_lx in enumerate(ILLUMINANCES_LX):
            shader = LampShader([_bulb(bulb_m, illuminance_lx)], _ROOM)
            radiance = shader.shade(gbuffer, _CAMERA, T_world_camera)
            for _ in range(_SETTLING_FRAMES):
                sensor.step(metered_radiance(radiance))
            picture = sensor.expose(radiance, _CAMERA, frame)
            reported = registers(picture.settings)
            yield SheetPicture(
                _mean_illuminance_lx(shader),
                picture.image_rgb,
                CameraRegisters(reported.red, reported.blue, reported.shutter, reported.gain),
                _region(T_world_camera),
            )
            sensor.hold(exposure=condition.fixed_exposure, white_balance=condition.fixed_white_balance)


def _bulb(position_m: tuple[float, float, float], illuminance_lx: float) -> Lamp:
    """Return the bulb with the flux that brings the sheet to a mean illuminance."""
    temperature_k = _BRIGHTEST_K * (illuminance_lx / ILLUMINANCES_LX[0]) ** _TEMPERATURE_EXPONENT
    by_1_lm = _mean_illuminance_lx(LampShader([Lamp(position_m, 1.0, temperature_k)], _ROOM))
    return Lamp(position_m, illuminance_lx / by_1_lm, temperature_k)


def _mean_illuminance_lx(shader: LampShader) -> float:
    u, v = (g.ravel() for g in np.meshgrid(np.linspace(-0.5, 0.5, 9), np.linspace(-0.5, 0.5, 7)))
    points = np.column_stack([np.zeros_like(u), _SHEET_M[0] * u, _CAMERA_HEIGHT_M + _SHEET_M[1] * v])
    return float((shader.illuminance_lx(points, np.tile([1.0, 0.0, 0.0], (len(u), 1))) @ LUMINANCE_WEIGHTS).mean())


def _hang(world: World, rng: np.random.Generator) -> None:
    """Put up the wall, in the plane x = 0 and facing +x, and the sheet a millimetre before it."""
    wall_texture, sheet_texture = (_paper(rgb, rng) for rgb in (_WALL_RGB, _SHEET_RGB))
    wall = _upright(0.0, _WALL_M, 0.5 * _WALL_M[1], wall_texture)
    world.add(wall, np.eye(4), name="wall", category="building")
    sheet = _upright(0.001, _SHEET_M, _CAMERA_HEIGHT_M, sheet_texture)
    world.add(sheet, np.eye(4), name="sheet", category="sheet")


def _upright(x_m: float, size_m: tuple[float, float], middle_m: float, texture: Texture) -> TexturedMesh:
    facets = Facets()
    y, z = 0.5 * size_m[0], 0.5 * size_m[1]
    corners = [(x_m, -y, middle_m - z), (x_m, y, middle_m - z), (x_m, y, middle_m + z), (x_m, -y, middle_m + z)]
    facets.polygon(corners, [(0, 1), (1, 1), (1, 0), (0, 0)])
    return facets.mesh(texture)


def _paper(rgb: tuple[int, int, int], rng: np.random.Generator) -> Texture:
    """Return an even colour with a little grain, fine and coarse."""
    fine, coarse = rng.normal(size=(2, _GRAIN_TEXELS, _GRAIN_TEXELS)).astype(np.float32)
    clouds = cv2.GaussianBlur(coarse, (0, 0), 30.0)
    grain = 1.0 + 0.012 * fine + 0.015 * clouds / clouds.std()
    return Texture(np.clip(np.array(rgb) * grain[..., None] + 0.5, 0, 255).astype(np.uint8), smooth=True)


def _camera_pose(distance_m: float, aside_m: float) -> NDArray[np.float64]:
    """Return T_world_camera (4, 4) of a level camera that looks at the sheet's middle."""
    eye = np.array([distance_m, aside_m, _CAMERA_HEIGHT_M])
    forward = np.array([0.0, 0.0, _CAMERA_HEIGHT_M]) - eye
    forward /= np.linalg.norm(forward)
    down = np.array([0.0, 0.0, -1.0])
    T = np.eye(4)
    T[:3, :3] = np.column_stack([np.cross(down, forward), down, forward])
    T[:3, 3] = eye
    return T


def _region(T_world_camera: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the rectangle (4,) within the picture of the sheet's inner part."""
    y, z = 0.5 * _INNER * _SHEET_M[0], 0.5 * _INNER * _SHEET_M[1]
    corners = [(0.0, a * y, _CAMERA_HEIGHT_M + b * z) for a, b in ((-1, -1), (-1, 1), (1, -1), (1, 1))]
    pixels = np.sort(project(_CAMERA, T_world_camera, np.array(corners))[0], axis=0)
    return np.concatenate([pixels[1], pixels[2]])
