"""The scenario ``road-town``: a car in a town, seen from a helicopter that loses it from view."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.objects import Labels, Objects
from scenarios.road_town.flight import ALTITUDE_RANGE_M, HELICOPTER, Helicopter, Instruments
from scenarios.road_town.ground import TEXTURE_PX
from scenarios.road_town.layout import Layout
from scenarios.road_town.pictureless.bank import RoadPictureless
from scenarios.road_town.plan import TARGET, camera_of, draw_kept_layout, make_plan
from scenarios.road_town.presets import ABLATIONS, NEXT_PRESETS, PRESETS, RoadTown
from scenarios.road_town.road_map import RoadMap
from scenarios.road_town.semantics import Semantics
from scenarios.road_town.town import (
    PassersByBodies,
    add_vehicle,
    build_town,
    parked_cars,
    town_of,
)
from scenarios.road_town.truth import Light, RoadTruth
from scenarios.road_town.weather import (
    Conditions,
    GroundLight,
    draw_conditions,
    ground_light_of,
    kind_of_ground,
    sensor_in,
    shader_in,
)
from scenarios.scenario import KeptWorld, Scenario, Setup
from scenarios.stage import SceneCamera, Stage
from sim.labels import backward_flow, ground_homography, pixels_from_ground
from sim.meshes.vehicle import OWN, SHIPPED, VEHICLES, class_of, kind_of
from sim.optics import CameraMotion
from sim.render.pipeline import Capture
from sim.shaders.all_weather import AllWeatherShader
from sim.shaders.daylight import SHADOW_TEXELS
from trackers.types import CameraCommand, EgoPose

_SHADOW_TEXELS_A_PIXEL = 3
_OF_CONDITIONS = (
    "weather",
    "season",
    "visibility_m",
    "rain_mm_h",
    "snow_cover",
    "street_lamps_on",
    "headlights_on",
)
"""Fields of truth that are those of ``Conditions``."""
_BRAKES_FROM_MPS2, _WAITS_BELOW_MPS = 0.8, 0.3
_NO_POSES = np.empty((0, 4, 4))
_NO_FLOW = np.empty((0, 0, 2), np.float32)
_NO_CLASSES = np.empty((0, 0), np.uint8)


@dataclass(frozen=True)
class Detail:
    """How finely a town is drawn.

    Attributes:
        ground_px: side of the picture of its ground. shadow_texels: see ``DaylightShader``.
    """

    ground_px: int = TEXTURE_PX
    shadow_texels: int = SHADOW_TEXELS


@dataclass(frozen=True, eq=False)
class KeptTown:
    """What a kept town was built from, and what its light keeps, if that is more than sun and sky."""

    layout: Layout
    detail: Detail = Detail()
    ground_light: GroundLight | None = None


def detail_for(preset: RoadTown) -> Detail:
    """Return the coarsest detail that pictures of a configuration do not show, seen from the lowest height."""
    camera = camera_of(preset)
    pixels_m = ALTITUDE_RANGE_M[0] / camera.focal_px
    wanted_texels = _SHADOW_TEXELS_A_PIXEL * max(camera.width_px, camera.height_px)
    return Detail(
        min(TEXTURE_PX, _power_of_2(preset.extent_m / pixels_m)), min(SHADOW_TEXELS, _power_of_2(wanted_texels))
    )


def _power_of_2(least: float) -> int:
    return 2 ** max(math.ceil(math.log2(least)), 6)


class RoadTownEpisode(Stage):
    """See ``scenarios.scenario.Episode``."""

    _objects: Objects

    def __init__(self, setup: Setup) -> None:
        kept = setup.kept
        plan = make_plan(
            setup.preset, setup.seed, closed_loop=setup.closed_loop, kept=None if kept is None else kept.content.layout
        )
        if kept is None:
            world = town_of(plan.seed, plan.layout, plan.preset.vehicles, plan.preset.season)
            ground_light = ground_light_of(world, plan.layout, plan.preset, plan.seed)
        else:
            world = kept.world.copy()
            ground_light = kept.content.ground_light or ground_light_of(world, plan.layout, plan.preset, plan.seed)
        cars = [
            add_vehicle(world, "target" if car == TARGET else f"traffic-{car}", look.model, look.paint_rgb)
            for car, look in enumerate(plan.looks)
        ]
        self.plan = plan
        self._passing = None if plan.passers_by is None else PassersByBodies(world, plan.passers_by)
        self._flow_px, self._semantic_map = _NO_FLOW, _NO_CLASSES
        roads = RoadMap(plan.layout.graph)
        self._semantics = Semantics(world, roads.area, plan.layout.extent_m) if setup.covers_all else None
        self._conditions = draw_conditions(plan.preset, plan.seed, plan.sun_azimuth_rad, plan.sun_elevation_rad)
        self._light = _light(self._conditions)
        shadow_texels = SHADOW_TEXELS if kept is None else kept.content.detail.shadow_texels
        self._shader, self._car_lights = shader_in(
            self._conditions, world, cars, plan.sizes_m, ground_light, plan.seed, shadow_texels
        )
        self._on_road = roads.is_on_road(plan.motion.position_m[:, TARGET])
        ego, self._set_path = plan.preset.ego, plan.camera_poses
        self._instruments = None if ego is None else Instruments(ego, setup.rng("instruments"))
        start = self._set_path[0, :2, 3]
        self._helicopter = Helicopter(plan.preset, plan.air, list(plan.pulses), start) if plan.closed_loop else None
        self._T_world_camera = np.eye(4)
        passing = () if self._passing is None else self._passing.standing
        super().__init__(
            setup,
            Objects(world, cars, kinds=[kind_of(look.model) for look in plan.looks], size_m=plan.sizes_m),
            SceneCamera(
                setup,
                world,
                plan.camera,
                sensor_in(self._conditions, setup, plan.camera),
                smooth=plan.preset.smooth_edges,
            ),
            standing=(*parked_cars(world), *passing) if setup.covers_all else (),
        )
        self._from_ground = pixels_from_ground(plan.camera, self._T_world_camera)
        self._remember_poses()

    @property
    def preset(self) -> RoadTown:
        """The configuration of the episode."""
        return self.plan.preset

    def map_of(self) -> Layout:
        """Return the town's layout."""
        return self.plan.layout

    def _obey(self, command: CameraCommand) -> None:
        assert self._helicopter is not None
        self._helicopter.obey(command, self._frame)

    def _move_to(self, frame: int) -> None:
        motion = self.plan.motion
        self._objects.move(motion.T_world_car[frame], motion.speed_mps[frame])
        if self._passing is not None:
            self._passing.move(frame)
        self._T_world_camera = self._set_path[frame] if self._helicopter is None else self._helicopter.pose(frame)

    def _remember_poses(self) -> None:
        """Keep all poses for the next picture; before the first one they are those of frame 0."""
        self._T_world_camera_before = self._T_world_camera
        self._from_ground_before = self._from_ground
        self._body_poses_before = self.world.poses.copy() if self._setup.covers_all else _NO_POSES

    def _capture(self, frame: int) -> Capture[Any]:
        camera, T_world_camera = self.plan.camera, self._T_world_camera
        if isinstance(self._shader, AllWeatherShader):
            self._shader.frame = frame
        if self._car_lights is not None:
            self._car_lights.braking = self._braking(frame)
        self._from_ground = pixels_from_ground(camera, T_world_camera)
        self._background_motion = ground_homography(self._from_ground_before, self._from_ground)
        motion = CameraMotion(self._background_motion, 1.0 / self.rate_hz)
        capture = self._camera.take(self._shader, T_world_camera, frame, motion=motion)
        if self._setup.covers_all:
            # Before the ids of limbs become those of people: each moves in its own way.
            poses, before = self.world.poses, self._body_poses_before
            self._flow_px = backward_flow(capture, camera, T_world_camera, self._T_world_camera_before, poses, before)
        if self._semantics is not None:
            self._semantic_map = self._semantics.of(capture.instance_id, self._from_ground)
        return capture

    def _braking(self, frame: int) -> NDArray[np.bool_]:
        """Return whether each car brakes, or waits."""
        speed_mps = self.plan.motion.speed_mps
        slower_mps2 = (speed_mps[max(frame - 1, 0)] - speed_mps[frame]) * self.rate_hz
        return np.asarray((slower_mps2 > _BRAKES_FROM_MPS2) | (speed_mps[frame] < _WAITS_BELOW_MPS))

    def _ego(self) -> EgoPose | None:
        return None if self._instruments is None else EgoPose(self._instruments.measure(self._T_world_camera))

    def _own_truth(self, capture: Capture[Any], labels: Labels) -> dict[str, Any]:
        plan, frame = self.plan, self._frame
        self._remember_poses()
        return {
            "on_road": bool(self._on_road[frame]),
            "turning": plan.turning(frame),
            "flow_px": self._flow_px,
            "semantic_map": self._semantic_map,
            "background_motion": self._background_motion,
            "light": self._light,
            **{name: getattr(self._conditions, name) for name in _OF_CONDITIONS},
        }


def _light(conditions: Conditions) -> Light:
    return Light(
        conditions.sun_direction,
        conditions.sun_illuminance_lx,
        conditions.sky_illuminance_lx,
    )


def keep_town(setup: Setup) -> KeptWorld:
    """Build the town of an episode as its picture needs it. Excursions of others there lead where nothing stands."""
    preset, detail = setup.preset, detail_for(setup.preset)
    layout = draw_kept_layout(preset, setup.seed)
    world = build_town(layout, setup.rng("town"), detail.ground_px, preset.vehicles, preset.season)
    return KeptWorld(world, KeptTown(layout, detail, ground_light_of(world, layout, preset, setup.seed)))


def kind_of_town(preset: RoadTown) -> Hashable:
    """Return what of a configuration decides what a kept town is."""
    drawn = preset.street_patterns, preset.extent_m, preset.traffic_side, preset.season, preset.has_lamp_posts
    furnished = preset.buildings, preset.building_models, preset.gardens, preset.signs, preset.overpasses
    has_zebras = preset.people[1] > 0 or preset.cyclists[1] > 0
    return *drawn, furnished, has_zebras, kind_of_ground(preset), detail_for(preset), preset.vehicles


class _Kinds(Mapping[str, str]):
    """All models of vehicles, people and cyclists, and models registered later, with their classes."""

    def __getitem__(self, kind: str) -> str:
        if kind in RoadTruth.passing:
            return kind
        if kind != OWN and kind not in VEHICLES:
            raise KeyError(kind)
        return class_of(kind)

    def __iter__(self) -> Iterator[str]:
        return iter((*SHIPPED, *RoadTruth.passing, OWN, *(model for model in VEHICLES if model not in SHIPPED)))

    def __len__(self) -> int:
        return len(VEHICLES) + len(RoadTruth.passing) + 1


ROAD_TOWN = Scenario(
    id="road-town-v2",
    summary="a car in a town, seen from a helicopter that often loses it from view",
    start="the first picture and the car's box in it; measured ego pose where the preset has instruments",
    stage=RoadTownEpisode,
    presets=PRESETS | ABLATIONS,
    classes=_Kinds(),
    carrier=HELICOPTER,
    truth=RoadTruth,
    pictureless=RoadPictureless(),
    new_world=keep_town,
    world_kind=kind_of_town,
)
ROAD_TOWN_NEXT = replace(
    ROAD_TOWN,
    id="road-town-v3",
    summary="the same among people, gardens and houses of many kinds, by day and night, in any weather",
    presets=NEXT_PRESETS,
)
"""The edition on which tables do not rest yet."""
