"""One episode of ``fish-tank``: the overview camera is at rest; a second camera, on the head, may be steered."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.camera_rig import SingleCamera
from scenarios.fish_tank.fish import Fish, Sighted
from scenarios.fish_tank.head import LENS, MOUNT
from scenarios.fish_tank.light import room_lights
from scenarios.fish_tank.presets import FishTank
from scenarios.fish_tank.shoal import swim
from scenarios.fish_tank.tank import VOLUME_M, build_tank
from scenarios.fish_tank.truth import FishTruth
from scenarios.pan_tilt_zoom import Head
from scenarios.scenario import Frame, RendererName
from scenarios.stage import Stage, covers_all
from scenarios.truth import TruthExtent, without_pixels
from scenarios.visibility import Exits, states_of
from sim.labels import bright_fractions
from sim.meshes.fish import draw_look
from sim.optics import PinholeCamera, look_down_pose
from sim.render.refraction import ThroughWater
from sim.rng import generator
from sim.sensors.camera_sensor import CameraSensor
from sim.sensors.config import SensorConfig
from sim.shaders.water import WaterShader
from sim.water_surface import RippledSurface, Ripples, draw_waves
from sim.world import World
from trackers.types import CameraCommand, CameraModel, CameraSettings, EgoPose, Observation, Start, SteeredCamera

TARGET = "fish-0"
_HEIGHT_M, _PIXELS_PER_M = 1.6, 925.0
"""Height of the overview camera above the floor, and its scale there in pictures 640 pixels wide."""
_MIDDLE_M = 0.5 * VOLUME_M[2]
"""Measured poses are relative to the plane at half the water's depth: their "ground"."""
_AMBIENT_LX = 250.0
"""Light from all around: of walls and ceiling."""
_SENSOR = SensorConfig(longest_exposure_s=8e-3, mid_grey=0.3)
"""A camera in a laboratory: its exposure is short enough for fish that dart."""
_GLARE_LEVEL = 200
"""A pixel shows a mirrored lamp where all channels are at least this: no fish is so bright by itself."""
_EMPTY_PICTURES, _EMPTY_EVERY_S = 20, 0.5


class FishTankEpisode(Stage):
    """See ``scenarios.scenario.Episode``."""

    def __init__(
        self, preset: FishTank, seed: int, renderer: RendererName, closed_loop: bool, truth: TruthExtent
    ) -> None:
        self._all, self._seed, self._renderer = covers_all(truth), seed, renderer
        world = World()
        build_tank(world, generator(seed, "tank"))
        focal_px = _PIXELS_PER_M * _HEIGHT_M * min(preset.width_px / 640, preset.height_px / 480)
        self._view = PinholeCamera(preset.width_px, preset.height_px, focal_px)
        rng = generator(seed, "looks")
        looks = [draw_look(rng, preset.variety) for _ in range(preset.fish)]
        lengths_m = np.array([look.length_m for look in looks])
        self._swims = swim(
            VOLUME_M, lengths_m, preset.frame_count, preset.rate_hz, preset.character, generator(seed, "shoal")
        )
        self._fish = Fish(world, self._swims, looks, rng)
        self._surface = _surface(preset.ripples, generator(seed, "ripples"))
        self._water = WaterShader(
            world,
            self._surface,
            preset.water,
            room_lights(generator(seed, "light"), preset.glare, preset.lamp),
            _AMBIENT_LX,
        )
        self._camera = self._overview(world, "sensor")
        super().__init__(
            world, self._camera, frame_count=preset.frame_count, rate_hz=preset.rate_hz, closed_loop=closed_loop
        )
        self._T_world_camera = look_down_pose(np.array([0.0, 0.0, _HEIGHT_M]), 0.5 * np.pi, 0.0, 0.0)
        self._head = Head(MOUNT, preset.rate_hz)
        self._head_exits = Exits(LENS, preset.fish)
        self._move_to(0)
        first = self._seen_by(self._view, self._T_world_camera)
        self._start = Start(_model(self._view), first.box_xyxy[self._fish.names.index(TARGET)], self._empty_tank())

    @property
    def start(self) -> Start:
        """Pictures of the tank without fish, and the box of the fish that a tracker of one target is started on."""
        return self._start

    @property
    def _shader(self) -> WaterShader:
        return self._water

    def map_of(self) -> tuple[float, float, float]:
        """Return length, width and depth of the water about (0, 0), in metres."""
        return VOLUME_M

    def _obey(self, command: CameraCommand) -> None:
        self._head.obey(command)

    def _move_to(self, frame: int) -> None:
        self._set_time(frame / self.rate_hz)
        self._fish.move_to(frame)

    def _set_time(self, time_s: float) -> None:
        self._surface.time_s = time_s

    def _overview(self, world: World, stream: str) -> SingleCamera:
        """Return the overview camera with a sensor of its own."""
        sensor = CameraSensor(_SENSOR, generator(self._seed, stream))
        return SingleCamera(
            world, self._view, self._renderer, sensor, through=lambda renderer: ThroughWater(renderer, self._surface)
        )

    def _empty_tank(self) -> tuple[Observation, ...]:
        camera = self._overview(self.world, "background")
        pictures = []
        self._fish.take_out()
        for k in range(_EMPTY_PICTURES):
            time_s = (k - _EMPTY_PICTURES) * _EMPTY_EVERY_S
            self._set_time(time_s)
            seen = camera.take(self._water, self._T_world_camera, k).picture
            settings = CameraSettings(seen.settings.exposure_s, seen.settings.gain)
            pictures.append(Observation(seen.image_rgb, time_s, _model(self._view), settings))
        self._move_to(0)
        return tuple(pictures)

    def _seen_by(
        self, camera: PinholeCamera, T: NDArray[np.float64], merged: NDArray[np.int32] | None = None
    ) -> Sighted:
        return self._fish.seen(camera, T, self._surface, merged, in_full=self._all)

    def _take(self, frame: int) -> Frame:
        capture = self._camera.take(self._water, self._T_world_camera, frame)
        steers = self.closed_loop
        # In place: the map belongs to this frame alone.
        self._fish.merge(capture.instance_id)
        fish, seen = self._fish, self._seen_by(self._view, self._T_world_camera, capture.instance_id)
        common = self._seen(
            capture,
            T_world_object=fish.T_world_fish,
            size_m=fish.size_m,
            box_xyxy=seen.box_xyxy,
            visible_fraction=seen.visible_fraction,
        )
        truth = FishTruth(
            **{**common, "position_px": seen.position_px},
            names=fish.names,
            bounds_m=fish.bounds_m(),
            kinds=("fish",) * len(fish.names),
            instance_id=fish.instance_id,
            speed_mps=self._swims.speed_mps[frame].copy(),
            glare_fraction=bright_fractions(
                capture.picture.image_rgb, capture.instance_id, fish.instance_id, _GLARE_LEVEL
            ),
            centre_line_m=fish.centre_line_m,
            below_surface_m=VOLUME_M[2] - self._swims.position_m[frame, :, 2],
            **seen.postures(),
        )
        observation = Observation(
            image_rgb=capture.picture.image_rgb,
            time_s=truth.time_s,
            camera=_model(self._view),
            settings=CameraSettings(truth.exposure_s, truth.gain),
            ego=_measured(self._T_world_camera),
            steered=SteeredCamera(_model(self._head.camera), _measured(self._head.T_world_camera)) if steers else None,
        )
        return Frame(observation, truth, steered=self._by_head(truth) if steers else None)

    def _by_head(self, truth: FishTruth) -> FishTruth:
        """Return the truth of the steered camera: it takes no picture, and what the overview sees counts as seen."""
        camera, T = self._head.camera, self._head.T_world_camera
        seen = self._seen_by(camera, T)
        state = states_of(camera, seen.box_xyxy, truth.visible_fraction)
        side, since = self._head_exits.follow(state, seen.box_xyxy)
        changes: dict[str, Any] = {**seen.postures(), "hidden_by": truth.hidden_by}
        return replace(
            without_pixels(truth),
            T_world_camera=T,
            box_xyxy=seen.box_xyxy,
            position_px=seen.position_px,
            state=state,
            side=side,
            frames_since_exit=since,
            **changes,
        )


def _surface(ripples: Ripples, rng: np.random.Generator) -> RippledSurface:
    x_m, y_m, depth_m = VOLUME_M
    corner_m = 0.5 * x_m, 0.5 * y_m
    return RippledSurface(draw_waves(ripples, depth_m, rng), (-corner_m[0], -corner_m[1]), corner_m, depth_m, depth_m)


def _model(camera: PinholeCamera) -> CameraModel:
    return CameraModel(camera.width_px, camera.height_px, camera.focal_px)


def _measured(T_world_camera: NDArray[np.float64]) -> EgoPose:
    T = T_world_camera.copy()
    T[2, 3] -= _MIDDLE_M
    return EgoPose(T)
