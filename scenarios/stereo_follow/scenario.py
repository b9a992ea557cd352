"""The scenario ``stereo-follow``: a person among others, followed by a robot with a stereo camera."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.objects import JointedObjects, Labels, add_parts
from scenarios.scenario import KeptWorld, Scenario, Setup
from scenarios.stereo_follow.building import Building
from scenarios.stereo_follow.camera import camera_pose
from scenarios.stereo_follow.carried import laden_size_m
from scenarios.stereo_follow.crowd import KINDS
from scenarios.stereo_follow.lighting import LitBuilding, build, illuminance_lx, set_light
from scenarios.stereo_follow.pictureless.bank import StereoPictureless
from scenarios.stereo_follow.plan import TARGET, Plan, building_of, make_plan
from scenarios.stereo_follow.presets import PRESETS, StereoFollow
from scenarios.stereo_follow.rig import LightEvents, StereoStage
from scenarios.stereo_follow.robot import ROBOT, Robot
from scenarios.stereo_follow.truth import PeopleTruth
from sim.meshes.person import person_parts, person_size_m
from sim.motion.gait import part_poses
from sim.motion.keypoints import person_points
from sim.motion.skeleton import skeleton
from sim.pose import pose_on_ground
from sim.render.pipeline import Capture
from sim.rng import generator
from sim.shaders.baked.shader import BakedLightShader
from sim.world import World
from trackers.types import CameraCommand

CHEST = 0.72
"""Height of the chest, share of stature."""


class People(JointedObjects):
    """N people, ``target``, ``crosser-1`` and so on, with what they carry; sizes are of those who stand, origins on the
    ground.
    """

    def __init__(self, world: World, plan: Plan) -> None:
        self._plan = plan
        self._bones = [skeleton(look.stature_m, look.build, look.figure) for look in plan.looks]
        kinds = plan.crowd.kinds
        names = [kind if k == TARGET else f"{kind}-{k}" for k, kind in enumerate(kinds)]
        rng = generator(plan.seed, "clothes")
        parts = [
            add_parts(world, name, "person", person_parts(look, rng) | {load.name: load.mesh for load in loads})
            for name, look, loads in zip(names, plan.looks, plan.loads, strict=True)
        ]
        sizes_m = np.array([laden_size_m(*each) for each in zip(plan.looks, plan.loads, strict=True)])
        super().__init__(world, names, kinds, parts, sizes_m, keypoints=[person_points(each) for each in self._bones])
        self._chest_m = CHEST * np.array([person_size_m(look)[2] for look in plan.looks])
        self._postures: list[tuple[float, ...]] = [()] * len(parts)

    def move_to(self, frame: int) -> None:
        """Move all people to their poses on a frame."""
        self.speed_mps = np.array([walk.speed_mps[frame] for walk in self._plan.crowd.walks])
        for k, walk in enumerate(self._plan.crowd.walks):
            (x_m, y_m), heading_rad = walk.place_m[frame], walk.heading_rad[frame]
            phase_rad, speed_mps = self._plan.phase_rad[frame, k], walk.speed_mps[frame]
            posture = (x_m, y_m, heading_rad, phase_rad if speed_mps > 0 else 0.0, speed_mps)
            if posture == self._postures[k]:
                continue
            self._postures[k] = posture
            pose = pose_on_ground(x_m, y_m, heading_rad)
            self.T_world_object[k] = pose
            poses = part_poses(self._bones[k], pose, phase_rad, speed_mps)
            carried = [load.pose(pose, poses)[None] for load in self._plan.loads[k]]
            self.move_parts(k, np.concatenate([poses, *carried]))

    def chests_m(self) -> NDArray[np.float64]:
        """Return the centres of all chests (N, 3)."""
        places_m = self.T_world_object[:, :3, 3].copy()
        places_m[:, 2] = self._chest_m
        return places_m


NOD_RAD, NOD_KEPT = np.deg2rad(0.12), 0.8
"""The robot shakes: standard deviation of nod and roll, and their autoregression coefficient."""
_NEAR_M = 1.5
_SHADOW_TEXELS = 1024


class StereoFollowEpisode(StereoStage):
    """See ``scenarios.scenario.Episode``."""

    _shader: BakedLightShader
    _objects: People

    def __init__(self, setup: Setup) -> None:
        kept = setup.kept
        building = None if kept is None else kept.content.building
        self.plan = plan = make_plan(setup.preset, setup.seed, closed_loop=setup.closed_loop, kept=building)
        preset, crowd = plan.preset, plan.crowd
        if kept is None:
            world = World()
            baked = build(world, plan.building)
        else:
            world, baked = kept.world.copy(), kept.content.baked
        people = People(world, plan)
        self._shader = BakedLightShader(world, baked, shadow_texels=_SHADOW_TEXELS, panels_raised=False)
        shake = setup.rng("shake").normal(0.0, NOD_RAD, (preset.frame_count, 2))
        for frame in range(1, preset.frame_count):
            shake[frame] = NOD_KEPT * shake[frame - 1] + (1 - NOD_KEPT**2) ** 0.5 * shake[frame]
        self._shake = shake
        self._robot = Robot(plan.building.plan, crowd.robot_m[0], crowd.robot_heading_rad[0], preset.rate_hz)
        events = LightEvents(plan.places, plan.light.switched, preset.rate_hz)
        super().__init__(setup, people, events, has_odometry=preset.odometry, smooth=preset.smooth_edges)

    def map_of(self) -> Building:
        """Return the building."""
        return self.plan.building

    def _obey(self, command: CameraCommand) -> None:
        self._robot.drive(command)

    def _move_to(self, frame: int) -> None:
        self._objects.move_to(frame)
        set_light(self._shader, self.plan.light, frame)
        crowd = self.plan.crowd
        if not self.closed_loop:
            self._robot.place_m, self._robot.heading_rad = crowd.robot_m[frame], float(crowd.robot_heading_rad[frame])
        self._robot_place = self._robot.place_m, self._robot.heading_rad
        self._T_world_camera = camera_pose(*self._robot_place, *self._shake[frame])

    def _capture(self, frame: int) -> Capture[Any]:
        self._camera.right_is_lost = bool(self.plan.dropped[frame])
        return super()._capture(frame)

    def _own_truth(self, capture: Capture[Any], labels: Labels) -> dict[str, Any]:
        people, pose = self._objects, self._T_world_camera
        distance_m = np.linalg.norm((people.T_world_object[:, :3, 3] - pose[:3, 3])[:, :2], axis=1)
        is_close = (distance_m < _NEAR_M) & (np.arange(len(distance_m)) != TARGET)
        seen = labels
        if is_close.any() and not self._setup.covers_all:
            seen = people.labels(self._camera.model, pose, capture, is_close)
        lux = illuminance_lx(self._shader, people.chests_m(), pose[:3, 3])
        return {
            **self._pair_truth(capture, self.plan.places[self._frame], lux),
            "occluder": labels.hidden_by,
            "near_person": bool((is_close & (seen.visible_fraction > 0)).any()),
        }


def keep_building(setup: Setup) -> KeptWorld:
    """Build the building of an episode, and its light."""
    building, world = building_of(setup.seed, setup.preset.place, setup.preset.rooms), World()
    baked = build(world, building)
    return KeptWorld(world, LitBuilding(building, baked))


def kind_of_building(preset: StereoFollow) -> tuple[str, str]:
    """Return what of a preset decides what a building is."""
    return preset.place, preset.rooms


STEREO_FOLLOW = Scenario(
    id="stereo-follow-v2",
    summary="a person among others, followed by a robot with a stereo camera from corridor to yard",
    start="the first pair and the person's box in the left picture; the camera's settings; odometry",
    stage=StereoFollowEpisode,
    presets=PRESETS,
    classes=dict.fromkeys(KINDS, "person"),
    carrier=ROBOT,
    truth=PeopleTruth,
    pictureless=StereoPictureless(),
    new_world=keep_building,
    world_kind=kind_of_building,
)
