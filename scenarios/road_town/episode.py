"""One episode of ``road-town``: the plan, frame by frame."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenarios.camera_rig import SingleCamera
from scenarios.kept_world import KeptWorld
from scenarios.road_town.flight import Helicopter
from scenarios.road_town.layout import Layout
from scenarios.road_town.measurement import Instruments
from scenarios.road_town.plan import TARGET, Plan
from scenarios.road_town.presets import RoadTown
from scenarios.road_town.road_map import RoadMap
from scenarios.road_town.town import add_vehicle, parked_cars, town_of
from scenarios.road_town.truth import Light, RoadTruth
from scenarios.scenario import Frame, RendererName
from scenarios.stage import Stage, covers_all
from scenarios.truth import TruthExtent
from sim.labels import amodal_boxes, backward_flow, ground_homography, outline, visible_fraction
from sim.optics import CameraMotion, PinholeCamera
from sim.render.pipeline import Capture
from sim.rng import generator
from sim.sensors.camera_sensor import CameraSensor
from sim.sensors.config import SensorConfig
from sim.shaders.daylight import DaylightShader, Sun
from trackers.types import CameraCommand, CameraModel, CameraSettings, EgoPose, Observation, Start

SUN_ILLUMINANCE_LX = 90_000.0
SKY_ILLUMINANCE_LX = 18_000.0
_NO_POSES = np.empty((0, 4, 4))
_NO_FLOW = np.empty((0, 0, 2), np.float32)


class RoadTownEpisode(Stage):
    """See ``scenarios.scenario.Episode``."""

    def __init__(
        self, plan: Plan, renderer: RendererName, truth: TruthExtent = "all", kept: KeptWorld | None = None
    ) -> None:
        self._covers_all = covers_all(truth)
        world = town_of(plan.seed, plan.layout) if kept is None else kept.vacated()
        self._cars = [
            add_vehicle(world, "target" if car == TARGET else f"traffic-{car}", look.model, look.paint_rgb)
            for car, look in enumerate(plan.looks)
        ]
        self._camera = SingleCamera(
            world, plan.camera, renderer, CameraSensor(SensorConfig(), generator(plan.seed, "sensor"))
        )
        preset = plan.preset
        super().__init__(
            world,
            self._camera,
            frame_count=preset.frame_count,
            rate_hz=preset.rate_hz,
            closed_loop=plan.closed_loop,
            standing=parked_cars(world) if self._covers_all else (),
        )
        self.plan = plan
        self._names = tuple(body.name for body in self._cars)
        self._kinds = tuple(look.model for look in plan.looks)
        self._instance_id = np.array([body.index for body in self._cars])
        self._outline = outline([body.mesh for body in self._cars])
        self._bounds_m = np.array([body.mesh.bounds_m for body in self._cars])
        self._light = _light(plan)
        self._daylight = DaylightShader(world, Sun(self._light.sun_direction, SUN_ILLUMINANCE_LX), SKY_ILLUMINANCE_LX)
        self._on_road = RoadMap(plan.layout.graph).is_on_road(plan.motion.position_m[:, TARGET])
        ego = preset.ego
        self._instruments = None if ego is None else Instruments(ego, generator(plan.seed, "instruments"))
        self._set_path = plan.camera_poses
        start = self._set_path[0, :2, 3]
        self._helicopter = Helicopter(preset, plan.air, list(plan.pulses), start) if plan.closed_loop else None
        self._T_world_camera_before = self._T_world_camera
        self._body_poses_before = _NO_POSES
        self._move_to(0)
        self._first_box_xyxy = self._boxes(0)[TARGET]

    @property
    def preset(self) -> RoadTown:
        """The configuration of the episode."""
        return self.plan.preset

    @property
    def start(self) -> Start:
        """The car's box in the first picture."""
        return Start(_model(self.plan.camera), box_xyxy=self._first_box_xyxy.copy())

    @property
    def _shader(self) -> DaylightShader:
        return self._daylight

    def map_of(self) -> Layout:
        """Return the town's layout."""
        return self.plan.layout

    def _obey(self, command: CameraCommand) -> None:
        assert self._helicopter is not None
        self._helicopter.obey(command, self._frame)

    def _move_to(self, frame: int) -> None:
        # Before the first frame, all poses are those of frame 0.
        self._T_world_camera_before = self._T_world_camera
        self._body_poses_before = self.world.poses.copy() if self._covers_all else _NO_POSES
        self.world.move_all(self._cars, self.plan.motion.T_world_car[frame])
        self._T_world_camera = self._set_path[frame] if self._helicopter is None else self._helicopter.pose(frame)

    def _boxes(self, frame: int) -> NDArray[np.float64]:
        poses = self.plan.motion.T_world_car[frame]
        return amodal_boxes(self.plan.camera, self._T_world_camera, self._outline, poses)

    def _take(self, frame: int) -> Frame:
        plan, camera, T_world_camera = self.plan, self.plan.camera, self._T_world_camera
        background_motion = ground_homography(camera, self._T_world_camera_before, T_world_camera)
        motion = CameraMotion(background_motion, 1.0 / self.rate_hz)
        seen = self._camera.take(self._shader, T_world_camera, frame, motion=motion)
        settings = seen.picture.settings
        flow_px = _NO_FLOW
        if self._covers_all:
            poses = self.world.poses
            flow_px = backward_flow(
                seen, camera, T_world_camera, self._T_world_camera_before, poses, self._body_poses_before
            )
        observation = Observation(
            image_rgb=seen.picture.image_rgb,
            time_s=frame / plan.preset.rate_hz,
            camera=_model(camera),
            settings=CameraSettings(settings.exposure_s, settings.gain),
            ego=None if self._instruments is None else EgoPose(self._instruments.measure(T_world_camera)),
        )
        return Frame(observation, self._truth(frame, seen, background_motion, flow_px))

    def _truth(
        self, frame: int, seen: Capture, background_motion: NDArray[np.float64], flow_px: NDArray[np.float32]
    ) -> RoadTruth:
        plan, poses, boxes = self.plan, self.plan.motion.T_world_car[frame], self._boxes(frame)
        fractions = self._visible_fractions(seen, poses, boxes)
        return RoadTruth(
            **self._seen(seen, T_world_object=poses, size_m=plan.sizes_m, box_xyxy=boxes, visible_fraction=fractions),
            names=self._names,
            kinds=self._kinds,
            bounds_m=self._bounds_m,
            instance_id=self._instance_id.copy(),
            speed_mps=plan.motion.speed_mps[frame],
            on_road=bool(self._on_road[frame]),
            turning=plan.turning(frame),
            flow_px=flow_px,
            background_motion=background_motion,
            light=self._light,
        )

    def _visible_fractions(
        self, seen: Capture, poses: NDArray[np.float64], boxes: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        camera, T_world_camera = self.plan.camera, self._T_world_camera
        fractions = np.full(len(self._cars), np.nan)
        for car, body in enumerate(self._cars):
            if self._covers_all or car == TARGET:
                fractions[car] = visible_fraction(
                    seen, camera, T_world_camera, body.mesh, poses[car], body.index, boxes[car]
                )
        return fractions


def _model(camera: PinholeCamera) -> CameraModel:
    return CameraModel(camera.width_px, camera.height_px, camera.focal_px)


def _light(plan: Plan) -> Light:
    c = np.cos(plan.sun_elevation_rad)
    direction = np.array(
        [c * np.cos(plan.sun_azimuth_rad), c * np.sin(plan.sun_azimuth_rad), np.sin(plan.sun_elevation_rad)]
    )
    return Light(direction, SUN_ILLUMINANCE_LX, SKY_ILLUMINANCE_LX)
