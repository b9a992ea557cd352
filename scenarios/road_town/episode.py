"""One episode of ``road-town``: the plan carried out, frame by frame."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenarios.road_town.flight import Helicopter
from scenarios.road_town.layout import Layout
from scenarios.road_town.measurement import Instruments
from scenarios.road_town.plan import TARGET, Plan
from scenarios.road_town.road_map import RoadMap
from scenarios.road_town.town import add_vehicle, build_town
from scenarios.road_town.truth import Light, RoadTruth
from scenarios.scenario import Frame, RendererName
from scenarios.truth import TruthExtent
from scenarios.visibility import Exits, centres_px, state_of
from sim.checks import check
from sim.labels import amodal_boxes, backward_flow, ground_homography, outline, visible_fraction
from sim.optics import PinholeCamera
from sim.render.pipeline import Capture, capture
from sim.render.protocol import create_renderer
from sim.rng import generator
from sim.sensors.camera_sensor import CameraSensor
from sim.sensors.config import SensorConfig
from sim.shaders.daylight import DaylightShader, Sun
from sim.world import World
from trackers.types import CameraCommand, CameraModel, CameraSettings, EgoPose, Observation

SUN_ILLUMINANCE_LX = 90_000.0
SKY_ILLUMINANCE_LX = 18_000.0
_NO_POSES = np.empty((0, 4, 4))
_NO_FLOW = np.empty((0, 0, 2), np.float32)


class RoadTownEpisode:
    """See ``scenarios.scenario.Episode``."""

    def __init__(self, plan: Plan, renderer: RendererName, truth: TruthExtent = "all") -> None:
        check("truth", truth in ("all", "target"), "'all' or 'target'", truth)
        self.plan = plan
        self._tells_all = truth == "all"
        self.frame_count = plan.preset.frame_count
        self.rate_hz = plan.preset.rate_hz
        self.closed_loop = plan.closed_loop
        self._world = build_town(plan.layout, generator(plan.seed, "town"))
        self._cars = [
            add_vehicle(self._world, "target" if car == TARGET else f"traffic-{car}", look.model, look.paint_rgb)
            for car, look in enumerate(plan.looks)
        ]
        self._names = tuple(body.name for body in self._cars)
        self._kinds = tuple(look.model for look in plan.looks)
        self._instance_id = np.array([body.index for body in self._cars])
        self._outline = outline([body.mesh for body in self._cars])
        self._renderer = create_renderer(renderer, self._world)
        self._light = _light(plan)
        self._shader = DaylightShader(
            self._world, Sun(self._light.sun_direction, SUN_ILLUMINANCE_LX), SKY_ILLUMINANCE_LX
        )
        self._sensor = CameraSensor(SensorConfig(), generator(plan.seed, "sensor"))
        self._on_road = RoadMap(plan.layout.graph).is_on_road(plan.motion.position_m[:, TARGET])
        ego = plan.preset.ego
        self._instruments = None if ego is None else Instruments(ego, generator(plan.seed, "instruments"))
        self._set_path = plan.camera_poses
        start = self._set_path[0, :2, 3]
        self._helicopter = Helicopter(plan.preset, plan.air, list(plan.pulses), start) if plan.closed_loop else None
        self._frame = -1
        self._T_world_camera = np.eye(4)
        self._exits = Exits(plan.camera)
        self._move_to(0)
        self.target_box_xyxy = self._boxes(0)[TARGET]

    def step(self, command: CameraCommand | None = None) -> Frame:
        """Return the next frame; see ``Episode.step``.

        Raises:
            ValueError: if a command is missing in closed loop, or given on a set path.
            StopIteration: after the last frame.
        """
        frame = self._frame + 1
        if frame >= self.frame_count:
            raise StopIteration(f"episode: expected at most {self.frame_count} steps")
        if self._helicopter is not None and frame > 0:
            if command is None:
                raise ValueError(
                    "command: expected a CameraCommand, since this episode is flown in closed loop, got None"
                )
            self._helicopter.fly(command)
        elif command is not None and self._helicopter is None:
            raise ValueError("command: expected None, since this episode flies a set path, got a CameraCommand")
        # Before the first frame everything is where it is on it.
        T_world_camera_before = self._T_world_camera
        body_poses_before = self._world.poses.copy() if self._tells_all else _NO_POSES
        self._move_to(frame)
        self._frame = frame
        return self._capture(T_world_camera_before, body_poses_before)

    def map_of(self) -> Layout:
        """Return the town's layout."""
        return self.plan.layout

    def larger_view(self, scale: float) -> NDArray[np.uint8]:
        """Return the current instant in a picture ``scale`` times as wide and high; see ``Episode.larger_view``."""
        camera = self.plan.camera
        wide = PinholeCamera(
            2 * round(0.5 * scale * camera.width_px), 2 * round(0.5 * scale * camera.height_px), camera.focal_px
        )
        gbuffer = self._renderer.gbuffer(wide, self._T_world_camera)
        radiance = self._shader.shade(gbuffer, wide, self._T_world_camera)
        return self._sensor.develop(radiance, wide, self._frame, self._settings).image_rgb

    @property
    def world(self) -> World:
        """The bodies, where they are now; for other renderers to draw."""
        return self._world

    def close(self) -> None:
        """Free the world."""
        self._world.close()

    def _move_to(self, frame: int) -> None:
        self._world.move_all(self._cars, self.plan.motion.T_world_car[frame])
        if self._helicopter is None:
            self._T_world_camera = self._set_path[frame]
        else:
            self._T_world_camera = self._helicopter.pose(frame)

    def _boxes(self, frame: int) -> NDArray[np.float64]:
        poses = self.plan.motion.T_world_car[frame]
        return amodal_boxes(self.plan.camera, self._T_world_camera, self._outline, poses)

    def _capture(self, T_world_camera_before: NDArray[np.float64], body_poses_before: NDArray[np.float64]) -> Frame:
        plan, camera, T_world_camera, frame = self.plan, self.plan.camera, self._T_world_camera, self._frame
        background_motion = ground_homography(camera, T_world_camera_before, T_world_camera)
        seen = capture(
            self._renderer,
            self._shader,
            self._sensor,
            camera,
            T_world_camera,
            frame,
            motion=background_motion,
            interval_s=1.0 / plan.preset.rate_hz,
        )
        self._settings = settings = seen.picture.settings
        flow_px = _NO_FLOW
        if self._tells_all:
            poses = self._world.poses
            flow_px = backward_flow(seen, camera, T_world_camera, T_world_camera_before, poses, body_poses_before)
        observation = Observation(
            image_rgb=seen.picture.image_rgb,
            time_s=frame / plan.preset.rate_hz,
            camera=CameraModel(camera.width_px, camera.height_px, camera.focal_px),
            settings=CameraSettings(settings.exposure_s, settings.gain),
            ego=None if self._instruments is None else EgoPose(self._instruments.measure(T_world_camera)),
        )
        return Frame(observation, self._truth(seen, background_motion, flow_px))

    def _truth(self, seen: Capture, background_motion: NDArray[np.float64], flow_px: NDArray[np.float32]) -> RoadTruth:
        plan, camera, T_world_camera, frame = self.plan, self.plan.camera, self._T_world_camera, self._frame
        settings, poses, boxes = seen.picture.settings, plan.motion.T_world_car[frame].copy(), self._boxes(frame)
        fractions = self._visible_fractions(seen, poses, boxes)
        state = state_of(camera, boxes[TARGET], fractions[TARGET])
        side, frames_since_exit = self._exits.follow(state, boxes[TARGET])
        return RoadTruth(
            frame=frame,
            time_s=frame / plan.preset.rate_hz,
            T_world_camera=T_world_camera,
            target=TARGET,
            names=self._names,
            kinds=self._kinds,
            T_world_object=poses,
            size_m=plan.sizes_m,
            speed_mps=plan.motion.speed_mps[frame],
            position_px=centres_px(camera, T_world_camera, poses, plan.sizes_m),
            box_xyxy=boxes,
            instance_id=self._instance_id.copy(),
            visible_fraction=fractions,
            state=state,
            side=side,
            frames_since_exit=frames_since_exit,
            on_road=bool(self._on_road[frame]),
            turning=plan.turning(frame),
            instance_map=seen.instance_id,
            depth_m=seen.depth_m,
            flow_px=flow_px,
            background_motion=background_motion,
            light=self._light,
            exposure_s=settings.exposure_s,
            gain=settings.gain,
        )

    def _visible_fractions(
        self, seen: Capture, poses: NDArray[np.float64], boxes: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        camera, T_world_camera = self.plan.camera, self._T_world_camera
        fractions = np.full(len(self._cars), np.nan)
        for car, body in enumerate(self._cars):
            if self._tells_all or car == TARGET:
                fractions[car] = visible_fraction(
                    seen, camera, T_world_camera, body.mesh, poses[car], body.index, boxes[car]
                )
        return fractions


def _light(plan: Plan) -> Light:
    c = np.cos(plan.sun_elevation_rad)
    direction = np.array(
        [c * np.cos(plan.sun_azimuth_rad), c * np.sin(plan.sun_azimuth_rad), np.sin(plan.sun_elevation_rad)]
    )
    return Light(direction, SUN_ILLUMINANCE_LX, SKY_ILLUMINANCE_LX)
