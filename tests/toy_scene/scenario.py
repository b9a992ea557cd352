"""Warm crates on a yard: a thermal camera at rest, and a second camera on a pan-tilt-zoom head that may be steered."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from scenarios import Objects, Scenario, SceneCamera, Setup, Stage
from scenarios.pan_tilt_zoom import Head, Mount
from sim.meshes.facets import painted_box
from sim.optics import look_down_pose
from sim.pose import pose_on_ground
from sim.world import World
from tests.toy_scene.thermal import BODY_K, GROUND_K, ThermalSensor, Warmth
from trackers.types import CameraModel, Carrier, CommandAxis, Observation

EMPTY_FRAMES = 5
HEIGHT_M, YARD_M, CRATE_M = 20.0, 30.0, (1.6, 0.9, 0.8)
_FAR_BELOW_M = -1000.0
HEAD = Carrier(
    "yard-head",
    (CommandAxis("pan_rad_s", 1.0, 40.0), CommandAxis("tilt_rad_s", 1.0, 40.0), CommandAxis("zoom_per_s", 0.5, 20.0)),
    "around",
)
"""A head that reaches any rate within a frame."""
LENS = CameraModel.from_field_of_view(320, 240, float(np.deg2rad(50.0)), band="thermal")
"""Of the camera on the head, not zoomed."""
MOUNT = Mount(
    HEAD,
    LENS,
    place_m=(-0.5 * YARD_M, -0.5 * YARD_M, 6.0),
    aim_m=(0.0, 0.0, -2.97),
    ahead=(1.0, 0.0, 0.0),
    left=(0.0, 1.0, 0.0),
    widest_pan_rad=np.pi,
    tilt_rad=(-float(np.deg2rad(80.0)), 0.0),
    zoom=(1.0, 4.0),
)
"""At the yard's corner."""


@dataclass(frozen=True)
class Yard:
    """Configuration of an episode."""

    summary: str
    frame_count: int = 40
    rate_hz: float = 10.0
    width_px: int = 96
    height_px: int = 72
    crates: int = 4
    speed_mps: float = 2.0
    closed_loop: bool = False


class YardEpisode(Stage):
    """See ``scenarios.scenario.Episode``. Crates drive in circles."""

    def __init__(self, setup: Setup) -> None:
        preset, rng, world = setup.preset, setup.rng("crates"), World()
        ground, crate = (painted_box(size_m, (128, 128, 128)) for size_m in ((2 * YARD_M, 2 * YARD_M, 0.01), CRATE_M))
        world.add(ground, pose_on_ground(0, 0, 0), name="ground", category="ground")
        names = ["target", *(f"crate-{k}" for k in range(1, preset.crates))]
        crates = [world.add(crate, np.eye(4), name=name, category="crate", movable=True) for name in names]
        kelvin = np.full(len(world.bodies), GROUND_K)
        kelvin[[body.index for body in crates]] = BODY_K
        self._shader = Warmth(kelvin)
        self._radius_m = rng.uniform(3.0, 0.4 * YARD_M, preset.crates)
        self._phase_rad = rng.uniform(0, 2 * np.pi, preset.crates)
        self._speed_mps = preset.speed_mps * rng.uniform(0.5, 1.0, preset.crates)
        self._view = CameraModel.from_field_of_view(
            preset.width_px, preset.height_px, float(np.deg2rad(70.0)), band="thermal"
        )
        self._T_world_camera = look_down_pose(np.array([0.0, 0.0, HEIGHT_M]), 0.0, 0.0, 0.0)
        camera, head = self._overview(setup, world, "sensor"), Head(MOUNT, preset.rate_hz)
        super().__init__(setup, Objects(world, crates), camera, head=head)

    def _overview(self, setup: Setup, world: World, stream: str) -> SceneCamera:
        return SceneCamera(setup, world, self._view, ThermalSensor(setup.rng(stream)))

    def _move_to(self, frame: int) -> None:
        angle = self._phase_rad + self._speed_mps / self._radius_m * frame / self.rate_hz
        x_m, y_m = self._radius_m * np.cos(angle), self._radius_m * np.sin(angle)
        poses = [pose_on_ground(*place) for place in zip(x_m, y_m, angle + np.pi / 2, strict=True)]
        self._objects.move(np.array(poses), self._speed_mps)

    def _empty_pictures(self) -> Sequence[Observation]:
        away = self._objects.T_world_object.copy()
        away[:, 2, 3] = _FAR_BELOW_M
        self._objects.move(away, self._speed_mps)
        camera = self._overview(self._setup, self.world, "background")
        taken = [camera.take(self._shader, self._T_world_camera, k).picture for k in range(EMPTY_FRAMES)]
        return [camera.observation(picture, (k - EMPTY_FRAMES) / self.rate_hz) for k, picture in enumerate(taken)]


TOY_YARD: Scenario[Any] = Scenario(
    id="toy-yard-v1",
    summary="warm crates on a yard, under a thermal camera at rest",
    start="a picture of the empty yard, and the box of one crate",
    stage=YardEpisode,
    presets={"standard": Yard("four crates"), "quick": Yard("two crates", frame_count=20, crates=2)},
    classes={"crate": "crate"},
    carrier=HEAD,
)
