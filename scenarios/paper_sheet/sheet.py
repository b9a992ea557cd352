"""A sheet of green drawing paper, the target of paper B's experiments on the camera, and the protocol of its worlds.

The sheet's frame: the origin is the middle of its lower edge, x points away from its green side, z is up.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from scenarios.stereo_follow.camera import CAMERA_HEIGHT_M
from scenarios.stereo_follow.floor_plan import Area
from scenarios.stereo_follow.panels import grained, panel
from sim.mesh import TexturedMesh
from sim.optics import project
from sim.shaders.colour import LUMINANCE_WEIGHTS
from sim.shaders.lamps import LampShader
from sim.world import Body, World
from trackers.types import CameraModel

SHEET_M = (0.54, 0.38)
"""Width and height."""
LOWER_EDGE_M = CAMERA_HEIGHT_M - 0.5 * SHEET_M[1]
"""Height above the ground: the sheet's middle is as high as the camera."""
_SHEET_RGB = (62, 146, 92)
_INNER = 0.8


@dataclass(frozen=True, slots=True)
class Rooms:
    """See ``floor_plan.RoomPlan``."""

    rooms: dict[str, Area]
    openings: tuple[Area, ...]


class SheetScene(Protocol):
    """A world with a sheet, and the camera's path in it.

    Attributes:
        settling_steps: steps of the camera's loops before each picture, in addition to the picture's own step.
        world, sheet: the bodies, and the target's body.
        shader: the current light.
        place_m, heading_rad: of the camera now: (2,) and about the vertical.
        T_world_sheet: (4, 4) now. speed_mps: of the sheet now.
        place: name of the place.
        plan: its walls.
    """

    settling_steps: int
    world: World
    sheet: Body
    shader: LampShader
    place_m: NDArray[np.float64]
    heading_rad: float
    T_world_sheet: NDArray[np.float64]
    speed_mps: float
    place: str
    plan: Rooms

    def move_to(self, frame: int) -> None:
        """Set bodies, camera and light to a frame."""
        ...


def sheet_mesh(rng: np.random.Generator) -> TexturedMesh:
    """Return the sheet in its frame, with its own grain."""
    width_m, height_m = SHEET_M
    return panel((0.0, -0.5 * width_m, 0.0), (0.0, width_m, 0.0), (0.0, 0.0, height_m), grained(_SHEET_RGB, rng))


def illuminance_on_sheet_lx(shader: LampShader, T_world_sheet: NDArray[np.float64]) -> float:
    """Return the mean illuminance on the sheet's green side."""
    y, z = (g.ravel() for g in np.meshgrid(np.linspace(-0.5, 0.5, 9), np.linspace(0.0, 1.0, 7)))
    points_m = np.column_stack([np.zeros_like(y), SHEET_M[0] * y, SHEET_M[1] * z])
    points_m = points_m @ T_world_sheet[:3, :3].T + T_world_sheet[:3, 3]
    return float(
        (shader.illuminance_lx(points_m, np.tile(T_world_sheet[:3, 0], (len(y), 1))) @ LUMINANCE_WEIGHTS).mean()
    )


def region_of_sheet(
    camera: CameraModel, T_world_camera: NDArray[np.float64], T_world_sheet: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the rectangle (4,), pixels, that lies within the picture of the sheet's inner part."""
    y, z = 0.5 * _INNER * SHEET_M[0], 0.5 * _INNER * SHEET_M[1]
    corners = np.array([(0.0, a * y, 0.5 * SHEET_M[1] + b * z) for a, b in ((-1, -1), (-1, 1), (1, -1), (1, 1))])
    corners = corners @ T_world_sheet[:3, :3].T + T_world_sheet[:3, 3]
    pixels = np.sort(project(camera, T_world_camera, corners)[0], axis=0)
    return np.concatenate([pixels[1], pixels[2]])
