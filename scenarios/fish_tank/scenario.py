"""The scenario ``fish-tank-v1``: a shoal in a tank, seen from above through rippled water.

By Bullet's closest points no two fish stand deeper in one another than 2 cm at any of 120 instants of ``quick`` (seeds
0 to 19, ``python -m tests.scenarios.standing_in_one_another fish-tank quick``).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.fish_tank.fish import Fish, FishLabels
from scenarios.fish_tank.pictureless.bank import TankPictureless
from scenarios.fish_tank.presets import PRESETS, FishTank
from scenarios.fish_tank.shoal import kind_of, swim
from scenarios.fish_tank.tank import VOLUME_M, Volume, add_leaves, build_tank, room_lights, varied_lights
from scenarios.fish_tank.truth import FishTruth
from scenarios.objects import Labels
from scenarios.pan_tilt_zoom import Head, Mount
from scenarios.scenario import Scenario, Setup
from scenarios.stage import SceneCamera, Stage
from sim.labels import bright_fractions
from sim.meshes.fish import draw_look
from sim.optics import look_down_pose
from sim.render.pipeline import Capture
from sim.render.refraction import ThroughWater
from sim.sensors.camera_sensor import CameraSensor
from sim.sensors.config import SensorConfig
from sim.shaders.water import WaterShader
from sim.water_surface import RippledSurface, Ripples, draw_waves
from sim.world import World
from trackers.types import CameraModel, Carrier, CommandAxis, EgoPose, Observation

HEAD = Carrier(
    "tank-head",
    (CommandAxis("pan_rad_s", 2.0, 12.0), CommandAxis("tilt_rad_s", 2.0, 12.0), CommandAxis("zoom_per_s", 1.0, 5.0)),
    "around",
)
"""Limits are those of a small servo head with a motor zoom."""
LENS = CameraModel.from_field_of_view(320, 240, float(np.deg2rad(15.0)))
"""Of its camera at zoom 1: it then sees two fifths of the tank's length."""
MOUNT = Mount(
    HEAD,
    LENS,
    place_m=(0.0, -0.5, 0.85),
    aim_m=(0.0, 0.0, 0.0),
    ahead=(0.0, 1.0, 0.0),
    left=(-1.0, 0.0, 0.0),
    widest_pan_rad=1.3,
    tilt_rad=(-1.4, -0.5),
    zoom=(1.0, 3.0),
)


_HEIGHT_M, _PIXELS_PER_M = 1.6, 925.0
"""Height of the overview camera above the floor, and its scale there in pictures 640 pixels wide."""
_AMBIENT_LX = 250.0
"""Light from all around: of walls and ceiling."""
_SENSOR = SensorConfig(longest_exposure_s=8e-3, mid_grey=0.3)
"""A camera in a laboratory: its exposure is short enough for fish that dart."""
_GLARE_LEVEL = 200
"""A pixel shows a mirrored lamp where all channels are at least this: no fish is so bright by itself."""
_EMPTY_PICTURES, _EMPTY_EVERY_S = 20, 0.5


class FishTankEpisode(Stage):
    """See ``scenarios.scenario.Episode``."""

    _objects: Fish

    def __init__(self, setup: Setup) -> None:
        preset, world = setup.preset, World()
        self._volume_m, is_round = preset.tank_m, preset.tank_shape == "round"
        build_tank(world, setup.rng("tank"), preset.tank_m, is_round=is_round, floor=preset.floor)
        leaf_id = add_leaves(world, preset.leaves, preset.tank_m, setup.rng("leaves"), is_round=is_round)
        focal_px = _PIXELS_PER_M * _HEIGHT_M * min(preset.width_px / 640, preset.height_px / 480) * _closeness(preset)
        self._view = CameraModel(preset.width_px, preset.height_px, focal_px)
        rng = setup.rng("looks")
        kinds = [preset.species[k % len(preset.species)] for k in range(preset.fish)]
        looks = [draw_look(rng, preset.variety, kind) for kind in kinds]
        lengths_m = np.array([look.length_m for look in looks])
        swims = swim(
            preset.tank_m,
            lengths_m,
            preset.frame_count,
            preset.rate_hz,
            preset.character,
            setup.rng("shoal"),
            [] if set(kinds) == {"zebrafish"} else [kind_of(kind) for kind in kinds],
            is_round=is_round,
        )
        self._surface = _surface(preset.ripples, preset.tank_m, setup.rng("ripples"))
        fish = Fish(world, swims, looks, self._surface, rng)
        fish.cover_id = leaf_id
        if preset.lamps == "room":
            lights = room_lights(setup.rng("light"), preset.glare, preset.lamp)
        else:
            lights = varied_lights(setup.rng("light"), preset.glare, preset.lamp, preset.tank_m)
        is_smooth = preset.glare_edge == "smooth"
        self._shader = WaterShader(world, self._surface, preset.water, lights, _AMBIENT_LX, smooth_glare=is_smooth)
        self._T_world_camera = look_down_pose(np.array([0.0, 0.0, _HEIGHT_M]), 0.5 * np.pi, 0.0, 0.0)
        super().__init__(setup, fish, self._overview(setup, world, "sensor"), head=self._head_over(setup, fish))

    def _head_over(self, setup: Setup, fish: Fish) -> Head:
        """Return the head of the steered camera."""
        return Head(MOUNT, setup.preset.rate_hz)

    def map_of(self) -> tuple[float, float, float]:
        """Return length, width and depth of the water about (0, 0), in metres."""
        return self._volume_m

    def _move_to(self, frame: int) -> None:
        self._surface.time_s = frame / self.rate_hz
        self._objects.move_to(frame)

    def _may_be_hidden(self) -> bool:
        """Only fish and leaves hide fish: where no other box reaches into the target's, it is seen as a whole."""
        if len(self._objects.cover_id):
            return True
        boxes = self._objects.labels(self._view, self._T_world_camera).box_xyxy
        own, others = boxes[self._target], np.delete(boxes, self._target, axis=0)
        return bool(((others[:, :2] < own[2:]) & (others[:, 2:] > own[:2])).all(axis=1).any())

    def _overview(self, setup: Setup, world: World, stream: str) -> SceneCamera:
        """Return the overview camera with a sensor of its own."""
        sensor = CameraSensor(_SENSOR, setup.rng(stream))
        return SceneCamera(
            setup, world, self._view, sensor, through=lambda renderer: ThroughWater(renderer, self._surface)
        )

    def _measured(self, T_world_camera: NDArray[np.float64]) -> EgoPose:
        """Return a pose relative to the plane at half the water's depth: its "ground"."""
        T = T_world_camera.copy()
        T[2, 3] -= 0.5 * self._volume_m[2]
        return EgoPose(T)

    def _empty_pictures(self) -> list[Observation]:
        camera = self._overview(self._setup, self.world, "background")
        pictures = []
        self._objects.take_out()
        for k in range(_EMPTY_PICTURES):
            self._surface.time_s = (k - _EMPTY_PICTURES) * _EMPTY_EVERY_S
            seen = camera.take(self._shader, self._T_world_camera, k)
            pictures.append(camera.observation(seen.picture, self._surface.time_s))
        return pictures

    def _of_camera(self, labels: Labels) -> dict[str, Any]:
        assert isinstance(labels, FishLabels)
        return {"centre_line_px": labels.centre_line_px, "heading_rad": labels.heading_rad}

    def _own_truth(self, capture: Capture[Any], labels: Labels) -> dict[str, Any]:
        fish, picture = self._objects, capture.picture
        return {
            "glare_fraction": bright_fractions(picture.image_rgb, capture.instance_id, fish.instance_id, _GLARE_LEVEL),
            "centre_line_m": fish.centre_line_m,
            "below_surface_m": fish.below_surface_m,
            "hidden_by": labels.hidden_by,
        }


def _closeness(preset: FishTank) -> float:
    """Return the factor by which the overview's lens is longer, so that it shows any tank as large as the usual one."""
    return 1.0 / max(preset.tank_m[0] / VOLUME_M[0], preset.tank_m[1] / VOLUME_M[1])


def _surface(ripples: Ripples, volume_m: Volume, rng: np.random.Generator) -> RippledSurface:
    x_m, y_m, depth_m = volume_m
    corner_m = 0.5 * x_m, 0.5 * y_m
    return RippledSurface(draw_waves(ripples, depth_m, rng), (-corner_m[0], -corner_m[1]), corner_m, depth_m, depth_m)


FISH_TANK = Scenario(
    id="fish-tank-v1",
    summary="a shoal in a tank, seen from above through rippled water",
    start="pictures of the tank without fish; for trackers of one target, the box of one fish",
    stage=FishTankEpisode,
    presets=PRESETS,
    classes={"fish": "fish"},
    carrier=HEAD,
    truth=FishTruth,
    target="fish-0",
    pictureless=TankPictureless(),
)
