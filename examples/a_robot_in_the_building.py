"""Drive a Husky of ``pybullet_data`` through the stereo building, and see it in the rendered pictures.

``python examples/a_robot_in_the_building.py`` writes ``robot.png``. Bullet moves the robot: it drives ahead until it
stands at the wall at the end of the hall. The pictures are those of the renderer and the light of the scene.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import pybullet_data
from numpy.typing import NDArray

from scenarios import catalog
from scenarios.stereo_follow.building import Building
from sim import bullet
from sim.render.protocol import create_renderer
from sim.shaders.baked.shader import BakedLightShader
from trackers.types import CameraModel

STEPS_A_FRAME, RATE_HZ = 8, 30
WHEELS, WHEEL_RAD_S, WHEEL_NM = (2, 3, 4, 5), 8.0, 60.0
CAMERA = CameraModel.from_field_of_view(320, 240, 1.2)


@dataclass
class Drive:
    """What happened.

    Attributes:
        way_m: (N, 2) the robot's places. wall_x_m: inner face of the wall that it drives against.
        picture_rgb: (H, W, 3) the last frame. is_robot: (H, W) where it shows the robot.
    """

    way_m: NDArray[np.float64]
    wall_x_m: float
    picture_rgb: NDArray[np.uint8]
    is_robot: NDArray[np.bool_]


def drive(seed: int = 3, frames: int = 240) -> Drive:
    """Drive the robot through the hall, beside its door."""
    scene = catalog.scenario("stereo-follow")
    kept = scene.keep_world(scene.presets["quick"], seed)
    world, building = kept.world.copy(), kept.content.building
    start_m = start_of(building)
    with bullet.client(world) as client:
        model = str(Path(pybullet_data.getDataPath()) / "husky" / "husky.urdf")
        robot = client.engine.loadURDF(model, [*start_m, 0.2])
        bodies = client.show(robot, "husky")
        shader, renderer = BakedLightShader(world, kept.content.baked), create_renderer("raster", world)
        for wheel in WHEELS:
            client.engine.setJointMotorControl2(
                robot, wheel, client.engine.VELOCITY_CONTROL, targetVelocity=WHEEL_RAD_S, force=WHEEL_NM
            )
        way_m = []
        for _ in range(frames):
            for _ in range(STEPS_A_FRAME):
                client.engine.stepSimulation()
            client.pull()
            way_m.append(world.poses[bodies[0].index][:2, 3].copy())
    # The camera looks along x from behind, 1.2 m above the floor.
    T_world_camera = np.array([[0, 0, 1, way_m[-1][0] - 3], [-1, 0, 0, way_m[-1][1]], [0, -1, 0, 1.2], [0, 0, 0, 1.0]])
    gbuffer = renderer.gbuffer(CAMERA, T_world_camera)
    radiance = shader.shade(gbuffer, CAMERA, T_world_camera).transpose(0, 2, 1)
    shown = np.clip(radiance / np.percentile(radiance, 95), 0.0, 1.0) ** (1 / 2.2)
    is_robot = np.isin(gbuffer.instance_id, [body.index for body in bodies])
    return Drive(np.array(way_m), building.plan.hall.x1, np.round(255 * shown).astype(np.uint8), is_robot)


def start_of(building: Building) -> NDArray[np.float64]:
    """Return a place in the hall, the larger part of the wall ahead in front of it."""
    hall, door = building.plan.hall, building.plan.door
    below = door.y0 - hall.y0 > hall.y1 - door.y1
    return np.array([0.5 * (hall.x0 + hall.x1), 0.5 * (hall.y0 + door.y0 if below else door.y1 + hall.y1)])


if __name__ == "__main__":
    driven = drive()
    cv2.imwrite("robot.png", driven.picture_rgb[..., ::-1])
    print(f"stands at x = {driven.way_m[-1, 0]:.2f} m, wall at {driven.wall_x_m:.2f} m; robot.png shows it")
